//! A model of one order among those that are compared.

use crate::Error;
use crate::data::DataSet;
use crate::data::scaled::Part;
use crate::model::stability::largest_radius;
use crate::model::{StateSpace, simulate};
use crate::pem::{Stop, refine_about_offsets};
use crate::selection::initial_conditions::InitialConditions;
use crate::selection::initial_estimates::{InitialEstimate, Stabilised};
use crate::selection::method::Method;
use crate::subspace::closed_loop::Feedback;
use crate::subspace::{Factor, Realization};

/// Enough to compare orders.
pub(crate) const ROUGH: Stop = Stop { steps: 25, least_gain: 2e-5 };
/// For the chosen order.
pub(crate) const FINE: Stop = Stop { steps: 40, least_gain: 1e-9 };
/// A model in scaled units with its fits.
#[derive(Debug, Clone)]
pub(crate) struct Candidate {
    pub(crate) method: Method,
    pub(crate) realization: Realization,
    pub(crate) horizon: usize,
    /// All of the decomposition that it was read from.
    pub(crate) singular_values: Vec<f64>,
    pub(crate) model: StateSpace,
    /// At the beginning of each segment of the data that it was made with; of the estimation data in the
    /// end.
    pub(crate) initial_conditions: InitialConditions,
    pub(crate) estimation_fit: f64,
    pub(crate) validation_fit: f64,
    /// Σ_i ln V_i of the one-step prediction errors that it is compared by.
    pub(crate) log_square: f64,
    /// BIC; of two orders the one with the lesser is the likelier.
    pub(crate) criterion: f64,
    /// What stability cost, where the subspace estimate was unstable.
    pub(crate) stabilised: Option<Stabilised>,
    pub(crate) has_logarithm: bool,
    /// Share by which the squared errors grew for a logarithm's sake.
    pub(crate) mirroring_cost: Option<f64>,
    pub(crate) feedthrough: bool,
    /// The model of this order that predicts best along with a model of the noise, where the errors are
    /// correlated; under feedback it may be the one that is taken.
    pub(crate) direct: Option<StateSpace>,
}

/// All orders that were tried, the chosen one, and its factor.
pub(crate) struct Choice {
    pub(crate) candidates: Vec<Candidate>,
    pub(crate) chosen: usize,
    pub(crate) factor: Factor,
    /// The test for feedback, where the data are enough for it.
    pub(crate) feedback: Option<Feedback>,
    /// The data whose simulation error the chosen model makes small, about their offset, where they are
    /// not the estimation data themselves: with the two-stage input estimate, or whitened.
    pub(crate) fitted: Option<DataSet>,
}

impl Candidate {
    pub(crate) fn new(start: InitialEstimate, feedthrough: bool) -> Self {
        Self {
            method: start.method,
            realization: start.realization,
            horizon: start.horizon,
            singular_values: start.singular_values,
            model: start.model,
            initial_conditions: start.initial_conditions,
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
    let radius = largest_radius(samples).max(model.spectral_radius());
    let from = InitialConditions::new(model, data, candidate.initial_conditions.offsets.is_some())?;
    let ((model, x0), offsets) = refine_about_offsets(
        model,
        (&from.x0, from.offsets.as_deref()),
        data,
        candidate.feedthrough,
        stop,
        (radius + 1e-12).min(1.0),
    )?;
    (candidate.model, candidate.initial_conditions) = (model, InitialConditions { x0, offsets });
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
    Ok(InitialConditions::new(model, &part.data, false)?.x0)
}
