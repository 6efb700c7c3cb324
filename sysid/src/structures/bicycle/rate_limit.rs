//! The largest rate of the road wheels as a parameter of the bicycle.

use crate::Error;
use crate::structures::bicycle::estimate::{Estimate, Problem};
use crate::structures::bicycle::parameters::{LAG, RATE, STEERING_FACTOR};
use crate::structures::rate_limit::{fastest, is_poor, is_worth_it, trials};

/// The estimate with a largest rate and its problem, if the drive shows one; `without` is the estimate without.
///
/// # Errors
/// [`Error::Numerical`] of the search.
pub(super) fn rate_limited<'a>(
    problem: &Problem<'a>,
    without: &Estimate,
) -> Result<Option<(Problem<'a>, Estimate)>, Error> {
    let mut limited = problem.clone();
    limited.free_rate();
    let steering = problem.segments.iter().map(|segment| segment.steering);
    let Some(sample_time) = problem.segments.first().map(|segment| segment.sample_time) else {
        return Ok(None);
    };
    let fastest = without.parameters[STEERING_FACTOR].exp() * fastest(steering, sample_time);
    let mut best: Option<Estimate> = None;
    for (rate, over) in trials(fastest) {
        let mut from = without.clone();
        from.parameters[RATE] = rate.ln();
        from.parameters[LAG] += over.ln();
        let Some(from) = limited.weighed(from) else { continue };
        if best.as_ref().is_none_or(|best| from.cost < best.cost) {
            best = Some(from);
        }
    }
    let errors = problem.errors(&without.parameters, &without.initial_states).unwrap_or_default();
    let yaw_rate: Vec<f64> = problem.segments.iter().flat_map(|s| s.yaw_rate).copied().collect();
    let is_poor = is_poor(&yaw_rate, &errors.concat());
    let Some(best) = best.filter(|best| is_poor || best.cost < without.cost) else {
        return Ok(None);
    };
    let Some(found) = limited.solve_from(&best)? else { return Ok(None) };
    // Costs are twice the negative logarithm, but for the long-run variance.
    let gain = 0.5 * (without.cost - found.cost) / without.long_run_variance;
    if !is_worth_it(gain, problem.samples()) {
        return Ok(None);
    }
    let found = limited.reweighted(found)?;
    Ok(Some((limited, found)))
}
