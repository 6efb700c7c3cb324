//! The choice of a model from data in memory.
//!
//! Without feedback each order's initial estimate is the subspace model of any horizon and
//! weighting that simulates the estimation data best ([`InitialEstimates`]), and the
//! [search](ascend) runs once more with feedthrough where the criterion requires it
//! ([`wants_feedthrough`]). Under feedback it is the best predictor-based one ([`Predicted`]); the
//! input of the simulation is the [two-stage estimate](crate::selection::two_stage), unless the
//! model that predicts best is the better simulator ([`finish`]). The validation data take no part but for the initial states of
//! blocks ([`simulated`]).

use crate::Error;
use crate::data::DataSet;
use crate::data::scaled::{Data, Part};
use crate::data::split::Selection;
use crate::data::statistics::fit_percent;
use crate::model::StateSpace;
use crate::selection::candidate::{Candidate, Choice, FINE, ROUGH, simulated};
use crate::selection::in_memory::{Estimates, InMemory};
use crate::selection::initial_conditions::InitialConditions;
use crate::selection::initial_estimates::InitialEstimates;
use crate::selection::options::{IdentifyOptions, Method};
use crate::selection::order::{AS_LIKELY, fit, sum_of_squares};
use crate::selection::predicted::Predicted;
use crate::selection::search::{
    AHEAD_S, Estimator, MEMORY_S, ascend, closed_loop_methods, criterion, least, select, weigh,
    with_logarithm,
};
use crate::subspace::closed_loop::{ClosedLoopMethod, feedback};

/// Errors of the simulation in one run that are larger by this share are those of a worse model.
const WORSE: f64 = 1.01;

/// Chooses for a vehicle. Where estimation and validation data are blocks of a drive, an error of a slow mode can hide
/// in the blocks' initial states: of the orders up to the likeliest, the one that simulates the estimation data best in one
/// run is taken where the likeliest is clearly worse.
pub(crate) fn choose(data: &Data, options: &IdentifyOptions) -> Result<Choice, Error> {
    let (estimation, validation) = (&data.estimation.data, &data.validation.data);
    let options = &IdentifyOptions {
        // The steering is the mean over the sample that follows: a gain on it is none of the continuous vehicle, of which the
        // packed plant between the samples is another model.
        feedthrough: Some(options.feedthrough == Some(true)),
        time_constants: options.time_constants * data.records_of_blocks(),
        ..options.clone()
    };
    let mut choice = choose_from(estimation, validation, options, true)?;
    measure_in_one_run(data, &mut choice.candidates)?;
    if data.selection == Selection::End {
        return Ok(choice);
    }
    let chosen = &choice.candidates[choice.chosen];
    let (order, error) = (chosen.model.order(), 100.0 - chosen.estimation_fit);
    let lower = choice.candidates.iter().filter(|c| c.model.order() < order);
    let best = lower.max_by(|a, b| a.estimation_fit.total_cmp(&b.estimation_fit));
    let Some(best) = best.filter(|c| error > WORSE * (100.0 - c.estimation_fit)) else {
        return Ok(choice);
    };
    let best = best.model.order();
    let stated = IdentifyOptions { order: Some(best), ..options.clone() };
    let mut found = choose_from(estimation, validation, &stated, true)?;
    measure_in_one_run(data, &mut found.candidates)?;
    found.warning = Some(format!(
        "order {order} predicts best, and simulates the drive in one run with an error of {error:.1} % of the yaw rate, order {best} with {:.1} %: order {best} is taken",
        100.0 - found.candidates[found.chosen].estimation_fit
    ));
    // The orders that were tried stay in the table and in the uncertainty.
    let tried = choice.candidates.into_iter().filter(|c| c.model.order() != best);
    found.candidates.extend(tried);
    Ok(found)
}

/// The fits of the simulation in one run.
fn measure_in_one_run(data: &Data, candidates: &mut [Candidate]) -> Result<(), Error> {
    for candidate in candidates {
        let about =
            candidate.initial_conditions.offsets.as_deref().map_or(0.0, |offsets| offsets[0]);
        let data = data.clone().about(about)?;
        let fit = |part: &Part| -> Result<f64, Error> {
            Ok(fit_percent(&part.output, &simulated(&candidate.model, &data, part)?))
        };
        (candidate.estimation_fit, candidate.validation_fit) =
            (fit(&data.estimation)?, fit(&data.validation)?);
    }
    Ok(())
}

/// Chooses what the options leave open, for a `vehicle` or any system.
pub(crate) fn choose_from(
    data: &DataSet,
    validation: &DataSet,
    options: &IdentifyOptions,
    vehicle: bool,
) -> Result<Choice, Error> {
    // What is not of a vehicle answers within so many samples.
    const SAMPLES: [f64; 2] = [40.0, 20.0];
    let [memory_s, ahead_s] = match vehicle {
        true => [MEMORY_S, AHEAD_S],
        false => SAMPLES.map(|count| count * data.sample_time_s()),
    };
    let feedback = feedback(data, memory_s, ahead_s).ok();
    let closed = closed_loop_methods(options, feedback);
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
        return Err(Error::no_model("no model can be simulated"));
    }
    Ok(choice)
}

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

