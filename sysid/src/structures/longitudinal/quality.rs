//! The quality of a longitudinal model.

use crate::Error;
use crate::structures::longitudinal::fit::Fit;
use crate::structures::longitudinal::model::{
    BRAKE_DELAY, BRAKE_GAIN, BRAKE_LAG, DELAY, LAG, PEDAL,
};
use crate::structures::longitudinal::signals::{Piece, Signals};
use steerwright_drivelog::Role;
use steerwright_formats::{Estimate, Grade, Longitudinal, NORMAL_95, Quality, Reason, ReasonCode};

/// Standard deviation of the command below which nothing is estimated: of an acceleration (m/s²), of an accelerator.
const LEAST_COMMAND: [f64; 2] = [0.02, 0.002];
/// Half width of the 95 % band of the mean gain over the gain.
const UNCERTAIN: f64 = 0.2;
const TOO_UNCERTAIN: f64 = 0.5;
/// The same of one gain of the table.
const UNCERTAIN_ROW: f64 = 0.5;
/// Relative variation of the gain at one speed up to which a log without a gear is one of a single gear: the upper end of
/// its band. Of 24 simulated vehicles, those of one gear have at most 0.064 and those of several 0.112 and more.
const VARYING_GAIN: f64 = 0.08;
/// Logarithm of a ratio of likelihoods from which a variation is not by chance: the deviation is no less than 0, so this is
/// half of the 90 % quantile of χ² with a degree of freedom.
const SIGNIFICANT: f64 = 1.35;
/// Longest period of pedals, s, over which it may stay open whether they are held: half of it is a tenth of a radian at
/// 0.3 Hz, above the bandwidth of a speed controller that settles within 4 s.
const LONGEST_OPEN_HOLD_S: f64 = 0.106;
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
/// Power of the drive over the mass, W/kg, and deceleration by the brake, m/s², of road cars.
const LARGEST_POWER: f64 = 200.0;
const LARGEST_BRAKING: f64 = 15.0;
/// Share of the samples above which those two are.
const RARE: f64 = 0.01;
/// Acceleration at a command of 0 on a level road, m/s², that is no slope, idling or wind.
const LARGEST_FREE_ACCELERATION: f64 = 1.0;
/// A measured change of the speed over the simulated one from which the command hides a part of its gain, where it is above 1 by
/// more than chance: noise in the place of a command moves no vehicle, and the faster of its samples decide the estimate.
const HIDDEN_GAIN: f64 = 1.1;
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

/// What the model does on the estimation data, which no estimate alone shows.
#[derive(Debug, Clone, Copy)]
pub(super) struct Demands {
    /// Power of the drive over the mass, W/kg, that few samples exceed; of an accelerator alone.
    power: Option<f64>,
    /// Deceleration by the brake that few samples exceed, m/s².
    braking: Option<f64>,
}

impl Demands {
    pub(super) fn new(signals: &Signals<'_>, fit: &Fit, pieces: &[Piece]) -> Self {
        let (mut powers, mut brakings) = (Vec::new(), Vec::new());
        for piece in pieces {
            for k in piece.range.clone() {
                let speed = signals.mean_speed[k];
                let gear = signals.gear.as_ref().map(|gear| gear[k]);
                let (low, high, share) = fit.schedule.weights(speed, gear);
                let gain = (1.0 - share) * fit.point[low] + share * fit.point[high];
                powers.push(gain * signals.log.input[k] * speed);
                if let Some(brake) = signals.brake {
                    brakings.push(fit.point[BRAKE_GAIN] * brake[k]);
                }
            }
        }
        let power = if signals.is_acceleration { None } else { rarely_exceeded(powers) };
        Self { power, braking: rarely_exceeded(brakings) }
    }
}

fn rarely_exceeded(mut values: Vec<f64>) -> Option<f64> {
    values.sort_by(f64::total_cmp);
    let place = ((1.0 - RARE) * values.len() as f64) as usize;
    values.get(place).copied()
}

/// What the simulated windows show in addition to their fit.
#[derive(Debug, Clone, Copy)]
pub(super) struct Changes {
    /// Root mean square change of the speed within the windows of the validation data, m/s.
    pub(super) rms_mps: f64,
    /// The measured change over the simulated one in all windows, with its standard error.
    pub(super) slope: Option<(f64, f64)>,
}

