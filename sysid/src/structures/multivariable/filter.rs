//! The data in scaled units, and the Kalman gain of a model on them.

use crate::Error;
use crate::data::{DataSet, Segment};
use crate::linalg::dense::spectral_radius;
use crate::model::{predictions, predictor, predictor_state};
use crate::pem::{Stop, refine_gain};
use crate::selection::candidate::{Candidate, Choice};
use crate::selection::initial_conditions::InitialConditions;
use crate::selection::order::{Errors, bic, errors, log_square};
use crate::structures::multivariable::delays;
use crate::subspace::noise_model;
use faer::Mat;

/// Estimation, validation and all data of the log, about the offsets and in units of the standard deviations of the
/// estimation data.
pub(super) struct Scaled {
    pub(super) estimation: DataSet,
    pub(super) validation: DataSet,
    pub(super) whole: DataSet,
}

impl Scaled {
    /// With each input later by so many samples.
    pub(super) fn delayed(&self, samples: &[usize]) -> Result<Self, Error> {
        Ok(Self {
            estimation: delays::delayed(&self.estimation, samples)?,
            validation: delays::delayed(&self.validation, samples)?,
            whole: delays::delayed(&self.whole, samples)?,
        })
    }
}

/// The Kalman gain of the model with its prediction errors, in scaled units.
pub(super) struct Filter {
    pub(super) gain: Mat<f64>,
    pub(super) residuals: Errors,
    pub(super) validation_residuals: Errors,
}

impl Filter {
    /// From the residual covariances, refined by its prediction errors; zero where by BIC it predicts no better than the
    /// simulation does, or is on the verge of instability.
    pub(super) fn new(
        scaled: &Scaled,
        choice: &Choice,
        refine: bool,
        warnings: &mut Vec<String>,
    ) -> Result<Self, Error> {
        const STOP: Stop = Stop { steps: 20, least_gain: 1e-5 };
        let chosen = &choice.candidates[choice.chosen];
        let (model, data) = (&chosen.model, &scaled.estimation);
        let x0 = InitialConditions::new(model, data, false)?.x0;
        let simulated = errors(model, &x0, data);
        let mut gain = match noise_model(&choice.factor, model) {
            Ok(noise) => noise.gain,
            // Too few block rows for so large an order.
            Err(_) => Mat::zeros(model.order(), model.outputs()),
        };
        if refine && gain.norm_max() > 0.0 {
            gain = refine_gain(model, gain.as_ref(), data, &x0, STOP)?;
        }
        let radius = spectral_radius((&model.a - &gain * &model.c).as_ref());
        let mut residuals = one_step(chosen, &gain, data)?;
        let is_stable = radius < 1.0 - 1e-6;
        // The gain has as many parameters as states times outputs.
        let count = data.samples() as f64;
        let parameters = model.order() * model.outputs();
        let more = bic(log_square(&residuals), model.outputs(), parameters, count);
        if !is_stable || more > bic(log_square(&simulated), model.outputs(), 0, count) {
            warnings.push(if is_stable {
                "the Kalman filter predicts no better than the simulation: K is 0".into()
            } else {
                "the Kalman filter is on the verge of instability: K is 0".into()
            });
            gain = Mat::zeros(model.order(), model.outputs());
            residuals = simulated;
        }
        let validation_residuals = one_step(chosen, &gain, &scaled.validation)?;
        Ok(Self { gain, residuals, validation_residuals })
    }
}

/// One-step prediction errors of each segment, the initial states estimated.
fn one_step(chosen: &Candidate, gain: &Mat<f64>, data: &DataSet) -> Result<Errors, Error> {
    let predictor = predictor(&chosen.model, gain.as_ref());
    let of = |s: &Segment| {
        let (u, y) = (s.u.as_ref(), s.y.as_ref());
        let x0 = predictor_state(&predictor, u, y)?;
        Ok(&s.y - predictions(&predictor, u, y, &x0))
    };
    data.segments().iter().map(of).collect()
}
