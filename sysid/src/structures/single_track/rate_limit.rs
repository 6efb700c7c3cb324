//! The largest rate of the road wheels as a parameter of the single-track model.

use crate::linalg::bounded_step::Normal;
use crate::structures::rate_limit::{PRIOR, fastest, is_poor, is_worth_it, trials};
use crate::structures::single_track::parameters::Parameter;
use crate::structures::single_track::problem::{Point, Problem};
use crate::structures::single_track::search::{FittedPoint, search_run, solve};

/// The estimate with a largest rate and its problem, if the drive shows one; `found` is the estimate without.
pub(super) fn rate_limited<'a>(
    problem: &Problem<'a>,
    found: &FittedPoint,
) -> Option<(Problem<'a>, FittedPoint)> {
    let [rate, lag] = [Parameter::RateMax, Parameter::Lag].map(Parameter::index);
    let unlimited = Parameter::RateMax.default_prior();
    // One that is stated is not looked for.
    if problem.free.contains(&rate) || problem.priors[rate].mean != unlimited.mean.ln() {
        return None;
    }
    let mut limited = problem.clone();
    limited.priors[rate] = Normal::new(Parameter::RateMax, &PRIOR);
    limited.free.push(rate);
    let run = search_run(problem.sample_time);
    let factor = Parameter::SteeringFactor.value(found.point[Parameter::SteeringFactor.index()]);
    let steering = problem.segments.iter().map(|segment| segment.steering_samples());
    let mut best: Option<(Point, f64)> = None;
    for (most, over) in trials(factor * fastest(steering, problem.sample_time)) {
        let mut point = found.point;
        point[rate] = most.ln();
        point[lag] = (point[lag] + over.ln()).max(problem.priors[lag].bounds[0]);
        let Some(cost) = limited.cost(&point, &run, &found.densities) else { continue };
        if best.is_none_or(|(_, least)| cost < least) {
            best = Some((point, cost));
        }
    }
    let (point, cost) = best?;
    let [errors, ..] = problem.errors(&found.point, &run)?;
    let yaw_rate: Vec<f64> = problem.segments.iter().flat_map(|s| s.yaw_rate).copied().collect();
    let is_poor = is_poor(&yaw_rate, &errors.concat());
    if !is_poor && cost > problem.cost(&found.point, &run, &found.densities)? {
        return None;
    }
    let with_rate = solve(&limited, Some(&point)).ok()?;
    let cost = |problem: &Problem<'_>, point| problem.cost(point, &found.run, &found.densities);
    let gain = cost(problem, &found.point)? - cost(&limited, &with_rate.point)?;
    let samples = problem.segments.iter().map(|segment| segment.len()).sum();
    if is_worth_it(gain, samples) { Some((limited, with_rate)) } else { None }
}
