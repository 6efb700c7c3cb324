//! How well the data determine the factor, and which way it was computed for that.
//!
//! Conditions are of variables scaled to equal size (A. van der Sluis, Numerische Mathematik 14,
//! 1969) and about their mean. That of all windows decides how the factor can be computed; data
//! without noise make it infinite. That of the input alone determines what the input excites:
//! beyond [`MOST_OF_INPUT`] shorter windows are used.

use crate::linalg::dense::short_dot;
use faer::MatRef;

/// What an [`Accumulator`](crate::subspace::Accumulator) keeps: sums of the Gram matrix (fast, for data
/// of a condition up to 1e6), or R of a QR factorisation (any data, at about twenty times the work).
pub use steerwright_formats::FactorMethod as Decomposition;

/// Condition of all windows up to which the Gram matrix is trusted.
pub(crate) const MOST_FOR_GRAM: f64 = 1e6;
/// Condition of the input beyond which it is not exciting.
pub(crate) const MOST_OF_INPUT: f64 = 1e12;

/// How the factor was computed, and what of the data decided that.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct Conditioning {
    /// Sums of the Gram matrix and their Cholesky factor, or a QR factorisation.
    pub method: Decomposition,
    /// Condition of the windows of the horizon used; infinite where data without noise depend on each
    /// other.
    pub condition: f64,
    /// Condition of the input's part of the windows of the horizon requested.
    pub input_condition: f64,
    /// The horizon that was requested.
    pub requested_horizon: usize,
    /// The horizon used: the longest up to that which the input excites.
    pub horizon: usize,
}

impl Conditioning {
    /// Whether the input does not excite the horizon that was requested.
    #[must_use]
    pub fn is_reduced(&self) -> bool {
        self.horizon < self.requested_horizon
    }
}

impl std::fmt::Display for Conditioning {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self {
            method,
            condition,
            input_condition: input,
            requested_horizon: requested,
            horizon,
        } = *self;
        match method {
            _ if self.is_reduced() => write!(
                f,
                "this input does not excite {} samples of past and future (condition {input:.1e}): the horizon is reduced from {requested} to {horizon}",
                2 * requested
            ),
            Decomposition::Gram => write!(f, "Gram matrix, condition {condition:.1e}"),
            Decomposition::Qr => write!(
                f,
                "QR factorisation, condition {condition:.1e}, that of the input {input:.1e}"
            ),
        }
    }
}

/// Condition, within a small factor from below, of a lower triangular matrix with rows scaled to
/// unit length: power and inverse iteration.
pub(crate) fn condition(l: MatRef<'_, f64>) -> f64 {
    let size = l.nrows();
    let scale: Vec<f64> = (0..size).map(|i| 1.0 / l.row(i).norm_l2()).collect();
    if size == 0 || scale.iter().any(|s| !s.is_finite()) {
        return if size == 0 { 1.0 } else { f64::INFINITY };
    }
    // Columns of the scaled matrix lie side by side in memory.
    let mut columns = vec![0.0; size * size];
    for (j, column) in columns.chunks_exact_mut(size).enumerate() {
        for i in j..size {
            column[i] = l[(i, j)] * scale[i];
        }
    }
    let diagonal = || (0..size).map(|j| columns[j * size + j]);
    if diagonal().any(|d| d == 0.0) {
        return f64::INFINITY;
    }
    let start = || (0..size).map(|i| if i % 2 == 0 { 1.0 } else { -0.7 }).collect::<Vec<f64>>();
    let largest = grow(start(), |x| {
        // x := L (Lᵀ x)
        let mut product = vec![0.0; size];
        for (j, column) in columns.chunks_exact(size).enumerate() {
            let dot = short_dot(&column[j..], &x[j..]);
            product[j..].iter_mut().zip(&column[j..]).for_each(|(p, c)| *p += c * dot);
        }
        *x = product;
    });
    let smallest = grow(start(), |x| {
        // x := L⁻ᵀ (L⁻¹ x)
        for (j, column) in columns.chunks_exact(size).enumerate() {
            x[j] /= column[j];
            let (done, rest) = x.split_at_mut(j + 1);
            rest.iter_mut().zip(&column[j + 1..]).for_each(|(r, c)| *r -= c * done[j]);
        }
        for (j, column) in columns.chunks_exact(size).enumerate().rev() {
            let dot = short_dot(&column[j + 1..], &x[j + 1..]);
            x[j] = (x[j] - dot) / column[j];
        }
    });
    let condition = (largest * smallest).sqrt();
    if condition.is_finite() { condition } else { f64::INFINITY }
}

/// Growth of a vector in the last of a few applications of `apply`.
fn grow(mut x: Vec<f64>, mut apply: impl FnMut(&mut Vec<f64>)) -> f64 {
    const STEPS: usize = 4;
    let mut growth = 0.0;
    for _ in 0..STEPS {
        let norm = short_dot(&x, &x).sqrt();
        x.iter_mut().for_each(|v| *v /= norm);
        apply(&mut x);
        growth = short_dot(&x, &x).sqrt();
    }
    growth
}
