//! The quality of an identified vehicle: signs and sizes of the channels before anything is estimated, and then
//! the fit on validation data, faults of the recording, and how near the model is to a spin.

use crate::Error;
use crate::data::recording::Recording;
use crate::structures::bicycle::{response_errors, response_in_gentle_driving};
use crate::structures::held::{Steering, with_open_hold};
use crate::structures::single_track::identify::SingleTrack;
use crate::structures::single_track::parameters::Parameter;
use crate::structures::single_track::unusual_parameters::unusual_parameters;
use crate::validation::faults::open_hold;
use crate::validation::faults::play::steering_play;
use crate::validation::faults::recording::{Recorded, faults};
use crate::validation::faults::steering_faults::SteeringFaults;
use crate::validation::plausible::opposite;
use crate::validation::quality::{
    GOOD_FIT, failed, failure, messages, short_validation, speed_range, weak_steering, with_error,
};
use crate::validation::residuals::pairs::pairs;
use crate::validation::response::uncertain_response::uncertain_response;
use crate::validation::vehicle_class::implausible_vehicle;
use std::f64::consts::TAU;
use steerwright_drivelog::signal::{mean, standard_deviation};
use steerwright_drivelog::{DriveLog, Role};
use steerwright_formats::{Grade, Quality, Reason, ReasonCode, VehicleData, VehicleEvidence};

/// Means over this time are compared, s.
const MEAN_S: f64 = 0.5;
/// Correlation from which two signals have opposite signs.
const OPPOSITE: f64 = -0.5;
/// Correlation from which their ratio has a meaning.
const ALIKE: f64 = 0.8;
/// Lateral acceleration over yaw rate times speed, beyond which its unit is another.
const RATIOS: [f64; 2] = [0.5, 2.0];
/// Relative loss of rear friction that a vehicle survives which is not near a spin.
pub(crate) const LEAST_SPIN_MARGIN: f64 = 0.02;
/// RMS error of the sideslip angle over its RMS, from which the simulated one does not follow it.
const FOLLOWS: f64 = 1.2;

/// Correlation and slope of `y` over `x`, of means without gaps.
fn regression(log: &DriveLog, x: &[f64], y: &[f64]) -> (f64, f64) {
    let width = ((MEAN_S / log.sample_time_s).round() as usize).max(1);
    let smooth = |signal: &[f64]| -> Vec<f64> {
        let of =
            |range: &std::ops::Range<usize>| signal[range.clone()].chunks_exact(width).map(mean);
        log.segments.iter().flat_map(|s| of(&s.range)).collect()
    };
    let (x, y) = (smooth(x), smooth(y));
    let (x0, y0) = (mean(&x), mean(&y));
    let [xx, yy, xy] = x.iter().zip(&y).fold([0.0; 3], |[xx, yy, xy], (x, y)| {
        let (x, y) = (x - x0, y - y0);
        [xx + x * x, yy + y * y, xy + x * y]
    });
    (xy / (xx * yy).sqrt(), xy / xx)
}

/// Rejects channels whose sign is that of other axes, which no estimate survives.
pub(super) fn check_signs(log: &DriveLog) -> Result<(), Error> {
    if let Some((reason, hint)) = opposite(&pairs(log), log.sample_time_s) {
        return Err(Error::Implausible { problem: reason.message, hint });
    }
    let Some(speed) = &log.speed else { return Ok(()) };
    let turned: Vec<f64> = log.output.iter().zip(speed).map(|(r, v)| r * v).collect();
    let slope = speed.windows(2).map(|v| (v[1] - v[0]) / log.sample_time_s);
    let slope: Vec<f64> = slope.chain([0.0]).collect();
    for (role, name, expected, of) in [
        (Role::LateralAcceleration, "lateral acceleration", &turned, "yaw rate times speed"),
        (
            Role::LongitudinalAcceleration,
            "longitudinal acceleration",
            &slope,
            "the rate of the speed",
        ),
    ] {
        let Some(measured) = log.others.get(&role) else { continue };
        let (correlation, ratio) = regression(log, expected, measured);
        if correlation < OPPOSITE {
            return Err(Error::Implausible {
                problem: format!(
                    "the {name} has the opposite sign to {of}: their correlation over means of {MEAN_S} s is {correlation:.2}"
                ),
                hint: "the axes are those of ISO 8855, x ahead, y to the left: negate the channel, by a - before its name".into(),
            });
        }
        let is_other = !(RATIOS[0]..=RATIOS[1]).contains(&ratio);
        if role == Role::LateralAcceleration && correlation > ALIKE && is_other {
            return Err(Error::Implausible {
                problem: format!("the {name} is {ratio:.2} times {of}"),
                hint: "check the units of the lateral acceleration, the yaw rate and the speed"
                    .into(),
            });
        }
    }
    Ok(())
}

