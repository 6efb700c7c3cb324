//! The Kalman gain of the chosen model, and how uncertain both are.
//!
//! The model is that of the least simulation errors, and stays; K makes its one-step prediction errors
//! least, in a loop as without one.

use crate::Error;
use crate::data::DataSet;
use crate::data::scaled::{Data, Part};
use crate::data::statistics::fit_percent;
use crate::linalg::dense::spectral_radius;
use crate::model::{Innovation, StateSpace, predictions, predictor, predictor_state};
use crate::pem::{Neighbours, Stop, refine_gain, uncertain_simulation, without_blocks};
use crate::selection::candidate::{Candidate, Choice, output};
use crate::selection::initial_conditions::InitialConditions;
use crate::selection::order::weights;
use crate::subspace::{Factor, noise_model};
use faer::{Mat, MatRef};

/// The innovation form's gain with what it predicts, in scaled units.
pub(crate) struct Filter {
    pub(crate) gain: Mat<f64>,
    pub(crate) residuals: Vec<f64>,
    /// One-step prediction errors on the validation data, to which no parameter was fitted.
    pub(crate) validation_residuals: Vec<f64>,
    pub(crate) validation_fit: f64,
}

/// The Kalman gain from the residual covariances (or zero), refined by its prediction errors; zero
/// where it would predict worse than the simulation does.
pub(crate) fn filter(
    data: &Data,
    factor: &Factor,
    chosen: &Candidate,
    refine: bool,
    warnings: &mut Vec<String>,
) -> Result<Filter, Error> {
    const STOP: Stop = Stop { steps: 20, least_gain: 1e-5 };
    let model = &chosen.model;
    let noise = noise_model(factor, model)?;
    let part = &data.estimation;
    let simulation_error =
        difference(&part.output, &output(model, part, &chosen.initial_conditions.x0));
    let mut gain = noise.gain;
    if !noise.solved {
        warnings.push("the Riccati equation has no stabilising solution".into());
    }
    if refine {
        gain = refine_gain(model, gain.as_ref(), &part.data, &chosen.initial_conditions.x0, STOP)?;
    }
    let mut residuals = difference(&part.output, &one_step(model, gain.as_ref(), part)?);
    let power = |e: &[f64]| e.iter().map(|x| x * x).sum::<f64>();
    // A gain that is stable by a hair, or in one scaling only, is not: rounding would decide.
    let scaled = |k: f64| {
        let gain = Mat::from_fn(gain.nrows(), 1, |i, _| gain[(i, 0)] / k);
        let c = Mat::from_fn(1, model.order(), |_, j| model.c[(0, j)] * k);
        spectral_radius((&model.a - gain * c).as_ref())
    };
    let stable = [1.0, data.output_scale, 1e3].into_iter().all(|k| scaled(k) < 1.0 - 1e-6);
    if !stable || power(&residuals) > power(&simulation_error) {
        warnings.push(if stable {
            "the Kalman filter predicts no better than the simulation: K is 0".into()
        } else {
            "the Kalman filter is on the verge of instability: K is 0".into()
        });
        gain = Mat::zeros(model.order(), 1);
        residuals = simulation_error;
    }
    let part = &data.validation;
    let predicted = one_step(model, gain.as_ref(), part)?;
    let validation_residuals = difference(&part.output, &predicted);
    let validation_fit = fit_percent(&part.output, &predicted);
    Ok(Filter { gain, residuals, validation_residuals, validation_fit })
}

/// Frequencies at which neighbouring models are compared with the chosen one, Hz.
const COMPARED_HZ: (f64, f64) = (0.05, 3.0);
const COMPARED: usize = 30;
/// Blocks of the jackknife, and the most samples that are refined for it.
const BLOCKS: usize = 20;
const MOST_REFINED: usize = 20_000;
/// Pieces of fewer samples are left out of a replica.
const LEAST_PIECE: usize = 50;

