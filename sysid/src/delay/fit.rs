//! The best model of one order, with a given delay or with its own.
//!
//! Variable projection (Golub and Pereyra 1973): for given poles and delay the numerator is a linear
//! least-squares problem, and Levenberg–Marquardt steps move poles and delay on what it leaves.

use super::lags::Quadratic;
use super::response::{basis, polynomial, with_pole};

/// A model with its cost; times in samples.
#[derive(Debug, Clone)]
pub(super) struct Fit {
    /// Poles, as [`polynomial`] takes them.
    pub(super) parameters: Vec<f64>,
    pub(super) delay: f64,
    /// Squared whitened error beyond the least.
    pub(super) excess: f64,
}

/// Natural logarithms of a polynomial's coefficients stay between these: time constants from a
/// twentieth of a sample to a thousand samples.
const BOUNDS: (f64, f64) = (-14.0, 6.0);

/// Which numerators a model may have.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Zeros {
    /// Those of a vehicle: yaw rate follows the road wheel with a zero, and what comes on top of two
    /// poles are lags without one, so that they cannot take the shape of a delay (Padé).
    Vehicle,
    /// As many as a held input allows.
    Free,
}

/// What is fitted to, and among what.
#[derive(Clone, Copy)]
pub(super) struct Search<'a> {
    pub(super) q: &'a Quadratic,
    /// Longest delay, samples.
    pub(super) most: f64,
    pub(super) zeros: Zeros,
    /// Time constant of a lag that every model has beside its poles, samples; 0 for none.
    pub(super) lag: f64,
}

impl Search<'_> {
    /// Coefficients of the numerator.
    pub(super) fn numerators(&self, order: usize) -> usize {
        if self.zeros == Zeros::Free || order < 3 { order } else { order - 1 }
    }
}

impl Fit {
    pub(super) fn order(&self) -> usize {
        self.parameters.len()
    }

    /// From these poles and this delay, which stays unless it is `free`.
    pub(super) fn new(
        search: &Search<'_>,
        parameters: &[f64],
        delay: f64,
        free: bool,
        steps: usize,
    ) -> Self {
        let q = search.q;
        let n = parameters.len();
        let mut x: Vec<f64> = parameters.to_vec();
        x.push(delay);
        let unknowns = if free { n + 1 } else { n };
        let mut residual = left(search, &x);
        let mut cost = squares(&residual);
        let mut damping = 1e-3;
        for _ in 0..steps {
            let jacobian = jacobian(search, &x, &residual, unknowns);
            let mut gain = 0.0;
            for _ in 0..6 {
                let step = damped(&jacobian, &residual, damping);
                let mut trial = x.clone();
                for (t, s) in trial.iter_mut().zip(&step) {
                    *t += s.clamp(-1.5, 1.5);
                }
                bound(&mut trial, search.most);
                let trial_residual = left(search, &trial);
                let trial_cost = squares(&trial_residual);
                if trial_cost < cost {
                    gain = cost - trial_cost;
                    (x, residual, cost) = (trial, trial_residual, trial_cost);
                    damping = (damping * 0.1).max(1e-10);
                    break;
                }
                damping *= 10.0;
            }
            // What is left to gain is nothing beside the noise.
            if gain <= 1e-3 * (q.least / q.count.max(1) as f64) + 1e-6 * cost {
                break;
            }
        }
        let delay = x.pop().unwrap_or(0.0);
        Self { parameters: x, delay, excess: cost }
    }

    /// Variance of the delay over that of the whitened noise, where all of them are free;
    /// `None` where the data do not determine it.
    pub(super) fn delay_variance(&self, search: &Search<'_>) -> Option<f64> {
        let mut x = self.parameters.clone();
        x.push(self.delay);
        let n = x.len();
        let jacobian = jacobian(search, &x, &left(search, &x), n);
        // The delay's column, what the poles explain of it taken away.
        let mut delay = jacobian.last().cloned().unwrap_or_default();
        let full = squares(&delay);
        let mut orthogonal: Vec<Vec<f64>> = Vec::new();
        for mut column in jacobian.into_iter().take(n - 1) {
            let size = squares(&column);
            without(&mut column, &orthogonal);
            // A pole far beyond the samples moves nothing: no direction to take away.
            let left = squares(&column);
            if left > 1e-8 * size && left > 1e-10 * full {
                column.iter_mut().for_each(|x| *x /= left.sqrt());
                orthogonal.push(column);
            }
        }
        without(&mut delay, &orthogonal);
        let information = squares(&delay);
        (information > 1e-12 * full).then_some(1.0 / information)
    }
}

