//! Starts from closed-loop data: predictor-based models of every order, judged by one-step prediction.
//!
//! Where the input depends on past outputs, simulation errors are correlated with it and whatever
//! makes them small is biased; one-step prediction errors of the innovation form are not
//! ([`closed_loop`](crate::closed_loop)). So here both the choice of the order and the refinement go
//! by prediction errors, and the dynamics of the disturbance count as states of the model.

use super::IdentifyOptions;
use super::candidates::{Candidate, Filtered};
use super::order::{Errors, errors, fit, sum_of_squares};
use super::starts::Stabilised;
use crate::closed_loop::{Criterion, Decomposition, Method, decompose, factor, past_horizon};
use crate::model::{Innovation, StateSpace, predictions, predictor, predictor_state};
use crate::stability::largest_radius;
use crate::subspace::{Factor, Realization};
use crate::{DataSet, Error};

/// Longest past that is tried, s: the memory of lateral dynamics and of what disturbs them.
const MEMORY_S: f64 = 2.0;
/// Windows for each regressor of the longest.
const WINDOWS: usize = 20;

/// The decomposition of each method, of which the models of all orders are read.
pub(super) struct Predicted<'a> {
    data: &'a DataSet,
    past: usize,
    factor: Factor,
    decompositions: Vec<(Method, Decomposition)>,
}

impl<'a> Predicted<'a> {
    pub(super) fn new(
        data: &'a DataSet,
        options: &IdentifyOptions,
        methods: &[Method],
    ) -> Result<Self, Error> {
        let feedthrough = options.feedthrough == Some(true);
        let width = data.inputs() + data.outputs();
        let states = options.order.unwrap_or(options.max_order).div_ceil(data.outputs()) + 1;
        let most = match options.horizon {
            Some(horizon) => horizon,
            None => ((MEMORY_S / data.sample_time_s()).round() as usize)
                .clamp(2 * states, 60)
                .min(data.samples() / (WINDOWS * width))
                .max(states),
        };
        let factor = factor(data, most, states.min(most))?;
        let past = match options.horizon {
            Some(horizon) => horizon,
            // Twice Akaike's order, as its criterion balances the bias that is to vanish here.
            None => {
                let order = past_horizon(&factor, most, Criterion::Aic, feedthrough)?;
                (2 * order).clamp(states.min(most), most)
            }
        };
        let future = states.min(past);
        let decompositions = methods
            .iter()
            .map(|&m| Ok((m, decompose(&factor, m, past, future, feedthrough)?)))
            .collect::<Result<_, Error>>()?;
        Ok(Self { data, past, factor, decompositions })
    }

    pub(super) fn largest_order(&self) -> usize {
        self.decompositions.iter().map(|(_, d)| d.largest_order()).max().unwrap_or(0)
    }

    pub(super) fn into_factor(self) -> Factor {
        self.factor
    }

    /// The model of an order that predicts the estimation data best.
    pub(super) fn best(&self, order: usize, feedthrough: bool) -> Result<Candidate, Error> {
        let mut best: Option<(f64, Candidate)> = None;
        let mut last_error = Error::NoModel { problem: "no method could be tried".into() };
        for (method, decomposition) in &self.decompositions {
            match self.start(*method, decomposition, order, feedthrough) {
                Ok(candidate) => {
                    let cost = sum_of_squares(&candidate.errors);
                    if best.as_ref().is_none_or(|(least, _)| cost < *least) {
                        best = Some((cost, candidate));
                    }
                }
                Err(error) => last_error = error,
            }
        }
        best.map(|(_, candidate)| candidate).ok_or(last_error)
    }

    fn start(
        &self,
        method: Method,
        decomposition: &Decomposition,
        order: usize,
        feedthrough: bool,
    ) -> Result<Candidate, Error> {
        let radius = largest_radius(self.data.samples());
        let Innovation { model, gain } = decomposition.stable_model(order, radius)?;
        let predictor = predictor(&model, gain.as_ref());
        let x0 = states(&predictor, self.data)?;
        let errors = prediction_errors(&predictor, &x0, self.data);
        if !sum_of_squares(&errors).is_finite() {
            return Err(Error::NoModel { problem: "the predictor overflows".into() });
        }
        // Held down to the radius, or near it by itself: which, the data without the penalty tell.
        let stabilised = if model.spectral_radius() > 0.99 * radius {
            decomposition.model(order).ok().and_then(|free| self.stabilised(&free.model, &model))
        } else {
            None
        };
        Ok(Candidate {
            approach: method.into(),
            realization: Realization::Eq12,
            horizon: self.past,
            singular_values: decomposition.singular_values.clone(),
            model,
            x0: Vec::new(),
            filtered: Some(Filtered { gain, x0 }),
            estimation_fit: f64::NEG_INFINITY,
            validation_fit: f64::NEG_INFINITY,
            criterion: f64::INFINITY,
            stabilised,
            refused: None,
            has_logarithm: false,
            feedthrough,
            errors,
        })
    }
}

impl Predicted<'_> {
    /// What stability took of the simulation fit, where the data's own A is unstable.
    fn stabilised(&self, free: &StateSpace, stable: &StateSpace) -> Option<Stabilised> {
        let radius = free.spectral_radius();
        let simulated = |model: &StateSpace| {
            let x0: Result<Vec<_>, _> = self
                .data
                .segments()
                .iter()
                .map(|s| initial_state(model, s.u.as_ref(), s.y.as_ref()))
                .collect();
            x0.map_or(f64::NEG_INFINITY, |x0| fit(self.data, &errors(model, &x0, self.data)))
        };
        (radius >= 1.0).then(|| Stabilised {
            radius,
            fit_before: simulated(free),
            fit_after: simulated(stable),
        })
    }
}

/// The states of a predictor at the beginning of each segment.
fn states(predictor: &StateSpace, data: &DataSet) -> Result<Vec<Vec<f64>>, Error> {
    let segments = data.segments().iter();
    segments.map(|s| predictor_state(predictor, s.u.as_ref(), s.y.as_ref())).collect()
}

/// What a predictor misses of each segment.
pub(super) fn prediction_errors(predictor: &StateSpace, x0: &[Vec<f64>], data: &DataSet) -> Errors {
    let segments = data.segments().iter().zip(x0);
    let of = |(s, x0): (&crate::Segment, &Vec<f64>)| {
        &s.y - predictions(predictor, s.u.as_ref(), s.y.as_ref(), x0)
    };
    segments.map(of).collect()
}
