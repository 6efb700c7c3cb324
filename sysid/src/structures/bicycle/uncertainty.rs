//! Standard errors that hold for errors of any autocorrelation: the sandwich `H⁻¹·(M + s²·P)·H⁻¹`
//! of docs/methods/bicycle.md, H the information after each segment's initial states are
//! eliminated, M the long-run covariance of the scores J_t·e_t with Bartlett's weights (Newey and
//! West 1987). These take off what lasts longer than their bandwidth, so M is the larger, direction
//! by direction, of that and the scatter of the scores' sums over blocks of time ([`larger`]).

use crate::Error;
use crate::linalg::dense::{pseudo_inverse, svd};
use crate::pem::larger;
use crate::structures::bicycle::estimate::{Estimate, Problem};
use crate::structures::bicycle::parameters::{
    ALL, DELAY, FRONT, INDEX, LAG, PARAMETERS, REAR, STEERING_FACTOR, WHEELBASE,
};
use faer::{Mat, Side};
use steerwright_formats::VehicleDirection;

const OWN: usize = ALL - PARAMETERS;
/// Blocks of time whose scores are summed.
const BLOCKS: usize = 20;
/// Relative standard error of the yaw rate's gain beyond which it is undetermined.
pub(super) const LARGEST_ERROR: f64 = 0.15;

/// Covariance of all parameters, zero for those that are not free.
pub(super) fn covariance(
    problem: &Problem<'_>,
    at: &Estimate,
) -> Result<[[f64; PARAMETERS]; PARAMETERS], Error> {
    let n = problem.free.len();
    let mut information: Mat<f64> = Mat::zeros(n, n);
    let mut scores: Mat<f64> = Mat::zeros(n, n);
    let mut blocks: Mat<f64> = Mat::zeros(n, BLOCKS);
    let mut before = 0;
    let errors = problem
        .errors(&at.parameters, &at.initial_states)
        .ok_or(Error::Numerical { what: "simulation of the estimate" })?;
    let variance =
        errors.iter().flatten().map(|e| e * e).sum::<f64>() / problem.samples().max(1) as f64;
    let lags = bandwidth(problem.samples(), at.long_run_variance / variance);
    for ((segment, start), errors) in problem.segments.iter().zip(&at.initial_states).zip(&errors) {
        let found = problem
            .sensitivities(&at.parameters, segment, start)
            .ok_or(Error::Numerical { what: "simulation of the estimate" })?;
        let count = segment.len();
        let own = Mat::from_fn(count, OWN, |t, j| found.by[t][PARAMETERS + j]);
        let all = Mat::from_fn(count, n, |t, j| found.by[t][problem.free[j]]);
        // What the initial states explain is no information.
        let inner = pseudo_inverse((own.transpose() * &own).as_ref(), 1e-12)?;
        let rest = &all - &own * (inner * (own.transpose() * &all));
        information += rest.transpose() * &rest;
        let score = Mat::from_fn(count, n, |t, j| rest[(t, j)] * errors[t]);
        scores += score.transpose() * &score;
        for t in 0..count {
            let block = (before + t) * BLOCKS / problem.samples();
            for j in 0..n {
                blocks[(j, block)] += score[(t, j)];
            }
        }
        before += count;
        for lag in 1..=lags.min(count.saturating_sub(1)) {
            let weight = 1.0 - lag as f64 / (lags as f64 + 1.0);
            let cross = score.get(lag.., ..).transpose() * score.get(..count - lag, ..);
            scores += Mat::from_fn(n, n, |i, j| weight * (cross[(i, j)] + cross[(j, i)]));
        }
    }
    let s2 = at.long_run_variance;
    scores = lasting(&scores, &blocks)?;
    for (j, &i) in problem.free.iter().enumerate() {
        let prior = s2 / problem.priors[i].deviation.powi(2);
        information[(j, j)] += prior;
        scores[(j, j)] += s2 * prior;
    }
    // Scaled to a unit diagonal, so that the inverse does not depend on units.
    let scale: Vec<f64> =
        (0..n).map(|i| information[(i, i)].max(f64::MIN_POSITIVE).sqrt()).collect();
    let scaled = Mat::from_fn(n, n, |i, j| information[(i, j)] / (scale[i] * scale[j]));
    let inverse = pseudo_inverse(scaled.as_ref(), 1e-13)?;
    let middle = Mat::from_fn(n, n, |i, j| scores[(i, j)] / (scale[i] * scale[j]));
    let small = &inverse * middle * &inverse;
    let mut all = [[0.0; PARAMETERS]; PARAMETERS];
    for (i, &row) in problem.free.iter().enumerate() {
        for (j, &column) in problem.free.iter().enumerate() {
            all[row][column] = small[(i, j)] / (scale[i] * scale[j]);
        }
    }
    Ok(all)
}

