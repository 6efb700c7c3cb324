//! The R factor of accumulated drives, as the [search](crate::selection::search) uses it: models of
//! open-loop methods are refined by simulation errors on its
//! [windows](crate::structures::state_space::accumulated::windows), under feedback by
//! [prediction](crate::structures::state_space::accumulated::prediction) errors, which it does not bias.

use crate::Error;
use crate::model::StateSpace;
use crate::model::stability::largest_radius;
use crate::pem::{Stop, refine_gain};
use crate::selection::candidate::{Candidate, Choice, FINE, ROUGH, refine_within};
use crate::selection::initial_conditions::InitialConditions;
use crate::selection::initial_estimates::{
    Fitted, InitialEstimates, horizons_of, least_cost, refit_about,
};
use crate::selection::options::IdentifyOptions;
use crate::selection::order::sum_of_squares;
use crate::selection::search::{
    AHEAD_S, Counts, Estimator, MEMORY_S, ascend, closed_loop_methods, largest_estimate, select,
    with_logarithm,
};
use crate::structures::state_space::accumulated::prediction::PlantAndNoise;
use crate::structures::state_space::accumulated::windows::Windows;
use crate::subspace::closed_loop::{
    ClosedLoopMethod, Decomposition, decompose, feedback_in, feedback_lags,
};
use crate::subspace::{Factor, noise_model};
use faer::Mat;

/// Chooses order, method and horizon; `samples` is the number that was accumulated.
pub(crate) fn choose(
    factor: &Factor,
    windows: &Windows,
    samples: usize,
    options: &IdentifyOptions,
) -> Result<Choice, Error> {
    let (past, ahead) =
        feedback_lags((MEMORY_S, AHEAD_S), windows.data.sample_time_s(), windows.length);
    let feedback = feedback_in(factor, past, ahead).ok();
    let closed = closed_loop_methods(options, feedback);
    let estimates = if closed.is_empty() {
        let fitted =
            Fitted { data: &windows.data, samples, output_scale: windows.scales[1], offset: false };
        let horizons = horizons_of(factor, options);
        Estimates::OpenLoop(InitialEstimates::of_factor(factor, horizons, fitted, options)?)
    } else {
        let past = past.min(windows.length - ahead - 1);
        let future = (past / 2).clamp(2, 15);
        let of = |&m: &ClosedLoopMethod| Ok((m, decompose(factor, m, past, future, false)?));
        Estimates::ClosedLoop(past, closed.iter().map(of).collect::<Result<_, Error>>()?)
    };
    let mut on = InWindows { windows, options, samples, estimates, noise_order: 0 };
    let feedthrough = options.feedthrough == Some(true);
    // In a loop a model of the noise is needed for a stated order too.
    if on.looped() || options.order.is_none() {
        let best = |order| on.best(order, feedthrough);
        let largest = largest_estimate(options, on.largest_order(), best)?;
        on.noise_order = PlantAndNoise::noise_order(windows, &largest.model);
    }
    let mut candidates = ascend(&on, feedthrough)?;
    let chosen = select(&on, &mut candidates);
    if options.refine {
        on.refine(&mut candidates[chosen], FINE)?;
    }
    let chosen = with_logarithm(&on, &mut candidates, chosen)?;
    Ok(Choice { candidates, chosen, factor: factor.clone(), feedback, fitted: None, warning: None })
}

struct InWindows<'a> {
    windows: &'a Windows,
    options: &'a IdentifyOptions,
    samples: usize,
    estimates: Estimates<'a>,
    /// Order of the noise's autoregression, as the largest model leaves it.
    noise_order: usize,
}

enum Estimates<'a> {
    OpenLoop(InitialEstimates<'a>),
    /// By predictor-based methods, with their past horizon.
    ClosedLoop(usize, Vec<(ClosedLoopMethod, Decomposition)>),
}

impl InWindows<'_> {
    fn looped(&self) -> bool {
        matches!(self.estimates, Estimates::ClosedLoop(..))
    }

    fn best(&self, order: usize, feedthrough: bool) -> Result<Candidate, Error> {
        let (past, states) = match &self.estimates {
            Estimates::OpenLoop(all) => return all.best(order, feedthrough),
            Estimates::ClosedLoop(past, states) => (*past, states),
        };
        let [u, y] = self.windows.scales;
        let radius = largest_radius(self.samples);
        let of =
            |(method, states): &(ClosedLoopMethod, Decomposition)| -> Result<Candidate, Error> {
                let model =
                    states.stable_model(order, radius)?.model.scaled(&[1.0 / u], &[1.0 / y]);
                let cost = self.plant_and_noise(&model)?.variance(self.windows);
                let found = (model, InitialConditions { x0: Vec::new(), offsets: None });
                let values = &states.singular_values;
                Ok(Candidate::new(*method, past, values, found, feedthrough, cost))
            };
        let long = states.iter().filter(|(_, d)| d.largest_order() >= order);
        let none = Error::no_model(format!("no horizon allows an order of {order}"));
        least_cost(long.map(of), none)
    }

    fn plant_and_noise(&self, model: &StateSpace) -> Result<PlantAndNoise, Error> {
        PlantAndNoise::new(self.windows, model.clone(), self.noise_order)
    }

    /// The model of least prediction errors, sought from that of a candidate.
    fn predicting(&self, of: &Candidate, stop: Stop) -> Result<PlantAndNoise, Error> {
        let radius = largest_radius(self.samples).max(of.model.spectral_radius());
        let radius = (radius + 1e-12).min(1.0);
        self.plant_and_noise(&of.model)?.refined(self.windows, of.feedthrough, stop, radius)
    }
}