pub(super) fn quality(
    model: &Longitudinal,
    fit: &Fit,
    demands: Demands,
    changes: Changes,
    has_single_gear: bool,
) -> Quality {
    let mut reasons = Vec::new();
    gains(model, fit.mean_gain(), &mut reasons);
    units(demands, &mut reasons);
    parameters(model, fit, &mut reasons);
    if !model.is_acceleration_commanded() && model.gear_gains.is_empty() {
        reasons.extend(unknown_gear(model, has_single_gear));
    }
    fits(model, changes.rms_mps, &mut reasons);
    if model.is_acceleration_commanded() {
        reasons.extend(hidden_gain(changes));
    }
    let advice = advice(model, &reasons);
    let mut remarks = Vec::new();
    let [shortest, _] = fit.priors[LAG].bounds;
    if model.time_constant_s.value <= shortest {
        remarks.push(format!(
            "the lag is {shortest} s, its lower bound: it is too short to be estimated from this log"
        ));
    }
    if model.grade_source == "none" {
        remarks.push(
            "the log has no grade: hills are part of the disturbance, and their mean is part of the resistance".into(),
        );
    }
    let e = &model.evidence;
    let error = match e.validation_fit_standard_error {
        // As every fit that is printed: two standard errors.
        Some(error) => format!(" ± {:.1}", 2.0 * error),
        None => String::new(),
    };
    let summary = format!(
        "The simulation of {:.0} s fits the change of the speed in the validation data by {:.1}{error} %.",
        e.window_s, e.validation_fit
    );
    Quality::new(summary, reasons, advice).with_remarks(remarks)
}

/// Of the simulated engines whose log has no gear, some have a gain at one speed that is wrong by a quarter, which neither
/// the band nor the residuals show, but its variation does (test `responses_of_usual_vehicles_are_those_of_the_files`).
fn unknown_gear(model: &Longitudinal, has_single_gear: bool) -> Option<Reason> {
    let Some(variation) = &model.evidence.gain_variation else {
        if has_single_gear {
            return None;
        }
        let message = "the log has no gear, and is too short to show whether the vehicle has several gains at one speed";
        return Some(Reason::new(ReasonCode::UnknownGear, Grade::Warn, message));
    };
    if variation.largest <= VARYING_GAIN {
        return None;
    }
    let message = if variation.log_likelihood_ratio > SIGNIFICANT {
        let origin =
            if has_single_gear { "though one gear is stated" } else { "as in several gears" };
        format!(
            "the gain varies by {:.0} % at one speed, {origin}; the stated gain is their mean, and that of one gear may be outside of its band by two or three times as much",
            100.0 * variation.deviation
        )
    } else if has_single_gear {
        return None;
    } else {
        "the log has no gear, and does not exclude that the vehicle has several gains at one speed"
            .into()
    };
    let reason = Reason::new(ReasonCode::UnknownGear, Grade::Warn, message);
    Some(reason.compared(variation.largest, VARYING_GAIN, "1"))
}

/// An acceleration that was measured, in the place of a command, has vibrations that move no vehicle.
fn hidden_gain(changes: Changes) -> Option<Reason> {
    let (slope, error) = changes.slope?;
    if slope <= HIDDEN_GAIN || slope - 2.0 * error <= 1.0 {
        return None;
    }
    let message = format!(
        "the speed changes by {slope:.2} ± {:.2} times what is simulated: noise in the command hides a part of the gain",
        2.0 * error
    );
    let reason = Reason::new(ReasonCode::UncertainGain, Grade::Warn, message);
    Some(reason.compared(slope, HIDDEN_GAIN, "1"))
}

/// What to do about the reasons.
fn advice(model: &Longitudinal, reasons: &[Reason]) -> Vec<String> {
    let column = |role: Role| {
        let mut channels = model.evidence.channels.iter();
        channels
            .find(|channel| channel.role == role.key())
            .map_or("NAME", |channel| channel.column.as_str())
    };
    // Of gravity that drives uphill.
    let is_reversed = model.grade_coefficient.is_some_and(|share| share.value < -GRADE_TOLERANCE);
    let mut advice = Vec::new();
    let mut drive_again = false;
    for reason in reasons {
        match reason.code {
            ReasonCode::UnusualParameter if is_reversed => {
                let source = &model.grade_source;
                let role = [Role::Grade, Role::Pitch, Role::Altitude];
                let role = role.into_iter().find(|role| role.key() == source);
                let name = role.map_or("NAME", column);
                advice.push(format!(
                    "reverse the sign of the {source}: --channel {source}=\"-{name}\""
                ));
            }
            ReasonCode::WrongSign => {
                let name = column(Role::LongitudinalCommand);
                advice.push(if model.command_unit == "m/s2" {
                    format!("reverse the sign of the command: --input-channel=\"-{name}\"")
                } else {
                    format!(
                        "where the log states 1 for a released pedal, reverse it: --input-channel \"1 - {name}\", or --channel brake=\"1 - {}\"",
                        column(Role::Brake)
                    )
                });
            }
            ReasonCode::UnknownGear => {
                advice.push("log the gear, or identify the model from another drive too and compare the gains of both; where the drive has one gear, as most electric ones, state it (--single-gear, single_gear in Python)".into());
            }
            ReasonCode::ImplausibleGain => advice
                .push("state the unit of a column that has another one: --unit NAME=UNIT".into()),
            ReasonCode::UncertainGain if reason.limit == Some(HIDDEN_GAIN) => advice.push("name the command, not an acceleration that was measured, or identify with longer samples (--sample-time, sample_time in Python)".into()),
            ReasonCode::SlowLog => advice.push("state whether the pedals are held between their samples (option intersample: zoh, foh or bl), or log them at 10 Hz or more".into()),
            _ => drive_again = true,
        }
    }
    if drive_again {
        advice.push(
            "record some minutes of accelerating and braking, at several speeds and by different amounts, with pauses of a second or two between them".into(),
        );
    }
    advice.dedup();
    advice
}

