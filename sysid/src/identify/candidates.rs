//! Models of every order, and the choice among them.
//!
//! 1. Each order's start is the subspace model of any horizon and weighting that simulates the
//!    estimation data best ([`Starts`]).
//! 2. It is refined by its simulation error on the estimation data, so that orders are compared by
//!    what each can do rather than by how well a subspace method happened to see it.
//! 3. The order is the one of least [criterion](super::order); orders are tried in turn until
//!    [`LOOK_AHEAD`] in a row have not lowered it.
//! 4. The same once more with feedthrough where the criterion asks for it ([`wants_feedthrough`]).
//! 5. Of orders that are [about as likely](AS_LIKELY), one whose A has a real logarithm (eq 9) goes
//!    before one without.
//!
//! Where the input depends on past outputs, a driver's as every other feedback does, the starts are
//! predictor-based and all errors are those of one-step prediction ([`super::predicted`]).
//!
//! The held-out data take no part, so the fit on them says what it should: how the model does on
//! data that neither estimated nor chose it.

use super::data::{Data, Part};
use super::order::{Errors, effective_samples, errors, fit, log_square, parameters, schwarz};
use super::predicted::{Predicted, prediction_errors};
use super::starts::{Stabilised, Start, Starts};
use super::{Approach, IdentifyOptions};
use crate::closed_loop::{self, Feedback, feedback};
use crate::conversion::to_continuous;
use crate::model::{Innovation, StateSpace, initial_state, predictor, simulate};
use crate::refine::{Focus, Stop, refine_output_error, refine_prediction};
use crate::stability::largest_radius;
use crate::subspace::{Factor, Realization, refit_output};
use crate::{DataSet, Error};
use faer::Mat;

/// Memory and reach of the test for feedback, s: of the vehicle, and of a driver's reaction.
const MEMORY_S: f64 = 2.0;
const AHEAD_S: f64 = 1.0;

/// Enough to compare orders.
const ROUGH: Stop = Stop { steps: 25, least_gain: 2e-5 };
/// For the chosen order.
const FINE: Stop = Stop { steps: 40, least_gain: 1e-9 };
/// Orders that are tried beyond the best so far.
const LOOK_AHEAD: usize = 3;
/// Orders up to this one are tried anyhow: modes come in pairs, and the first may show little.
const AT_LEAST: usize = 4;
/// A difference of the criterion that is no strong evidence (R. E. Kass, A. E. Raftery, *Bayes
/// factors*, J. American Statistical Association 90, 1995).
const AS_LIKELY: f64 = 6.0;

/// A model in scaled units with its fits.
#[derive(Debug, Clone)]
pub(crate) struct Candidate {
    pub(crate) approach: Approach,
    pub(crate) realization: Realization,
    pub(crate) horizon: usize,
    /// All of the decomposition that it was read from.
    pub(crate) singular_values: Vec<f64>,
    pub(crate) model: StateSpace,
    /// State at the first sample of each segment of the estimation data, for the simulation.
    pub(crate) x0: Vec<Vec<f64>>,
    /// The predictor, where its errors are those that are made small.
    pub(crate) filtered: Option<Filtered>,
    pub(crate) estimation_fit: f64,
    pub(crate) validation_fit: f64,
    /// Schwarz's criterion; of two orders the one with the lesser is the likelier.
    pub(crate) criterion: f64,
    /// What stability cost, where the subspace estimate was unstable.
    pub(crate) stabilised: Option<Stabilised>,
    /// Spectral radius of the A that a refinement led to and that was not taken for it.
    pub(crate) refused: Option<f64>,
    pub(crate) has_logarithm: bool,
    pub(crate) feedthrough: bool,
    /// Those that are made small: of the simulation, or of one-step prediction.
    pub(crate) errors: Errors,
}

/// The rest of a predictor in innovation form.
#[derive(Debug, Clone)]
pub(crate) struct Filtered {
    /// Kalman gain.
    pub(crate) gain: Mat<f64>,
    /// Its state at the first sample of each segment of the estimation data.
    pub(crate) x0: Vec<Vec<f64>>,
}

