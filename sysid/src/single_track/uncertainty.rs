//! Standard errors that hold for errors of any autocorrelation: the sandwich `H⁻¹·(M + P)·H⁻¹` with the
//! information H of data and priors, the priors' information P, and the long-run covariance M of the
//! scores `J_t·e_t` with Bartlett's weights (Newey and West, *A simple, positive semi-definite,
//! heteroskedasticity and autocorrelation consistent covariance matrix*, Econometrica 55, 1987).

use crate::Error;
use crate::linalg::dense::pseudo_inverse;
use crate::single_track::noise::Densities;
use crate::single_track::parameters::COUNT;
use crate::single_track::problem::{OUTPUTS, Point, Problem};
use crate::single_track::simulate::Run;
use faer::Mat;

/// Covariance of the coordinates; zero for those that are fixed.
pub(super) type Covariance = [[f64; COUNT]; COUNT];

/// Time over which scores are summed before they are correlated, s.
const BIN_S: f64 = 0.1;
/// Least and largest lag of the correlation, s, and lag over the errors' correlation time.
const LAG_S: [f64; 2] = [0.5, 15.0];
const LAG_PER_CORRELATION_TIME: f64 = 4.0;

/// The covariance of an estimate.
pub(super) fn covariance(
    problem: &Problem<'_>,
    p: &Point,
    densities: &Densities,
    run: &Run,
) -> Result<Covariance, Error> {
    let failed = || Error::Numerical { what: "the covariance of the single-track model" };
    let normals = problem.normals(p, run, densities).ok_or_else(failed)?;
    let period = problem.period(run);
    let bin = (BIN_S / period).round().max(1.0) as usize;
    // Sums of scores over bins, segment by segment, and each output's sum of squares.
    let mut bins: Vec<Vec<Point>> = vec![Vec::new(); problem.segments.len()];
    let mut filled = vec![0_usize; problem.segments.len()];
    let (mut squares, mut count) = ([0.0; OUTPUTS], 0.0);
    let finite = problem.sensitivities(p, run, |segment, outputs| {
        if filled[segment].is_multiple_of(bin) {
            bins[segment].push([0.0; COUNT]);
        }
        filled[segment] += 1;
        count += 1.0;
        let Some(score) = bins[segment].last_mut() else { return };
        for (i, output) in outputs.iter().enumerate() {
            let Some((error, by)) = output else { continue };
            squares[i] += error * error;
            let weighted = error * period / densities[i];
            for (s, b) in score.iter_mut().zip(by) {
                *s += weighted * b;
            }
        }
    });
    if !finite {
        return Err(failed());
    }
    // How long the errors last: their density over their variance.
    let lasting = |i: usize| {
        if problem.fitted[i] && squares[i] > 0.0 { densities[i] * count / squares[i] } else { 0.0 }
    };
    let correlation_s = (0..OUTPUTS).map(lasting).fold(0.0, f64::max);
    let duration_s = count * period;
    let lag_s =
        (LAG_PER_CORRELATION_TIME * correlation_s).clamp(LAG_S[0], LAG_S[1]).min(0.1 * duration_s);
    let lags = (lag_s / (bin as f64 * period)).round() as usize;
    let free = &problem.free;
    let n = free.len();
    let mut middle: Mat<f64> = Mat::zeros(n, n);
    for bins in &bins {
        let scores = Mat::from_fn(bins.len(), n, |t, j| bins[t][free[j]]);
        middle += scores.transpose() * &scores;
        for lag in 1..=lags.min(bins.len().saturating_sub(1)) {
            let weight = 1.0 - lag as f64 / (lags as f64 + 1.0);
            let cross = scores.get(lag.., ..).transpose() * scores.get(..bins.len() - lag, ..);
            middle += Mat::from_fn(n, n, |i, j| weight * (cross[(i, j)] + cross[(j, i)]));
        }
    }
    for (j, &i) in free.iter().enumerate() {
        middle[(j, j)] += problem.priors[i].deviation.powi(-2);
    }
    // In priors' deviations, so that the inverse does not depend on units.
    let scale = |j: usize| problem.priors[free[j]].deviation;
    let information =
        Mat::from_fn(n, n, |i, j| normals.hessian[free[i]][free[j]] * scale(i) * scale(j));
    let inverse = pseudo_inverse(information.as_ref(), 1e-14)?;
    let middle = Mat::from_fn(n, n, |i, j| middle[(i, j)] * scale(i) * scale(j));
    let sandwich = &inverse * middle * &inverse;
    let mut all = [[0.0; COUNT]; COUNT];
    for (i, &row) in free.iter().enumerate() {
        for (j, &column) in free.iter().enumerate() {
            all[row][column] = sandwich[(i, j)] * scale(i) * scale(j);
        }
    }
    Ok(all)
}