/// The uncertainty of the chosen model and its gain, in SI units, with that of its neighbours.
pub(crate) fn uncertainty(
    data: &Data,
    choice: &Choice,
    gain: &Mat<f64>,
    refined: bool,
) -> Result<steerwright_formats::Uncertainty, Error> {
    let chosen = &choice.candidates[choice.chosen];
    let innovation = Innovation { model: chosen.model.clone(), gain: gain.clone() };
    let actual = &data.estimation.data;
    let fitted = choice.fitted.as_ref().unwrap_or(actual);
    let x0 = InitialConditions::new(&chosen.model, fitted, false)?.x0;
    let omegas = omegas(data.sample_time);
    let replicas = if refined { replicas(chosen, fitted) } else { Vec::new() };
    let rivals = rivals(choice);
    let estimate = uncertain_simulation(
        &innovation,
        (&x0, fitted),
        (&chosen.initial_conditions.x0, actual),
        chosen.feedthrough,
        chosen.initial_conditions.offsets.is_some(),
        Neighbours { replicas: &replicas, rivals: &rivals, omegas: &omegas },
    )?;
    estimate.scaled(&[data.input_scale], &[data.output_scale]).to_file(data.sample_time)
}

/// rad per sample, evenly spaced on a logarithmic axis, well below half the sample rate.
fn omegas(sample_time: f64) -> Vec<f64> {
    let (low, high) = (COMPARED_HZ.0, COMPARED_HZ.1.min(0.3 / sample_time));
    let hz = |k: usize| low * (high / low).powf(k as f64 / (COMPARED - 1) as f64);
    (0..COMPARED).map(|k| std::f64::consts::TAU * hz(k) * sample_time).collect()
}

/// The chosen model refined on the data less one block of time each, where possible.
pub(crate) fn replicas(chosen: &Candidate, fitted: &DataSet) -> Vec<StateSpace> {
    const STOP: Stop = Stop { steps: 10, least_gain: 1e-6 };
    if fitted.samples() > MOST_REFINED {
        return Vec::new();
    }
    let refined = |data: DataSet| {
        let mut replica = chosen.clone();
        crate::selection::candidate::refine(&data, &mut replica, STOP).ok()?;
        Some(replica.model)
    };
    without_blocks(fitted, BLOCKS, LEAST_PIECE).into_iter().filter_map(refined).collect()
}

/// Models of other orders, weighted by `exp(−Δ/2)` over the sum of all, and the one of the same
/// order that predicts best, by one half, since nothing determines which is nearer.
pub(crate) fn rivals(choice: &Choice) -> Vec<(f64, StateSpace)> {
    /// Less than that counts for nothing.
    const LEAST_WEIGHT: f64 = 1e-3;
    let all = &choice.candidates;
    let criteria: Vec<_> = all.iter().map(|c| (c.criterion, 0)).collect();
    let weighted = weights(&criteria, 0.0).into_iter().zip(all).enumerate();
    let others = weighted.filter(|(k, _)| *k != choice.chosen);
    let others = others.map(|(_, (weight, c))| (weight, c.model.clone()));
    let direct = all[choice.chosen].direct.clone().map(|model| (0.5, model));
    others.filter(|(weight, _)| *weight > LEAST_WEIGHT).chain(direct).collect()
}

/// One-step predictions of a part, the initial states estimated.
fn one_step(model: &StateSpace, gain: MatRef<'_, f64>, part: &Part) -> Result<Vec<f64>, Error> {
    let predictor = predictor(model, gain);
    let mut all = Vec::with_capacity(part.len());
    for segment in part.data.segments() {
        let (u, y) = (segment.u.as_ref(), segment.y.as_ref());
        let x0 = predictor_state(&predictor, u, y)?;
        all.extend(predictions(&predictor, u, y, &x0).row(0));
    }
    Ok(all)
}

fn difference(a: &[f64], b: &[f64]) -> Vec<f64> {
    a.iter().zip(b).map(|(x, y)| x - y).collect()
}
