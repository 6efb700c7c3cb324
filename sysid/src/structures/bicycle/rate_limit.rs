//! The largest rate of the road wheels as a parameter of the bicycle.

use crate::Error;
use crate::structures::bicycle::estimate::{COMPARED, Estimate, Problem};
use crate::structures::bicycle::parameters::{DELAY, LAG, RATE, STEERING_FACTOR};
use crate::structures::rate_limit::{LAGS, fastest, is_worth_it, rates};

/// The estimates of a drive without a delay and with one, each with its problem.
pub(super) struct Estimates<'a> {
    pub(super) prompt: Problem<'a>,
    pub(super) without_delay: Estimate,
    pub(super) delayed: Problem<'a>,
    pub(super) with_delay: Estimate,
}

impl<'a> Estimates<'a> {
    /// With a largest rate where the drive shows one; the problems are without, `delayed` the one with a delay.
    ///
    /// # Errors
    /// [`Error::NoModel`] where nothing follows the drive, [`Error::Numerical`] of the search.
    pub(super) fn new(prompt: Problem<'a>, delayed: Problem<'a>) -> Result<Self, Error> {
        let without_delay = prompt.solve()?;
        let with_delay = delayed.solve_with_delay(&without_delay)?;
        // By its own errors: a prompt wheel errs by the delay, which would hide a limit.
        let judged = delayed.with_own_variance(with_delay.clone());
        let limited = |mut problem: Problem<'a>| {
            problem.free_rate();
            problem
        };
        let mut found: Vec<Self> = Vec::new();
        if let Some((prompt, without_delay)) = rate_limited(&prompt, &without_delay)? {
            let delayed = limited(delayed.clone());
            let with_delay = delayed.solve_with_delay(&without_delay)?;
            found.push(Self { prompt, without_delay, delayed, with_delay });
        }
        if with_delay.parameters[DELAY] > 0.0
            && let Some((delayed, with_delay)) = rate_limited(&delayed, &judged)?
        {
            let prompt = limited(prompt.clone());
            let mut from = with_delay.clone();
            from.parameters[DELAY] = 0.0;
            let without_delay = prompt.solve_from(&from)?;
            found.extend(without_delay.map(|without_delay| Self {
                prompt,
                without_delay,
                delayed,
                with_delay,
            }));
        }
        // A limit may stand for a delay, too.
        found.retain(|found| is_better(&found.delayed, &judged, &found.with_delay));
        // By the errors of the better one: with those of a model without a limit the priors would weigh too much.
        let own = |found: &Self| found.delayed.with_own_variance(found.with_delay.clone());
        let least =
            found.iter().map(|found| own(found).long_run_variance).fold(f64::INFINITY, f64::min);
        let cost = |found: &Self| {
            let judged = Estimate { long_run_variance: least, ..found.with_delay.clone() };
            found.delayed.weighed(judged).map_or(f64::INFINITY, |estimate| estimate.cost)
        };
        let best = found.into_iter().min_by(|a, b| cost(a).total_cmp(&cost(b)));
        Ok(best.unwrap_or(Self { prompt, without_delay, delayed, with_delay }))
    }
}

/// The estimate with a largest rate and its problem, if the drive shows one; `without` is the estimate without.
///
/// # Errors
/// [`Error::Numerical`] of the search.
fn rate_limited<'a>(
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
    // A delay may stand for the limit as a lag may.
    let delay = without.parameters[DELAY];
    let delays = if delay > 0.0 { vec![delay, 0.6 * delay] } else { vec![0.0] };
    let mut best: Option<Estimate> = None;
    for over in LAGS {
        let tried = rates.clone().flat_map(|rate| delays.iter().map(move |delay| (rate, *delay)));
        let tried = tried.filter_map(|(rate, delay)| {
            let mut from = without.clone();
            from.parameters[RATE] = rate.ln();
            from.parameters[LAG] += over.ln();
            from.parameters[DELAY] = delay;
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
fn is_better(problem: &Problem<'_>, without: &Estimate, with: &Estimate) -> bool {
    let s2 = without.long_run_variance;
    let Some(with) = problem.weighed(Estimate { long_run_variance: s2, ..with.clone() }) else {
        return false;
    };
    // Costs are twice the negative logarithm, but for the long-run variance.
    let [without, with] = [without.cost, with.cost].map(|cost| 0.5 * cost / s2);
    is_worth_it(without - with, without, problem.samples())
}
