//! Models of every order, and the choice among them.
//!
//! 1. Each order's start is the subspace model of any horizon and weighting that simulates the
//!    estimation data best ([`Starts`]); where the input depends on past outputs, a driver's as every
//!    other feedback does, the best predictor-based one ([`Predicted`]).
//! 2. It is refined by its simulation error, since it is to simulate, and compared by how well it then
//!    [predicts](super::comparison) along with a model of the noise.
//! 3. The order is the one of least criterion; orders are tried in turn until [`LOOK_AHEAD`] in a row
//!    have not lowered it.
//! 4. The same once more with feedthrough where the criterion asks for it ([`wants_feedthrough`]).
//! 5. Of orders that are about as likely, one whose A has a real logarithm (eq 9) goes before one
//!    without; the chosen model is [given](super::logarithm) one where that costs nearly nothing.
//!
//! Under feedback the input of the simulation is the [external](super::external) one, unless the model
//! that predicts best is the better simulator ([`finish`]).
//!
//! The held-out data take no part, so the fit on them says what it should: how the model does on
//! data that neither estimated nor chose it.

use super::comparison::Comparison;
use super::conditions::Conditions;
use super::data::{Data, Part};
use super::feedthrough::{wants_feedthrough, without_feedthrough};
use super::logarithm::with_logarithm;
use super::order::{fit, sum_of_squares};
use super::predicted::Predicted;
use super::starts::{Stabilised, Start, Starts, at_least_one, refit_about};
use super::{Approach, IdentifyOptions};
use crate::closed_loop::{self, Feedback, feedback};
use crate::conversion::has_logarithm;
use crate::model::{StateSpace, simulate};
use crate::refine::{Stop, refine_about_levels};
use crate::stability::largest_radius;
use crate::subspace::{Factor, Realization};
use crate::{DataSet, Error};

/// Memory and reach of the test for feedback, s: of the vehicle, and of a driver's reaction.
const MEMORY_S: f64 = 2.0;
const AHEAD_S: f64 = 1.0;

/// Enough to compare orders.
pub(super) const ROUGH: Stop = Stop { steps: 25, least_gain: 2e-5 };
/// For the chosen order.
pub(super) const FINE: Stop = Stop { steps: 40, least_gain: 1e-9 };
/// Orders that are tried beyond the best so far.
const LOOK_AHEAD: usize = 3;
/// Orders up to this one are tried anyhow: modes come in pairs, and the first may show little.
const AT_LEAST: usize = 6;

/// A model in scaled units with its fits.
#[derive(Debug, Clone)]
pub(crate) struct Candidate {
    pub(crate) approach: Approach,
    pub(crate) realization: Realization,
    pub(crate) horizon: usize,
    /// All of the decomposition that it was read from.
    pub(crate) singular_values: Vec<f64>,
    pub(crate) model: StateSpace,
    /// At the beginning of each segment of the data that it was made with; of the estimation data in the
    /// end.
    pub(crate) conditions: Conditions,
    pub(crate) estimation_fit: f64,
    pub(crate) validation_fit: f64,
    /// Σ_i ln V_i of the one-step prediction errors that it is compared by.
    pub(crate) log_square: f64,
    /// Schwarz's criterion; of two orders the one with the lesser is the likelier.
    pub(crate) criterion: f64,
    /// What stability cost, where the subspace estimate was unstable.
    pub(crate) stabilised: Option<Stabilised>,
    pub(crate) has_logarithm: bool,
    /// Share by which the squared errors grew for a logarithm's sake.
    pub(crate) mirroring_cost: Option<f64>,
    pub(crate) feedthrough: bool,
    /// The model of this order that predicts best along with a model of the noise, where the errors have a
    /// colour; under feedback it may be the one that is taken.
    pub(crate) direct: Option<StateSpace>,
}

/// All orders that were tried, the chosen one, and its factor.
pub(crate) struct Choice {
    pub(crate) candidates: Vec<Candidate>,
    pub(crate) chosen: usize,
    pub(crate) factor: Factor,
    /// The test for feedback, where the data are enough for it.
    pub(crate) feedback: Option<Feedback>,
    /// The data whose simulation error the chosen model makes small, about their level, where they are
    /// not the estimation data themselves: with the external input, or whitened.
    pub(crate) fitted: Option<DataSet>,
}

/// [`choose_from`] for the signals of a drive.
pub(crate) fn choose(data: &Data, options: &IdentifyOptions) -> Result<Choice, Error> {
    choose_from(&data.estimation.data, &data.validation.data, options, true)
}

