//! Models near the estimate, and the uncertainty that they show where first-order theory
//! ([`crate::pem::covariance`]) falls short (docs/methods/refinement.md): *replicas*, estimates
//! from the data less one block of time each (block jackknife: H. R. Künsch, Annals of Statistics
//! 17, 1989), and *rivals*, models of another order or criterion with weights (Buckland, Burnham
//! and Augustin, Biometrics 53, 1997).
//!
//! A neighbour is compared by its response: δ is the step of the local coordinates that moves the
//! estimate's response nearest to the neighbour's over the frequencies `omegas`, each weighted by
//! the size of the response there.

use crate::Error;
use crate::data::{DataSet, Segment};
use crate::linalg::dense::{least_squares, solve, svd};
use crate::model::StateSpace;
use crate::pem::coordinates::Coordinates;
use crate::pem::uncertain::Response;
use faer::Mat;
use std::ops::Range;

/// Neighbours of an estimate.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Neighbours<'a> {
    /// Estimates from the data less one block of time each.
    pub(crate) replicas: &'a [StateSpace],
    pub(crate) rivals: &'a [(f64, StateSpace)],
    /// Where responses are compared, rad per sample.
    pub(crate) omegas: &'a [f64],
}

/// Directions of a smaller share of the largest effect on the response are left alone.
const LEAST_EFFECT: f64 = 1e-3;

/// Steps of the local coordinates towards `others`, one column each.
pub(super) fn steps(
    coordinates: &Coordinates,
    others: &[&StateSpace],
    omegas: &[f64],
) -> Result<Mat<f64>, Error> {
    let model = &coordinates.model;
    let (m, p, q) = (model.inputs(), model.outputs(), coordinates.count());
    let unit = |k: usize| (0..q).map(|j| f64::from(u8::from(j == k))).collect::<Vec<f64>>();
    let moves: Vec<_> = (0..q).map(|k| coordinates.direction(&unit(k))).collect();
    let rows = 2 * omegas.len() * m * p;
    let mut by = Mat::<f64>::zeros(rows, q);
    let mut apart = Mat::<f64>::zeros(rows, others.len());
    let mut at = 0;
    for omega in omegas {
        for (i, l) in (0..p).flat_map(|i| (0..m).map(move |l| (i, l))) {
            let here = Response::new(model, i, l, *omega);
            let weight = here.value.re.hypot(here.value.im).max(1e-300).recip();
            let set = |to: &mut Mat<f64>, column: usize, (re, im): (f64, f64)| {
                to[(at, column)] = weight * re;
                to[(at + 1, column)] = weight * im;
            };
            for (k, delta) in moves.iter().enumerate() {
                let moved = here.along(delta);
                set(&mut by, k, (moved.re, moved.im));
            }
            for (k, other) in others.iter().enumerate() {
                let (re, im) = other.frequency_response(i, l, *omega);
                set(&mut apart, k, (re - here.value.re, im - here.value.im));
            }
            at += 2;
        }
    }
    least_squares(by.as_ref(), apart.as_ref(), LEAST_EFFECT)
}

/// The root of the larger of `root · rootᵀ` and the jackknife's covariance in each direction.
pub(crate) fn larger(root: &Mat<f64>, deviations: &Mat<f64>) -> Result<Mat<f64>, Error> {
    let (q, b) = (root.nrows(), deviations.ncols());
    let scale = ((b as f64 - 1.0) / b as f64).sqrt();
    let relative = solve(root.as_ref(), deviations.as_ref());
    let axes = svd(relative.as_ref())?;
    let size = |k: usize| axes.s.get(k).map_or(1.0, |s| (scale * s).max(1.0));
    let full = root * &axes.u;
    let columns = full.ncols();
    let widened = Mat::from_fn(q, columns, |i, k| full[(i, k)] * size(k));
    let finite = crate::linalg::dense::is_finite(widened.as_ref());
    Ok(if columns == q && finite { widened } else { root.clone() })
}

