//! Refinement of a model by its errors, and how uncertain what was reached is
//! (docs/methods/refinement.md).
//!
//! Both errors are one problem. The predictor of the innovation form, `x⁺ = (A − KC)x + (B − KD)u +
//! Ky, ŷ = Cx + Du`, is a model without noise with the inputs (u, y), whose D has no column for y;
//! its output error is the prediction error. So the steps (`search`), the local coordinates
//! (`coordinates`) and the derivatives (`rows`) are those of one kind of model only. What is kept
//! stable is A for the simulation and A − KC for the prediction. The rows of the Jacobian are
//! reduced to an R factor as they come.

mod coordinates;
mod covariance;
mod file;
mod gain;
mod neighbours;
mod noise;
mod rows;
mod search;
#[cfg(test)]
mod tests;
mod uncertain;

use crate::Error;
use crate::data::DataSet;
use crate::linalg::dense::spectral_radius;
use crate::model::{Innovation, StateSpace, predictor};
use crate::pem::rows::Drive;
use crate::pem::search::{Point, search};
use faer::Mat;

pub(crate) use crate::pem::coordinates::Coordinates;
pub use crate::pem::covariance::uncertain;
pub(crate) use crate::pem::covariance::uncertain_simulation;
pub use crate::pem::gain::refine_gain;
pub(crate) use crate::pem::neighbours::{Neighbours, larger, without_blocks};
pub use crate::pem::search::Stop;
pub(crate) use crate::pem::search::damped_step;
pub use crate::pem::uncertain::{ResponseEstimate, Uncertain};

/// Which errors are made small: the one-step prediction errors, over (A, B, C, D, K), or those of the
/// simulation, over (A, B, C, D); K is then that of the least prediction errors with this model.
pub use steerwright_formats::EstimationFocus as Focus;
pub use steerwright_formats::UncertainPole as PoleEstimate;

/// The result of a refinement.
#[derive(Debug, Clone, PartialEq)]
pub struct Refined {
    /// The model with its Kalman gain.
    pub innovation: Innovation,
    /// The state at the first sample of each segment.
    pub x0s: Vec<Vec<f64>>,
    /// Covariance Σ e eᵀ/N of the errors that were made small, ny by ny.
    pub error_covariance: Mat<f64>,
    /// Steps taken over the parameters of [`Focus`].
    pub steps: usize,
}

/// Refines a model in innovation form and the initial states `x0s` of the segments until `stop`.
///
/// With [`Focus::Prediction`] spectral radii of A − KC above `radius` are rejected, with
/// [`Focus::Simulation`] those of A. An initial estimate whose A − KC is beyond it has its gain halved
/// until it is not. D moves only with `feedthrough`. The result is in a basis of the state of its own.
///
/// # Errors
/// [`Error::NoModel`] where the initial estimate is unstable, [`Error::Numerical`] where a
/// decomposition does not converge.
pub fn refine_prediction(
    start: &Innovation,
    x0s: &[Vec<f64>],
    data: &DataSet,
    feedthrough: bool,
    focus: Focus,
    stop: Stop,
    radius: f64,
) -> Result<Refined, Error> {
    let model = &start.model;
    match focus {
        Focus::Simulation => {
            require_stable(model.spectral_radius())?;
            let found = by_simulation(model, (x0s, None), data, feedthrough, stop, radius)?;
            let (model, x0s) = (found.point.model, found.point.x0s);
            let gain = stable_gain(&model, &(&found.basis * &start.gain), 1.0)?;
            let gain = refine_gain(&model, gain.as_ref(), data, &x0s, stop)?;
            Ok(Refined {
                innovation: Innovation { model, gain },
                x0s,
                error_covariance: found.covariance,
                steps: found.steps,
            })
        }
        Focus::Prediction => {
            let gain = stable_gain(model, &start.gain, radius)?;
            let point =
                Point { model: predictor(model, gain.as_ref()), x0s: x0s.to_vec(), offsets: None };
            let feedthrough =
                moving_inputs(data.inputs(), data.outputs(), feedthrough, Drive::InputsAndOutputs);
            let found = search(point, Drive::InputsAndOutputs, data, &feedthrough, stop, radius)?;
            Ok(Refined {
                innovation: innovation_of(&found.point.model, model.inputs()),
                x0s: found.point.x0s,
                error_covariance: found.covariance,
                steps: found.steps,
            })
        }
    }
}

/// Refines `model` and the initial states `x0` of the segments for the simulation of the data until
/// `stop`; spectral radii above `radius` are refused. Returns what was reached, in a basis of the
/// state of its own.
///
/// # Errors
/// [`Error::Numerical`] where a decomposition does not converge.
pub fn refine_output_error(
    model: &StateSpace,
    x0: &[Vec<f64>],
    data: &DataSet,
    feedthrough: bool,
    stop: Stop,
    radius: f64,
) -> Result<(StateSpace, Vec<Vec<f64>>), Error> {
    let found = by_simulation(model, (x0, None), data, feedthrough, stop, radius)?;
    Ok((found.point.model, found.point.x0s))
}

/// As [`refine_output_error`], with the initial states and, where there are any, the constants
/// `offsets` on the outputs, both of which move.
pub(crate) fn by_simulation(
    model: &StateSpace,
    (x0, offsets): (&[Vec<f64>], Option<&[f64]>),
    data: &DataSet,
    feedthrough: bool,
    stop: Stop,
    radius: f64,
) -> Result<search::Found, Error> {
    let offsets = offsets.map(<[f64]>::to_vec);
    let point = Point { model: model.clone(), x0s: x0.to_vec(), offsets };
    let feedthrough = moving_inputs(data.inputs(), data.outputs(), feedthrough, Drive::Inputs);
    search(point, Drive::Inputs, data, &feedthrough, stop, radius)
}

/// For each input of the driven model whether its column of D may move: never that of a measured
/// output.
fn moving_inputs(inputs: usize, outputs: usize, feedthrough: bool, drive: Drive) -> Vec<bool> {
    (0..drive.width(inputs, outputs)).map(|l| feedthrough && l < inputs).collect()
}

/// The gain, halved until A − KC has a spectral radius below `radius`.
fn stable_gain(model: &StateSpace, gain: &Mat<f64>, radius: f64) -> Result<Mat<f64>, Error> {
    let mut factor = 1.0;
    for _ in 0..30 {
        let gain = Mat::from_fn(gain.nrows(), gain.ncols(), |i, j| factor * gain[(i, j)]);
        if spectral_radius((&model.a - &gain * &model.c).as_ref()) < radius {
            return Ok(gain);
        }
        factor *= 0.5;
    }
    require_stable(model.spectral_radius())?;
    Ok(Mat::zeros(gain.nrows(), gain.ncols()))
}

fn require_stable(radius: f64) -> Result<(), Error> {
    if radius < 1.0 {
        return Ok(());
    }
    Err(Error::no_model(format!(
        "a model that is not stable (spectral radius {radius:.4}) cannot be refined"
    )))
}

/// (A, B, C, D, K) of a predictor with the inputs (u, y).
fn innovation_of(predictor: &StateSpace, inputs: usize) -> Innovation {
    let gain = predictor.b.get(.., inputs..).to_owned();
    let d = predictor.d.get(.., ..inputs).to_owned();
    let model = StateSpace {
        a: &predictor.a + &gain * &predictor.c,
        b: predictor.b.get(.., ..inputs) + &gain * &d,
        c: predictor.c.clone(),
        d,
    };
    Innovation { model, gain }
}
