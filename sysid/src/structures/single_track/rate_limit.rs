//! The largest rate of the road wheels as a parameter of the single-track model.

use crate::linalg::bounded_step::Normal;
use crate::structures::rate_limit::{LAGS, PRIOR, fastest, is_worth_it, rates};
use crate::structures::single_track::parameters::Parameter;
use crate::structures::single_track::problem::Problem;
use crate::structures::single_track::search::{FittedPoint, ON_THE_WAY, search_run, solve};
use crate::structures::single_track::step::refine;

/// The estimate with a largest rate and its problem, if the drive shows one; `found` is the estimate without.
pub(super) fn rate_limited<'a>(
    problem: &Problem<'a>,
    found: &FittedPoint,
) -> Option<(Problem<'a>, FittedPoint)> {
    let [rate, lag] = [Parameter::RateMax, Parameter::Lag].map(Parameter::index);
    let mut limited = problem.clone();
    limited.priors[rate] = Normal::new(Parameter::RateMax, &PRIOR);
    limited.free.push(rate);
    let run = search_run(problem.sample_time);
    let factor = Parameter::SteeringFactor.value(found.point[Parameter::SteeringFactor.index()]);
    let steering = problem.segments.iter().map(|segment| segment.steering_samples());
    let rates = rates(factor * fastest(steering, problem.sample_time));
    let best_with = |over: f64| {
        let tried = rates.clone().filter_map(|most| {
            let mut point = found.point;
            point[rate] = most.ln();
            point[lag] = (point[lag] + over.ln()).max(problem.priors[lag].bounds[0]);
            Some((point, limited.cost(&point, &run, &found.densities)?))
        });
        let (point, _) = tried.min_by(|a, b| a.1.total_cmp(&b.1))?;
        refine(&limited, &point, &found.densities, &run, ON_THE_WAY)
    };
    let refined = LAGS.into_iter().filter_map(best_with);
    let best = refined.min_by(|a, b| a.cost.total_cmp(&b.cost))?;
    let samples = problem.segments.iter().map(|segment| segment.len()).sum();
    let without = problem.cost(&found.point, &run, &found.densities)?;
    if !is_worth_it(without - best.cost, without, samples) {
        return None;
    }
    let with_rate = solve(&limited, Some(&best.point)).ok()?;
    let cost = |problem: &Problem<'_>, point| problem.cost(point, &found.run, &found.densities);
    let without = cost(problem, &found.point)?;
    let gain = without - cost(&limited, &with_rate.point)?;
    if is_worth_it(gain, without, samples) { Some((limited, with_rate)) } else { None }
}
