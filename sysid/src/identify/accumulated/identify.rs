//! Order, model and noise from accumulated drives, as they are chosen from a log in memory.
//!
//! The initial estimates of growing order come from the subspace methods on the R factor
//! ([`initial_estimates`](crate::identify::accumulated::initial_estimates)). They are refined by
//! simulation errors on its [windows](crate::identify::accumulated::windows), or where the test finds
//! feedback by [prediction](crate::identify::accumulated::prediction) errors, which it does not bias.
//! They are compared by the errors of one-step prediction that they make along with a model of the
//! noise: BIC holds for these, whatever the spectrum of the noise.

use crate::Error;
use crate::identify::accumulated::initial_estimates::{InitialEstimate, InitialEstimates};
use crate::identify::accumulated::prediction::Predicted;
use crate::identify::accumulated::windows::Windows;
use crate::model::StateSpace;
use crate::model::conversion::{costs_nothing, has_logarithm, off_branch_cut};
use crate::model::stability::largest_radius;
use crate::pem::{Stop, refine_gain, refine_output_error};
use crate::selection::logarithm::{in_turn, mirroring_warning};
use crate::selection::method::Method;
use crate::selection::options::IdentifyOptions;
use crate::selection::order::{bic, likeliest, of_a_vehicle, parameters, sum_of_squares};
use crate::subspace::closed_loop::{self, Feedback, feedback_in};
use crate::subspace::{Factor, Realization, noise_model, refit_output};
use faer::Mat;

/// Memory and reach of the test for feedback, s.
const MEMORY_S: f64 = 2.0;
const AHEAD_S: f64 = 1.0;
const ROUGH: Stop = Stop { steps: 25, least_gain: 2e-5 };
const FINE: Stop = Stop { steps: 40, least_gain: 1e-9 };
/// Orders that are tried beyond the best so far, and those that are tried anyhow.
const LOOK_AHEAD: usize = 3;
const AT_LEAST: usize = 6;

/// A model in the units of the windows.
#[derive(Debug, Clone)]
pub(crate) struct Candidate {
    pub(crate) method: Method,
    pub(crate) realization: Realization,
    pub(crate) horizon: usize,
    pub(crate) singular_value: f64,
    pub(crate) model: StateSpace,
    x0s: Vec<Vec<f64>>,
    /// Variance of the errors that were made small.
    variance: f64,
    /// … of the one-step prediction errors that it is compared by.
    predicted: f64,
    pub(crate) criterion: f64,
    has_logarithm: bool,
    pub(crate) stabilised_from: Option<f64>,
}

/// What was chosen of what.
pub(crate) struct Choice {
    pub(crate) candidates: Vec<Candidate>,
    pub(crate) chosen: usize,
    pub(crate) gain: Mat<f64>,
    pub(crate) feedback: Option<Feedback>,
    pub(crate) warnings: Vec<String>,
}

/// Chooses order, method and horizon.
pub(crate) fn choose(
    factor: &Factor,
    windows: &Windows,
    samples: usize,
    options: &IdentifyOptions,
) -> Result<Choice, Error> {
    let step = windows.data.sample_time_s();
    let count = |s: f64| (s / step).round().clamp(5.0, 40.0) as usize;
    let (mut past, mut ahead) = (count(MEMORY_S), count(AHEAD_S));
    while past + ahead + 1 > windows.length && past + ahead > 2 {
        if past > ahead { past -= 1 } else { ahead -= 1 }
    }
    let feedback = feedback_in(factor, past, ahead).ok();
    let closed = match options.method {
        Some(Method::ClosedLoop(method)) => vec![method],
        None if feedback.is_some_and(|f| f.detected) => closed_loop::ClosedLoopMethod::ALL.to_vec(),
        _ => Vec::new(),
    };
    let looped = !closed.is_empty();
    let initial_estimates = if looped {
        let past = past.min(windows.length - ahead - 1);
        InitialEstimates::closed_loop(factor, &closed, past, (past / 2).clamp(2, 15))?
    } else {
        InitialEstimates::open_loop(factor, options)?
    };
    let mut search =
        Search { windows, options, samples, initial_estimates, looped, noise_order: 0 };
    search.noise_order = search.noise_order();
    let mut candidates = search.ascend()?;
    let mut chosen = search.select(&mut candidates);
    search.refine(&mut candidates[chosen], FINE)?;
    let mut warnings = Vec::new();
    chosen = search.with_logarithm(&mut candidates, chosen, &mut warnings)?;
    let gain = search.gain(factor, &candidates[chosen], &mut warnings)?;
    Ok(Choice { candidates, chosen, gain, feedback, warnings })
}

