//! The quality of an identified plant: reasons with their numbers, and the next thing to do.

use crate::selection::options::IdentifyOptions;
use crate::validation::faults::open_hold;
use crate::validation::faults::recording::{Recorded, faults};
use crate::validation::residuals::model_error_reasons::{
    NOTICED, coherent_model_error, model_errors, suggested_checks, too_far,
};
use crate::validation::response::sweep::{Drive, SWEEP, WANTED, swept, what_to_drive};
use crate::validation::response::uncertain_response::uncertain_response;
use steerwright_formats::{
    BLOCK_S, Evidence, Excitation, ExcitationBand, Grade, Information, InputKind, LEAST_BLOCKS,
    Quality, Reason, ReasonCode, too_few_blocks,
};

/// Below, the steering hardly moves the vehicle: a fifth of a degree at the road wheel.
const LEAST_STEERING: f64 = 0.0035;
/// The band that a yaw controller with a settling time of a second needs, Hz.
pub(crate) const LEAST_BAND: f64 = 0.8;
/// Simulation fit that a model must reach to design on it, percent.
pub(crate) const GOOD_FIT: f64 = 60.0;
/// A fit that near to its bound, in percentage points, is as good as the validation data allow.
const NEAR_BOUND: f64 = 10.0;
/// Noise over the yaw rate beyond which a model is not trusted.
pub(crate) const LARGEST_NOISE: f64 = 0.5;
/// From here on the choice of the order shows in the scatter, which stated bands lack.
const LOUD: f64 = 0.25;

