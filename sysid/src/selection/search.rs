//! Models of every order, and the choice among them.
//!
//! 1. Each order's initial estimate is the subspace model of any horizon and weighting that simulates
//!    the estimation data best ([`InitialEstimates`]); where the input depends on past outputs, by a
//!    driver or any other feedback, the best predictor-based one ([`Predicted`]).
//! 2. It is refined by its simulation error, since it is to simulate, and compared by how well it then
//!    [predicts](crate::selection::comparison) along with a model of the noise.
//! 3. The order is the one of least criterion; orders are tried in turn until [`LOOK_AHEAD`] in a row
//!    have not lowered it.
//! 4. The same once more with feedthrough where the criterion requires it ([`wants_feedthrough`]).
//! 5. Of orders that are about as likely, one whose A has a real logarithm (eq 9) goes before one
//!    without; the chosen model is [given](crate::selection::logarithm) one where that costs nearly nothing.
//!
//! Under feedback the input of the simulation is the [two-stage estimate](crate::selection::two_stage), unless the model
//! that predicts best is the better simulator ([`finish`]).
//!
//! The validation data take no part, so the fit on them is that of the model on data that neither
//! estimated nor chose it.

use crate::Error;
use crate::data::DataSet;
use crate::data::scaled::Data;
use crate::model::StateSpace;
use crate::model::conversion::has_logarithm;
use crate::selection::candidate::{Candidate, Choice, FINE, ROUGH, refine};
use crate::selection::comparison::Comparison;
use crate::selection::feedthrough::{wants_feedthrough, without_feedthrough};
use crate::selection::initial_conditions::InitialConditions;
use crate::selection::initial_estimates::{
    InitialEstimate, InitialEstimates, at_least_one, refit_about,
};
use crate::selection::logarithm::with_logarithm;
use crate::selection::method::Method;
use crate::selection::options::IdentifyOptions;
use crate::selection::order::{fit, sum_of_squares};
use crate::selection::predicted::Predicted;
use crate::selection::vehicle;
use crate::subspace::closed_loop::{self, feedback};

/// Memory and reach of the test for feedback, s: of the vehicle, and of a driver's reaction.
const MEMORY_S: f64 = 2.0;
const AHEAD_S: f64 = 1.0;

/// Orders that are tried beyond the best so far.
const LOOK_AHEAD: usize = 3;
/// Orders up to this one are tried anyhow: modes come in pairs, and the first may show little.
const AT_LEAST: usize = 6;

/// [`choose_from`] for the signals of a drive.
pub(crate) fn choose(data: &Data, options: &IdentifyOptions) -> Result<Choice, Error> {
    choose_from(&data.estimation.data, &data.validation.data, options, true)
}

/// Chooses what the options leave open from scaled estimation data, of a `vehicle` or of any system;
/// the fits on the validation data are computed with it.
pub(crate) fn choose_from(
    data: &DataSet,
    validation: &DataSet,
    options: &IdentifyOptions,
    vehicle: bool,
) -> Result<Choice, Error> {
    let feedback = feedback(data, MEMORY_S, AHEAD_S).ok();
    let closed = match options.method {
        Some(Method::ClosedLoop(method)) => vec![method],
        None if feedback.is_some_and(|f| f.detected) => closed_loop::ClosedLoopMethod::ALL.to_vec(),
        _ => Vec::new(),
    };
    let mut choice = if closed.is_empty() {
        open_loop(data, options, vehicle)?
    } else {
        in_a_loop(data, options, &closed, vehicle)?
    };
    choice.feedback = feedback;
    for candidate in &mut choice.candidates {
        candidate.model.scale_state();
        measure(data, validation, candidate)?;
    }
    let chosen = &choice.candidates[choice.chosen];
    if let Some(fitted) = choice.fitted.take() {
        let offset = chosen.initial_conditions.offsets.is_some();
        let own = InitialConditions::new(&chosen.model, &fitted, offset)?;
        choice.fitted = Some(own.about_output_offset(&fitted)?);
    }
    if !choice.candidates[choice.chosen].validation_fit.is_finite() {
        return Err(Error::NoModel { problem: "no model can be simulated".into() });
    }
    Ok(choice)
}

/// The simulation fits of a candidate.
fn measure(data: &DataSet, validation: &DataSet, candidate: &mut Candidate) -> Result<(), Error> {
    let offset = candidate.initial_conditions.offsets.is_some();
    let model = &candidate.model;
    candidate.initial_conditions = InitialConditions::new(model, data, offset)?;
    candidate.estimation_fit = fit(data, &candidate.initial_conditions.errors(model, data));
    let about = candidate.initial_conditions.about_output_offset(validation)?;
    let errors = InitialConditions::new(model, &about, false)?.errors(model, &about);
    candidate.validation_fit = fit(&about, &errors);
    Ok(())
}

