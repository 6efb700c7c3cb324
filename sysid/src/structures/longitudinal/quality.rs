//! The quality of a longitudinal model.

use crate::Error;
use crate::structures::longitudinal::fit::Fit;
use crate::structures::longitudinal::model::{BRAKE_LAG, DELAY, LAG};
use crate::structures::longitudinal::signals::{Piece, Signals};
use steerwright_formats::{Estimate, Grade, Longitudinal, NORMAL_95, Quality, Reason, ReasonCode};

/// Standard deviation of the command below which nothing is estimated: of an acceleration (m/s²), of an accelerator.
const LEAST_COMMAND: [f64; 2] = [0.02, 0.002];
/// Half width of the 95 % band of the mean gain over the gain.
const UNCERTAIN: f64 = 0.2;
const TOO_UNCERTAIN: f64 = 0.5;
/// The same of one gain of the table.
const UNCERTAIN_ROW: f64 = 0.5;
/// Fits in percent.
const GOOD_FIT: f64 = 60.0;
const LEAST_FIT: f64 = 30.0;
/// Half width of the 95 % band of the fit on validation data, percent.
const UNCERTAIN_FIT: f64 = 20.0;
/// Gains of an acceleration command, and accelerations at the full accelerator and brake, m/s², that vehicles have.
const COMMAND_GAINS: [f64; 2] = [0.4, 1.8];
const ACCELERATOR_GAINS: [f64; 2] = [0.3, 25.0];
const BRAKE_GAINS: [f64; 2] = [1.0, 60.0];
/// Differences of the coefficient of the grade from 1 that are unusual.
const GRADE_TOLERANCE: f64 = 0.5;
/// Root mean square change of the speed within windows of the validation data below which they show little, m/s.
const LEAST_CHANGE_MPS: f64 = 0.15;

/// Rejects a drive whose command hardly varies.
pub(super) fn check_excitation(signals: &Signals<'_>, pieces: &[Piece]) -> Result<(), Error> {
    let used = || pieces.iter().flat_map(|piece| &signals.log.input[piece.range.clone()]);
    let count = used().count().max(1) as f64;
    let mean = used().sum::<f64>() / count;
    let deviation = (used().map(|u| (u - mean).powi(2)).sum::<f64>() / count).sqrt();
    let [acceleration, accelerator] = LEAST_COMMAND;
    let (least, name) = match signals.is_acceleration {
        true => (acceleration, "acceleration command (m/s²)"),
        false => (accelerator, "accelerator"),
    };
    if deviation < least {
        return Err(Error::NotExciting {
            problem: format!(
                "the standard deviation of the {name} is {deviation:.2e} where the vehicle drives, below {least}"
            ),
        });
    }
    Ok(())
}

pub(super) fn quality(model: &Longitudinal, fit: &Fit, change_mps: f64) -> Quality {
    let mut reasons = Vec::new();
    gains(model, fit.mean_gain(), &mut reasons);
    parameters(model, fit, &mut reasons);
    fits(model, change_mps, &mut reasons);
    let mut advice = Vec::new();
    if !reasons.is_empty() {
        advice.push(
            "record some minutes of accelerating and braking, at several speeds and by different amounts, with pauses of a second or two between them".into(),
        );
    }
    let mut remarks = Vec::new();
    if model.grade_source == "none" {
        remarks.push(
            "the log has no grade: hills are part of the disturbance, and their mean is part of the resistance".into(),
        );
    }
    let e = &model.evidence;
    let error = e
        .validation_fit_standard_error
        .map_or_else(String::new, |error| format!(" ± {:.1}", NORMAL_95 * error));
    let summary = format!(
        "The simulation of {:.0} s fits the change of the speed in the validation data by {:.1}{error} %.",
        e.window_s, e.validation_fit
    );
    Quality::new(summary, reasons, advice).with_remarks(remarks)
}

fn gains(model: &Longitudinal, mean: Estimate, reasons: &mut Vec<Reason>) {
    let is_acceleration = model.command_unit == "m/s2";
    let half_width = |gain: Estimate| NORMAL_95 * gain.standard_error;
    if mean.value <= 0.0 && mean.value.abs() > half_width(mean) {
        let message = "the vehicle slows down where the command is to accelerate";
        reasons.push(Reason::new(ReasonCode::WrongSign, Grade::Fail, message));
    }
    let relative = half_width(mean) / mean.value.abs();
    if relative > UNCERTAIN {
        let grade = if relative > TOO_UNCERTAIN { Grade::Fail } else { Grade::Warn };
        let message = "the gain from the command to the acceleration is too uncertain";
        let reason = Reason::new(ReasonCode::UncertainGain, grade, message);
        reasons.push(reason.compared(relative, UNCERTAIN, "1"));
    } else {
        let rows = model.gains.iter().map(|row| row.gain);
        let worst = rows
            .chain(model.gear_gains.iter().map(|row| row.gain))
            .map(|gain| half_width(gain) / gain.value.abs())
            .fold(0.0, f64::max);
        if worst > UNCERTAIN_ROW {
            let message = "the gain at one of the speeds or in one of the gears is too uncertain";
            let reason = Reason::new(ReasonCode::UncertainGain, Grade::Warn, message);
            reasons.push(reason.compared(worst, UNCERTAIN_ROW, "1"));
        }
    }
    let [low, high] = if is_acceleration { COMMAND_GAINS } else { ACCELERATOR_GAINS };
    let is_other = mean.value + half_width(mean) < low || mean.value - half_width(mean) > high;
    if is_other && mean.value > 0.0 {
        let limit = if mean.value < low { low } else { high };
        let message = match is_acceleration {
            true => format!(
                "an acceleration command of 1 m/s² causes {:.2} m/s²{}",
                mean.value,
                suspicion(mean.value)
            ),
            false => format!(
                "the full accelerator causes {:.2} m/s²: check the units of accelerator and speed",
                mean.value
            ),
        };
        let grade = if is_acceleration { Grade::Warn } else { Grade::Fail };
        let reason = Reason::new(ReasonCode::ImplausibleGain, grade, message);
        reasons.push(reason.compared(mean.value, limit, "m/s2"));
    }
    let Some(brake) = &model.brake else { return };
    let gain = brake.gain_mps2;
    if gain.value + half_width(gain) < 0.0 {
        let message = "the vehicle accelerates where it is braked";
        reasons.push(Reason::new(ReasonCode::WrongSign, Grade::Fail, message));
        return;
    }
    let [low, high] = BRAKE_GAINS;
    if gain.value + half_width(gain) < low || gain.value - half_width(gain) > high {
        let limit = if gain.value < low { low } else { high };
        let message = "the deceleration at the full brake is that of no vehicle: check the units of brake and speed";
        let reason = Reason::new(ReasonCode::ImplausibleGain, Grade::Warn, message);
        reasons.push(reason.compared(gain.value, limit, "m/s2"));
    }
    let relative = half_width(gain) / gain.value.abs();
    if relative > TOO_UNCERTAIN {
        let message = "the deceleration per brake is too uncertain";
        let reason = Reason::new(ReasonCode::UncertainGain, Grade::Warn, message);
        reasons.push(reason.compared(relative, TOO_UNCERTAIN, "1"));
    }
}