fn open_loop(data: &DataSet, options: &IdentifyOptions, vehicle: bool) -> Result<Choice, Error> {
    let initial_estimates = InitialEstimates::new(data, options)?;
    let estimates = Estimates::OpenLoop(&initial_estimates);
    let mut on = InMemory::new((data, data), options, estimates, vehicle)?;
    let mut candidates = ascend(&on, options.feedthrough == Some(true))?;
    let mut chosen = select(&on, &mut candidates);
    // At a stated order, a direct gain could represent states that are not allowed.
    let open = options.feedthrough.is_none() && options.order.is_none();
    if open && wants_feedthrough(&on, &initial_estimates, &candidates, chosen) {
        let mut others = ascend(&on, true)?;
        let other = select(&on, &mut others);
        // The same poles without: what the first pass may not have found.
        let rival = without_feedthrough(&on, &others[other])?;
        let mut finals = vec![candidates[chosen].clone(), rival, others[other].clone()];
        let least = least(&on, &mut finals);
        // The evidence for feedthrough is strong.
        let sure = finals[..2].iter().all(|c| finals[2].criterion + AS_LIKELY < c.criterion);
        if sure {
            (candidates, chosen) = (others, other);
        } else if least != 0 && finals[1].criterion < finals[0].criterion {
            let rival = finals.swap_remove(1);
            let same = |c: &Candidate| c.model.order() == rival.model.order();
            match candidates.iter().position(same) {
                Some(at) => candidates[at] = rival,
                None => candidates.push(rival),
            }
            chosen = select(&on, &mut candidates);
        }
    }
    let had_output_offset = on.offset;
    on.settle_output_offset(&mut candidates, chosen)?;
    if options.refine {
        let of = &mut candidates[chosen];
        if had_output_offset && !on.offset {
            on.refit(of)?;
        }
        on.refine(of, FINE)?;
    }
    chosen = with_logarithm(&on, &mut candidates, chosen)?;
    let factor = initial_estimates
        .into_factor(candidates[chosen].horizon)
        .ok_or(Error::no_model("the chosen horizon was not tried"))?;
    Ok(Choice { candidates, chosen, factor, feedback: None, fitted: None, warning: None })
}

/// The choice under feedback; D, like the feedback's own gain, is zero unless requested.
fn in_a_loop(
    data: &DataSet,
    options: &IdentifyOptions,
    methods: &[ClosedLoopMethod],
    vehicle: bool,
) -> Result<Choice, Error> {
    let predicted = Predicted::new(data, options, methods)?;
    let by = &predicted.two_stage_input;
    let others =
        if options.method.is_none() { Some(InitialEstimates::new(by, options)?) } else { None };
    let estimates = Estimates::ClosedLoop(&predicted, others);
    let mut on = InMemory::new((data, by), options, estimates, vehicle)?;
    let mut candidates = ascend(&on, options.feedthrough == Some(true))?;
    let mut chosen = select(&on, &mut candidates);
    on.settle_output_offset(&mut candidates, chosen)?;
    let whitened = if options.refine { finish(&on, &mut candidates[chosen])? } else { None };
    let fitted = whitened.as_ref().unwrap_or(by);
    chosen = with_logarithm(&on.fitting(fitted), &mut candidates, chosen)?;
    let (factor, two_stage_input) = predicted.into_parts();
    let fitted = Some(whitened.unwrap_or(two_stage_input));
    Ok(Choice { candidates, chosen, factor, feedback: None, fitted, warning: None })
}

/// Takes the better simulator of the estimation data of the two-stage model and the one that
/// predicts best; returns the whitened data of the latter.
fn finish(on: &InMemory<'_>, chosen: &mut Candidate) -> Result<Option<DataSet>, Error> {
    on.refine(chosen, FINE)?;
    let Some(model) = chosen.direct.take() else { return Ok(None) };
    let mut direct = Candidate { model, ..chosen.clone() };
    let whitened = on.refine_predictions(&mut direct, FINE)?;
    let cost = |model: &StateSpace| -> Result<f64, Error> {
        let initial_conditions = InitialConditions::new(model, on.data, on.offset)?;
        Ok(sum_of_squares(&initial_conditions.errors(model, on.data)))
    };
    if cost(&direct.model)? < cost(&chosen.model)? {
        *chosen = direct;
        return Ok(Some(whitened));
    }
    Ok(None)
}

/// Whether a direct gain with B lowers the criterion, at the chosen order or the one before.
fn wants_feedthrough(
    on: &InMemory<'_>,
    initial_estimates: &InitialEstimates<'_>,
    candidates: &[Candidate],
    chosen: usize,
) -> bool {
    candidates[chosen.saturating_sub(1)..=chosen].iter().any(|c| {
        let criterion = |feedthrough: bool| {
            let Method::OpenLoop(method) = c.method else { return None };
            let order = c.model.order();
            let mut start =
                initial_estimates.again((c.horizon, method, c.realization), order, feedthrough)?;
            start.log_square = on.log_square(&start).ok()?;
            Some(criterion(on, &start))
        };
        matches!((criterion(true), criterion(false)), (Some(a), Some(b)) if a < b)
    })
}

fn without_feedthrough(on: &InMemory<'_>, from: &Candidate) -> Result<Candidate, Error> {
    let mut rival = Candidate { feedthrough: false, ..from.clone() };
    on.refit(&mut rival)?;
    if on.options.refine {
        on.refine(&mut rival, ROUGH)?;
    }
    weigh(on, &mut rival, Vec::new())?;
    Ok(rival)
}
