//! Least squares over blocks, each with a yaw and a bias of its own.

use crate::linalg::dense::{identity, short_dot, solve};
use crate::sideslip::displacements::{
    DisplacementSegment, LEAST_BLOCKS, LEAST_SEGMENTS, OUTLIER, TERMS,
};
use faer::Mat;

/// Values of the terms, 0 where they are not looked for, and their covariance.
pub(super) struct Regression {
    pub(super) values: [f64; TERMS],
    pub(super) covariance: [[f64; TERMS]; TERMS],
    pub(super) residuals: Vec<Vec<f64>>,
}

impl Regression {
    /// The standard error of a term.
    pub(super) fn error(&self, term: usize) -> f64 {
        self.covariance[term][term].sqrt()
    }

    /// Takes in that a linear combination of the terms has a value with a standard deviation, which is known beside the
    /// fixes: the update of a Kalman filter.
    pub(super) fn take(&mut self, combination: &[f64; TERMS], value: f64, deviation: f64) {
        let dot = |a: &[f64; TERMS]| a.iter().zip(combination).map(|(a, b)| a * b).sum::<f64>();
        let with = self.covariance.map(|row| dot(&row));
        let variance = dot(&with) + deviation * deviation;
        let difference = value - dot(&self.values);
        for (i, row) in self.covariance.iter_mut().enumerate() {
            self.values[i] += with[i] / variance * difference;
            row.iter_mut().zip(&with).for_each(|(c, with_j)| *c -= with[i] * with_j / variance);
        }
    }
}

/// Some terms over all blocks without fixes far off; `None` where there are too few blocks.
pub(super) fn robust(blocks: &[Vec<DisplacementSegment>], wanted: &[usize]) -> Option<Regression> {
    let first = regression(blocks, wanted)?;
    let mut sizes: Vec<f64> = first.residuals.iter().flatten().map(|r| r.abs()).collect();
    sizes.sort_by(f64::total_cmp);
    let bound = OUTLIER * 1.4826 * sizes[sizes.len() / 2];
    if bound.is_nan() {
        return Some(first);
    }
    let good = |(segments, residuals): (&Vec<DisplacementSegment>, &Vec<f64>)| -> Vec<DisplacementSegment> {
        let good = segments.iter().zip(residuals).filter(|(_, r)| r.abs() <= bound);
        good.map(|(displacement, _)| *displacement).collect()
    };
    let mut blocks: Vec<Vec<DisplacementSegment>> =
        blocks.iter().zip(&first.residuals).map(good).collect();
    blocks.retain(|segments| segments.len() >= LEAST_SEGMENTS);
    regression(&blocks, wanted)
}

/// Frisch and Waugh: yaw and bias are taken out of both sides. Standard errors of clusters.
fn regression(blocks: &[Vec<DisplacementSegment>], wanted: &[usize]) -> Option<Regression> {
    if blocks.len() < LEAST_BLOCKS {
        return None;
    }
    let blocks: Vec<Detrended> =
        blocks.iter().map(|segments| Detrended::from_segments(segments, wanted)).collect();
    let total = |f: &dyn Fn(&Detrended) -> f64| blocks.iter().map(f).sum::<f64>();
    // Each term in its own unit, so that the sums are of one size.
    let n = wanted.len();
    let unit: Vec<f64> =
        (0..n).map(|i| total(&|b| short_dot(&b.terms[i], &b.terms[i])).sqrt()).collect();
    let square = Mat::from_fn(n, n, |i, j| {
        total(&|b| short_dot(&b.terms[i], &b.terms[j])) / (unit[i] * unit[j])
    });
    let inverse = solve(square.as_ref(), identity(n).as_ref());
    let product =
        Mat::from_fn(n, 1, |i, _| total(&|b| short_dot(&b.terms[i], &b.difference)) / unit[i]);
    let found = &inverse * product;
    let left = |block: &Detrended| {
        let mut left = block.difference.clone();
        for (i, term) in block.terms.iter().enumerate() {
            let value = found[(i, 0)] / unit[i];
            left.iter_mut().zip(term).for_each(|(left, x)| *left -= value * x);
        }
        left
    };
    let residuals: Vec<Vec<f64>> = blocks.iter().map(left).collect();
    let count = blocks.len() as f64;
    let mut scatter = Mat::<f64>::zeros(n, n);
    for (block, left) in blocks.iter().zip(&residuals) {
        let score = Mat::from_fn(n, 1, |i, _| short_dot(&block.terms[i], left) / unit[i]);
        let by = &inverse * score;
        scatter += &by * by.transpose();
    }
    let mut made =
        Regression { values: [0.0; TERMS], covariance: [[0.0; TERMS]; TERMS], residuals };
    for (i, &term) in wanted.iter().enumerate() {
        made.values[term] = found[(i, 0)] / unit[i];
        for (j, &other) in wanted.iter().enumerate() {
            made.covariance[term][other] =
                count / (count - 1.0) * scatter[(i, j)] / (unit[i] * unit[j]);
        }
    }
    Some(made)
}

/// A block without its yaw and bias: the wanted terms, and what they are to explain.
struct Detrended {
    terms: Vec<Vec<f64>>,
    difference: Vec<f64>,
}

impl Detrended {
    fn from_segments(segments: &[DisplacementSegment], wanted: &[usize]) -> Self {
        let each =
            |f: &dyn Fn(&DisplacementSegment) -> f64| segments.iter().map(f).collect::<Vec<f64>>();
        let time = each(&|w| w.time);
        let terms = wanted.iter().map(|&i| without_line(&time, each(&|w| w.terms[i]))).collect();
        Self { terms, difference: without_line(&time, each(&|w| w.difference)) }
    }
}

fn without_line(time: &[f64], mut values: Vec<f64>) -> Vec<f64> {
    let n = time.len() as f64;
    let mean = |x: &[f64]| x.iter().sum::<f64>() / n;
    let (t0, v0) = (mean(time), mean(&values));
    let square: f64 = time.iter().map(|t| (t - t0).powi(2)).sum();
    let product: f64 = time.iter().zip(&values).map(|(t, v)| (t - t0) * (v - v0)).sum();
    let slope = if square > 0.0 { product / square } else { 0.0 };
    values.iter_mut().zip(time).for_each(|(v, t)| *v -= v0 + slope * (t - t0));
    values
}
