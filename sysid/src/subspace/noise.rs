//! The noise of a model: its Kalman gain and the covariance of its innovation.

use crate::Error;
use crate::linalg::dense::{RANK_TOLERANCE, pseudo_inverse, vcat};
use crate::model::riccati::kalman_filter;
use crate::model::{StateSpace, free_response};
use crate::subspace::factor::Factor;
use faer::{Mat, MatRef};

/// Residuals [W; V] of the state recursion with the states that Γ sees in the data:
/// X_i = Γ_i⁺(Z_i − H_i U_f), X_{i+1} = Γ_{i−1}⁺(Z_{i+1} − H_{i−1} U_f⁻).
fn recursion_residuals(
    factor: &Factor,
    model: &StateSpace,
    gamma: MatRef<'_, f64>,
) -> Result<Mat<f64>, Error> {
    let (m, p, s) = (factor.inputs, factor.outputs, factor.horizon);
    let (past, future) = (factor.past(), factor.future());
    let width = future + p;
    let h = toeplitz(model, gamma, s);
    let l = &factor.l;
    let mut z = l.get(future.., ..width).to_owned();
    for j in future..width {
        for i in 0..z.nrows() {
            z[(i, j)] = 0.0;
        }
    }
    let u = l.get(..past, ..width);
    let x = pseudo_inverse(gamma, RANK_TOLERANCE)? * (z - &h * u);
    let z_next = l.get(future + p.., ..width);
    let short = (s - 1) * p;
    let h_next = h.get(..short, ..(s - 1) * m);
    let x_next = pseudo_inverse(gamma.get(..short, ..), RANK_TOLERANCE)?
        * (z_next - h_next * l.get(m..past, ..width));
    let now = l.get(..m, ..width);
    let w = x_next - &model.a * &x - &model.b * now;
    let v = l.get(future..future + p, ..width) - &model.c * &x - &model.d * now;
    Ok(vcat(&[w.as_ref(), v.as_ref()]))
}

/// Block Toeplitz matrix of D and Γ's rows times B, s·ny by s·nu.
fn toeplitz(model: &StateSpace, gamma: MatRef<'_, f64>, s: usize) -> Mat<f64> {
    let (m, p) = (model.inputs(), model.outputs());
    let gb = gamma * &model.b;
    Mat::from_fn(s * p, s * m, |i, j| {
        let (row, column) = (i / p, j / m);
        match row.cmp(&column) {
            std::cmp::Ordering::Less => 0.0,
            std::cmp::Ordering::Equal => model.d[(i % p, j % m)],
            std::cmp::Ordering::Greater => gb[((row - column - 1) * p + i % p, j % m)],
        }
    })
}

/// Kalman gain and innovation covariance of a model.
#[derive(Debug, Clone, PartialEq)]
pub struct NoiseModel {
    /// K, n by ny.
    pub gain: Mat<f64>,
    /// Covariance of the innovation, ny by ny.
    pub innovation: Mat<f64>,
    /// Whether the gain is the solution of the Riccati equation; otherwise it is zero, and A − K C = A.
    pub solved: bool,
}

/// The noise of `model` from the covariances of the recursion's residuals and the Riccati equation.
///
/// # Errors
/// [`Error::Numerical`] where a decomposition does not converge.
pub fn noise_model(factor: &Factor, model: &StateSpace) -> Result<NoiseModel, Error> {
    let n = model.order();
    let gamma = free_response(model, factor.horizon);
    let residuals = recursion_residuals(factor, model, gamma.as_ref())?;
    let covariance = &residuals * residuals.transpose();
    let q = covariance.get(..n, ..n);
    let s = covariance.get(..n, n..);
    let r = covariance.get(n.., n..);
    let future = factor.future();
    let y = factor.l.get(future..future + factor.outputs, ..);
    // Data without noise leave rounding here, of which no filter can be made.
    let noisy = (0..r.nrows()).all(|i| r[(i, i)] > 1e-18 * y.row(i).squared_norm_l2());
    let filter =
        if noisy { kalman_filter(model.a.as_ref(), model.c.as_ref(), q, r, s) } else { None };
    Ok(match filter {
        Some(f) => NoiseModel { gain: f.gain, innovation: f.innovation, solved: true },
        None => NoiseModel {
            gain: Mat::zeros(n, factor.outputs),
            innovation: r.to_owned(),
            solved: false,
        },
    })
}