/// The larger, in each direction, of `scores` and `B/(B − 1)·Σ (z_b − z̄)(z_b − z̄)ᵀ`.
fn lasting(scores: &Mat<f64>, blocks: &Mat<f64>) -> Result<Mat<f64>, Error> {
    let (n, count) = (blocks.nrows(), blocks.ncols() as f64);
    let scale: Vec<f64> = (0..n).map(|i| scores[(i, i)].max(f64::MIN_POSITIVE).sqrt()).collect();
    let scaled = Mat::from_fn(n, n, |i, j| {
        scores[(i, j)] / (scale[i] * scale[j]) + if i == j { 1e-12 } else { 0.0 }
    });
    let Ok(root) = scaled.llt(Side::Lower) else { return Ok(scores.clone()) };
    // [`larger`] takes the deviations of a jackknife, which are smaller by (B − 1)/B.
    let deviations = Mat::from_fn(n, blocks.ncols(), |i, b| {
        let mean = (0..blocks.ncols()).map(|b| blocks[(i, b)]).sum::<f64>() / count;
        count / (count - 1.0) * (blocks[(i, b)] - mean) / scale[i]
    });
    let root = larger(&root.L().to_owned(), &deviations)?;
    Ok(Mat::from_fn(n, n, |i, j| {
        let product: f64 = (0..root.ncols()).map(|k| root[(i, k)] * root[(j, k)]).sum();
        product * scale[i] * scale[j]
    }))
}

/// Lags by Newey and West's rule, or several times the errors' correlation time.
fn bandwidth(samples: usize, correlation: f64) -> usize {
    let n = samples as f64;
    let short = 4.0 * (n / 100.0).powf(2.0 / 9.0);
    let long = if correlation > 2.0 { 3.0 * correlation } else { 0.0 };
    short.max(long).min(0.1 * n).ceil() as usize
}

/// The principal axes of the parameters' covariance, as changes of the logarithms of the vehicle's
/// data ([`crate::structures::bicycle::parameters::vehicle`]) and changes of its delay, without offsets.
pub(super) fn covariance_factor(
    covariance: &[[f64; PARAMETERS]; PARAMETERS],
) -> Result<Vec<VehicleDirection>, Error> {
    const OF_VEHICLE: [usize; 7] = [FRONT, REAR, WHEELBASE, INDEX, LAG, DELAY, STEERING_FACTOR];
    let n = OF_VEHICLE.len();
    let own = Mat::from_fn(n, n, |i, j| covariance[OF_VEHICLE[i]][OF_VEHICLE[j]]);
    let axes = svd(own.as_ref())?;
    let largest = axes.s.first().copied().unwrap_or(0.0);
    let direction = |k: usize| {
        let deviation = axes.s[k].sqrt();
        let p = |parameter: usize| {
            let place = OF_VEHICLE.iter().position(|&own| own == parameter);
            place.map_or(0.0, |i| axes.u[(i, k)] * deviation)
        };
        let stiffness = |axle: usize| p(axle) + p(INDEX) + p(WHEELBASE);
        VehicleDirection {
            wheelbase: p(WHEELBASE),
            yaw_inertia: p(INDEX) + 2.0 * p(WHEELBASE),
            cornering_stiffness_front: stiffness(FRONT),
            cornering_stiffness_rear: stiffness(REAR),
            actuator_time_constant: p(LAG),
            actuator_delay_s: p(DELAY),
            steering_ratio: -p(STEERING_FACTOR),
        }
    };
    // Those that are not free have no variance.
    Ok((0..n).filter(|&k| axes.s[k] > 1e-12 * largest).map(direction).collect())
}

/// √(gᵀ·C·g).
pub(super) fn deviation(
    gradient: &[f64; PARAMETERS],
    covariance: &[[f64; PARAMETERS]; PARAMETERS],
) -> f64 {
    let form: f64 = (0..PARAMETERS)
        .flat_map(|i| (0..PARAMETERS).map(move |j| (i, j)))
        .map(|(i, j)| gradient[i] * covariance[i][j] * gradient[j])
        .sum();
    form.max(0.0).sqrt()
}
