//! The largest rate of the road wheels, of a servo that a command outruns.
//!
//! It is no parameter until the drive shows it: a drive that does not reach the limit says nothing about it, and the cost has
//! no slope there. So rates below the fastest of the command are tried, with a faster lag, which stands for the limit until
//! then; the best is where the search goes on with the rate as a parameter. The model with the fewer parameters stays unless
//! the other is better by the Bayesian information criterion.

use crate::linalg::bounded_step::Normal;
use crate::structures::single_track::parameters::Parameter;
use crate::structures::single_track::problem::{Point, Problem};
use crate::structures::single_track::search::{FittedPoint, search_run, solve};
use steerwright_formats::Prior;

/// The prior of a rate that the drive shows: servos of model cars, of road cars and of lorries.
const PRIOR: Prior = Prior { mean: 0.5, standard_deviation: 1.0, min: 0.02, max: 10.0 };
/// Rates that are tried, each as a share of the one before, from that share of the fastest of the command.
const RATES: i32 = 9;
const SHARE: f64 = 0.7;
/// Time constants that are tried with them, over the one that was found without a limit.
const LAGS: [f64; 3] = [1.0, 0.5, 0.15];

/// An estimate with the rate as a parameter, and its problem.
pub(super) struct RateLimited<'a> {
    pub(super) problem: Problem<'a>,
    pub(super) found: FittedPoint,
    pub(super) prior: Prior,
}

/// The estimate with a largest rate, if the drive shows one; `found` is the one without.
pub(super) fn rate_limited<'a>(
    problem: &Problem<'a>,
    found: &FittedPoint,
) -> Option<RateLimited<'a>> {
    let [rate, lag] = [Parameter::RateMax, Parameter::Lag].map(Parameter::index);
    let unlimited = Parameter::RateMax.default_prior();
    // One that is stated is not looked for.
    if problem.free.contains(&rate) || problem.priors[rate].mean != unlimited.mean.ln() {
        return None;
    }
    let with_rate = {
        let mut with_rate = problem.clone();
        with_rate.priors[rate] = Normal::new(Parameter::RateMax, &PRIOR);
        with_rate.free.push(rate);
        with_rate
    };
    let run = search_run(problem.sample_time);
    let factor = Parameter::SteeringFactor.value(found.point[Parameter::SteeringFactor.index()]);
    let fastest =
        factor * problem.segments.iter().map(|s| s.fastest_steering()).fold(0.0, f64::max);
    let mut best: Option<(Point, f64)> = None;
    for power in 1..=RATES {
        for over in LAGS {
            let mut point = found.point;
            let [low, high] = with_rate.priors[rate].bounds;
            point[rate] = (fastest * SHARE.powi(power)).ln().clamp(low, high);
            point[lag] = (point[lag] + over.ln()).max(problem.priors[lag].bounds[0]);
            let Some(cost) = with_rate.cost(&point, &run, &found.densities) else { continue };
            if best.is_none_or(|(_, least)| cost < least) {
                best = Some((point, cost));
            }
        }
    }
    let (point, cost) = best?;
    if cost > problem.cost(&found.point, &run, &found.densities)? {
        return None;
    }
    let limited = solve(&with_rate, Some(&point)).ok()?;
    let cost = |problem: &Problem<'_>, point| problem.cost(point, &found.run, &found.densities);
    let gain = cost(problem, &found.point)? - cost(&with_rate, &limited.point)?;
    let samples: usize = problem.segments.iter().map(|s| s.len()).sum();
    if gain > 0.5 * (samples as f64).ln() {
        Some(RateLimited { problem: with_rate, found: limited, prior: PRIOR })
    } else {
        None
    }
}