/// All orders that were tried, the chosen one, and its factor.
pub(crate) struct Choice {
    pub(crate) candidates: Vec<Candidate>,
    pub(crate) chosen: usize,
    pub(crate) factor: Factor,
    /// The test for feedback, where the data are enough for it.
    pub(crate) feedback: Option<Feedback>,
}

/// [`choose_from`] for the signals of a drive.
pub(crate) fn choose(data: &Data, options: &IdentifyOptions) -> Result<Choice, Error> {
    choose_from(&data.estimation.data, &data.validation.data, options)
}

/// Chooses what the options leave open from scaled estimation data; the held-out data are measured on.
pub(crate) fn choose_from(
    data: &DataSet,
    held_out: &DataSet,
    options: &IdentifyOptions,
) -> Result<Choice, Error> {
    let feedback = feedback(data, MEMORY_S, AHEAD_S).ok();
    let closed = match options.method {
        Some(Approach::ClosedLoop(method)) => vec![method],
        None if feedback.is_some_and(|f| f.detected) => closed_loop::Method::ALL.to_vec(),
        _ => Vec::new(),
    };
    let mut choice = if closed.is_empty() {
        by_simulation(data, options)?
    } else {
        by_prediction(data, options, &closed)?
    };
    choice.feedback = feedback;
    for candidate in &mut choice.candidates {
        measure(data, held_out, candidate)?;
    }
    if !choice.candidates[choice.chosen].validation_fit.is_finite() {
        return Err(Error::NoModel { problem: "no model can be simulated".into() });
    }
    Ok(choice)
}

/// The simulation fits of a candidate.
fn measure(data: &DataSet, held_out: &DataSet, candidate: &mut Candidate) -> Result<(), Error> {
    if candidate.filtered.is_some() {
        candidate.x0 = simulated_states(&candidate.model, data)?;
        candidate.estimation_fit = fit(data, &errors(&candidate.model, &candidate.x0, data));
    } else {
        candidate.estimation_fit = fit(data, &candidate.errors);
    }
    let x0 = simulated_states(&candidate.model, held_out)?;
    candidate.validation_fit = fit(held_out, &errors(&candidate.model, &x0, held_out));
    Ok(())
}

/// The choice for data without feedback.
fn by_simulation(data: &DataSet, options: &IdentifyOptions) -> Result<Choice, Error> {
    let starts = Starts::new(data, options)?;
    let start =
        |order, feedthrough| Ok(Candidate::new(starts.best(order, feedthrough)?, feedthrough));
    let largest = starts.largest_order();
    let ascend = |feedthrough| ascend(data, options, largest, |order| start(order, feedthrough));
    let mut candidates = ascend(options.feedthrough == Some(true))?;
    let mut chosen = judge_orders(data, &mut candidates);
    // At a given order, a direct gain could stand for states that are not allowed.
    let open = options.feedthrough.is_none() && options.order.is_none();
    if open && wants_feedthrough(data, &starts, &candidates, chosen) {
        let mut others = ascend(true)?;
        let other = judge_orders(data, &mut others);
        // The same poles without: what the first pass may not have found.
        let rival = without_feedthrough(data, options, &others[other])?;
        let mut finals = vec![candidates[chosen].clone(), rival, others[other].clone()];
        let least = least_criterion(data, &mut finals);
        let sure = finals[..2].iter().all(|c| c.criterion > finals[2].criterion + AS_LIKELY);
        if sure {
            (candidates, chosen) = (others, other);
        } else if least != 0 && finals[1].criterion < finals[0].criterion {
            let rival = finals.swap_remove(1);
            let same = |c: &Candidate| c.model.order() == rival.model.order();
            match candidates.iter().position(same) {
                Some(at) => candidates[at] = rival,
                None => candidates.push(rival),
            }
            chosen = judge_orders(data, &mut candidates);
        }
    }
    if options.refine {
        refine(data, &mut candidates[chosen], FINE)?;
    }
    let factor = starts
        .into_factor(candidates[chosen].horizon)
        .ok_or(Error::NoModel { problem: "the chosen horizon was not tried".into() })?;
    Ok(Choice { candidates, chosen, factor, feedback: None })
}