impl Estimator for InWindows<'_> {
    fn options(&self) -> &IdentifyOptions {
        self.options
    }

    fn counts(&self) -> Counts {
        let samples = self.windows.count as f64;
        Counts { inputs: 1, outputs: 1, samples, segments: 1, vehicle: true }
    }

    fn largest_order(&self) -> usize {
        match &self.estimates {
            Estimates::OpenLoop(all) => all.largest_order(),
            Estimates::ClosedLoop(_, states) => {
                states.iter().map(|(_, d)| d.largest_order()).max().unwrap_or(0)
            }
        }
    }

    fn initial_estimates(&self, order: usize, feedthrough: bool) -> Result<Vec<Candidate>, Error> {
        Ok(vec![self.best(order, feedthrough)?])
    }

    fn refine(&self, of: &mut Candidate, stop: Stop) -> Result<(), Error> {
        if self.looped() {
            of.model = self.predicting(of, stop)?.model;
            return Ok(());
        }
        refine_within(&self.windows.data, self.samples, of, stop)
    }

    fn mean_square(&self, of: &Candidate) -> Result<f64, Error> {
        if self.looped() {
            return Ok(self.plant_and_noise(&of.model)?.variance(self.windows));
        }
        let errors = of.initial_conditions.errors_on(&of.model, &self.windows.data)?;
        Ok(self.windows.variance(&errors, of.model.order()))
    }

    /// B and D; under feedback neither, since those of the simulation are biased.
    fn refit(&self, of: &mut Candidate) -> Result<(), Error> {
        if !self.looped() {
            let (a, c) = (&of.model.a, &of.model.c);
            (of.model, of.initial_conditions, _) =
                refit_about(a, c, &self.windows.data, of.feedthrough, false)?;
        }
        Ok(())
    }

    fn predict(&self, of: &Candidate) -> Result<(f64, Option<StateSpace>), Error> {
        let found = match self.options.refine {
            true => self.predicting(of, ROUGH)?,
            false => self.plant_and_noise(&of.model)?,
        };
        Ok((found.variance(self.windows).max(1e-300).ln(), Some(found.model)))
    }

    /// With another state, what predicted best with one less predicts no worse.
    fn other_models(&self, first: StateSpace, before: Option<&Candidate>) -> Vec<StateSpace> {
        if !self.options.refine {
            return Vec::new();
        }
        let larger = before.and_then(|c| c.direct.as_ref()).map(with_another_state);
        std::iter::once(first).chain(larger).collect()
    }
}

/// The Kalman gain; zero where its filter is barely stable or no better than the simulation.
pub(crate) fn kalman_gain(
    windows: &Windows,
    choice: &Choice,
    warnings: &mut Vec<String>,
) -> Result<Mat<f64>, Error> {
    const STOP: Stop = Stop { steps: 20, least_gain: 1e-5 };
    let chosen = &choice.candidates[choice.chosen];
    let (model, order) = (&chosen.model, chosen.model.order());
    let [u, y] = windows.scales;
    let cut = choice.factor.with_horizon(chosen.horizon.min(choice.factor.horizon))?;
    let noise = noise_model(&cut, &model.scaled(&[u], &[y]))?;
    if !noise.solved {
        warnings.push("the Riccati equation has no stabilising solution".into());
    }
    let gain = Mat::from_fn(order, 1, |i, _| noise.gain[(i, 0)] * y);
    let x0s = windows.predictor_states(model, gain.as_ref())?;
    let gain = refine_gain(model, gain.as_ref(), &windows.data, &x0s, STOP)?;
    let filter = crate::model::predictor(model, gain.as_ref());
    let simulated = windows.ahead(model)?;
    let predicted = windows.predicted_ahead(model, gain.as_ref())?;
    let better = sum_of_squares(&predicted) <= sum_of_squares(&simulated);
    if better && filter.spectral_radius() < 1.0 - 1e-6 {
        return Ok(gain);
    }
    warnings.push("the Kalman filter predicts no better than the simulation: K is 0".into());
    Ok(Mat::zeros(order, 1))
}

/// The model with a state more that hardly shows.
fn with_another_state(model: &StateSpace) -> StateSpace {
    const POLE: f64 = 0.5;
    const SHARE: f64 = 0.01;
    let n = model.order();
    let mut a = Mat::zeros(n + 1, n + 1);
    a.get_mut(..n, ..n).copy_from(&model.a);
    a[(n, n)] = POLE;
    StateSpace {
        a,
        b: Mat::from_fn(n + 1, 1, |i, _| if i < n { model.b[(i, 0)] } else { SHARE }),
        c: Mat::from_fn(1, n + 1, |_, j| if j < n { model.c[(0, j)] } else { SHARE }),
        d: model.d.clone(),
    }
}