/// The choice for data without feedback.
fn open_loop(data: &DataSet, options: &IdentifyOptions, vehicle: bool) -> Result<Choice, Error> {
    let initial_estimates = InitialEstimates::new(data, options)?;
    let largest = initial_estimates.largest_order();
    let first = match options.order {
        Some(_) => None,
        None => Some(
            largest_estimate(options, largest, |order| initial_estimates.best(order, true))?.model,
        ),
    };
    let mut compare = Comparison::new(data, options, false, first.as_ref())?.of(vehicle);
    let ascend = |feedthrough| {
        let start = |order| {
            let best = initial_estimates.best(order, feedthrough)?;
            Ok(with_physical(data, best, vehicle, feedthrough, options))
        };
        ascend(data, &compare, options, largest, feedthrough, start)
    };
    let mut candidates = ascend(options.feedthrough == Some(true))?;
    let mut chosen = compare.select(&mut candidates);
    // At a stated order, a direct gain could represent states that are not allowed.
    let open = options.feedthrough.is_none() && options.order.is_none();
    if open && wants_feedthrough(&compare, &initial_estimates, &candidates, chosen) {
        let mut others = ascend(true)?;
        let other = compare.select(&mut others);
        // The same poles without: what the first pass may not have found.
        let rival = without_feedthrough(&compare, options, &others[other])?;
        let mut finals = vec![candidates[chosen].clone(), rival, others[other].clone()];
        let least = compare.least(&mut finals);
        let sure = finals[..2].iter().all(|c| compare.surely_less(&finals[2], c));
        if sure {
            (candidates, chosen) = (others, other);
        } else if least != 0 && finals[1].criterion < finals[0].criterion {
            let rival = finals.swap_remove(1);
            let same = |c: &Candidate| c.model.order() == rival.model.order();
            match candidates.iter().position(same) {
                Some(at) => candidates[at] = rival,
                None => candidates.push(rival),
            }
            chosen = compare.select(&mut candidates);
        }
    }
    let had_output_offset = compare.offset;
    compare.settle_output_offset(&mut candidates, chosen)?;
    if options.refine {
        let of = &mut candidates[chosen];
        if had_output_offset && !compare.offset {
            let (a, c) = (&of.model.a, &of.model.c);
            (of.model, of.initial_conditions, _) = refit_about(a, c, data, of.feedthrough, false)?;
        }
        refine(data, of, FINE)?;
    }
    chosen = with_logarithm(data, &mut candidates, chosen, options.refine)?;
    let factor = initial_estimates
        .into_factor(candidates[chosen].horizon)
        .ok_or(Error::NoModel { problem: "the chosen horizon was not tried".into() })?;
    Ok(Choice { candidates, chosen, factor, feedback: None, fitted: None })
}

/// The choice for data with feedback. D is zero unless it is requested: without a delay in the loop it
/// could not be distinguished from the feedback's own gain.
fn in_a_loop(
    data: &DataSet,
    options: &IdentifyOptions,
    methods: &[closed_loop::ClosedLoopMethod],
    vehicle: bool,
) -> Result<Choice, Error> {
    let feedthrough = options.feedthrough == Some(true);
    let predicted = Predicted::new(data, options, methods)?;
    let largest = predicted.largest_order();
    let first =
        largest_estimate(options, largest, |order| predicted.best(data, order, feedthrough))?;
    let mut compare = Comparison::new(data, options, true, Some(&first.model))?.of(vehicle);
    let by = &predicted.two_stage_input;
    // To the open-loop methods the two-stage input estimate is one of open loop.
    let others =
        if options.method.is_none() { Some(InitialEstimates::new(by, options)?) } else { None };
    let start = |order| {
        let other = others.as_ref().map(|o| o.best(order, feedthrough));
        let all = std::iter::once(predicted.best(data, order, feedthrough)).chain(other);
        let mut all = at_least_one(all)?;
        let last = all.swap_remove(all.len() - 1);
        all.extend(with_physical(by, last, vehicle, feedthrough, options));
        Ok(all)
    };
    let mut candidates = ascend(by, &compare, options, largest, feedthrough, start)?;
    let mut chosen = compare.select(&mut candidates);
    compare.settle_output_offset(&mut candidates, chosen)?;
    let whitened = match options.refine {
        true => finish(by, &compare, &mut candidates[chosen])?,
        false => None,
    };
    let made_small = whitened.as_ref().unwrap_or(by);
    chosen = with_logarithm(made_small, &mut candidates, chosen, options.refine)?;
    let (factor, two_stage_input) = predicted.into_parts();
    let fitted = Some(whitened.unwrap_or(two_stage_input));
    Ok(Choice { candidates, chosen, factor, feedback: None, fitted })
}