/// Reasons to doubt the unit of the speed or of a pedal.
fn units(demands: Demands, reasons: &mut Vec<Reason>) {
    if let Some(power) = demands.power.filter(|power| *power > LARGEST_POWER) {
        let message = "the power of the drive over the mass is that of no road car: check the unit of the speed, which may be in km/h";
        let reason = Reason::new(ReasonCode::ImplausibleGain, Grade::Warn, message);
        reasons.push(reason.compared(power, LARGEST_POWER, "W/kg"));
    }
    if let Some(braking) = demands.braking.filter(|braking| *braking > LARGEST_BRAKING) {
        let message = "the deceleration by the brake is that of no road car: check the unit of the speed, which may be in km/h";
        let reason = Reason::new(ReasonCode::ImplausibleGain, Grade::Warn, message);
        reasons.push(reason.compared(braking, LARGEST_BRAKING, "m/s2"));
    }
}

fn gains(model: &Longitudinal, mean: Estimate, reasons: &mut Vec<Reason>) {
    let is_acceleration = model.command_unit == "m/s2";
    let half_width = |gain: Estimate| NORMAL_95 * gain.standard_error;
    if mean.value <= 0.0 && mean.value.abs() > half_width(mean) {
        let message = "the vehicle slows down where the command is to accelerate: its sign may be reversed, or 1 may be the released pedal";
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
        return ": the command may be in units of 0.1 m/s2, or the speed may be scaled";
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
        (Some(model.delay_s), DELAY, "delay"),
        (model.brake.map(|brake| brake.time_constant_s), BRAKE_LAG, "lag of the brake"),
        (model.brake.map(|brake| brake.delay_s), BRAKE_DELAY, "delay of the brake"),
    ];
    for (estimate, place, name) in places {
        let Some(estimate) = estimate else { continue };
        // A short lag or delay is none.
        let [_, high] = fit.priors[place].bounds;
        if estimate.value >= high {
            let message = format!("the {name} is at its bound");
            let reason = Reason::new(ReasonCode::UnusualParameter, Grade::Warn, message);
            reasons.push(reason.compared(estimate.value, high, "s"));
        }
    }
    if let Some(curvature) = model.pedal_curvature {
        let [_, high] = fit.priors[PEDAL].bounds;
        if curvature.value.abs() >= high {
            let message = "the curvature of the pedal is at its bound: the acceleration is not that of a smooth curve of the accelerator";
            let reason = Reason::new(ReasonCode::UnusualParameter, Grade::Warn, message);
            reasons.push(reason.compared(curvature.value.abs(), high, "1"));
        }
    }
    if let Some(period_s) = fit.open_hold_s.filter(|period| *period > LONGEST_OPEN_HOLD_S) {
        let message = "the log does not show whether the pedals are held over their period or move on within it, which the delay depends on";
        let reason = Reason::new(ReasonCode::SlowLog, Grade::Warn, message);
        reasons.push(reason.compared(period_s, LONGEST_OPEN_HOLD_S, "s"));
    }
    let free = -model.resistance_mps2.value;
    if free - NORMAL_95 * model.resistance_mps2.standard_error > LARGEST_FREE_ACCELERATION {
        let message = "the vehicle accelerates at a command of 0: check the offset of the command, whose 1 may be the released pedal";
        let reason = Reason::new(ReasonCode::UnusualParameter, Grade::Warn, message);
        reasons.push(reason.compared(free, LARGEST_FREE_ACCELERATION, "m/s2"));
    }
    if let Some(share) = model.grade_coefficient {
        let half_width = NORMAL_95 * share.standard_error;
        // However wide its band: a plant with this share of gravity climbs wrongly.
        let away = (share.value - 1.0).abs();
        // A controller behind an acceleration command may compensate the grade.
        let is_compensated = model.command_unit == "m/s2" && share.value > -half_width;
        if away > GRADE_TOLERANCE && !is_compensated {
            let message = format!(
                "the gravity along the road acts with {:.2} of its value: check sign, unit, offset and resolution of the {}",
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
