//! The structure `torque`: the response of the lateral acceleration to a steering torque, or to its normalised
//! command (docs/methods/torque.md).
//!
//! `a(t) = K·(u(t − d) − f·tanh(ω/ω0)) + ρ·g·sin(roll) + b`: linear in (K, K·f, ρ, b) for a delay d. All signals pass
//! the same low-pass filter, which the equation permits; the command between its samples is then known well
//! enough for a delay. Samples are selected by speed, never by the acceleration: a selection by the output makes K
//! too small. The covariance comes from sums of the errors over blocks of time, which include the correlation of the
//! errors.

mod fit;
mod options;
mod signals;

pub use options::TorqueOptions;

use crate::Error;
use crate::sideslip::unused_fixes;
use crate::structures::model::{IdentifiedModel, StructureOptions};
use crate::structures::multivariable::ChannelTraces;
use crate::structures::torque::fit::{BLOCK_S, Fit};
use crate::structures::torque::signals::Signals;
use steerwright_drivelog::{DriveLog, Response, Role};
use steerwright_formats::{
    Document, Estimate, Grade, Matrix, Model, NORMAL_95, Provenance, Quality, Reason, ReasonCode,
    Structure, Torque, TorqueEvidence,
};

/// Fewest blocks of which a covariance of five parameters is estimated.
const LEAST_BLOCKS: usize = 15;

impl StructureOptions for TorqueOptions {
    fn structure(&self) -> Structure {
        Structure::Torque
    }

    fn response(&self) -> Response {
        Response::LateralAcceleration
    }

    fn identify(&self, log: &DriveLog) -> Result<IdentifiedModel, Error> {
        let (torque, signals) = identify_with_signals(log, self)?;
        Ok(IdentifiedModel {
            model: Model::Torque(Box::new(torque)),
            traces: None,
            channels: Some(signals),
        })
    }
}

/// Identifies the model in a log of the response of the lateral acceleration, with speed and steering angle.
///
/// # Errors
/// [`Error::TorqueLogNeeded`] for another log, [`Error::TooFewSamples`] at or above the lowest speed,
/// [`Error::NotExciting`] if a parameter is not determined, [`Error::Option`].
pub fn identify_torque(log: &DriveLog, options: &TorqueOptions) -> Result<Torque, Error> {
    Ok(identify_with_signals(log, options)?.0)
}