pub(super) fn quality(
    recorded: &Steering<'_>,
    recording: &Recording,
    found: &SingleTrack,
    e: &VehicleEvidence,
    gentle: &VehicleData,
) -> Quality {
    let (log, steering_faults) = (recorded.log, recorded.faults());
    let steering = standard_deviation(&recording.steering);
    let mut reasons: Vec<Reason> = weak_steering(steering).into_iter().collect();
    let (mut remarks, mut advice) = (Vec::new(), Vec::new());
    if reasons.is_empty() {
        let errors = response_errors(gentle, &e.directions, e.speed.mean_mps);
        let (errors, open_hold_s) = with_open_hold(errors, e.open_hold_s);
        reasons = uncertain_response(&errors);
        advice.extend(open_hold_s.map(open_hold::advice));
        if let Some(fit) = &e.validation {
            reasons.extend(short_validation(fit.yaw_rate_standard_error, fit.blocks));
        }
    }
    if !reasons.is_empty() {
        advice.push(
            "drive a slalom whose rhythm sweeps from 0.2 to 2 Hz, and curves up to the limit of grip"
                .into(),
        );
    }
    let at = response_in_gentle_driving(gentle, e.speed.mean_mps);
    for (reason, cause) in recorded_faults(log, found, steering, &steering_faults, &at) {
        reasons.push(reason);
        advice.push(cause);
    }
    let length = found.parameter(Parameter::Wheelbase);
    let wheelbase = Some([length.value, length.standard_error]);
    let implausible = implausible_vehicle(log.vehicle_class, wheelbase, e.speed.mean_mps);
    // Of a vehicle that is none, the parameters are those of none: the same reason once more.
    let unusual = match &implausible {
        Some((reason, _)) if reason.grade == Grade::Fail => None,
        _ => unusual_parameters(&e.parameters),
    };
    for (reason, cause) in implausible.into_iter().chain(unusual) {
        reasons.push(reason);
        advice.push(cause);
    }
    match &e.validation {
        None => reasons.extend(Quality::not_validated().reasons),
        Some(fit) if fit.yaw_rate < GOOD_FIT => {
            let message = format!(
                "the fit on validation data is {}, below {GOOD_FIT} %",
                with_error(fit.yaw_rate, fit.yaw_rate_standard_error, 1)
            );
            let reason = failed(ReasonCode::LowValidationFit, message);
            reasons.push(reason.compared(fit.yaw_rate, GOOD_FIT, "%"));
            advice.push(
                "check the mapping, signs and clocks of the channels, and the steering ratio"
                    .into(),
            );
        }
        Some(_) => {}
    }
    if e.spin_margin < LEAST_SPIN_MARGIN {
        let (margin, least) = (100.0 * e.spin_margin, 100.0 * LEAST_SPIN_MARGIN);
        let message = format!(
            "with {least} % less friction at the rear axle the model spins on its own drive"
        );
        let reason = Reason::new(ReasonCode::NearSpin, Grade::Warn, message);
        reasons.push(reason.compared(margin, least, "%"));
        remarks.push(
            "on a drive at the limit of grip the model may spin where the vehicle does not".into(),
        );
    }
    if let (Some(error), Some(size)) =
        (e.estimation.sideslip_rms_error_rad, e.estimation.sideslip_rms_rad)
        && error > FOLLOWS * size
    {
        let message = format!(
            "the simulated sideslip misses the measured one by {:.2}°, of {:.2}°",
            error.to_degrees(),
            size.to_degrees()
        );
        let reason = Reason::new(ReasonCode::ModelError, Grade::Warn, message);
        reasons.push(reason.compared(error.to_degrees(), FOLLOWS * size.to_degrees(), "deg"));
        advice
            .push("check sign and place of the sensor of the sideslip or lateral velocity".into());
    }
    let friction = found.parameter(Parameter::FrictionFront);
    if !friction.is_determined {
        remarks.push(format!(
            "the drive reaches {:.1} m/s² and does not determine the grip: beyond that the model is that of its priors",
            e.lateral_acceleration_mps2
        ));
    }
    let fit = e.validation.unwrap_or(e.estimation);
    let fit = with_error(fit.yaw_rate, fit.yaw_rate_standard_error, 1);
    let of = if e.validation.is_some() { "validation" } else { "estimation" };
    let range = format!(
        "{}, to {:.1} m/s²",
        speed_range(e.speed.min_mps, e.speed.max_mps),
        e.lateral_acceleration_mps2
    );
    let summary = if reasons.is_empty() {
        format!("The fit on {of} data is {fit} {range}: fit to design on there.")
    } else if let Some(failure) = failure(&reasons) {
        failure
    } else {
        format!(
            "The fit on {of} data is {fit} {range}. A controller may be designed there with reservations: {}.",
            messages(&reasons)
        )
    };
    Quality::new(summary, reasons, advice).with_remarks(remarks)
}

fn recorded_faults(
    log: &DriveLog,
    found: &SingleTrack,
    steering: f64,
    steering_faults: &SteeringFaults,
    at: &dyn Fn(f64) -> (f64, f64),
) -> Vec<(Reason, String)> {
    let play = steering_faults.play_rad.map(|width| steering_play(width, &|w| at(w / TAU)));
    let at_zero = |parameter| found.model.get(parameter);
    faults(&Recorded {
        channels: &log.channels,
        play: play.as_ref(),
        delay_in_windows_s: None,
        yaw_rate_lead_s: steering_faults.yaw_rate_lead_s,
        yaw_rate_lag_s: steering_faults.yaw_rate_lag_s,
        road_wheel_std_rad: steering,
        yaw_rate_std_radps: standard_deviation(&log.output),
        steering_ratio: log.steering_ratio,
        noise_radps: found.noise[0].unwrap_or_default(),
        seconds: log.len() as f64 * log.sample_time_s,
        road_wheel_offset_rad: at_zero(Parameter::SteeringOffset),
        yaw_rate_offset_radps: at_zero(Parameter::YawRateOffset),
    })
}
