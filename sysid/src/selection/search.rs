//! The search for a model over an [`Estimator`]: [data in memory](crate::selection::in_memory) or
//! the R factor of [accumulated drives](crate::structures::state_space::accumulated). Each order's [initial
//! estimates](Estimator::initial_estimates) are refined, and the one of least errors is scored by
//! one-step prediction errors along with a model of the noise ([`Estimator::predict`]). Orders are
//! tried in turn until [`LOOK_AHEAD`] in a row have not lowered the criterion; of orders about as
//! likely, one whose A has a real logarithm (eq 9) goes before one without, and the chosen model is
//! given one where that costs nearly nothing ([`with_logarithm`]).

use crate::Error;
use crate::model::StateSpace;
use crate::model::conversion::{costs_nothing, has_logarithm, off_branch_cut};
use crate::pem::Stop;
use crate::selection::candidate::{Candidate, FINE, ROUGH};
use crate::selection::options::{IdentifyOptions, Method};
use crate::selection::order::{bic, likeliest, of_a_vehicle, parameters};
use crate::subspace::closed_loop::{ClosedLoopMethod, Feedback};

/// Memory and reach of the test for feedback, s: of the vehicle, and of a driver's reaction.
pub(crate) const MEMORY_S: f64 = 2.0;
pub(crate) const AHEAD_S: f64 = 1.0;
/// Orders that are tried beyond the best so far.
const LOOK_AHEAD: usize = 3;
/// Orders up to this one are tried anyhow: modes come in pairs, and the first may show little.
const AT_LEAST: usize = 6;

/// Data that models are estimated from and scored on.
pub(crate) trait Estimator {
    fn options(&self) -> &IdentifyOptions;

    fn counts(&self) -> Counts;

    fn largest_order(&self) -> usize;

    /// The initial estimates of an order that are to be refined, at least one.
    fn initial_estimates(&self, order: usize, feedthrough: bool) -> Result<Vec<Candidate>, Error>;

    fn refine(&self, of: &mut Candidate, stop: Stop) -> Result<(), Error>;

    /// Mean square of the errors that [`refine`](Self::refine) lowers.
    fn mean_square(&self, of: &Candidate) -> Result<f64, Error>;

    /// Fits what is linear in the errors to the poles of a candidate.
    fn refit(&self, of: &mut Candidate) -> Result<(), Error>;

    /// Σ_i ln V_i of the one-step prediction errors along with a model of the noise. Where models are
    /// refined, of the model that makes them least, sought from the candidate's, and that model.
    fn predict(&self, of: &Candidate) -> Result<(f64, Option<StateSpace>), Error>;

    /// Other models to predict from; `first` is the initial estimate, `before` the last order's.
    fn other_models(&self, first: StateSpace, before: Option<&Candidate>) -> Vec<StateSpace>;
}

pub(crate) struct Counts {
    pub(crate) inputs: usize,
    pub(crate) outputs: usize,
    /// Samples with a prediction error.
    pub(crate) samples: f64,
    /// Segments with an initial state of their own.
    pub(crate) segments: usize,
    pub(crate) vehicle: bool,
}

/// The closed-loop methods to be used; none for data of open loop.
pub(crate) fn closed_loop_methods(
    options: &IdentifyOptions,
    feedback: Option<Feedback>,
) -> Vec<ClosedLoopMethod> {
    match options.method {
        Some(Method::ClosedLoop(method)) => vec![method],
        None if feedback.is_some_and(|f| f.detected) => ClosedLoopMethod::ALL.to_vec(),
        _ => Vec::new(),
    }
}

/// An initial estimate of the largest possible order, or of the stated one.
pub(crate) fn largest_estimate(
    options: &IdentifyOptions,
    largest: usize,
    estimate: impl Fn(usize) -> Result<Candidate, Error>,
) -> Result<Candidate, Error> {
    let most = options.order.unwrap_or(options.max_order.min(largest)).max(1);
    let mut last_error = None;
    for order in (1..=most).rev() {
        match estimate(order) {
            Ok(found) => return Ok(found),
            // The error of the largest order is the reason why there is none.
            Err(error) if options.order.is_some() => return Err(error),
            Err(error) => last_error = Some(error),
        }
    }
    Err(last_error.unwrap_or_else(|| Error::no_model("no order could be tried")))
}

/// Models of growing order, until the criterion has not fallen for a while.
pub(crate) fn ascend(on: &impl Estimator, feedthrough: bool) -> Result<Vec<Candidate>, Error> {
    let options = on.options();
    let orders = match options.order {
        Some(order) => order..=order,
        None => 1..=options.max_order.min(on.largest_order()),
    };
    let mut candidates: Vec<Candidate> = Vec::new();
    let mut last_error = Error::no_model("no order could be tried");
    for order in orders {
        let before = candidates.last().filter(|c| c.model.order() + 1 == order);
        match of_order(on, order, feedthrough, before) {
            Ok(candidate) => candidates.push(candidate),
            Err(error) => {
                last_error = error;
                continue;
            }
        }
        let least = least(on, &mut candidates);
        if candidates.len() - 1 - least >= LOOK_AHEAD && order >= AT_LEAST {
            break;
        }
    }
    if candidates.is_empty() { Err(last_error) } else { Ok(candidates) }
}

