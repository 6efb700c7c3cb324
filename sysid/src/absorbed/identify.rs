//! Order, model and noise from absorbed drives.
//!
//! Models of growing order are started by the subspace methods on the factor and refined on its
//! windows (see [`windows`](super::windows)): by simulation errors, or by one-step prediction errors
//! where the test finds feedback. Schwarz's criterion chooses the order, counted over the independent
//! samples: on prediction errors, or on those of the second half of each window simulated from the state
//! that its first half gives. Over the whole window the initial state would take up what disturbances
//! leave, so that their modes would count as the plant's.

use super::effective::effective_samples;
use super::windows::Windows;
use crate::closed_loop::{self, Feedback, feedback_in};
use crate::conversion::to_continuous;
use crate::identify::order::{parameters, schwarz, sum_of_squares};
use crate::model::{Innovation, StateSpace};
use crate::refine::{Focus, Stop, refine_gain, refine_output_error, refine_prediction};
use crate::stability::{largest_radius, stable_shift};
use crate::subspace::{
    Factor, Method, Projections, Realization, Subspace, eq12, noise_model, refit_output,
    shift_realization, stable_eq12, subspace,
};
use crate::{Approach, Error, IdentifyOptions};
use faer::Mat;

/// Horizons that are tried where none is given.
const HORIZONS: [usize; 4] = [10, 15, 20, 30];
/// Memory and reach of the test for feedback, s.
const MEMORY_S: f64 = 2.0;
const AHEAD_S: f64 = 1.0;
const ROUGH: Stop = Stop { steps: 25, least_gain: 2e-5 };
const FINE: Stop = Stop { steps: 40, least_gain: 1e-9 };
/// Orders that are tried beyond the best so far, and those that are tried anyhow.
const LOOK_AHEAD: usize = 3;
const AT_LEAST: usize = 4;
/// Errors that differ by that share of their variance do not speak for another state: with so many
/// samples anything is significant, and every window's own state takes up a little.
const NO_MORE: f64 = 0.01;

/// A model in the units of the windows.
#[derive(Debug, Clone)]
pub(super) struct Candidate {
    pub(super) approach: Approach,
    pub(super) realization: Realization,
    pub(super) horizon: usize,
    pub(super) singular_value: f64,
    pub(super) model: StateSpace,
    x0s: Vec<Vec<f64>>,
    /// Of a model whose errors are those of one-step prediction.
    gain: Option<Mat<f64>>,
    /// Variance of the errors that were made small.
    variance: f64,
    /// … of those that the order is chosen by.
    ahead: f64,
    pub(super) criterion: f64,
    pub(super) stabilised_from: Option<f64>,
}

/// What was chosen of what.
pub(super) struct Choice {
    pub(super) candidates: Vec<Candidate>,
    pub(super) chosen: usize,
    pub(super) gain: Mat<f64>,
    pub(super) feedback: Option<Feedback>,
    pub(super) warnings: Vec<String>,
}

/// Chooses order, method and horizon.
pub(super) fn choose(
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
        Some(Approach::ClosedLoop(method)) => vec![method],
        None if feedback.is_some_and(|f| f.detected) => closed_loop::Method::ALL.to_vec(),
        _ => Vec::new(),
    };
    let search = Search { windows, options, samples };
    let mut candidates = if closed.is_empty() {
        let starts = search.open_loop(factor)?;
        search.ascend(|order| search.best_start(&starts, order), factor.horizon - 1)?
    } else {
        let past = past.min(windows.length - ahead - 1);
        let future = (past / 2).clamp(2, 15);
        let states = closed
            .iter()
            .map(|&method| {
                closed_loop::decompose(factor, method, past, future, false).map(|d| (method, d))
            })
            .collect::<Result<Vec<_>, Error>>()?;
        let largest = states.iter().map(|(_, d)| d.largest_order()).max().unwrap_or(0);
        search.ascend(|order| search.best_filter(&states, past, order), largest)?
    };
    let chosen = search.least(&mut candidates);
    search.refine(&mut candidates[chosen], FINE)?;
    search.least(&mut candidates);
    let mut warnings = Vec::new();
    let gain = search.gain(factor, &candidates[chosen], &mut warnings)?;
    Ok(Choice { candidates, chosen, gain, feedback, warnings })
}

struct Search<'a> {
    windows: &'a Windows,
    options: &'a IdentifyOptions,
    samples: usize,
}

/// A horizon with what does not depend on the order.
struct Start {
    factor: Factor,
    projections: Projections,
    subspaces: Vec<(Method, Subspace)>,
}

