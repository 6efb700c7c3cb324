//! Models of every order, horizon and weighting asked for, and the choice among them.
//!
//! 1. Every horizon and weighting gives two subspace models of each order: A, C from the shift
//!    structure of Γ and from eq 12 (each regularised where it is unstable), B and the initial state
//!    by least squares on the simulated output. Of the two, which have equally many parameters, the
//!    one that simulates the estimation data better is kept.
//! 2. The horizon and weighting whose best order simulates the held-out data best are kept.
//! 3. Each order's model is refined by its simulation error on the estimation data.
//! 4. The order is the least whose held-out fit is within a tolerance of the best: 0.5 percentage
//!    points, or 2 % of what the best leaves unexplained where that is more. Among these, one
//!    whose A has a real logarithm (eq 9) goes before one without.
//!
//! The held-out data choose, so the fit quoted on them is slightly in favour of the model, which the
//! verdict says; the choice is among a few dozen, and the parameters have not seen these data.

use super::IdentifyOptions;
use super::data::{Data, Part};
use crate::Error;
use crate::conversion::to_continuous;
use crate::model::{StateSpace, initial_state, simulate};
use crate::refine::{Stop, refine_output_error};
use crate::stability::{largest_radius, stable_shift};
use crate::statistics::fit_percent;
use crate::subspace::{
    Factor, Method, Projections, Realization, Subspace, eq12, refit_output, shift_realization,
    stable_eq12, subspace,
};
use faer::Mat;

const HORIZONS: [usize; 4] = [10, 15, 20, 30];
/// Held-out fits within so many percentage points are equally good.
const TOLERANCE_POINTS: f64 = 0.5;
/// … or within that share of what the best fit leaves.
const TOLERANCE_SHARE: f64 = 0.02;
/// Enough to compare orders.
const ROUGH: Stop = Stop { steps: 25, least_gain: 2e-5 };
/// For the chosen order.
const FINE: Stop = Stop { steps: 40, least_gain: 1e-9 };

/// A model in scaled units with its fits.
#[derive(Clone)]
pub(crate) struct Candidate {
    pub(crate) method: Method,
    pub(crate) realization: Realization,
    pub(crate) horizon: usize,
    pub(crate) singular_value: f64,
    pub(crate) model: StateSpace,
    /// State at the first sample of each segment of the estimation data.
    pub(crate) x0: Vec<Vec<f64>>,
    pub(crate) estimation_fit: f64,
    pub(crate) validation_fit: f64,
    /// Spectral radius before stability was enforced, where it was.
    pub(crate) stabilised_from: Option<f64>,
    pub(crate) has_logarithm: bool,
}

/// All orders of the chosen horizon and weighting, which is the chosen one, and its factor.
pub(crate) struct Choice {
    pub(crate) candidates: Vec<Candidate>,
    pub(crate) chosen: usize,
    pub(crate) factor: Factor,
}

pub(crate) fn choose(data: &Data, options: &IdentifyOptions) -> Result<Choice, Error> {
    let horizons = horizons(data, options)?;
    let longest = horizons.iter().copied().max().unwrap_or(2);
    let full = Factor::new(&data.estimation.data, longest)?;
    let methods = options.method.map_or(Method::ALL.to_vec(), |m| vec![m]);
    let mut best: Option<(f64, Factor, Vec<Candidate>)> = None;
    let mut last_error = None;
    for horizon in horizons {
        let factor = full.with_horizon(horizon)?;
        let projections = Projections::new(&factor)?;
        for &method in &methods {
            let sub = subspace(&factor, method)?;
            let mut row = Vec::new();
            for order in orders(options, horizon) {
                let base = Base { factor: &factor, projections: &projections, sub: &sub, method };
                match better(data, options, &base, order) {
                    Ok(candidate) => row.push(candidate),
                    Err(error) => last_error = Some(error),
                }
            }
            let top = row.iter().map(|c| c.validation_fit).fold(f64::NEG_INFINITY, f64::max);
            if !row.is_empty() && best.as_ref().is_none_or(|(fit, ..)| top > *fit) {
                best = Some((top, factor.clone(), row));
            }
        }
    }
    let Some((_, factor, mut candidates)) = best else {
        return Err(last_error
            .unwrap_or_else(|| Error::NoModel { problem: "no order could be tried".into() }));
    };
    for candidate in &mut candidates {
        if options.refine {
            refine(data, options, candidate, ROUGH)?;
        }
        let m = &candidate.model;
        candidate.has_logarithm = to_continuous(m.a.as_ref(), m.b.as_ref(), 1.0).is_ok();
    }
    let chosen = select(&candidates);
    if options.refine {
        refine(data, options, &mut candidates[chosen], FINE)?;
    }
    if !candidates[chosen].validation_fit.is_finite() {
        return Err(Error::NoModel { problem: "no model can be simulated".into() });
    }
    Ok(Choice { candidates, chosen, factor })
}

