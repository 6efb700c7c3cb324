//! SSARX: the state from canonical correlations after what is known of the future is taken out (M.
//! Jansson, *Subspace identification and ARX modeling*, IFAC SYSID 2003).
//!
//! With Φ̃ and Ψ̃ block Toeplitz of D and the predictor Markov parameters, `ỹ_f = y_f − Φ̃ u_f − Ψ̃
//! y_f = Γ̃ T z_p + e_f` is a regression of low rank on the past: the state is S^{1/2} Vᵀ of `(Ỹ
//! Ỹᵀ)^{−1/2} Ỹ Zᵀ (Z Zᵀ)^{−1/2} = U S Vᵀ`, times (Z Zᵀ)^{−1/2} Z.

use crate::Error;
use crate::linalg::dense::{RANK_TOLERANCE, Svd, svd};
use crate::subspace::closed_loop::Predictor;
use crate::subspace::closed_loop::windows::{Signals, Windows};
use faer::{Mat, MatRef};

/// The map from z_p to the states, rows by falling canonical correlation, and these.
pub(crate) fn states(
    windows: &Windows,
    predictor: &Predictor,
    future: usize,
) -> Result<(Mat<f64>, Vec<f64>), Error> {
    let past = predictor.past();
    let z = windows.take(0..past, Signals::Z);
    let rest = without_the_known(windows, predictor, future);
    let (from_past, weight) = whitened(z.as_ref())?;
    let (from_future, _) = whitened(rest.as_ref())?;
    let f = svd((from_future.transpose() * &from_past).as_ref())?;
    let vt = Mat::from_fn(f.s.len(), f.v.nrows(), |i, j| f.v[(j, i)] * f.s[i].sqrt());
    Ok((vt * weight.transpose(), f.s))
}

/// ỹ_f, samples by f·ny.
fn without_the_known(windows: &Windows, predictor: &Predictor, future: usize) -> Mat<f64> {
    let (p, past) = (windows.outputs, predictor.past());
    let mut out = windows.take(past..past + future, Signals::Y);
    for row in 0..future {
        let now = past + row;
        let mut known = windows.take(now..now + 1, Signals::U) * predictor.feedthrough.transpose();
        for j in 1..=row.min(past) {
            known += windows.take(now - j..now - j + 1, Signals::Z)
                * predictor.markov[j - 1].transpose();
        }
        let mut part = out.get_mut(.., row * p..(row + 1) * p);
        part -= known;
    }
    out
}

/// An orthonormal basis of the column space of `m`, and the matrix that makes it of `m`.
fn whitened(m: MatRef<'_, f64>) -> Result<(Mat<f64>, Mat<f64>), Error> {
    let Svd { u, s, v } = svd(m)?;
    let cut = RANK_TOLERANCE * s.first().copied().unwrap_or(0.0);
    let rank = s.iter().take_while(|x| **x > cut).count();
    let weight = Mat::from_fn(v.nrows(), rank, |i, j| v[(i, j)] / s[j]);
    Ok((u.get(.., ..rank).to_owned(), weight))
}
