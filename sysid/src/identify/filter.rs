//! The Kalman gain of the chosen model, and how uncertain both are.
//!
//! The model is that of the least simulation errors, and stays; K makes its one-step prediction errors
//! least, in a loop as without one.

use super::candidates::{Candidate, output};
use super::conditions::Conditions;
use super::data::{Data, Part};
use crate::dense::spectral_radius;
use crate::model::{Innovation, StateSpace, predictions, predictor, predictor_state};
use crate::refine::{Stop, refine_gain, uncertain_simulation};
use crate::statistics::fit_percent;
use crate::subspace::{Factor, noise_model};
use crate::{DataSet, Error};
use faer::{Mat, MatRef};

/// The innovation form's gain with what it predicts, in scaled units.
pub(super) struct Filter {
    /// K.
    pub(super) gain: Mat<f64>,
    /// One-step prediction errors on the estimation data.
    pub(super) residuals: Vec<f64>,
    /// One-step prediction errors on the held-out data, which are those that are tested: no
    /// parameter has been fitted to them, so the χ² bounds need no correction for that.
    pub(super) validation_residuals: Vec<f64>,
    /// One-step fit on the held-out data, percent.
    pub(super) validation_fit: f64,
}

/// The Kalman gain from the residual covariances, refined by its prediction errors; zero where it
/// would predict worse than the simulation does. Where the Riccati equation has no solution, the
/// refinement starts from zero, with A − K C = A stable.
pub(super) fn filter(
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
    let simulation_error = difference(&part.output, &output(model, part, &chosen.conditions.x0));
    let mut gain = noise.gain;
    if !noise.solved {
        warnings.push("the Riccati equation has no stabilising solution".into());
    }
    if refine {
        gain = refine_gain(model, gain.as_ref(), &part.data, &chosen.conditions.x0, STOP)?;
    }
    let mut residuals = difference(&part.output, &one_step(model, gain.as_ref(), part)?);
    let power = |e: &[f64]| e.iter().map(|x| x * x).sum::<f64>();
    // A gain that is stable by a hair, or only in one scaling of the signals, is not: rounding in
    // the file would decide.
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

/// The uncertainty of the model and its gain, in SI units; `fitted` are the data whose simulation
/// errors the model makes small, where they are not the estimation data.
pub(super) fn uncertainty(
    data: &Data,
    chosen: &Candidate,
    fitted: Option<&DataSet>,
    gain: &Mat<f64>,
) -> Result<formats::Uncertainty, Error> {
    let innovation = Innovation { model: chosen.model.clone(), gain: gain.clone() };
    let actual = &data.estimation.data;
    let fitted = fitted.unwrap_or(actual);
    let x0 = Conditions::new(&chosen.model, fitted, false)?.x0;
    let estimate = uncertain_simulation(
        &innovation,
        (&x0, fitted),
        (&chosen.conditions.x0, actual),
        chosen.feedthrough,
        chosen.conditions.levels.is_some(),
    )?;
    estimate.scaled(&[data.input_scale], &[data.output_scale]).to_file(data.sample_time)
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