fn bound(x: &mut [f64], most: f64) {
    let n = x.len() - 1;
    for p in &mut x[..n] {
        *p = p.clamp(BOUNDS.0, BOUNDS.1);
    }
    x[n] = x[n].clamp(0.0, most);
}

/// What the best numerator leaves of the target.
fn left(search: &Search<'_>, x: &[f64]) -> Vec<f64> {
    let q = search.q;
    let n = x.len() - 1;
    let mut a = polynomial(&x[..n]);
    if search.lag > 0.0 {
        a = with_pole(&a, 1.0 / search.lag);
    }
    let columns = basis(&a, x[n], q.target.len());
    let mut residual = q.target.clone();
    let mut orthogonal: Vec<Vec<f64>> = Vec::with_capacity(n);
    for column in columns.into_iter().skip(a.len() - search.numerators(n)) {
        let mut c = q.times(&column);
        let full = squares(&c);
        without(&mut c, &orthogonal);
        let size = squares(&c);
        if size > 1e-20 * full {
            let norm = size.sqrt();
            c.iter_mut().for_each(|x| *x /= norm);
            let along = inner(&c, &residual);
            residual.iter_mut().zip(&c).for_each(|(r, c)| *r -= along * c);
            orthogonal.push(c);
        }
    }
    residual
}

/// Takes what lies along orthonormal columns out of `x`; twice is enough (Kahan and Parlett).
fn without(x: &mut [f64], orthonormal: &[Vec<f64>]) {
    for _ in 0..2 {
        for o in orthonormal {
            let along = inner(o, x);
            x.iter_mut().zip(o).for_each(|(x, o)| *x -= along * o);
        }
    }
}

/// Columns of derivatives of [`left`] by the first unknowns.
fn jacobian(search: &Search<'_>, x: &[f64], residual: &[f64], unknowns: usize) -> Vec<Vec<f64>> {
    const STEP: f64 = 1e-4;
    // The delay is last, and is differenced towards the inside.
    (0..x.len())
        .map(|i| {
            if i >= unknowns {
                return vec![0.0; residual.len()];
            }
            let h = if i + 1 == x.len() && x[i] + STEP > search.most { -STEP } else { STEP };
            let mut moved = x.to_vec();
            moved[i] += h;
            left(search, &moved).iter().zip(residual).map(|(a, b)| (a - b) / h).collect()
        })
        .collect()
}

/// −(JᵀJ + λ·diag)⁻¹ Jᵀ r by Cholesky; a column of zeros gives a zero.
fn damped(columns: &[Vec<f64>], residual: &[f64], damping: f64) -> Vec<f64> {
    let n = columns.len();
    let mut m = vec![vec![0.0; n]; n];
    for i in 0..n {
        for j in 0..=i {
            m[i][j] = inner(&columns[i], &columns[j]);
        }
        m[i][i] = m[i][i] * (1.0 + damping) + f64::MIN_POSITIVE;
    }
    let mut x: Vec<f64> = columns.iter().map(|c| -inner(c, residual)).collect();
    for i in 0..n {
        for j in 0..=i {
            let known: f64 = (0..j).map(|k| m[i][k] * m[j][k]).sum();
            let value = m[i][j] - known;
            m[i][j] = if i == j { value.max(1e-14 * m[i][i]).sqrt() } else { value / m[j][j] };
        }
        let known: f64 = (0..i).map(|k| m[i][k] * x[k]).sum();
        x[i] = (x[i] - known) / m[i][i];
    }
    for i in (0..n).rev() {
        let known: f64 = (i + 1..n).map(|k| m[k][i] * x[k]).sum();
        x[i] = (x[i] - known) / m[i][i];
    }
    x
}

fn squares(x: &[f64]) -> f64 {
    inner(x, x)
}

fn inner(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(x, y)| x * y).sum()
}
