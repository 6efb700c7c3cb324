//! Standard errors that hold for errors of any autocorrelation: the sandwich `H⁻¹·(M + P)·H⁻¹` with the
//! information H of data and priors, the priors' information P, and the long-run covariance M of the
//! scores `J_t·e_t` with Bartlett's weights (Newey and West, *A simple, positive semi-definite,
//! heteroskedasticity and autocorrelation consistent covariance matrix*, Econometrica 55, 1987), over the
//! lags of Andrews's rule (*Heteroskedasticity and autocorrelation consistent covariance matrix
//! estimation*, Econometrica 59, 1991).
//!
//! A few seconds near the limit of grip may determine most of a parameter; the fit then follows the errors
//! of these seconds, which become smaller than they were. The scores of each second are enlarged for that:
//! by `(I − H_b·H⁻¹)⁻¹` with the second's own information H_b, as the jackknife does (Bell and McCaffrey,
//! *Bias reduction in standard errors for linear regression with multi-stage samples*, Survey Methodology
//! 28, 2002).

use crate::Error;
use crate::linalg::dense::pseudo_inverse;
use crate::structures::single_track::parameters::COUNT;
use crate::structures::single_track::problem::{Densities, OUTPUTS, Point, Problem};
use crate::structures::single_track::simulate::Run;
use faer::{Mat, Side};

/// Covariance of the coordinates; zero for those that are fixed.
pub(super) type Covariance = [[f64; COUNT]; COUNT];

/// Time over which scores are summed, s.
const BIN_S: f64 = 1.0;
/// Largest share of the drive that correlations last.
const LARGEST_LAG: f64 = 0.2;
/// Largest share of its own information that a bin is supposed to have in any direction.
const LARGEST_LEVERAGE: f64 = 0.95;

/// What a second of the drive adds.
#[derive(Clone)]
struct Bin {
    score: Point,
    information: Covariance,
    /// Sums of the outputs' errors.
    errors: [f64; OUTPUTS],
}

/// The covariance of an estimate.
pub(super) fn covariance(
    problem: &Problem<'_>,
    p: &Point,
    densities: &Densities,
    run: &Run,
) -> Result<Covariance, Error> {
    let failed = || Error::Numerical { what: "the covariance of the single-track model" };
    let segments = bins(problem, p, densities, run).ok_or_else(failed)?;
    let free = &problem.free;
    let n = free.len();
    // In priors' deviations, so that nothing depends on units.
    let scale = |j: usize| problem.priors[free[j]].deviation;
    let scaled =
        |m: &Covariance| Mat::from_fn(n, n, |i, j| m[free[i]][free[j]] * scale(i) * scale(j));
    // With the priors, whose information is 1 in these units.
    let mut information: Mat<f64> = Mat::identity(n, n);
    for bin in segments.iter().flatten() {
        information += scaled(&bin.information);
    }
    let inverse = pseudo_inverse(information.as_ref(), 1e-15)?;
    let root = information.llt(Side::Lower).map_err(|_| failed())?.L().to_owned();
    let mut middle: Mat<f64> = Mat::identity(n, n);
    let lags = lags(&segments);
    for segment in &segments {
        let mut scores = Mat::zeros(segment.len(), n);
        for (t, bin) in segment.iter().enumerate() {
            let score = Mat::from_fn(n, 1, |j, _| bin.score[free[j]] * scale(j));
            let score = enlarged(&root, &scaled(&bin.information), &score).ok_or_else(failed)?;
            scores.row_mut(t).copy_from(score.transpose().row(0));
        }
        middle += scores.transpose() * &scores;
        for lag in 1..=lags.min(segment.len().saturating_sub(1)) {
            let weight = 1.0 - lag as f64 / (lags as f64 + 1.0);
            let cross = scores.get(lag.., ..).transpose() * scores.get(..segment.len() - lag, ..);
            middle += Mat::from_fn(n, n, |i, j| weight * (cross[(i, j)] + cross[(j, i)]));
        }
    }
    let sandwich = &inverse * middle * &inverse;
    let mut all = [[0.0; COUNT]; COUNT];
    for (i, &row) in free.iter().enumerate() {
        for (j, &column) in free.iter().enumerate() {
            all[row][column] = sandwich[(i, j)] * scale(i) * scale(j);
        }
    }
    Ok(all)
}

/// The bins of each segment; `None` where the simulation leaves all bounds.
fn bins(
    problem: &Problem<'_>,
    p: &Point,
    densities: &Densities,
    run: &Run,
) -> Option<Vec<Vec<Bin>>> {
    let period = problem.period(run);
    let per_bin = (BIN_S / period).round().max(1.0) as usize;
    let empty =
        Bin { score: [0.0; COUNT], information: [[0.0; COUNT]; COUNT], errors: [0.0; OUTPUTS] };
    let mut all: Vec<Vec<Bin>> = vec![Vec::new(); problem.segments.len()];
    let mut filled = vec![0_usize; problem.segments.len()];
    let finite = problem.sensitivities(p, run, |segment, outputs| {
        if filled[segment].is_multiple_of(per_bin) {
            all[segment].push(empty.clone());
        }
        filled[segment] += 1;
        let Some(bin) = all[segment].last_mut() else { return };
        for (i, output) in outputs.iter().enumerate() {
            let Some((error, by)) = output else { continue };
            bin.errors[i] += error;
            let weight = period / densities[i];
            for (j, b) in by.iter().enumerate() {
                let weighted = weight * b;
                bin.score[j] += weighted * error;
                for (h, c) in bin.information[j].iter_mut().zip(by) {
                    *h += weighted * c;
                }
            }
        }
    });
    finite.then_some(all)
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

/// Lags of Bartlett's weights by Andrews's rule for the most lasting output.
fn lags(segments: &[Vec<Bin>]) -> usize {
    let count: usize = segments.iter().map(Vec::len).sum();
    let correlation = |i: usize| {
        let product = |lag: usize| -> f64 {
            let of = |bins: &Vec<Bin>| -> f64 {
                bins.iter().zip(bins.iter().skip(lag)).map(|(a, b)| a.errors[i] * b.errors[i]).sum()
            };
            segments.iter().map(of).sum()
        };
        let variance = product(0);
        if variance > 0.0 { (product(1) / variance).clamp(0.0, 0.95) } else { 0.0 }
    };
    let rho = (0..OUTPUTS).map(correlation).fold(0.0, f64::max);
    let alpha = 4.0 * rho * rho / ((1.0 - rho) * (1.0 + rho)).powi(2);
    let lags = 1.1447 * (alpha * count as f64).cbrt();
    lags.min(LARGEST_LAG * count as f64).ceil() as usize
}