/// The data less one of `blocks` equal blocks each, without pieces shorter than `least`.
pub(crate) fn without_blocks(data: &DataSet, blocks: usize, least: usize) -> Vec<DataSet> {
    let count = data.samples();
    let part = |s: &Segment, range: Range<usize>| {
        if range.len() >= least {
            Some(Segment::new(s.u.columns(range.clone()), s.y.columns(range)))
        } else {
            None
        }
    };
    (0..blocks)
        .filter_map(|b| {
            let (from, to) = (b * count / blocks, (b + 1) * count / blocks);
            let mut start = 0;
            let mut kept = Vec::new();
            for s in data.segments() {
                let inside = |at: usize| at.clamp(start, start + s.len()) - start;
                kept.extend(part(s, 0..inside(from)));
                kept.extend(part(s, inside(to)..s.len()));
                start += s.len();
            }
            DataSet::new(data.sample_time_s(), kept).ok()
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn row(values: &[f64]) -> Mat<f64> {
        Mat::from_fn(1, values.len(), |_, j| values[j])
    }

    fn model(pole: f64, gain: f64) -> StateSpace {
        StateSpace { a: row(&[pole]), b: row(&[gain]), c: row(&[1.0]), d: row(&[0.0]) }
    }

    /// A model that differs a little is reached by its step.
    #[test]
    fn a_step_leads_to_the_neighbour() {
        let (here, there) = (model(0.8, 1.0), model(0.801, 1.002));
        let coordinates = Coordinates::new(&here, &row(&[1.0]), &[false]).unwrap();
        let omegas = [0.05, 0.1, 0.3, 1.0];
        let step = steps(&coordinates, &[&there], &omegas).unwrap();
        let step: Vec<f64> = (0..step.nrows()).map(|i| step[(i, 0)]).collect();
        let reached = coordinates.moved(&step);
        for omega in [0.02, 0.2, 2.0] {
            let (a, b) =
                (reached.frequency_response(0, 0, omega), there.frequency_response(0, 0, omega));
            let start = here.frequency_response(0, 0, omega);
            let left = (a.0 - b.0).hypot(a.1 - b.1);
            assert!(left < 0.02 * (start.0 - b.0).hypot(start.1 - b.1), "{omega}: {left}");
        }
    }

    /// In one direction the jackknife is three times as wide, in the other half as wide.
    #[test]
    fn the_larger_of_two_covariances_is_that_of_each_direction() {
        let root = Mat::from_fn(2, 2, |i, j| [[2.0, 0.0], [0.0, 1.0]][i][j]);
        let b = 9.0_f64;
        let scale = (b / (b - 1.0)).sqrt();
        let deviations = Mat::from_fn(2, 9, |i, j| match (i, j) {
            (0, 0) => 6.0 * scale,
            (1, 1) => 0.5 * scale,
            _ => 0.0,
        });
        let joined = larger(&root, &deviations).unwrap();
        let covariance = &joined * joined.transpose();
        for (i, j, expected) in [(0, 0, 36.0), (1, 1, 1.0), (0, 1, 0.0)] {
            assert!((covariance[(i, j)] - expected).abs() < 1e-12, "{covariance:?}");
        }
    }

    #[test]
    fn each_block_is_left_out_once() {
        let segment = |n: usize| {
            let x = Mat::from_fn(1, n, |_, j| j as f64);
            Segment::new(x.clone(), x)
        };
        let data = DataSet::new(0.1, vec![segment(60), segment(40)]).unwrap();
        let parts = without_blocks(&data, 5, 1);
        assert_eq!(parts.len(), 5);
        assert!(parts.iter().all(|p| p.samples() == 80));
        // The third block ends with the first segment.
        assert_eq!(parts[2].segments().len(), 2);
        assert_eq!(parts[1].segments().len(), 3);
    }
}