/// An initial estimate, and one with the poles of a vehicle where the system is one and the order its
/// own.
fn with_physical(
    data: &DataSet,
    start: InitialEstimate,
    of_vehicle: bool,
    feedthrough: bool,
    options: &IdentifyOptions,
) -> Vec<InitialEstimate> {
    let own = of_vehicle && options.refine && start.model.order() == vehicle::ORDER;
    let offset = start.initial_conditions.offsets.is_some();
    let physical =
        own.then(|| vehicle::initial_estimate(data, &start, feedthrough, offset)).flatten();
    std::iter::once(start).chain(physical).collect()
}

/// An initial estimate of the largest possible order, or of the stated one.
fn largest_estimate(
    options: &IdentifyOptions,
    largest: usize,
    start: impl Fn(usize) -> Result<InitialEstimate, Error>,
) -> Result<InitialEstimate, Error> {
    let most = options.order.unwrap_or(options.max_order.min(largest)).max(1);
    let mut last_error = None;
    for order in (1..=most).rev() {
        match start(order) {
            Ok(start) => return Ok(start),
            // The error of the largest order is the reason why there is none.
            Err(error) if options.order.is_some() => return Err(error),
            Err(error) => last_error = Some(error),
        }
    }
    Err(last_error.unwrap_or_else(|| Error::NoModel { problem: "no order could be tried".into() }))
}

/// Feedback biases neither the model that simulates the two-stage input estimate best nor the one that
/// predicts best; of the two the better simulator of the estimation data is taken. Returns the whitened
/// data where it is the latter.
fn finish(
    by: &DataSet,
    compare: &Comparison<'_>,
    chosen: &mut Candidate,
) -> Result<Option<DataSet>, Error> {
    refine(by, chosen, FINE)?;
    let Some(model) = chosen.direct.take() else { return Ok(None) };
    let mut direct = Candidate { model, ..chosen.clone() };
    let whitened = compare.refine(&mut direct, FINE)?;
    let cost = |model: &StateSpace| -> Result<f64, Error> {
        let initial_conditions = InitialConditions::new(model, compare.data, compare.offset)?;
        Ok(sum_of_squares(&initial_conditions.errors(model, compare.data)))
    };
    if cost(&direct.model)? < cost(&chosen.model)? {
        *chosen = direct;
        return Ok(Some(whitened));
    }
    Ok(None)
}

/// Models of growing order, refined by the simulation errors of the data `by`, until the criterion has
/// not fallen for a while.
fn ascend(
    by: &DataSet,
    compare: &Comparison<'_>,
    options: &IdentifyOptions,
    largest: usize,
    feedthrough: bool,
    initial_estimates: impl Fn(usize) -> Result<Vec<InitialEstimate>, Error>,
) -> Result<Vec<Candidate>, Error> {
    let orders = match options.order {
        Some(order) => order..=order,
        None => 1..=options.max_order.min(largest),
    };
    let mut candidates: Vec<Candidate> = Vec::new();
    let mut last_error = None;
    for order in orders {
        let (mut candidate, first) = match initial_estimates(order) {
            Ok(initial_estimates) => {
                let first = initial_estimates.first().map(|start| start.model.clone());
                (best_of(by, initial_estimates, options.refine, feedthrough)?, first)
            }
            Err(error) => {
                last_error = Some(error);
                continue;
            }
        };
        compare.weigh(&mut candidate, first, options.refine)?;
        if !candidate.log_square.is_finite() {
            last_error = Some(Error::NoModel { problem: "no model can be simulated".into() });
            continue;
        }
        candidate.has_logarithm = has_logarithm(&candidate.model);
        candidates.push(candidate);
        let least = compare.least(&mut candidates);
        let far = candidates.len() - 1 - least;
        if far >= LOOK_AHEAD && order >= AT_LEAST {
            break;
        }
    }
    if candidates.is_empty() {
        return Err(last_error
            .unwrap_or_else(|| Error::NoModel { problem: "no order could be tried".into() }));
    }
    Ok(candidates)
}

/// Of models of one order, refined where requested, the one that simulates the data best.
fn best_of(
    by: &DataSet,
    initial_estimates: Vec<InitialEstimate>,
    refined: bool,
    feedthrough: bool,
) -> Result<Candidate, Error> {
    let mut best: Option<(f64, Candidate)> = None;
    for start in initial_estimates {
        let mut cost = start.cost;
        let mut candidate = Candidate::new(start, feedthrough);
        if refined {
            refine(by, &mut candidate, ROUGH)?;
            cost = sum_of_squares(&candidate.initial_conditions.errors(&candidate.model, by));
        }
        if best.as_ref().is_none_or(|(least, _)| cost < *least) {
            best = Some((cost, candidate));
        }
    }
    best.map(|(_, candidate)| candidate)
        .ok_or_else(|| Error::NoModel { problem: "no method could be tried".into() })
}
