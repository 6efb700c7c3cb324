//! PBSID-opt: the state from the predictor Markov parameters (A. Chiuso, *The role of vector
//! autoregressive modeling in predictor-based subspace identification*, Automatica 43, 2007). Block
//! row i of ΓK is (Ξ_p … Ξ_1) shifted by i, with zeros for Ãᵖ ≈ 0; ΓK Z_p = U S Vᵀ over the data,
//! and the state is S^{1/2} Vᵀ = S^{−1/2} Uᵀ ΓK Z_p.

use crate::Error;
use crate::linalg::dense::{RANK_TOLERANCE, svd};
use crate::subspace::closed_loop::Predictor;
use crate::subspace::closed_loop::windows::{Signals, Windows};
use faer::Mat;

/// The map from z_p to the states (rows in order of the singular values) and the singular values.
pub(crate) fn states(
    windows: &Windows,
    predictor: &Predictor,
    future: usize,
) -> Result<(Mat<f64>, Vec<f64>), Error> {
    let (p, width, past) = (windows.outputs, windows.channels(), predictor.past());
    let product = Mat::from_fn(future * p, past * width, |i, j| {
        let (row, lag) = (i / p, j / width);
        if lag < row { 0.0 } else { predictor.markov[past - 1 - (lag - row)][(i % p, j % width)] }
    });
    let z = windows.take(0..past, Signals::Z);
    let f = svd((&product * z.transpose()).as_ref())?;
    let cut = RANK_TOLERANCE * f.s.first().copied().unwrap_or(0.0);
    let inverse = |s: f64| if s > cut { 1.0 / s.sqrt() } else { 0.0 };
    let ut = Mat::from_fn(f.s.len(), f.u.nrows(), |i, j| f.u[(j, i)] * inverse(f.s[i]));
    Ok((ut * product, f.s))
}