fn of_order(
    on: &impl Estimator,
    order: usize,
    feedthrough: bool,
    before: Option<&Candidate>,
) -> Result<Candidate, Error> {
    let mut best: Option<(f64, Candidate)> = None;
    let mut first = None;
    for mut candidate in on.initial_estimates(order, feedthrough)? {
        let mut cost = candidate.cost;
        first.get_or_insert_with(|| candidate.model.clone());
        if on.options().refine {
            on.refine(&mut candidate, ROUGH)?;
            cost = on.mean_square(&candidate)?;
        }
        if best.as_ref().is_none_or(|(least, _)| cost < *least) {
            best = Some((cost, candidate));
        }
    }
    let (Some((_, mut candidate)), Some(first)) = (best, first) else {
        return Err(Error::no_model("no method could be tried"));
    };
    weigh(on, &mut candidate, on.other_models(first, before))?;
    if !candidate.log_square.is_finite() {
        return Err(Error::no_model("no model can be simulated"));
    }
    candidate.has_logarithm = has_logarithm(&candidate.model);
    Ok(candidate)
}

/// Finds the prediction errors that a candidate is compared by; they are sought from `others` too.
pub(crate) fn weigh(
    on: &impl Estimator,
    candidate: &mut Candidate,
    others: Vec<StateSpace>,
) -> Result<(), Error> {
    (candidate.log_square, candidate.direct) = on.predict(candidate)?;
    for model in others {
        let trial = Candidate { model, ..candidate.clone() };
        if let Ok((log_square, direct)) = on.predict(&trial)
            && log_square < candidate.log_square
        {
            (candidate.log_square, candidate.direct) = (log_square, direct);
        }
    }
    Ok(())
}

/// BIC for the model, and AIC for the initial states of the segments after the first.
pub(crate) fn criterion(on: &impl Estimator, of: &Candidate) -> f64 {
    let Counts { inputs, outputs, samples, segments, .. } = on.counts();
    let count = parameters(of.model.order(), inputs, outputs, of.feedthrough);
    let initial_states = of.model.order() * (segments - 1);
    bic(of.log_square, outputs, count, samples) + 2.0 * initial_states as f64
}

/// Sets the criterion of all and returns the least.
pub(crate) fn least(on: &impl Estimator, candidates: &mut [Candidate]) -> usize {
    for c in candidates.iter_mut() {
        c.criterion = criterion(on, c);
    }
    (0..candidates.len())
        .min_by(|a, b| candidates[*a].criterion.total_cmp(&candidates[*b].criterion))
        .unwrap_or(0)
}

/// The [`likeliest`] order; of a vehicle that which suits one.
pub(crate) fn select(on: &impl Estimator, candidates: &mut [Candidate]) -> usize {
    least(on, candidates);
    let each: Vec<_> = candidates.iter().map(|c| (c.criterion, c.has_logarithm)).collect();
    let chosen = likeliest(&each);
    let Counts { samples, vehicle, .. } = on.counts();
    if !vehicle {
        return chosen;
    }
    let each = candidates.iter().map(|c| (c.model.order(), c.criterion, c.has_logarithm));
    of_a_vehicle(chosen, &each.collect::<Vec<_>>(), samples)
}

/// The chosen model taken off the branch cut, or one of lower order, whichever costs least, where
/// that is nearly nothing; returns which is chosen then.
pub(crate) fn with_logarithm(
    on: &impl Estimator,
    candidates: &mut [Candidate],
    chosen: usize,
) -> Result<usize, Error> {
    if off_branch_cut(&candidates[chosen].model)?.is_empty() {
        return Ok(chosen);
    }
    let least = on.mean_square(&candidates[chosen])?;
    let mut best: Option<(usize, Candidate, f64)> = None;
    let order = |i: usize| candidates[i].model.order();
    let lower = (0..candidates.len()).filter(|i| order(*i) < order(chosen));
    for i in std::iter::once(chosen).chain(lower) {
        let mut one = candidates[i].clone();
        if i != chosen {
            on.refit(&mut one)?;
            if on.options().refine {
                on.refine(&mut one, FINE)?;
            }
        }
        let places = off_branch_cut(&one.model)?;
        let moved = !places.is_empty();
        let mut now = if moved { f64::INFINITY } else { on.mean_square(&one)? };
        let from = one.clone();
        for model in places {
            let mut placed = Candidate { model, ..from.clone() };
            on.refit(&mut placed)?;
            let square = on.mean_square(&placed)?;
            if square < now {
                (one, now) = (placed, square);
            }
        }
        one.has_logarithm = has_logarithm(&one.model);
        one.mirroring_cost = if moved { Some(now / least - 1.0) } else { None };
        let is_best = best.as_ref().is_none_or(|(_, _, square)| now < *square);
        if one.has_logarithm && costs_nothing(least, now) && is_best {
            best = Some((i, one, now));
        }
    }
    let Some((i, one, _)) = best else { return Ok(chosen) };
    candidates[i] = one;
    Ok(i)
}

/// The warning for a model that was taken off the branch cut at this cost of squared errors.
pub(crate) fn mirroring_warning(cost: f64) -> String {
    format!(
        "a mode that decays within a sample alternated in sign, which no mode of a continuous model does: it was replaced by one that does not alternate, which adds {:.2} % to the squared errors",
        100.0 * cost.max(0.0)
    )
}
