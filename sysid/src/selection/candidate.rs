//! A model of one order among those that are compared.

use crate::Error;
use crate::data::DataSet;
use crate::data::scaled::{Data, Part};
use crate::model::stability::{TIME_CONSTANTS, radius_of_slowest};
use crate::model::{StateSpace, simulate};
use crate::pem::{Stop, by_simulation};
use crate::selection::initial_conditions::InitialConditions;
use crate::selection::options::Method;
use crate::subspace::closed_loop::Feedback;
use crate::subspace::{Factor, Realization};

/// Enough to compare orders.
pub(crate) const ROUGH: Stop = Stop { steps: 25, least_gain: 2e-5 };
/// For the chosen order.
pub(crate) const FINE: Stop = Stop { steps: 40, least_gain: 1e-9 };

/// A stable model of some order in scaled units, first as a method estimated it.
#[derive(Debug, Clone)]
pub(crate) struct Candidate {
    pub(crate) method: Method,
    pub(crate) realization: Realization,
    pub(crate) horizon: usize,
    /// All of the decomposition that it was read from.
    pub(crate) singular_values: Vec<f64>,
    pub(crate) model: StateSpace,
    /// Of the data that it was made with; of the estimation data in the end.
    pub(crate) initial_conditions: InitialConditions,
    pub(crate) feedthrough: bool,
    /// As [`IdentifyOptions::time_constants`](crate::IdentifyOptions::time_constants).
    pub(crate) time_constants: f64,
    /// Sum of squared simulation errors of the initial estimate, or of its least squares.
    pub(crate) cost: f64,
    /// What stability cost, where the subspace estimate was unstable.
    pub(crate) stabilised: Option<Stabilised>,
    pub(crate) estimation_fit: f64,
    pub(crate) validation_fit: f64,
    /// Σ_i ln V_i of the one-step prediction errors that it is compared by.
    pub(crate) log_square: f64,
    /// BIC; of two orders the one with the lesser is the likelier.
    pub(crate) criterion: f64,
    pub(crate) has_logarithm: bool,
    /// Share by which the squared errors grew for a logarithm's sake.
    pub(crate) mirroring_cost: Option<f64>,
    /// The model of this order that predicts best along with a noise model, if errors correlate.
    pub(crate) direct: Option<StateSpace>,
}

/// What it took to make an estimate stable.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Stabilised {
    pub(crate) radius: f64,
    /// Simulation fit on the estimation data before, B and x0 fitted as after, percent, and no less than
    /// that of no output; −∞ where there is no such fit.
    pub(crate) fit_before: f64,
    pub(crate) fit_after: f64,
}

/// All orders that were tried, the chosen one, and its factor.
pub(crate) struct Choice {
    pub(crate) candidates: Vec<Candidate>,
    pub(crate) chosen: usize,
    pub(crate) factor: Factor,
    /// The test for feedback, where the data are enough for it.
    pub(crate) feedback: Option<Feedback>,
    /// The data that were fitted, where they are not the estimation data: two-stage or whitened.
    pub(crate) fitted: Option<DataSet>,
    /// Why the likeliest order was not chosen.
    pub(crate) warning: Option<String>,
}

impl Candidate {
    /// An initial estimate by eq 12 that has not been compared yet.
    pub(crate) fn new(
        method: impl Into<Method>,
        horizon: usize,
        singular_values: &[f64],
        (model, initial_conditions): (StateSpace, InitialConditions),
        feedthrough: bool,
        cost: f64,
    ) -> Self {
        Self {
            method: method.into(),
            realization: Realization::Eq12,
            horizon,
            singular_values: singular_values.to_vec(),
            model,
            initial_conditions,
            feedthrough,
            time_constants: TIME_CONSTANTS,
            cost,
            stabilised: None,
            estimation_fit: f64::NEG_INFINITY,
            validation_fit: f64::NEG_INFINITY,
            log_square: f64::INFINITY,
            criterion: f64::INFINITY,
            has_logarithm: false,
            mirroring_cost: None,
            direct: None,
        }
    }
}

/// Refines by the simulation errors of these data.
pub(crate) fn refine(data: &DataSet, candidate: &mut Candidate, stop: Stop) -> Result<(), Error> {
    refine_within(data, data.samples(), candidate, stop)
}

/// Refines by the simulation errors of data that represent so many samples.
pub(crate) fn refine_within(
    data: &DataSet,
    samples: usize,
    candidate: &mut Candidate,
    stop: Stop,
) -> Result<(), Error> {
    let model = &candidate.model;
    let slowest = radius_of_slowest(samples, candidate.time_constants);
    let radius = slowest.max(model.spectral_radius());
    let from = InitialConditions::new(model, data, candidate.initial_conditions.offsets.is_some())?;
    let found = by_simulation(
        model,
        (&from.x0, from.offsets.as_deref()),
        data,
        candidate.feedthrough,
        stop,
        (radius + 1e-12).min(1.0),
    )?;
    candidate.model = found.point.model;
    let (x0, offsets) = (found.point.x0s, found.point.offsets);
    candidate.initial_conditions = InitialConditions { x0, offsets };
    Ok(())
}

/// The simulated output of a part of the data, in one run from the state at the beginning of the log's segment: with an
/// initial state for each part, an error of a slow mode would not show.
pub(crate) fn simulated(model: &StateSpace, data: &Data, part: &Part) -> Result<Vec<f64>, Error> {
    Ok(part.samples(&simulated_whole(model, data)?))
}

/// The same of all samples of the log.
pub(crate) fn simulated_whole(model: &StateSpace, data: &Data) -> Result<Vec<f64>, Error> {
    let whole = &data.whole;
    let mut all = vec![0.0; whole.ranges.last().map_or(0, |r| r.end)];
    whole.put(&from_initial_states(model, whole)?, &mut all);
    Ok(all)
}

/// The simulated output of a part, from the state at the beginning of each segment that fits its output best.
fn from_initial_states(model: &StateSpace, part: &Part) -> Result<Vec<f64>, Error> {
    Ok(output(model, part, &InitialConditions::new(model, &part.data, false)?.x0))
}

/// The same from stated states.
pub(crate) fn output(model: &StateSpace, part: &Part, x0: &[Vec<f64>]) -> Vec<f64> {
    let mut all = Vec::with_capacity(part.len());
    for (segment, x0) in part.data.segments().iter().zip(x0) {
        all.extend(simulate(model, segment.u.as_ref(), x0).row(0));
    }
    all
}