/// The unit that a gain from an acceleration command in m/s² suggests.
fn suspicion(gain: f64) -> &'static str {
    let is_near = |factor: f64| (gain / factor).ln().abs() < 0.25;
    if is_near(9.806_65) {
        return ": the command may be in g";
    }
    if is_near(1.0 / 9.806_65) {
        return ": the command may be in units of 0.1 m/s2, or the speed be scaled";
    }
    if is_near(3.6) {
        return ": the speed may be in km/h";
    }
    if is_near(1.0 / 3.6) {
        return ": the speed may be in m/s where km/h is stated";
    }
    ": check the units of command and speed"
}

fn parameters(model: &Longitudinal, fit: &Fit, reasons: &mut Vec<Reason>) {
    let places = [
        (Some(model.time_constant_s), LAG, "lag"),
        (model.brake.map(|brake| brake.time_constant_s), BRAKE_LAG, "lag of the brake"),
    ];
    for (estimate, place, name) in places {
        let Some(estimate) = estimate else { continue };
        // A short lag is none.
        let [_, high] = fit.priors[place].bounds;
        if estimate.value >= high {
            let message = format!("the {name} is at its bound");
            let reason = Reason::new(ReasonCode::UnusualParameter, Grade::Warn, message);
            reasons.push(reason.compared(estimate.value, high, "s"));
        }
    }
    let [_, longest] = fit.priors[DELAY].bounds;
    if model.delay_s.value >= longest {
        let message = "the delay is at its bound";
        let reason = Reason::new(ReasonCode::UnusualParameter, Grade::Warn, message);
        reasons.push(reason.compared(model.delay_s.value, longest, "s"));
    }
    if let Some(share) = model.grade_coefficient {
        let half_width = NORMAL_95 * share.standard_error;
        let away = (share.value - 1.0).abs();
        // A controller behind an acceleration command may compensate the grade.
        let is_compensated = model.command_unit == "m/s2" && share.value > -half_width;
        if away - half_width > GRADE_TOLERANCE && !is_compensated {
            let message = format!(
                "the gravity along the road acts with {:.2} of its value: check sign, unit and offset of the {}",
                share.value, model.grade_source
            );
            let reason = Reason::new(ReasonCode::UnusualParameter, Grade::Warn, message);
            reasons.push(reason.compared(away, GRADE_TOLERANCE, "1"));
        }
    }
}

fn fits(model: &Longitudinal, change_mps: f64, reasons: &mut Vec<Reason>) {
    let e = &model.evidence;
    if e.validation_windows == 0 {
        let message = "the model was not validated";
        reasons.push(Reason::new(ReasonCode::NotValidated, Grade::Warn, message));
        return;
    }
    if change_mps < LEAST_CHANGE_MPS {
        let message = "the speed hardly changes in the validation data";
        let reason = Reason::new(ReasonCode::UninformativeValidation, Grade::Warn, message);
        reasons.push(reason.compared(change_mps, LEAST_CHANGE_MPS, "m/s"));
    }
    let fit = e.validation_fit;
    if fit < GOOD_FIT {
        let grade = if fit < LEAST_FIT { Grade::Fail } else { Grade::Warn };
        let limit = if fit < LEAST_FIT { LEAST_FIT } else { GOOD_FIT };
        let message =
            "the simulation reproduces little of the change of the speed in the validation data";
        let reason = Reason::new(ReasonCode::LowValidationFit, grade, message);
        reasons.push(reason.compared(fit, limit, "%"));
    }
    match e.validation_fit_standard_error {
        Some(error) if NORMAL_95 * error <= UNCERTAIN_FIT => {}
        Some(error) => {
            let message = "the fit on validation data is too uncertain";
            let reason = Reason::new(ReasonCode::ShortValidation, Grade::Warn, message);
            reasons.push(reason.compared(NORMAL_95 * error, UNCERTAIN_FIT, "%"));
        }
        None => {
            let message = "the validation data are too short for a standard error of the fit";
            reasons.push(Reason::new(ReasonCode::ShortValidation, Grade::Warn, message));
        }
    }
}