impl Search<'_> {
    fn feedthrough(&self) -> bool {
        self.options.feedthrough == Some(true)
    }

    fn in_units(&self, model: &StateSpace) -> StateSpace {
        let [u, y] = self.windows.scales;
        model.scaled(&[1.0 / u], &[1.0 / y])
    }

    fn open_loop(&self, factor: &Factor) -> Result<Vec<Start>, Error> {
        let least = self.options.order.map_or(2, |order| order + 1);
        let mut horizons: Vec<usize> = match self.options.horizon {
            Some(horizon) => vec![horizon],
            None => HORIZONS.into_iter().filter(|s| (least..=factor.horizon).contains(s)).collect(),
        };
        if horizons.is_empty() {
            horizons.push(factor.horizon);
        }
        let methods = match self.options.method {
            Some(Approach::OpenLoop(method)) => vec![method],
            _ => Method::ALL.to_vec(),
        };
        let of = |s: usize| -> Result<Start, Error> {
            let factor = factor.with_horizon(s)?;
            let subspaces = methods.iter().map(|&m| Ok((m, subspace(&factor, m)?)));
            let subspaces = subspaces.collect::<Result<_, Error>>()?;
            Ok(Start { projections: Projections::new(&factor)?, factor, subspaces })
        };
        horizons.into_iter().map(of).collect()
    }

    /// The subspace model of an order that simulates the windows best, refined.
    fn best_start(&self, starts: &[Start], order: usize) -> Result<Candidate, Error> {
        let mut best: Option<Candidate> = None;
        let mut last_error =
            Error::NoModel { problem: format!("no horizon allows an order of {order}") };
        for start in starts.iter().filter(|s| s.factor.horizon > order) {
            for (method, subspace) in &start.subspaces {
                for realization in Realization::ALL {
                    match self.start(start, (*method, subspace), realization, order) {
                        Ok(c) if best.as_ref().is_none_or(|b| c.variance < b.variance) => {
                            best = Some(c);
                        }
                        Ok(_) => {}
                        Err(error) => last_error = error,
                    }
                }
            }
        }
        let mut best = best.ok_or(last_error)?;
        self.refine(&mut best, ROUGH)?;
        Ok(best)
    }

    fn start(
        &self,
        start: &Start,
        (method, subspace): (Method, &Subspace),
        realization: Realization,
        order: usize,
    ) -> Result<Candidate, Error> {
        let factor = &start.factor;
        let (mut a, c) = match realization {
            Realization::Shift => shift_realization(subspace, order, 1)?,
            Realization::Eq12 => {
                let model = eq12(factor, &start.projections, subspace, order, self.feedthrough())?;
                (model.a, model.c)
            }
        };
        let (radius, most) =
            (crate::dense::spectral_radius(a.as_ref()), largest_radius(self.samples));
        if radius > most || radius.is_nan() {
            let stable = match realization {
                Realization::Shift => stable_shift(subspace.basis.as_ref(), order, 1, most),
                Realization::Eq12 => {
                    stable_eq12(factor, &start.projections, subspace, order, most)?
                }
            };
            a = stable.ok_or(Error::Numerical { what: "stabilisation" })?;
        }
        let c = Mat::from_fn(1, order, |_, k| c[(0, k)] / self.windows.scales[1]);
        let data = &self.windows.data;
        let refit = refit_output(a.as_ref(), c.as_ref(), data, self.feedthrough(), false)?;
        let mut candidate = Candidate {
            approach: method.into(),
            realization,
            horizon: factor.horizon,
            singular_value: subspace.singular_values[order - 1],
            model: refit.model,
            x0s: refit.x0,
            gain: None,
            variance: 0.0,
            ahead: 0.0,
            criterion: f64::INFINITY,
            stabilised_from: (radius >= 1.0).then_some(radius),
        };
        self.measure(&mut candidate)?;
        Ok(candidate)
    }

    /// The closed-loop model of an order that predicts the windows best, refined.
    fn best_filter(
        &self,
        states: &[(closed_loop::Method, closed_loop::Decomposition)],
        past: usize,
        order: usize,
    ) -> Result<Candidate, Error> {
        let mut best: Option<Candidate> = None;
        let mut last_error = Error::NoModel { problem: "no method could be tried".into() };
        for (method, decomposition) in states.iter().filter(|(_, d)| d.largest_order() >= order) {
            let of = || -> Result<Candidate, Error> {
                let Innovation { model, gain } =
                    decomposition.stable_model(order, largest_radius(self.samples))?;
                let scale = self.windows.scales[1];
                let mut candidate = Candidate {
                    approach: (*method).into(),
                    realization: Realization::Eq12,
                    horizon: past,
                    singular_value: decomposition.singular_values[order - 1],
                    model: self.in_units(&model),
                    x0s: Vec::new(),
                    gain: Some(Mat::from_fn(order, 1, |i, _| gain[(i, 0)] * scale)),
                    variance: 0.0,
                    ahead: 0.0,
                    criterion: f64::INFINITY,
                    stabilised_from: None,
                };
                self.measure(&mut candidate)?;
                Ok(candidate)
            };
            match of() {
                Ok(c) if best.as_ref().is_none_or(|b| c.variance < b.variance) => best = Some(c),
                Ok(_) => {}
                Err(error) => last_error = error,
            }
        }
        let mut best = best.ok_or(last_error)?;
        self.refine(&mut best, ROUGH)?;
        Ok(best)
    }

    /// Initial states, and the variance of the errors.
    fn measure(&self, candidate: &mut Candidate) -> Result<(), Error> {
        let (x0s, errors) = match &candidate.gain {
            Some(gain) => self.windows.predicted(&candidate.model, gain.as_ref())?,
            None => self.windows.simulated(&candidate.model)?,
        };
        candidate.variance = self.windows.variance(&errors, candidate.model.order());
        candidate.ahead = match &candidate.gain {
            Some(_) => candidate.variance,
            None => self.windows.variance_ahead(&self.windows.ahead(&candidate.model)?),
        };
        candidate.x0s = x0s;
        Ok(())
    }

    /// A step to an unstable A, which prediction errors allow, is not taken.
    fn refine(&self, candidate: &mut Candidate, stop: Stop) -> Result<(), Error> {
        if !self.options.refine {
            return Ok(());
        }
        let (data, feedthrough) = (&self.windows.data, self.feedthrough());
        let Some(gain) = candidate.gain.clone() else {
            let radius = largest_radius(self.samples).max(candidate.model.spectral_radius());
            let radius = (radius + 1e-12).min(1.0);
            let (model, x0s) = (&candidate.model, &candidate.x0s);
            candidate.model = refine_output_error(model, x0s, data, feedthrough, stop, radius)?.0;
            return self.measure(candidate);
        };
        let start = Innovation { model: candidate.model.clone(), gain };
        let found = refine_prediction(
            &start,
            &candidate.x0s,
            data,
            feedthrough,
            Focus::Prediction,
            stop,
            1.0,
        )?;
        if found.innovation.model.spectral_radius() < 1.0 {
            candidate.model = found.innovation.model;
            candidate.gain = Some(found.innovation.gain);
        }
        self.measure(candidate)
    }

    /// Models of growing order, until the criterion has not fallen for a while.
    fn ascend(
        &self,
        start: impl Fn(usize) -> Result<Candidate, Error>,
        largest: usize,
    ) -> Result<Vec<Candidate>, Error> {
        let orders = match self.options.order {
            Some(order) => order..=order,
            None => 1..=self.options.max_order.min(largest),
        };
        let mut candidates: Vec<Candidate> = Vec::new();
        let mut last_error = Error::NoModel { problem: "no order could be tried".into() };
        for order in orders {
            match start(order) {
                Ok(candidate) if candidate.ahead.is_finite() => candidates.push(candidate),
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

    /// Sets the criterion of all and tells the model to take: of those whose errors' variance is
    /// within [`NO_MORE`] of that of least criterion, the one of least order, if it may be of those
    /// that have a continuous form.
    fn least(&self, candidates: &mut [Candidate]) -> usize {
        let best = candidates.iter().min_by(|a, b| a.ahead.total_cmp(&b.ahead));
        let errors = best.and_then(|c| match &c.gain {
            Some(gain) => self.windows.predicted(&c.model, gain.as_ref()).ok(),
            None => self.windows.simulated(&c.model).ok(),
        });
        let Some((_, errors)) = errors else { return 0 };
        let data = &self.windows.data;
        let share = effective_samples(data, &errors) / data.samples() as f64;
        let samples = share * self.samples as f64;
        for c in candidates.iter_mut() {
            let order = c.model.order();
            let gain = if c.gain.is_some() { order } else { 0 };
            let d = parameters(order, 1, 1, self.feedthrough()) + gain;
            c.criterion = schwarz(c.ahead.max(1e-300).ln(), 1, d, samples);
        }
        let least = (0..candidates.len())
            .min_by(|a, b| candidates[*a].criterion.total_cmp(&candidates[*b].criterion))
            .unwrap_or(0);
        let enough = (1.0 + NO_MORE) * candidates[least].ahead;
        let first = |also: &dyn Fn(&Candidate) -> bool| {
            candidates.iter().position(|c| c.ahead <= enough && also(c))
        };
        let continuous =
            |c: &Candidate| to_continuous(c.model.a.as_ref(), c.model.b.as_ref(), 1.0).is_ok();
        first(&continuous).or_else(|| first(&|_| true)).unwrap_or(least)
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
        let gain = match &chosen.gain {
            Some(gain) => gain.clone(),
            None => {
                let cut = factor.with_horizon(chosen.horizon.min(factor.horizon))?;
                let noise = noise_model(&cut, &model.scaled(&[u], &[y]))?;
                if !noise.solved {
                    warnings.push("the Riccati equation has no stabilising solution".into());
                }
                let gain = Mat::from_fn(order, 1, |i, _| noise.gain[(i, 0)] * y);
                let (x0s, _) = self.windows.predicted(model, gain.as_ref())?;
                refine_gain(model, gain.as_ref(), &self.windows.data, &x0s, STOP)?
            }
        };
        let filter = crate::model::predictor(model, gain.as_ref());
        let (_, simulated) = self.windows.simulated(model)?;
        let (_, predicted) = self.windows.predicted(model, gain.as_ref())?;
        let better = sum_of_squares(&predicted) <= sum_of_squares(&simulated);
        if better && filter.spectral_radius() < 1.0 - 1e-6 {
            return Ok(gain);
        }
        warnings.push("the Kalman filter predicts no better than the simulation: K is 0".into());
        Ok(Mat::zeros(order, 1))
    }
}
