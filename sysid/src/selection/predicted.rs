//! Initial estimates from closed-loop data: A and C of the [predictor-based
//! methods](crate::subspace::closed_loop); B, D and the initial states make the simulation of the
//! [two-stage input](crate::selection::two_stage) best.

use crate::Error;
use crate::data::DataSet;
use crate::model::stability::radius_of_slowest;
use crate::model::{Innovation, StateSpace, predictor, predictor_state};
use crate::pem::{Focus, Refined, Stop, refine_prediction};
use crate::selection::candidate::{Candidate, ROUGH, Stabilised};
use crate::selection::initial_conditions::InitialConditions;
use crate::selection::initial_estimates::{least_cost, refit_about};
use crate::selection::options::IdentifyOptions;
use crate::selection::order::{fit, fit_of, sum_of_squares};
use crate::selection::two_stage::two_stage_input;
use crate::subspace::Factor;
use crate::subspace::closed_loop::{
    ClosedLoopMethod, Decomposition, decompose, factor, past_horizon,
};

/// Longest past that is tried, s: the memory of lateral dynamics and of what disturbs them.
const MEMORY_S: f64 = 2.0;
/// Windows for each regressor of the longest.
const WINDOWS: usize = 20;

/// The decomposition of each method, of which the models of all orders are read.
pub(crate) struct Predicted {
    past: usize,
    factor: Factor,
    decompositions: Vec<(ClosedLoopMethod, Decomposition)>,
    pub(crate) two_stage_input: DataSet,
    refined: bool,
    offset: bool,
    time_constants: f64,
}

impl Predicted {
    pub(crate) fn new(
        data: &DataSet,
        options: &IdentifyOptions,
        methods: &[ClosedLoopMethod],
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
                let order = past_horizon(&factor, most, feedthrough)?;
                (2 * order).clamp(states.min(most), most)
            }
        };
        let future = states.min(past);
        let decompositions = methods
            .iter()
            .map(|&m| Ok((m, decompose(&factor, m, past, future, feedthrough)?)))
            .collect::<Result<_, Error>>()?;
        let two_stage_input = two_stage_input(data, &factor, past)?;
        let (refined, offset) = (options.refine, options.has_output_offset());
        let time_constants = options.time_constants;
        Ok(Self { past, factor, decompositions, two_stage_input, refined, offset, time_constants })
    }

    pub(crate) fn largest_order(&self) -> usize {
        self.decompositions.iter().map(|(_, d)| d.largest_order()).max().unwrap_or(0)
    }

    /// The R factor of the data, and the data with the two-stage input estimate.
    pub(crate) fn into_parts(self) -> (Factor, DataSet) {
        (self.factor, self.two_stage_input)
    }

    /// The model of an order that simulates the two-stage input best: one of those that the methods estimate, or that of
    /// them which predicts `data` best, refined by its prediction errors.
    pub(crate) fn best(
        &self,
        data: &DataSet,
        order: usize,
        feedthrough: bool,
    ) -> Result<Candidate, Error> {
        let radius = radius_of_slowest(data.samples(), self.time_constants);
        let mut all = Vec::new();
        let mut best: Option<(usize, Predicting)> = None;
        for (place, (_, decomposition)) in self.decompositions.iter().enumerate() {
            let found = decomposition.stable_model(order, radius);
            if self.refined
                && let Ok(found) = &found
                && let Ok(start) = Predicting::new(found, data)
                && best.as_ref().is_none_or(|(_, best)| start.cost < best.cost)
            {
                best = Some((place, start));
            }
            let start = |found: Innovation| self.start(place, &found.model, feedthrough, radius);
            all.push(found.and_then(start));
        }
        if let Some((place, start)) = best {
            let refined = start.refined(data, feedthrough, radius);
            all.push(
                refined.and_then(|found| self.start(place, &found.model, feedthrough, radius)),
            );
        }
        least_cost(all.into_iter(), Error::no_model("no method could be tried"))
    }

    /// A and C of a model by the method at a place, with the rest for the simulation.
    fn start(
        &self,
        place: usize,
        model: &StateSpace,
        feedthrough: bool,
        radius: f64,
    ) -> Result<Candidate, Error> {
        let (method, decomposition) = &self.decompositions[place];
        let mut start =
            self.estimate(*method, model, &decomposition.singular_values, feedthrough)?;
        // Held down to the radius, or near it by itself.
        if model.spectral_radius() > 0.99 * radius {
            let free = decomposition.model(model.order()).ok();
            start.stabilised = free.and_then(|f| self.stabilised(&f.model, &start));
        }
        Ok(start)
    }

    /// A and C of a model with the rest for the simulation of the two-stage input estimate.
    fn estimate(
        &self,
        method: ClosedLoopMethod,
        model: &StateSpace,
        singular_values: &[f64],
        feedthrough: bool,
    ) -> Result<Candidate, Error> {
        let data = &self.two_stage_input;
        let (model, initial_conditions, _) =
            refit_about(&model.a, &model.c, data, feedthrough, self.offset)?;
        let cost = sum_of_squares(&initial_conditions.errors(&model, data));
        if !cost.is_finite() {
            return Err(Error::no_model("the simulation overflows"));
        }
        let found = (model, initial_conditions);
        let new = Candidate::new(method, self.past, singular_values, found, feedthrough, cost);
        Ok(Candidate { time_constants: self.time_constants, ..new })
    }

    /// What stability took of the simulation fit, where the data's own A is unstable.
    fn stabilised(&self, free: &StateSpace, start: &Candidate) -> Option<Stabilised> {
        let radius = free.spectral_radius();
        if radius < 1.0 {
            return None;
        }
        let data = &self.two_stage_input;
        let initial_conditions = InitialConditions::new(free, data, self.offset);
        let fit_before = initial_conditions.map(|c| fit(data, &c.errors(free, data)));
        Some(Stabilised {
            radius,
            fit_before: fit_before.unwrap_or(f64::NEG_INFINITY),
            fit_after: fit_of(data, start.cost),
        })
    }
}

/// An innovation form with the initial states of its predictor.
struct Predicting {
    innovation: Innovation,
    x0: Vec<Vec<f64>>,
    /// Determinant of the covariance of the prediction errors.
    cost: f64,
}

impl Predicting {
    fn new(found: &Innovation, data: &DataSet) -> Result<Self, Error> {
        let predictor = predictor(&found.model, found.gain.as_ref());
        let segments = data.segments().iter();
        let x0 = segments
            .map(|s| predictor_state(&predictor, s.u.as_ref(), s.y.as_ref()))
            .collect::<Result<Vec<_>, _>>()?;
        let mut start = Self { innovation: found.clone(), x0, cost: f64::INFINITY };
        let as_it_is = Stop { steps: 0, least_gain: 0.0 };
        start.cost = start.by_steps(data, false, as_it_is)?.error_covariance.determinant();
        Ok(start)
    }

    fn by_steps(&self, data: &DataSet, feedthrough: bool, stop: Stop) -> Result<Refined, Error> {
        refine_prediction(
            &self.innovation,
            &self.x0,
            data,
            feedthrough,
            Focus::Prediction,
            stop,
            1.0,
        )
    }

    /// Of the least prediction errors, where that leaves A with a spectral radius of at most `radius`.
    fn refined(&self, data: &DataSet, feedthrough: bool, radius: f64) -> Result<Innovation, Error> {
        let found = self.by_steps(data, feedthrough, ROUGH)?.innovation;
        if found.model.spectral_radius() <= radius {
            Ok(found)
        } else {
            Err(Error::no_model(
                "the model of least prediction errors is slower than the data show",
            ))
        }
    }
}