struct Search<'a> {
    windows: &'a Windows,
    options: &'a IdentifyOptions,
    samples: usize,
    initial_estimates: InitialEstimates,
    /// Whether the data come from a loop.
    looped: bool,
    /// Number of coefficients of the noise's autoregression.
    noise_order: usize,
}

impl Search<'_> {
    fn feedthrough(&self) -> bool {
        self.options.feedthrough == Some(true)
    }

    fn largest_order(&self) -> usize {
        self.options
            .order
            .unwrap_or(self.options.max_order.min(self.initial_estimates.largest_order()))
    }

    fn initial_estimates(&self, order: usize) -> Result<Vec<InitialEstimate>, Error> {
        self.initial_estimates.of_order(self.windows, order, self.feedthrough(), self.samples)
    }

    /// That of the noise as the largest model leaves it, for all models. A given order is not compared
    /// with others, but in a loop a model of the noise is needed all the same.
    fn noise_order(&self) -> usize {
        if !self.looped && self.options.order.is_some() {
            return 0;
        }
        let start = (1..=self.largest_order()).rev().find_map(|order| self.best(order).ok());
        start.map_or(0, |c| Predicted::noise_order(self.windows, &c.model))
    }

    /// The initial estimate of an order with the least errors, as it is.
    fn best(&self, order: usize) -> Result<Candidate, Error> {
        let mut best: Option<Candidate> = None;
        let mut last_error = Error::NoModel { problem: "no model can be simulated".into() };
        for start in self.initial_estimates(order)? {
            let mut candidate = Candidate {
                method: start.method,
                realization: start.realization,
                horizon: start.horizon,
                singular_value: start.singular_value,
                model: start.model,
                x0s: start.x0s,
                variance: f64::INFINITY,
                predicted: f64::INFINITY,
                criterion: f64::INFINITY,
                has_logarithm: false,
                stabilised_from: start.stabilised_from,
            };
            match self.measure(&mut candidate) {
                Ok(()) if best.as_ref().is_none_or(|b| candidate.variance < b.variance) => {
                    best = Some(candidate);
                }
                Ok(()) => {}
                Err(error) => last_error = error,
            }
        }
        best.ok_or(last_error)
    }

    /// The variance of the errors that are made small, and the initial states of a simulation.
    fn measure(&self, candidate: &mut Candidate) -> Result<(), Error> {
        if self.looped {
            let found = Predicted::new(self.windows, candidate.model.clone(), self.noise_order)?;
            candidate.variance = found.variance(self.windows);
            return Ok(());
        }
        let (x0s, errors) = self.windows.simulated(&candidate.model)?;
        candidate.variance = self.windows.variance(&errors, candidate.model.order());
        candidate.x0s = x0s;
        Ok(())
    }

    fn refine(&self, candidate: &mut Candidate, stop: Stop) -> Result<(), Error> {
        if !self.options.refine {
            return Ok(());
        }
        if self.looped {
            candidate.model = self.predicting(&candidate.model, stop)?.model;
        } else {
            let (model, x0s) = (&candidate.model, &candidate.x0s);
            let (data, radius) = (&self.windows.data, self.radius(model));
            candidate.model =
                refine_output_error(model, x0s, data, self.feedthrough(), stop, radius)?.0;
        }
        self.measure(candidate)
    }

    /// The model of least prediction errors, sought from this one.
    fn predicting(&self, model: &StateSpace, stop: Stop) -> Result<Predicted, Error> {
        let start = Predicted::new(self.windows, model.clone(), self.noise_order)?;
        start.refined(self.windows, self.feedthrough(), stop, self.radius(model))
    }

    fn radius(&self, model: &StateSpace) -> f64 {
        (largest_radius(self.samples).max(model.spectral_radius()) + 1e-12).min(1.0)
    }

    /// Finds the prediction errors that a candidate is compared by: where models are refined, those of
    /// the model that makes them least, sought from its own and from `others`. Returns that model.
    fn weigh(&self, candidate: &mut Candidate, others: &[StateSpace]) -> Result<StateSpace, Error> {
        let m = &candidate.model;
        candidate.has_logarithm = has_logarithm(m);
        if !self.options.refine {
            let found = Predicted::new(self.windows, m.clone(), self.noise_order)?;
            candidate.predicted = found.variance(self.windows);
            return Ok(found.model);
        }
        let mut best = self.predicting(m, ROUGH)?;
        candidate.predicted = best.variance(self.windows);
        for found in others.iter().filter_map(|m| self.predicting(m, ROUGH).ok()) {
            let variance = found.variance(self.windows);
            if variance < candidate.predicted {
                (best, candidate.predicted) = (found, variance);
            }
        }
        Ok(best.model)
    }

    /// Models of growing order, until the criterion has not fallen for a while.
    fn ascend(&self) -> Result<Vec<Candidate>, Error> {
        let orders = self.options.order.unwrap_or(1)..=self.largest_order();
        let mut candidates: Vec<Candidate> = Vec::new();
        let mut last_error = Error::NoModel { problem: "no order could be tried".into() };
        // With another state, what predicted best with one less predicts no worse.
        let mut before: Option<StateSpace> = None;
        for order in orders {
            let found = self.best(order).and_then(|mut candidate| {
                let larger = before.take().map(|model| with_another_state(&model));
                let others: Vec<_> = [candidate.model.clone()].into_iter().chain(larger).collect();
                self.refine(&mut candidate, ROUGH)?;
                before = Some(self.weigh(&mut candidate, &others)?);
                Ok(candidate)
            });
            match found {
                Ok(candidate) if candidate.predicted.is_finite() => candidates.push(candidate),
                Ok(_) => continue,
                Err(error) => {
                    last_error = error;
                    continue;
                }
            }
            let least = self.least(&mut candidates);
            if candidates.len() - 1 - least >= LOOK_AHEAD && order >= AT_LEAST {
                break;
            }
        }
        if candidates.is_empty() { Err(last_error) } else { Ok(candidates) }
    }

    /// Sets the criterion of all and returns the least.
    fn least(&self, candidates: &mut [Candidate]) -> usize {
        for c in candidates.iter_mut() {
            let count = parameters(c.model.order(), 1, 1, self.feedthrough());
            let log_square = c.predicted.max(1e-300).ln();
            c.criterion = bic(log_square, 1, count, self.windows.count as f64);
        }
        let values = (0..candidates.len()).map(|i| (i, candidates[i].criterion));
        values.min_by(|a, b| a.1.total_cmp(&b.1)).map_or(0, |(i, _)| i)
    }

    /// The order of least criterion, or of one about as likely that has a continuous form.
    fn select(&self, candidates: &mut [Candidate]) -> usize {
        self.least(candidates);
        let each: Vec<(f64, bool)> =
            candidates.iter().map(|c| (c.criterion, c.has_logarithm)).collect();
        let chosen = likeliest(&each);
        let each = candidates.iter().map(|c| (c.model.order(), c.criterion, c.has_logarithm));
        of_a_vehicle(chosen, &each.collect::<Vec<_>>(), self.windows.count as f64)
    }

    /// The chosen model taken off the branch cut, or one of lower order that has a continuous form or is
    /// brought to one, whichever costs least, where that is nearly nothing; returns which is chosen then.
    fn with_logarithm(
        &self,
        candidates: &mut [Candidate],
        chosen: usize,
        warnings: &mut Vec<String>,
    ) -> Result<usize, Error> {
        if off_branch_cut(&candidates[chosen].model)?.is_empty() {
            return Ok(chosen);
        }
        let least = candidates[chosen].variance;
        let mut best: Option<(usize, Candidate, bool)> = None;
        for i in in_turn(candidates.iter().map(|c| c.model.order()), chosen) {
            let mut one = candidates[i].clone();
            if i != chosen {
                self.refine(&mut one, FINE)?;
            }
            let from = one.clone();
            let places = off_branch_cut(&from.model)?;
            let moved = !places.is_empty();
            for (i, place) in places.into_iter().enumerate() {
                let mut placed = self.refitted(place, &from)?;
                self.measure(&mut placed)?;
                if i == 0 || placed.variance < one.variance {
                    one = placed;
                }
            }
            one.has_logarithm = has_logarithm(&one.model);
            let is_best = best.as_ref().is_none_or(|(_, b, _)| one.variance < b.variance);
            if one.has_logarithm && costs_nothing(least, one.variance) && is_best {
                best = Some((i, one, moved));
            }
        }
        let Some((i, one, moved)) = best else { return Ok(chosen) };
        warnings.extend(moved.then(|| mirroring_warning(one.variance / least - 1.0)));
        candidates[i] = one;
        Ok(i)
    }

    /// A candidate with the poles of a model; under feedback its B, too, since the simulation's is biased.
    fn refitted(&self, mut model: StateSpace, from: &Candidate) -> Result<Candidate, Error> {
        if !self.looped {
            let (a, c, data) = (model.a.as_ref(), model.c.as_ref(), &self.windows.data);
            model = refit_output(a, c, data, self.feedthrough(), false)?.model;
        }
        Ok(Candidate { model, ..from.clone() })
    }

    /// The Kalman gain; zero where its filter is on the verge of instability or predicts worse than the
    /// simulation.
    fn gain(
        &self,
        factor: &Factor,
        chosen: &Candidate,
        warnings: &mut Vec<String>,
    ) -> Result<Mat<f64>, Error> {
        const STOP: Stop = Stop { steps: 20, least_gain: 1e-5 };
        let (model, order) = (&chosen.model, chosen.model.order());
        let [u, y] = self.windows.scales;
        let cut = factor.with_horizon(chosen.horizon.min(factor.horizon))?;
        let noise = noise_model(&cut, &model.scaled(&[u], &[y]))?;
        if !noise.solved {
            warnings.push("the Riccati equation has no stabilising solution".into());
        }
        let gain = Mat::from_fn(order, 1, |i, _| noise.gain[(i, 0)] * y);
        let x0s = self.windows.predictor_states(model, gain.as_ref())?;
        let gain = refine_gain(model, gain.as_ref(), &self.windows.data, &x0s, STOP)?;
        let filter = crate::model::predictor(model, gain.as_ref());
        let simulated = self.windows.ahead(model)?;
        let predicted = self.windows.predicted_ahead(model, gain.as_ref())?;
        let better = sum_of_squares(&predicted) <= sum_of_squares(&simulated);
        if better && filter.spectral_radius() < 1.0 - 1e-6 {
            return Ok(gain);
        }
        warnings.push("the Kalman filter predicts no better than the simulation: K is 0".into());
        Ok(Mat::zeros(order, 1))
    }
}

/// The model with a state more that hardly shows.
fn with_another_state(model: &StateSpace) -> StateSpace {
    const POLE: f64 = 0.5;
    const SHARE: f64 = 0.01;
    let n = model.order();
    StateSpace {
        a: Mat::from_fn(n + 1, n + 1, |i, j| {
            if i < n && j < n {
                model.a[(i, j)]
            } else if i == j {
                POLE
            } else {
                0.0
            }
        }),
        b: Mat::from_fn(n + 1, 1, |i, _| if i < n { model.b[(i, 0)] } else { SHARE }),
        c: Mat::from_fn(1, n + 1, |_, j| if j < n { model.c[(0, j)] } else { SHARE }),
        d: model.d.clone(),
    }
}
