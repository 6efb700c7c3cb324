//! A vehicle on a drive that need not be its own: the NonlinearVehicle that its file makes, in free simulation over the
//! recorded speed.
//!
//! Each part of a segment starts from the measured yaw rate in a steady turn. The offset of the steering is that of its
//! evidence, the offset of the yaw rate the median error on the estimation data. A vehicle that spins where the recorded
//! one did not has the errors of that.

use crate::Error;
use std::borrow::Cow;
use std::ops::Range;
use steerwright_drivelog::DriveLog;
use steerwright_formats::Vehicle;
use steerwright_models::{Error as ModelError, NonlinearVehicle, files};
use steerwright_sysid::{Validated, fit_percent, held_as};

/// Validates a vehicle on a drive, with the recorded speed, or its own where none was recorded. The last
/// `validation_fraction` of the samples is validation data.
///
/// # Errors
/// [`Error::Rejected`] where the file is no vehicle that can be simulated.
pub(crate) fn validate_vehicle(
    log: &DriveLog,
    validation_fraction: f64,
    vehicle: &Vehicle,
) -> Result<Validated, Error> {
    let log = &*match &vehicle.evidence {
        Some(e) => held_as(log, &e.channels, e.open_hold_s.is_some(), None)?,
        None => Cow::Borrowed(log),
    };
    let first = ((1.0 - validation_fraction) * log.len() as f64).round() as usize;
    let mut simulated = Vec::with_capacity(log.len());
    for segment in &log.segments {
        let Range { start, end } = segment.range.clone();
        let border = first.clamp(start, end);
        for part in [start..border, border..end] {
            simulated.extend(simulate(log, part, vehicle).map_err(rejected)?);
        }
    }
    let mut errors: Vec<f64> =
        log.output[..first].iter().zip(&simulated).map(|(y, s)| y - s).collect();
    errors.sort_by(f64::total_cmp);
    let offset = errors.get(errors.len() / 2).copied().unwrap_or(0.0);
    for value in &mut simulated {
        *value += offset;
    }
    let fit = |range: Range<usize>| fit_percent(&log.output[range.clone()], &simulated[range]);
    Ok(Validated {
        estimation_fit: fit(0..first),
        validation_fit: fit(first..log.len()),
        first_validation_sample: first,
        simulated_yaw_rate_radps: simulated,
    })
}

fn rejected(error: ModelError) -> Error {
    let (message, hint) = (error.to_string(), error.hint().to_owned());
    Error::Rejected { message, hint }
}

/// The yaw rates of samples that follow each other.
fn simulate(
    log: &DriveLog,
    range: Range<usize>,
    vehicle: &Vehicle,
) -> Result<Vec<f64>, ModelError> {
    if range.is_empty() {
        return Ok(Vec::new());
    }
    let mut model = NonlinearVehicle::new(files::nonlinear_parameters(vehicle))?;
    let ratio = vehicle.actuator.steering_ratio;
    let offset = steering_offset(vehicle) * ratio;
    let speed = |k: usize| log.speed.as_ref().map_or(vehicle.speed_mps, |v| v[k].max(0.0));
    let begin = range.start;
    let stop = vehicle.actuator.road_wheel_angle_max_rad;
    let angle = ((log.input[begin] + offset) / ratio).clamp(-stop, stop);
    let (yaw_rate, start_speed) = (log.output[begin], speed(begin));
    let turn = model.parameters.bicycle().lateral_velocity_per_yaw_rate(start_speed);
    model.initial_states = [turn * yaw_rate, yaw_rate, angle, start_speed * yaw_rate];
    model.speed = start_speed;
    model.start()?;
    let mut yaw_rates = Vec::with_capacity(range.len());
    for k in range {
        yaw_rates.push(model.yaw_rate());
        model.speed = speed(k);
        model.steering_angle = log.input[k] + offset;
        model.step(log.sample_time_s)?;
    }
    Ok(yaw_rates)
}

/// Of the road wheel, rad.
fn steering_offset(vehicle: &Vehicle) -> f64 {
    let parameters = vehicle.evidence.iter().flat_map(|e| &e.parameters);
    for parameter in parameters {
        if parameter.name == "steering_offset" {
            return parameter.value;
        }
    }
    0.0
}