/// The same with the signals behind the plots: the acceleration after the low-pass filter, at the samples that are used.
fn identify_with_signals(
    log: &DriveLog,
    options: &TorqueOptions,
) -> Result<(Torque, ChannelTraces), Error> {
    options.check()?;
    if log.response != Response::LateralAcceleration {
        let missing = "it was read for the response of the yaw rate";
        return Err(Error::TorqueLogNeeded { missing });
    }
    let needed = |missing| Error::TorqueLogNeeded { missing };
    let speed = log.speed.as_ref().ok_or_else(|| needed("it has no channel of the speed"))?;
    let angle = log.others.get(&Role::Steering);
    let angle = angle.ok_or_else(|| needed("it has no channel of the steering angle"))?;
    let signals = Signals::from_log(log, angle, options);
    let rows = signals.rows(speed, options.least_speed_mps);
    let split = ((1.0 - options.validation_fraction) * rows.len() as f64) as usize;
    let need = (LEAST_BLOCKS as f64 * BLOCK_S / log.sample_time_s) as usize;
    if split < need {
        let got = split;
        return Err(Error::TooFewSamples { got, need, sample_time_s: log.sample_time_s });
    }
    let (estimation, validation) = rows.split_at(split);
    let fit = Fit::estimate(&signals, estimation)?;
    let [k, kf, rho, offset, delay] = fit.parameters;
    let c = &fit.covariance;
    let f = kf / k;
    let friction_variance = (c[(1, 1)] - 2.0 * f * c[(0, 1)] + f * f * c[(0, 0)]) / (k * k);
    let estimate =
        |value: f64, variance: f64| Estimate { value, standard_error: variance.max(0.0).sqrt() };
    let (estimation_fit, error_mps2) = fit.fit_and_deviation(&signals, estimation);
    let (validation_fit, _) = fit.fit_and_deviation(&signals, validation);
    let evidence = TorqueEvidence {
        channels: log.channels.clone(),
        estimation_samples: estimation.len(),
        validation_samples: validation.len(),
        sample_time_s: log.sample_time_s,
        blocks: fit.blocks,
        least_speed_mps: options.least_speed_mps,
        mean_speed_mps: estimation.iter().map(|&k| speed[k]).sum::<f64>() / split as f64,
        error_mps2,
        estimation_fit,
        validation_fit,
        warnings: log
            .warnings
            .iter()
            .cloned()
            .chain(unused_fixes(log, "a torque's model has no sideslip"))
            .collect(),
    };
    let factor = estimate(k, c[(0, 0)]);
    let unit = log.channels.iter().find(|channel| channel.role == Role::SteeringTorque.key());
    let mut used = log.options.clone();
    used.extend(options.to_map());
    let torque = Torque {
        schema: Torque::SCHEMA.into(),
        name: log.name.clone(),
        command_unit: unit.map_or("1", |c| if c.unit == "Nm" { "Nm" } else { "1" }).into(),
        acceleration_per_command: factor,
        friction: estimate(f, friction_variance),
        friction_rate_radps: options.friction_rate_radps,
        roll_coefficient: if signals.has_roll() { Some(estimate(rho, c[(2, 2)])) } else { None },
        offset_mps2: estimate(offset, c[(3, 3)]),
        delay_s: estimate(delay, c[(4, 4)]),
        covariance: Matrix(c.row_iter().map(|row| row.iter().copied().collect()).collect()),
        quality: quality(factor, &evidence),
        evidence,
        provenance: Provenance {
            version: env!("CARGO_PKG_VERSION").into(),
            sources: log.sources.clone(),
            options: used,
        },
    };
    torque.checked("torque.json").map_err(|e| Error::no_model(e.to_string()))?;
    let mut modelled = vec![f64::NAN; log.len()];
    fit.write_to(&mut modelled, &signals, &rows);
    let mut is_validation = vec![false; log.len()];
    validation.iter().for_each(|&row| is_validation[row] = true);
    let unit = if torque.command_unit == "Nm" { "_nm" } else { "" };
    let inputs = vec![
        (format!("steering_torque{unit}"), log.input.clone()),
        ("steering_rad".to_owned(), angle.clone()),
    ];
    let outputs = vec![("lateral_acceleration_mps2".to_owned(), signals.acceleration, modelled)];
    Ok((torque, ChannelTraces { time_s: log.time_s(), inputs, outputs, is_validation }))
}

/// Of a fit in percent, below which the command explains too little of the acceleration.
const LEAST_FIT: f64 = 30.0;
/// Of the half width of the 95 % band of K over K, above which a controller would be designed on chance.
const LARGEST_ERROR: f64 = 0.2;

fn quality(factor: Estimate, evidence: &TorqueEvidence) -> Quality {
    let mut reasons = Vec::new();
    if factor.value <= 0.0 {
        let message = "the vehicle accelerates against the command";
        reasons.push(Reason::new(ReasonCode::WrongSign, Grade::Fail, message));
    }
    let error = NORMAL_95 * factor.standard_error / factor.value.abs();
    if error > LARGEST_ERROR {
        let message = "the lateral acceleration per command is too uncertain";
        let reason = Reason::new(ReasonCode::UncertainGain, Grade::Fail, message);
        reasons.push(reason.compared(error, LARGEST_ERROR, "1"));
    }
    let fit = evidence.validation_fit;
    if evidence.validation_samples == 0 {
        let message = "the model was not validated";
        reasons.push(Reason::new(ReasonCode::NotValidated, Grade::Warn, message));
    } else if fit < LEAST_FIT {
        let grade = if fit < 0.0 { Grade::Fail } else { Grade::Warn };
        let message = "the command explains little of the acceleration of the validation data";
        let reason = Reason::new(ReasonCode::LowValidationFit, grade, message);
        reasons.push(reason.compared(fit, LEAST_FIT, "%"));
    }
    let advice = match reasons.is_empty() {
        true => Vec::new(),
        false => vec!["record curves in both directions with the controller engaged".into()],
    };
    Quality::new(format!("The fit on validation data is {fit:.1} %."), reasons, advice)
}

#[cfg(test)]
mod tests;