/// The quality by excitation, fit on validation data and conversion.
pub(crate) fn quality(
    evidence: &Evidence,
    drive: &Drive<'_>,
    options: &IdentifyOptions,
) -> Quality {
    let e = &evidence.excitation;
    let mut reasons: Vec<Reason> = weak_steering(e.road_wheel_std_rad).into_iter().collect();
    let (mut remarks, mut advice) = (Vec::new(), Vec::new());
    if e.informative_up_to_hz < LEAST_BAND {
        let message = if e.informative_up_to_hz > 0.0 {
            format!(
                "yaw rate follows the steering (coherence above 0.5) up to {:.1} Hz only",
                e.informative_up_to_hz
            )
        } else {
            "at no frequency does the steering explain half of the yaw rate".to_owned()
        };
        let reason = failed(ReasonCode::NarrowBand, message);
        reasons.push(reason.compared(e.informative_up_to_hz, LEAST_BAND, "Hz"));
    }
    let weak = !reasons.is_empty();
    if !weak {
        reasons.extend(uncertain_response(&drive.response_errors));
        advice.extend(drive.open_hold_s.map(open_hold::advice));
        // Windows of accumulated drives have no blocks of time.
        if let Some(h) = evidence.held_out.as_ref().filter(|h| h.selection != "windows") {
            reasons.extend(short_validation(h.fit_standard_error, h.blocks));
        }
    }
    let poor = poor_bands(e);
    if !reasons.is_empty() || !poor.is_empty() {
        remarks.extend(poor);
        advice.push(what_to_drive(evidence, drive));
    }
    if weak || e.noise_to_signal > LOUD {
        let hint = "the stated uncertainty is that of the chosen order and does not include its choice on the same noise: expect errors up to twice as large from a log like this";
        remarks.push(hint.to_owned());
    }
    if e.noise_to_signal > LARGEST_NOISE {
        let percent = 100.0 * e.noise_to_signal;
        let message = format!("noise is {percent:.0} % of the yaw rate");
        let reason = failed(ReasonCode::NoisyYawRate, message);
        reasons.push(reason.compared(percent, 100.0 * LARGEST_NOISE, "%"));
        advice.push("steer more strongly, or use a less noisy gyro".to_owned());
    }
    let in_windows = evidence.held_out.as_ref().is_some_and(|h| h.selection == "windows");
    let faults = faults(&Recorded {
        channels: &evidence.channels,
        play: evidence.play.as_ref(),
        delay_in_windows_s: evidence.delay.filter(|d| d.taken && in_windows).map(|d| d.estimate_s),
        yaw_rate_lead_s: evidence.yaw_rate_lead_s,
        yaw_rate_lag_s: evidence.yaw_rate_lag_s,
        road_wheel_std_rad: e.road_wheel_std_rad,
        yaw_rate_std_radps: e.yaw_rate_std_radps,
        steering_ratio: drive.steering_ratio,
        noise_radps: drive.noise_radps,
        seconds: drive.seconds,
        road_wheel_offset_rad: drive.road_wheel_offset_rad,
        yaw_rate_offset_radps: drive.yaw_rate_offset_radps,
    });
    let explained = !drive.implausible.is_empty() || evidence.yaw_rate_lead_s.is_some();
    for (reason, cause) in drive.implausible.iter().cloned().chain(faults) {
        reasons.push(reason);
        advice.push(cause);
    }
    let fit = evidence.fit.validation;
    let fit_error = evidence.held_out.as_ref().and_then(|h| h.fit_standard_error);
    if evidence.validation_samples == 0 {
        let message = "there are no validation data";
        reasons.push(failed(ReasonCode::NotValidated, message));
    } else if let Some(bound) = uninformative(evidence) {
        let message = format!(
            "the fit on validation data is {}, and noise allows at most {bound:.0} % there: these data cannot validate a model",
            with_error(fit, fit_error, 0)
        );
        // What fits the estimation data is no bad model, only one that was not validated.
        let grade = if evidence.fit.estimation < GOOD_FIT { Grade::Fail } else { Grade::Warn };
        let reason = Reason::new(ReasonCode::UninformativeValidation, grade, message);
        reasons.push(reason.compared(bound, GOOD_FIT, "%"));
        let hint = "validate on a drive that is steered as strongly as the one that was estimated from: add a manoeuvre to the log, or use a part of the log that has one";
        advice.push(hint.to_owned());
    } else if fit < GOOD_FIT {
        let message = format!(
            "the fit on validation data is {}, below {GOOD_FIT} %",
            with_error(fit, fit_error, 0)
        );
        let reason = failed(ReasonCode::LowValidationFit, message);
        reasons.push(reason.compared(fit, GOOD_FIT, "%"));
        if !weak && !explained {
            let hint = "check the mapping, signs and clocks of the channels; a delay between clocks and a changing speed lower the fit";
            advice.push(hint.to_owned());
        }
    }
    if !drive.has_continuous {
        let message = "the model has no continuous counterpart";
        reasons.push(failed(ReasonCode::NoContinuousModel, message));
        advice.push("try another order or sample time".to_owned());
    }
    if let Some((reason, cause)) = drive.slow_log.clone() {
        reasons.push(reason);
        advice.push(cause);
    }
    let model_errors = model_errors(evidence);
    reasons.extend(too_far(evidence, &model_errors));
    if let Some((remark, checks)) = suggested_checks(evidence, drive, options, &model_errors) {
        remarks.push(remark);
        advice.push(checks);
    }
    remarks.extend(limits(evidence, drive));
    advice.extend(doubts(evidence, drive, options));
    let summary = if reasons.is_empty() {
        let fit = with_error(fit, fit_error, 1);
        let hz = e.informative_up_to_hz;
        let informative = format!(
            "The fit on validation data is {fit}, and the log is informative up to {hz:.1} Hz"
        );
        match coherent_model_error(evidence) {
            None => format!("{informative}: fit to design on."),
            Some((percent, from, to)) if percent <= 100.0 * NOTICED => format!(
                "{informative}; from {from} to {to} Hz it is within {percent:.0} % of the measured response: fit to design on."
            ),
            Some((percent, from, to)) => format!(
                "{informative}. From {from} to {to} Hz the measured response confirms it to {percent:.0} % only: require margins for that."
            ),
        }
    } else if let Some(failure) = failure(&reasons) {
        failure
    } else {
        format!(
            "The fit on validation data is {}. A controller may be designed with reservations: {}.",
            with_error(fit, fit_error, 1),
            messages(&reasons)
        )
    };
    Quality::new(summary, reasons, advice).with_remarks(remarks)
}