fn horizons(data: &Data, options: &IdentifyOptions) -> Result<Vec<usize>, Error> {
    if let Some(horizon) = options.horizon {
        return Ok(vec![horizon]);
    }
    // At least twice as many columns as rows: N − 2s + 1 ≥ 8 s for one input and one output.
    let most = data.estimation.len() / 10;
    let least = options.order.map_or(2, |order| order + 2);
    let mut fitting: Vec<usize> =
        HORIZONS.into_iter().filter(|s| (least..=most).contains(s)).collect();
    if fitting.is_empty() {
        if least > most {
            return Err(Error::TooFewSamples {
                got: data.estimation.len() + data.validation.len(),
                need: 20 * least,
                sample_time_s: data.sample_time,
            });
        }
        fitting.push(least.max(most.min(10)));
    }
    Ok(fitting)
}

fn orders(options: &IdentifyOptions, horizon: usize) -> std::ops::RangeInclusive<usize> {
    match options.order {
        Some(order) => order..=order,
        None => 1..=options.max_order.min(horizon - 1),
    }
}

/// What the models of one horizon and weighting are made of.
struct Base<'a> {
    factor: &'a Factor,
    projections: &'a Projections,
    sub: &'a Subspace,
    method: Method,
}

/// A and C with A stable.
struct Realized {
    a: Mat<f64>,
    c: Mat<f64>,
    /// Spectral radius of A before, where it was not.
    stabilised_from: Option<f64>,
}

impl Base<'_> {
    /// A and C of one order; where A is unstable, one of spectral radius `most`.
    fn realize(
        &self,
        realization: Realization,
        order: usize,
        most: f64,
    ) -> Result<Realized, Error> {
        let (factor, sub) = (self.factor, self.sub);
        let (a, c) = match realization {
            Realization::Shift => shift_realization(sub, order, factor.outputs)?,
            Realization::Eq12 => {
                let model = eq12(factor, self.projections, sub, order, false)?;
                (model.a, model.c)
            }
        };
        let radius = crate::dense::spectral_radius(a.as_ref());
        if radius < 1.0 {
            return Ok(Realized { a, c, stabilised_from: None });
        }
        let stable = match realization {
            Realization::Shift => stable_shift(sub.basis.as_ref(), order, factor.outputs, most),
            Realization::Eq12 => stable_eq12(factor, self.projections, sub, order, most)?,
        };
        let a = stable.ok_or(Error::Numerical { what: "stabilisation" })?;
        Ok(Realized { a, c, stabilised_from: Some(radius) })
    }
}

/// The subspace model of one order that simulates the estimation data best.
fn better(
    data: &Data,
    options: &IdentifyOptions,
    base: &Base<'_>,
    order: usize,
) -> Result<Candidate, Error> {
    let realizations = options.realization.map_or(Realization::ALL.to_vec(), |r| vec![r]);
    let mut best: Option<Candidate> = None;
    let mut last_error = Error::NoModel { problem: "no realization could be tried".into() };
    for realization in realizations {
        match start(data, options, base, realization, order) {
            Ok(candidate) => {
                if best.as_ref().is_none_or(|b| candidate.estimation_fit > b.estimation_fit) {
                    best = Some(candidate);
                }
            }
            Err(error) => last_error = error,
        }
    }
    let mut best = best.ok_or(last_error)?;
    measure_validation(data, &mut best)?;
    Ok(best)
}