/// Chooses what the options leave open from scaled estimation data, of a `vehicle` or of any system; the
/// held-out data are measured on.
pub(crate) fn choose_from(
    data: &DataSet,
    held_out: &DataSet,
    options: &IdentifyOptions,
    vehicle: bool,
) -> Result<Choice, Error> {
    let feedback = feedback(data, MEMORY_S, AHEAD_S).ok();
    let closed = match options.method {
        Some(Approach::ClosedLoop(method)) => vec![method],
        None if feedback.is_some_and(|f| f.detected) => closed_loop::Method::ALL.to_vec(),
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
        measure(data, held_out, candidate)?;
    }
    let chosen = &choice.candidates[choice.chosen];
    if let Some(fitted) = choice.fitted.take() {
        let level = chosen.conditions.levels.is_some();
        let own = Conditions::new(&chosen.model, &fitted, level)?;
        choice.fitted = Some(own.about_level(&fitted)?);
    }
    if !choice.candidates[choice.chosen].validation_fit.is_finite() {
        return Err(Error::NoModel { problem: "no model can be simulated".into() });
    }
    Ok(choice)
}

/// The simulation fits of a candidate.
fn measure(data: &DataSet, held_out: &DataSet, candidate: &mut Candidate) -> Result<(), Error> {
    let level = candidate.conditions.levels.is_some();
    let model = &candidate.model;
    candidate.conditions = Conditions::new(model, data, level)?;
    candidate.estimation_fit = fit(data, &candidate.conditions.errors(model, data));
    let about = candidate.conditions.about_level(held_out)?;
    let errors = Conditions::new(model, &about, false)?.errors(model, &about);
    candidate.validation_fit = fit(&about, &errors);
    Ok(())
}

/// The choice for data without feedback.
fn open_loop(data: &DataSet, options: &IdentifyOptions, vehicle: bool) -> Result<Choice, Error> {
    let starts = Starts::new(data, options)?;
    let largest = starts.largest_order();
    let first = match options.order {
        Some(_) => None,
        None => Some(largest_start(options, largest, |order| starts.best(order, true))?.model),
    };
    let mut compare = Comparison::new(data, options, false, first.as_ref())?.of(vehicle);
    let ascend = |feedthrough| {
        let start = |order| {
            let best = starts.best(order, feedthrough)?;
            Ok(with_physical(data, best, vehicle, feedthrough, options))
        };
        ascend(data, &compare, options, largest, feedthrough, start)
    };
    let mut candidates = ascend(options.feedthrough == Some(true))?;
    let mut chosen = compare.judge(&mut candidates);
    // At a given order, a direct gain could stand for states that are not allowed.
    let open = options.feedthrough.is_none() && options.order.is_none();
    if open && wants_feedthrough(&compare, &starts, &candidates, chosen) {
        let mut others = ascend(true)?;
        let other = compare.judge(&mut others);
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
            chosen = compare.judge(&mut candidates);
        }
    }
    let had_level = compare.level;
    compare.settle_level(&mut candidates, chosen)?;
    if options.refine {
        let of = &mut candidates[chosen];
        if had_level && !compare.level {
            let (a, c) = (&of.model.a, &of.model.c);
            (of.model, of.conditions, _) = refit_about(a, c, data, of.feedthrough, false)?;
        }
        refine(data, of, FINE)?;
    }
    chosen = with_logarithm(data, &mut candidates, chosen, options.refine)?;
    let factor = starts
        .into_factor(candidates[chosen].horizon)
        .ok_or(Error::NoModel { problem: "the chosen horizon was not tried".into() })?;
    Ok(Choice { candidates, chosen, factor, feedback: None, fitted: None })
}

/// The choice for data with feedback. D is zero unless asked for: without a delay in the loop it could
/// not be told from the feedback's own gain.
fn in_a_loop(
    data: &DataSet,
    options: &IdentifyOptions,
    methods: &[closed_loop::Method],
    vehicle: bool,
) -> Result<Choice, Error> {
    let feedthrough = options.feedthrough == Some(true);
    let predicted = Predicted::new(data, options, methods)?;
    let largest = predicted.largest_order();
    let first = largest_start(options, largest, |order| predicted.best(data, order, feedthrough))?;
    let mut compare = Comparison::new(data, options, true, Some(&first.model))?.of(vehicle);
    let by = &predicted.external;
    // To the open-loop methods the external input is one of open loop.
    let others = if options.method.is_none() { Some(Starts::new(by, options)?) } else { None };
    let start = |order| {
        let other = others.as_ref().map(|o| o.best(order, feedthrough));
        let all = std::iter::once(predicted.best(data, order, feedthrough)).chain(other);
        let mut all = at_least_one(all)?;
        let last = all.swap_remove(all.len() - 1);
        all.extend(with_physical(by, last, vehicle, feedthrough, options));
        Ok(all)
    };
    let mut candidates = ascend(by, &compare, options, largest, feedthrough, start)?;
    let mut chosen = compare.judge(&mut candidates);
    compare.settle_level(&mut candidates, chosen)?;
    let whitened = match options.refine {
        true => finish(by, &compare, &mut candidates[chosen])?,
        false => None,
    };
    let made_small = whitened.as_ref().unwrap_or(by);
    chosen = with_logarithm(made_small, &mut candidates, chosen, options.refine)?;
    let (factor, external) = predicted.into_parts();
    let fitted = Some(whitened.unwrap_or(external));
    Ok(Choice { candidates, chosen, factor, feedback: None, fitted })
}