/// The messages of all reasons.
pub(crate) fn messages(reasons: &[Reason]) -> String {
    reasons.iter().map(|r| r.message.as_str()).collect::<Vec<_>>().join("; ")
}

/// The summary of a model that fails, of any structure.
pub(crate) fn failure(reasons: &[Reason]) -> Option<String> {
    let messages = messages(reasons);
    if reasons.iter().any(|r| matches!(r.code, ReasonCode::WeakSteering | ReasonCode::NarrowBand)) {
        return Some(format!("Weakly excited: {messages}. Do not design on this model."));
    }
    if reasons.iter().any(|r| r.grade == Grade::Fail) {
        return Some(format!("Validation failed: {messages}."));
    }
    None
}

/// The reason where the road wheel hardly moves, by its standard deviation.
pub(crate) fn weak_steering(road_wheel_std_rad: f64) -> Option<Reason> {
    if road_wheel_std_rad < LEAST_STEERING {
        let degrees = road_wheel_std_rad.to_degrees();
        let message = format!("the road wheel moves by {degrees:.2}° (standard deviation) only");
        let limit = LEAST_STEERING.to_degrees();
        Some(failed(ReasonCode::WeakSteering, message).compared(degrees, limit, "deg"))
    } else {
        None
    }
}

pub(crate) fn failed(code: ReasonCode, message: impl Into<String>) -> Reason {
    Reason::new(code, Grade::Fail, message)
}

/// The bound of the fit where it is what keeps the fit low: the validation data are mostly noise.
fn uninformative(evidence: &Evidence) -> Option<f64> {
    let validation = evidence.held_out.as_ref()?;
    let bound = validation.fit_bound?;
    let fit = evidence.fit.validation;
    let near = NEAR_BOUND.max(2.0 * validation.fit_standard_error.unwrap_or(0.0));
    if fit < GOOD_FIT && bound < GOOD_FIT + NEAR_BOUND && fit > bound - near {
        Some(bound)
    } else {
        None
    }
}

/// `45 ± 6 %`: twice the standard error, about 95 %.
pub(crate) fn with_error(fit: f64, standard_error: Option<f64>, digits: usize) -> String {
    match standard_error {
        // An uncertainty below the last digit would read as none.
        Some(error) => {
            let shown = (2.0 * error).max(0.1_f64.powi(digits as i32));
            format!("{fit:.digits$} ± {shown:.digits$} %")
        }
        None => format!("{fit:.digits$} %"),
    }
}

/// `between 8 and 22 m/s`; `at 15 m/s` where both ends read the same.
pub(crate) fn speed_range(least_mps: f64, largest_mps: f64) -> String {
    let [from, to] = [least_mps, largest_mps].map(|v| format!("{v:.0}"));
    if from == to { format!("at {from} m/s") } else { format!("between {from} and {to} m/s") }
}

/// The reason where the validation data are too short for a standard error of the fit: as little data determine
/// standard errors of the model no better.
pub(crate) fn short_validation(standard_error: Option<f64>, blocks: usize) -> Option<Reason> {
    if standard_error.is_some() {
        return None;
    }
    let reason = Reason::new(ReasonCode::ShortValidation, Grade::Warn, too_few_blocks(blocks));
    Some(reason.compared(blocks as f64 * BLOCK_S, LEAST_BLOCKS as f64 * BLOCK_S, "s"))
}

