//! The covariance of an estimate whose errors may be correlated over time: the sandwich `H⁻¹·(M + P)·H⁻¹` with the
//! information H of data and priors, the priors' information P, and the long-run covariance M of the scores with
//! Bartlett's weights (Newey and West, *A simple, positive semi-definite, heteroskedasticity and autocorrelation
//! consistent covariance matrix*, Econometrica 55, 1987), over the lags of Andrews's rule (*Heteroskedasticity and
//! autocorrelation consistent covariance matrix estimation*, Econometrica 59, 1991).
//!
//! The scores of each bin are enlarged by `(I − H_b·H⁻¹)⁻¹` with the bin's own information H_b, as the jackknife does
//! (Bell and McCaffrey, *Bias reduction in standard errors for linear regression with multi-stage samples*, Survey
//! Methodology 28, 2002): the fit follows the errors of a bin that determines most of a parameter.

use crate::Error;
use crate::linalg::dense::pseudo_inverse;
use faer::{Mat, Side};

/// Largest share of the drive that correlations last.
const LARGEST_LAG: f64 = 0.2;
/// Largest share of its own information that a bin is supposed to have in any direction.
const LARGEST_LEVERAGE: f64 = 0.95;

/// What a bin of time adds, in units of the priors' deviations: n numbers, and n by n.
pub(crate) struct ScoreBin {
    pub(crate) score: Mat<f64>,
    pub(crate) information: Mat<f64>,
}

/// The covariance, n by n, from the bins of each segment; the priors' information is 1 in these units.
pub(crate) fn sandwich(
    segments: &[Vec<ScoreBin>],
    n: usize,
    lags: usize,
    failed: impl Fn() -> Error,
) -> Result<Mat<f64>, Error> {
    let mut information: Mat<f64> = Mat::identity(n, n);
    for bin in segments.iter().flatten() {
        information += &bin.information;
    }
    let inverse = pseudo_inverse(information.as_ref(), 1e-15)?;
    let root = information.llt(Side::Lower).map_err(|_| failed())?.L().to_owned();
    let mut middle: Mat<f64> = Mat::identity(n, n);
    for segment in segments {
        let mut scores = Mat::zeros(segment.len(), n);
        for (t, bin) in segment.iter().enumerate() {
            let score = enlarged(&root, &bin.information, &bin.score).ok_or_else(&failed)?;
            scores.row_mut(t).copy_from(score.transpose().row(0));
        }
        middle += scores.transpose() * &scores;
        for lag in 1..=lags.min(segment.len().saturating_sub(1)) {
            let weight = 1.0 - lag as f64 / (lags as f64 + 1.0);
            let cross = scores.get(lag.., ..).transpose() * scores.get(..segment.len() - lag, ..);
            middle += Mat::from_fn(n, n, |i, j| weight * (cross[(i, j)] + cross[(j, i)]));
        }
    }
    Ok(&inverse * middle * &inverse)
}

/// `L·(I − L⁻¹·H_b·L⁻ᵀ)⁻¹·L⁻¹·g` with `H = L·Lᵀ`.
fn enlarged(root: &Mat<f64>, information: &Mat<f64>, score: &Mat<f64>) -> Option<Mat<f64>> {
    let n = root.nrows();
    let solve = |m: &Mat<f64>| {
        let mut x = m.clone();
        faer::linalg::triangular_solve::solve_lower_triangular_in_place(
            root.as_ref(),
            x.as_mut(),
            faer::Par::Seq,
        );
        x
    };
    let half = solve(information);
    let share = solve(&half.transpose().to_owned());
    let share = Mat::from_fn(n, n, |i, j| 0.5 * (share[(i, j)] + share[(j, i)]));
    let eigen = share.self_adjoint_eigen(Side::Lower).ok()?;
    let (u, s) = (eigen.U(), eigen.S().column_vector());
    let mut along = u.transpose() * solve(score);
    for k in 0..n {
        along[(k, 0)] /= 1.0 - s[k].clamp(0.0, LARGEST_LEVERAGE);
    }
    Some(root * (u * along))
}

/// Lags of Bartlett's weights by Andrews's rule for a correlation `rho` from one bin to the next, of `count` bins.
pub(crate) fn andrews_lags(rho: f64, count: usize) -> usize {
    let alpha = 4.0 * rho * rho / ((1.0 - rho) * (1.0 + rho)).powi(2);
    let lags = 1.1447 * (alpha * count as f64).cbrt();
    lags.min(LARGEST_LAG * count as f64).ceil() as usize
}