/// A start, and one with the poles of a vehicle where the system is one and the order its own.
fn with_physical(
    data: &DataSet,
    start: Start,
    vehicle: bool,
    feedthrough: bool,
    options: &IdentifyOptions,
) -> Vec<Start> {
    let own = vehicle && options.refine && start.model.order() == super::vehicle::ORDER;
    let level = start.conditions.levels.is_some();
    let physical = own.then(|| super::vehicle::start(data, &start, feedthrough, level)).flatten();
    std::iter::once(start).chain(physical).collect()
}

/// A start of the largest order that can be had, or of the given one.
fn largest_start(
    options: &IdentifyOptions,
    largest: usize,
    start: impl Fn(usize) -> Result<Start, Error>,
) -> Result<Start, Error> {
    let most = options.order.unwrap_or(options.max_order.min(largest)).max(1);
    let mut last_error = None;
    for order in (1..=most).rev() {
        match start(order) {
            Ok(start) => return Ok(start),
            // The error of the largest order tells why there is none.
            Err(error) if options.order.is_some() => return Err(error),
            Err(error) => last_error = Some(error),
        }
    }
    Err(last_error.unwrap_or_else(|| Error::NoModel { problem: "no order could be tried".into() }))
}

/// Feedback biases neither the model that simulates the external input best nor the one that predicts
/// best; of the two the better simulator of the estimation data is taken. Returns the whitened data
/// where it is the latter.
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
        let conditions = Conditions::new(model, compare.data, compare.level)?;
        Ok(sum_of_squares(&conditions.errors(model, compare.data)))
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
    starts: impl Fn(usize) -> Result<Vec<Start>, Error>,
) -> Result<Vec<Candidate>, Error> {
    let orders = match options.order {
        Some(order) => order..=order,
        None => 1..=options.max_order.min(largest),
    };
    let mut candidates: Vec<Candidate> = Vec::new();
    let mut last_error = None;
    for order in orders {
        let (mut candidate, first) = match starts(order) {
            Ok(starts) => {
                let first = starts.first().map(|start| start.model.clone());
                (best_of(by, starts, options.refine, feedthrough)?, first)
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

/// Of models of one order, refined where asked, the one that simulates the data best.
fn best_of(
    by: &DataSet,
    starts: Vec<Start>,
    refined: bool,
    feedthrough: bool,
) -> Result<Candidate, Error> {
    let mut best: Option<(f64, Candidate)> = None;
    for start in starts {
        let mut cost = start.cost;
        let mut candidate = Candidate::new(start, feedthrough);
        if refined {
            refine(by, &mut candidate, ROUGH)?;
            cost = sum_of_squares(&candidate.conditions.errors(&candidate.model, by));
        }
        if best.as_ref().is_none_or(|(least, _)| cost < *least) {
            best = Some((cost, candidate));
        }
    }
    best.map(|(_, candidate)| candidate)
        .ok_or_else(|| Error::NoModel { problem: "no method could be tried".into() })
}

impl Candidate {
    pub(super) fn new(start: Start, feedthrough: bool) -> Self {
        Self {
            approach: start.approach,
            realization: start.realization,
            horizon: start.horizon,
            singular_values: start.singular_values,
            model: start.model,
            conditions: start.conditions,
            estimation_fit: f64::NEG_INFINITY,
            validation_fit: f64::NEG_INFINITY,
            log_square: f64::INFINITY,
            criterion: f64::INFINITY,
            stabilised: start.stabilised,
            has_logarithm: false,
            mirroring_cost: None,
            feedthrough,
            direct: None,
        }
    }
}

/// Refines by the simulation errors of these data.
pub(super) fn refine(data: &DataSet, candidate: &mut Candidate, stop: Stop) -> Result<(), Error> {
    let model = &candidate.model;
    let radius = largest_radius(data.samples()).max(model.spectral_radius());
    let from = Conditions::new(model, data, candidate.conditions.levels.is_some())?;
    let ((model, x0), levels) = refine_about_levels(
        model,
        (&from.x0, from.levels.as_deref()),
        data,
        candidate.feedthrough,
        stop,
        (radius + 1e-12).min(1.0),
    )?;
    (candidate.model, candidate.conditions) = (model, Conditions { x0, levels });
    Ok(())
}

/// Simulated output of one part from the states at the beginning of its segments.
pub(crate) fn output(model: &StateSpace, part: &Part, x0: &[Vec<f64>]) -> Vec<f64> {
    let mut all = Vec::with_capacity(part.len());
    for (segment, x0) in part.data.segments().iter().zip(x0) {
        all.extend(simulate(model, segment.u.as_ref(), x0).row(0));
    }
    all
}

/// The states at the beginning of each segment of a part that fit its output best.
pub(crate) fn initial_states(model: &StateSpace, part: &Part) -> Result<Vec<Vec<f64>>, Error> {
    Ok(Conditions::new(model, &part.data, false)?.x0)
}
