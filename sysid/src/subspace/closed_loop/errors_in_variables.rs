//! Errors in variables: white noise on the sensors of input and output, the loop closed around the
//! true signals (C. T. Chou and M. Verhaegen, *Subspace algorithms for the identification of
//! multivariable dynamic errors-in-variables models*, Automatica 33, 1997).
//!
//! The past z_p is an instrument: `Y_f/Z_p = Γ X/Z_p + H U_f/Z_p` holds with the true Γ and H but
//! for what vanishes as N grows, and the rows of the past lags of the R factor in order of time are
//! these projections. An LQ factorisation takes U_f/Z_p out, the singular vectors of the rest span
//! Γ, and Γ^⊥ᵀ Y_f/Z_p = Γ^⊥ᵀ H(B, D) U_f/Z_p is linear in B and D.
//!
//! An external excitation must move the loop, and the input over the `future` samples must be
//! predictable from the past: a sum of at least `future`/2 sines is; white excitation is not. The
//! result's `excitation` measures how far that holds. Process noise is allowed where it is white.
//! The method has no Kalman gain: in the innovation form u is known.

use crate::Error;
use crate::data::DataSet;
use crate::linalg::dense::{RANK_TOLERANCE, hcat, least_squares, pseudo_inverse, r_factor, svd};
use crate::model::{StateSpace, free_response};
use crate::subspace::closed_loop::windows::{Signals, Windows};
use crate::subspace::closed_loop::{factor, horizons};
use crate::subspace::factor::Factor;
use faer::{Mat, MatRef};

/// The result of the method.
#[derive(Debug, Clone, PartialEq)]
pub struct ErrorsInVariables {
    /// The model.
    pub model: StateSpace,
    /// Singular values of the outputs' part, which determine the order.
    pub singular_values: Vec<f64>,
    /// The least of the future input's directions in the projection on the past, over what chance alone
    /// puts there in a record of this length: below about 3 the past predicts too little of the input
    /// for the method.
    pub excitation: f64,
}

/// Identifies the model of one order from a data set.
///
/// # Errors
/// As [`identify_in`], and [`Error::TooFewSamples`].
pub fn identify(
    data: &DataSet,
    past: usize,
    future: usize,
    order: usize,
    feedthrough: bool,
) -> Result<ErrorsInVariables, Error> {
    identify_in(&factor(data, past, future)?, past, future, order, feedthrough)
}

/// Identifies the model of one order from a factor of `past + future` lags or more.
///
/// # Errors
/// [`Error::Option`] where a horizon is 0 or `future` above `past`, [`Error::OrderAboveHorizon`] where
/// the factor is shorter or the order is not below `future·ny`, [`Error::NoModel`] where a channel
/// does not move, [`Error::Numerical`] where a decomposition fails.
pub fn identify_in(
    factor: &Factor,
    past: usize,
    future: usize,
    order: usize,
    feedthrough: bool,
) -> Result<ErrorsInVariables, Error> {
    horizons(past, future)?;
    let windows = Windows::new(factor)?;
    windows.holds(past + future)?;
    let (m, p) = (windows.inputs, windows.outputs);
    if order == 0 || order + p > future * p {
        return Err(Error::OrderAboveHorizon { order, horizon: future });
    }
    // Columns of R at the future lags; rows of the past lags are the projection on Z_p.
    let rows = past * windows.channels();
    let future_lags = past..past + future;
    let (u_all, y_all) =
        (windows.take(future_lags.clone(), Signals::U), windows.take(future_lags, Signals::Y));
    let rows = rows.min(u_all.nrows());
    let (u, y) = (u_all.get(..rows, ..), y_all.get(..rows, ..));
    let excitation = excitation(u_all.as_ref(), rows, windows.count)?;
    // LQ of [U_f/Z_p; Y_f/Z_p], transposed.
    let r = r_factor(hcat(&[u, y]).as_ref());
    let width = u.ncols();
    let from = width.min(r.nrows());
    let f = svd(r.get(from.., width..).transpose())?;
    if order > f.s.len() {
        return Err(Error::OrderAboveHorizon { order, horizon: future });
    }
    let gamma = Mat::from_fn(future * p, order, |i, j| f.u[(i, j)] * f.s[j].sqrt());
    let short = (future - 1) * p;
    let a = pseudo_inverse(gamma.get(..short, ..), RANK_TOLERANCE)? * gamma.get(p.., ..);
    let c = gamma.get(..p, ..).to_owned();
    let base = StateSpace { a, b: Mat::zeros(order, m), c, d: Mat::zeros(p, m) };
    let model = input_matrices(base, gamma.as_ref(), u, y, feedthrough)?;
    Ok(ErrorsInVariables {
        model: model.scaled(&windows.input_scale, &windows.output_scale),
        singular_values: f.s,
        excitation,
    })
}

/// Least singular value of U_f/Z_p over what chance leaves, a share `rows`/N of the power.
fn excitation(u: MatRef<'_, f64>, rows: usize, count: usize) -> Result<f64, Error> {
    let predicted = svd(u.get(..rows, ..))?;
    let unpredicted = svd(u.get(rows.., ..))?;
    let least = if predicted.s.len() < u.ncols() {
        0.0
    } else {
        predicted.s.last().copied().unwrap_or(0.0)
    };
    let noise = unpredicted.s.first().copied().unwrap_or(0.0);
    let chance = noise * (rows as f64 / (count.max(rows + 1) - rows) as f64).sqrt();
    Ok(if chance > 0.0 { least / chance } else { f64::INFINITY })
}

/// B and D of Γ^⊥ᵀ (Y − H(B, D) U) = 0 by least squares, rows of `u` and `y` as samples.
fn input_matrices(
    base: StateSpace,
    gamma: MatRef<'_, f64>,
    u: MatRef<'_, f64>,
    y: MatRef<'_, f64>,
    feedthrough: bool,
) -> Result<StateSpace, Error> {
    let (n, m, p) = (base.order(), base.inputs(), base.outputs());
    let size = gamma.nrows();
    let future = size / p;
    // The complement of Γ's column space, of its QR factorisation.
    let q = gamma.qr().compute_Q();
    let complement = q.get(.., n..);
    let target = y * complement;
    let cells = target.nrows() * target.ncols();
    let stacked = |x: &Mat<f64>| Mat::from_fn(cells, 1, |k, _| x[(k % x.nrows(), k / x.nrows())]);
    let response = free_response(&base, future);
    let count = m * (n + if feedthrough { p } else { 0 });
    let mut slopes = Mat::zeros(cells, count);
    for index in 0..count {
        let (row, input) = (index / m, index % m);
        // Output over the future samples of a unit in this place of B or D, for each sample's U_f.
        let h = Mat::from_fn(size, future * m, |i, j| {
            let (block, past) = (i / p, j / m);
            if j % m != input {
                0.0
            } else if row >= n {
                if block == past && i % p == row - n { 1.0 } else { 0.0 }
            } else if block > past {
                response[((block - past - 1) * p + i % p, row)]
            } else {
                0.0
            }
        });
        let effect = u * h.transpose() * complement;
        slopes.get_mut(.., index..index + 1).copy_from(stacked(&effect));
    }
    let solution = least_squares(slopes.as_ref(), stacked(&target).as_ref(), RANK_TOLERANCE)?;
    let at = |row: usize, input: usize| solution[(row * m + input, 0)];
    let d = if feedthrough { Mat::from_fn(p, m, |i, j| at(n + i, j)) } else { base.d };
    Ok(StateSpace { a: base.a, b: Mat::from_fn(n, m, at), c: base.c, d })
}