/// The subspace model of one order and realization, stable, with B and x0 refitted.
fn start(
    data: &Data,
    options: &IdentifyOptions,
    base: &Base<'_>,
    realization: Realization,
    order: usize,
) -> Result<Candidate, Error> {
    let part = &data.estimation;
    let most = largest_radius(part.len());
    let Realized { a, c, stabilised_from } = base.realize(realization, order, most)?;
    let refit = refit_output(a.as_ref(), c.as_ref(), &part.data, options.feedthrough, false)?;
    let mut candidate = Candidate {
        method: base.method,
        realization,
        horizon: base.factor.horizon,
        singular_value: base.sub.singular_values[order - 1],
        model: refit.model,
        x0: refit.x0,
        estimation_fit: 0.0,
        validation_fit: f64::NEG_INFINITY,
        stabilised_from,
        has_logarithm: false,
    };
    measure_estimation(data, &mut candidate);
    Ok(candidate)
}

fn refine(
    data: &Data,
    options: &IdentifyOptions,
    candidate: &mut Candidate,
    stop: Stop,
) -> Result<(), Error> {
    let part = &data.estimation;
    let radius = largest_radius(part.len()).max(candidate.model.spectral_radius());
    let (model, x0) = refine_output_error(
        &candidate.model,
        &candidate.x0,
        &part.data,
        options.feedthrough,
        stop,
        (radius + 1e-12).min(1.0),
    )?;
    candidate.model = model;
    candidate.x0 = x0;
    measure_estimation(data, candidate);
    measure_validation(data, candidate)
}

fn measure_estimation(data: &Data, candidate: &mut Candidate) {
    let part = &data.estimation;
    let y_hat = output(&candidate.model, part, &candidate.x0);
    candidate.estimation_fit = fit_percent(&part.output, &y_hat);
}

fn measure_validation(data: &Data, candidate: &mut Candidate) -> Result<(), Error> {
    let part = &data.validation;
    let x0 = initial_states(&candidate.model, part)?;
    candidate.validation_fit = fit_percent(&part.output, &output(&candidate.model, part, &x0));
    Ok(())
}

/// Simulated output of one part from the states at the beginning of its segments.
pub(crate) fn output(model: &StateSpace, part: &Part, x0: &[Vec<f64>]) -> Vec<f64> {
    let mut all = Vec::with_capacity(part.len());
    for (segment, x0) in part.data.segments().iter().zip(x0) {
        let y = simulate(model, segment.u.as_ref(), x0);
        all.extend((0..y.ncols()).map(|t| y[(0, t)]));
    }
    all
}

/// The states at the beginning of each segment of a part that fit its output best.
pub(crate) fn initial_states(model: &StateSpace, part: &Part) -> Result<Vec<Vec<f64>>, Error> {
    let segments = part.data.segments().iter();
    segments.map(|s| initial_state(model, s.u.as_ref(), s.y.as_ref())).collect()
}

/// The least order that is about as good as the best.
fn select(candidates: &[Candidate]) -> usize {
    let best = candidates.iter().map(|c| c.validation_fit).fold(f64::NEG_INFINITY, f64::max);
    let enough = best - TOLERANCE_POINTS.max(TOLERANCE_SHARE * (100.0 - best));
    let good = |i: &usize| candidates[*i].validation_fit >= enough;
    let order = |i: &usize| candidates[*i].model.order();
    (0..candidates.len())
        .filter(good)
        .filter(|i| candidates[*i].has_logarithm)
        .min_by_key(order)
        .or_else(|| (0..candidates.len()).filter(good).min_by_key(order))
        .unwrap_or(0)
}