/// Where the log has too little information for a controller, and how much more it would take.
fn poor_bands(excitation: &Excitation) -> Vec<String> {
    let name = |b: &ExcitationBand| format!("{} to {} Hz", b.from_hz, b.to_hz);
    let silent = excitation.silent_from_hz().filter(|f| *f <= SWEEP.1);
    let mut out = Vec::new();
    if let Some(from) = silent {
        out.push(if from > 0.0 {
            format!("above {from} Hz there is no information in this log")
        } else {
            "there is no information in this log at any frequency".to_owned()
        });
    }
    for b in excitation.bands.iter().filter(|b| swept(b.from_hz, b.to_hz)) {
        let explained = 100.0 * b.coherence;
        match b.information {
            Information::Good => {}
            Information::None if silent.is_some_and(|from| b.from_hz >= from) => {}
            Information::None => {
                out.push(format!("from {} there is no information in this log", name(b)));
            }
            Information::Weak if b.relative_error > WANTED => out.push(format!(
                "from {} steering explains {explained:.0} % of the yaw rate, and the gain is known to ±{:.0} %: {:.0} times the time of such driving would make it ±{:.0} %",
                name(b),
                200.0 * b.relative_error,
                (b.relative_error / WANTED).powi(2).ceil(),
                200.0 * WANTED
            )),
            Information::Weak => out.push(format!(
                "from {} steering explains {explained:.0} % of the yaw rate only: something else moves the vehicle, or what it does there is not linear",
                name(b)
            )),
        }
    }
    out
}

/// Effects that the model leaves out, and frequencies that the steering lacks.
fn limits(evidence: &Evidence, drive: &Drive<'_>) -> Vec<String> {
    let mut out = Vec::new();
    if evidence.independence.lags > 0 && !evidence.independence.pass {
        let remark = "validation residuals still depend on past steering: expect effects that a linear model of this order leaves out";
        out.push(remark.to_owned());
    }
    if let Some(persistence) = evidence.excitation.persistence
        && persistence.order < persistence.tried
    {
        out.push(format!(
            "the steering is persistently exciting of order {} only: its rhythm holds too few frequencies{}",
            persistence.order,
            if persistence.order < 2 * drive.order {
                format!(", too few for a model of order {}", drive.order)
            } else {
                String::new()
            }
        ));
    }
    out
}

fn doubts(evidence: &Evidence, drive: &Drive<'_>, options: &IdentifyOptions) -> Vec<String> {
    let mut out = Vec::new();
    if drive.speed_spread > 0.2 {
        let other = match options.input_kind {
            InputKind::Steering => ", or identify with the input steering*speed",
            InputKind::SteeringTimesSpeed => "",
        };
        let percent = 100.0 * drive.speed_spread;
        out.push(format!("speed varies by {percent:.0} % (standard deviation): hold it{other}"));
    }
    if evidence.residuals.as_ref().is_some_and(|r| !r.feedback.pass) {
        let hint = "the steering depends on the past yaw rate (feedback by the driver), which biases methods that take it for independent: steer by a plan, such as a slalom, more than by the road";
        out.push(hint.to_owned());
    }
    if let Some((angle, share)) = at_limit(drive.steering) {
        out.push(format!(
            "the steering stays at {:.1}° for {:.0} % of the time: if that is a limit, log the angle that was reached, not the command",
            angle.to_degrees(),
            100.0 * share
        ));
    }
    if let Some(radius) = evidence.stabilised_from {
        out.push(format!(
            "the subspace estimate was unstable (largest eigenvalue modulus {radius:.4}) before it was stabilised: compare neighbouring orders"
        ));
    }
    out
}

/// The extreme at which the steering rests, and for how long; not of a command of few values.
fn at_limit(steering: &[f64]) -> Option<(f64, f64)> {
    const SHARE: f64 = 0.03;
    let (low, high) = steering
        .iter()
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), v| (a.min(*v), b.max(*v)));
    let near = 1e-3 * (high - low);
    let share = |at: f64| {
        let resting = steering.windows(2).filter(|w| w.iter().all(|v| (v - at).abs() <= near));
        resting.count() as f64 / steering.len().max(1) as f64
    };
    let still = steering.windows(2).filter(|w| (w[0] - w[1]).abs() <= near).count() as f64
        / steering.len().max(1) as f64;
    let (low, high) = ((low, share(low)), (high, share(high)));
    let worst = if low.1 > high.1 { low } else { high };
    // Where it moves, it moves: most of the resting is at the extremes.
    if worst.1 >= SHARE && still < 0.6 && low.1 + high.1 > 0.5 * still { Some(worst) } else { None }
}
