//! Another model on the same drive, judged as an identified one is.

use super::IdentifyOptions;
use super::candidates::{initial_states, output};
use super::data::{Data, Part};
use crate::conversion::discretize;
use crate::model::StateSpace;
use crate::statistics::fit_percent;
use crate::{DriveLog, Error};
use faer::Mat;
use formats::{Continuous, InputKind, Matrix};

/// How well a given model follows a drive, by the measures of [`formats::Fits`].
#[derive(Debug, Clone, PartialEq)]
pub struct Judged {
    /// Simulation fit on the estimation part, percent.
    pub estimation_fit: f64,
    /// Simulation fit on the held-out part, percent.
    pub validation_fit: f64,
    /// Simulated yaw rate over the whole drive, rad/s; the initial state is estimated at the start
    /// of each part.
    pub simulated_yaw_rate_radps: Vec<f64>,
}

/// Judges a model from steering angle (rad) to yaw rate (rad/s) on a drive: the same halves, means
/// and estimated initial states as in [`identify`](crate::identify), the same hold of the input.
///
/// # Errors
/// As [`identify`](crate::identify) for a drive that is too short or does not move, and
/// [`Error::NoModel`] for matrices that do not fit each other.
pub fn judge(
    log: &DriveLog,
    options: &IdentifyOptions,
    model: &Continuous,
) -> Result<Judged, Error> {
    options.check()?;
    let options = IdentifyOptions { input_kind: InputKind::Steering, ..options.clone() };
    let data = Data::new(log, &options)?;
    let n = model.f.rows();
    let fits = |m: &Matrix, rows, columns| m.rows() == rows && m.columns() == Some(columns);
    if !(fits(&model.f, n, n) && fits(&model.g, n, 1) && fits(&model.h, 1, n)) {
        return Err(Error::NoModel { problem: "the matrices F, G, H do not fit".into() });
    }
    let dense = |m: &Matrix, rows, columns| Mat::from_fn(rows, columns, |i, j| m.at(i, j));
    let (f, g) = (dense(&model.f, n, n), dense(&model.g, n, 1));
    let (a, b) = discretize(f.as_ref(), g.as_ref(), data.sample_time);
    // Into the scaled signals of the data: u' = (u − ū)/s_u, y' = (y − ȳ)/s_y.
    let scaled = StateSpace { a, b, c: dense(&model.h, 1, n), d: Mat::zeros(1, 1) }
        .scaled(&[1.0 / data.input_scale], &[1.0 / data.output_scale]);

    let mut simulated = Vec::with_capacity(data.estimation.len() + data.validation.len());
    let mut fit = |part: &Part| -> Result<f64, Error> {
        let x0 = initial_states(&scaled, part)?;
        let y = output(&scaled, part, &x0);
        simulated.extend(y.iter().map(|y| data.output_mean + data.output_scale * y));
        Ok(fit_percent(&part.output, &y))
    };
    let estimation_fit = fit(&data.estimation)?;
    let validation_fit = fit(&data.validation)?;
    Ok(Judged { estimation_fit, validation_fit, simulated_yaw_rate_radps: simulated })
}
