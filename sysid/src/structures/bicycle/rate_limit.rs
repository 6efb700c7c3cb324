//! The largest rate of the road wheels as a parameter of the bicycle.

use crate::Error;
use crate::structures::bicycle::estimate::{COMPARED, Estimate, Problem};
use crate::structures::bicycle::parameters::{LAG, RATE, STEERING_FACTOR};
use crate::structures::rate_limit::{LAGS, fastest, is_worth_it, rates};

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
    let rates = rates(fastest);
    let mut best: Option<Estimate> = None;
    for over in LAGS {
        let tried = rates.clone().filter_map(|rate| {
            let mut from = without.clone();
            from.parameters[RATE] = rate.ln();
            from.parameters[LAG] += over.ln();
            limited.weighed(from)
        });
        let Some(from) = tried.min_by(|a, b| a.cost.total_cmp(&b.cost)) else { continue };
        let found = limited.refine(from, COMPARED)?;
        if best.as_ref().is_none_or(|best| found.cost < best.cost) {
            best = Some(found);
        }
    }
    let Some(best) = best else { return Ok(None) };
    if !is_better(problem, without, &best) {
        return Ok(None);
    }
    let found = limited.reweighted(best)?;
    Ok(Some((limited, found)))
}

/// Whether an estimate with a largest rate is better than one without by more than the parameter is worth.
pub(super) fn is_better(problem: &Problem<'_>, without: &Estimate, with: &Estimate) -> bool {
    let s2 = without.long_run_variance;
    let Some(with) = problem.weighed(Estimate { long_run_variance: s2, ..with.clone() }) else {
        return false;
    };
    // Costs are twice the negative logarithm, but for the long-run variance.
    let [without, with] = [without.cost, with.cost].map(|cost| 0.5 * cost / s2);
    is_worth_it(without - with, without, problem.samples())
}