/// The choice for data with feedback. D is zero unless asked for: without a delay in the loop it could
/// not be told from the feedback's own gain.
fn by_prediction(
    data: &DataSet,
    options: &IdentifyOptions,
    methods: &[closed_loop::Method],
) -> Result<Choice, Error> {
    let feedthrough = options.feedthrough == Some(true);
    let predicted = Predicted::new(data, options, methods)?;
    let mut candidates = ascend(data, options, predicted.largest_order(), |order| {
        predicted.best(order, feedthrough)
    })?;
    let chosen = judge_orders(data, &mut candidates);
    if options.refine {
        refine(data, &mut candidates[chosen], FINE)?;
    }
    Ok(Choice { candidates, chosen, factor: predicted.into_factor(), feedback: None })
}

/// Models of growing order, until the criterion has not fallen for a while.
fn ascend(
    data: &DataSet,
    options: &IdentifyOptions,
    largest: usize,
    start: impl Fn(usize) -> Result<Candidate, Error>,
) -> Result<Vec<Candidate>, Error> {
    let orders = match options.order {
        Some(order) => order..=order,
        None => 1..=options.max_order.min(largest),
    };
    let mut candidates: Vec<Candidate> = Vec::new();
    let mut last_error = None;
    for order in orders {
        let mut candidate = match start(order) {
            Ok(candidate) => candidate,
            Err(error) => {
                last_error = Some(error);
                continue;
            }
        };
        if options.refine {
            refine(data, &mut candidate, ROUGH)?;
        }
        if !log_square(&candidate.errors).is_finite() {
            last_error = Some(Error::NoModel { problem: "no model can be simulated".into() });
            continue;
        }
        let m = &candidate.model;
        candidate.has_logarithm = to_continuous(m.a.as_ref(), m.b.as_ref(), 1.0).is_ok();
        candidates.push(candidate);
        let least = least_criterion(data, &mut candidates);
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

/// Sets the criterion of all and tells the least.
fn least_criterion(data: &DataSet, candidates: &mut [Candidate]) -> usize {
    let Some(samples) = independent_samples(data, candidates) else { return 0 };
    let (m, p) = (data.inputs(), data.outputs());
    for c in candidates.iter_mut() {
        let gain = if c.filtered.is_some() { c.model.order() * p } else { 0 };
        let d = parameters(c.model.order(), m, p, c.feedthrough) + gain;
        c.criterion = schwarz(log_square(&c.errors), p, d, samples);
    }
    (0..candidates.len())
        .min_by(|a, b| candidates[*a].criterion.total_cmp(&candidates[*b].criterion))
        .unwrap_or(0)
}

/// The independent samples in the errors of the model that errs least.
fn independent_samples(data: &DataSet, candidates: &[Candidate]) -> Option<f64> {
    let cost = |c: &&Candidate| log_square(&c.errors);
    let best = candidates.iter().min_by(|a, b| cost(a).total_cmp(&cost(b)))?;
    Some(effective_samples(data, &best.errors))
}

/// The order of least criterion, or of one about as likely whose A has a real logarithm.
fn judge_orders(data: &DataSet, candidates: &mut [Candidate]) -> usize {
    let least = least_criterion(data, candidates);
    let enough = candidates[least].criterion + AS_LIKELY;
    if candidates[least].has_logarithm {
        return least;
    }
    (0..candidates.len())
        .filter(|i| candidates[*i].has_logarithm && candidates[*i].criterion <= enough)
        .min_by(|a, b| candidates[*a].criterion.total_cmp(&candidates[*b].criterion))
        .unwrap_or(least)
}

/// Whether a direct gain, estimated along with B for the poles of a subspace model, lowers the
/// criterion, at the chosen order or the one before: it was chosen without, which may have cost a
/// state.
fn wants_feedthrough(
    data: &DataSet,
    starts: &Starts<'_>,
    candidates: &[Candidate],
    chosen: usize,
) -> bool {
    let Some(samples) = independent_samples(data, candidates) else { return false };
    let (m, p) = (data.inputs(), data.outputs());
    candidates[chosen.saturating_sub(1)..=chosen].iter().any(|c| {
        let criterion = |feedthrough: bool| {
            let order = c.model.order();
            let Approach::OpenLoop(method) = c.approach else { return None };
            let start = starts.again((c.horizon, method, c.realization), order, feedthrough)?;
            let d = parameters(order, m, p, feedthrough);
            Some(schwarz(log_square(&start.errors), p, d, samples))
        };
        matches!((criterion(true), criterion(false)), (Some(a), Some(b)) if a < b)
    })
}

/// The model with D taken out, fitted anew.
fn without_feedthrough(
    data: &DataSet,
    options: &IdentifyOptions,
    from: &Candidate,
) -> Result<Candidate, Error> {
    let m = &from.model;
    let refit = refit_output(m.a.as_ref(), m.c.as_ref(), data, false, false)?;
    let mut rival = Candidate { feedthrough: false, ..from.clone() };
    rival.errors = errors(&refit.model, &refit.x0, data);
    (rival.model, rival.x0) = (refit.model, refit.x0);
    if options.refine {
        refine(data, &mut rival, ROUGH)?;
    }
    Ok(rival)
}

impl Candidate {
    fn new(start: Start, feedthrough: bool) -> Self {
        Self {
            approach: start.method.into(),
            realization: start.realization,
            horizon: start.horizon,
            singular_values: start.singular_values,
            model: start.model,
            x0: start.x0,
            filtered: None,
            estimation_fit: f64::NEG_INFINITY,
            validation_fit: f64::NEG_INFINITY,
            criterion: f64::INFINITY,
            stabilised: start.stabilised,
            refused: None,
            has_logarithm: false,
            feedthrough,
            errors: start.errors,
        }
    }
}

fn refine(data: &DataSet, candidate: &mut Candidate, stop: Stop) -> Result<(), Error> {
    if candidate.filtered.is_some() {
        return refine_predictor(data, candidate, stop);
    }
    let radius = largest_radius(data.samples()).max(candidate.model.spectral_radius());
    let (model, x0) = refine_output_error(
        &candidate.model,
        &candidate.x0,
        data,
        candidate.feedthrough,
        stop,
        (radius + 1e-12).min(1.0),
    )?;
    candidate.errors = errors(&model, &x0, data);
    (candidate.model, candidate.x0) = (model, x0);
    Ok(())
}

/// Refines by the prediction errors; a step to an unstable A, which they allow, is not taken.
fn refine_predictor(data: &DataSet, candidate: &mut Candidate, stop: Stop) -> Result<(), Error> {
    let Some(Filtered { gain, x0 }) = candidate.filtered.clone() else { return Ok(()) };
    let start = Innovation { model: candidate.model.clone(), gain };
    let found =
        refine_prediction(&start, &x0, data, candidate.feedthrough, Focus::Prediction, stop, 1.0)?;
    let Innovation { model, gain } = found.innovation;
    let radius = model.spectral_radius();
    candidate.refused = (radius >= 1.0).then_some(radius);
    if candidate.refused.is_none() {
        candidate.errors = prediction_errors(&predictor(&model, gain.as_ref()), &found.x0s, data);
        candidate.model = model;
        candidate.filtered = Some(Filtered { gain, x0: found.x0s });
    }
    Ok(())
}

fn simulated_states(model: &StateSpace, data: &DataSet) -> Result<Vec<Vec<f64>>, Error> {
    let segments = data.segments().iter();
    segments.map(|s| initial_state(model, s.u.as_ref(), s.y.as_ref())).collect()
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
    simulated_states(model, &part.data)
}
