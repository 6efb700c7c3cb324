//! Reasons and suggested fixes where the model error against the measured response is large.

use crate::selection::options::IdentifyOptions;
use crate::validation::response::sweep::{Drive, LINEAR, swept};
use steerwright_formats::{BandDeparture, Evidence, Grade, Reason, ReasonCode, ResidualTest};

/// Beyond that share, less chance, no design: a sixth of a turn of 60° of margin is 17°.
pub(crate) const LARGEST_MODEL_ERROR: f64 = 0.3;
/// Beyond that share it is reported.
pub(crate) const NOTICED: f64 = 0.1;

/// Bands in which the model differs from the measured response beyond chance.
pub(crate) fn model_errors(evidence: &Evidence) -> Vec<BandDeparture> {
    let bands = evidence.frequency_response.iter().flat_map(|r| &r.bands);
    bands.filter(|b| b.departure > NOTICED).copied().collect()
}

/// The model error that forbids a design, or under feedback leaves it in doubt.
pub(crate) fn too_far(evidence: &Evidence, model_errors: &[BandDeparture]) -> Option<Reason> {
    let far = model_errors
        .iter()
        .filter(|b| swept(b.from_hz, b.to_hz) && b.departure > LARGEST_MODEL_ERROR);
    let worst = far.max_by(|a, b| a.departure.total_cmp(&b.departure))?;
    let message =
        format!("the error against the measured frequency response is large: {}", in_words(worst));
    let grade = if fed_back(evidence) { Grade::Warn } else { Grade::Fail };
    let reason = Reason::new(ReasonCode::ModelError, grade, message);
    Some(reason.compared(100.0 * worst.departure, 100.0 * LARGEST_MODEL_ERROR, "%"))
}

/// Worst error in the coherent swept bands, percent with twice the error, and their ends.
pub(crate) fn coherent_model_error(evidence: &Evidence) -> Option<(f64, f64, f64)> {
    let bands = evidence.frequency_response.iter().flat_map(|r| &r.bands);
    let apart = |b: &BandDeparture| {
        let (s, c) = b.phase_ahead_rad.sin_cos();
        (b.gain_ratio * c - 1.0).hypot(b.gain_ratio * s)
    };
    bands.filter(|b| swept(b.from_hz, b.to_hz)).fold(None, |all: Option<(f64, f64, f64)>, b| {
        let percent = 100.0 * apart(b).max(2.0 * b.standard_error);
        let (worst, from, to) = all.unwrap_or((0.0, f64::INFINITY, 0.0));
        Some((worst.max(percent), from.min(b.from_hz), to.max(b.to_hz)))
    })
}

/// Whether feedback biases the measured response (Ljung 1999, section 13.5).
fn fed_back(evidence: &Evidence) -> bool {
    let detected = |t: &ResidualTest| !t.pass;
    evidence.feedback.as_ref().is_some_and(detected)
        || evidence.residuals.as_ref().is_some_and(|r| detected(&r.feedback))
}

fn in_words(band: &BandDeparture) -> String {
    let degrees = band.phase_ahead_rad.to_degrees();
    format!(
        "from {} to {} Hz the gain is {:.2} times the measured, the phase {:.0}° {} (each known to ±{:.0} % or {:.0}°)",
        band.from_hz,
        band.to_hz,
        band.gain_ratio,
        degrees.abs(),
        if degrees >= 0.0 { "ahead" } else { "behind" },
        (200.0 * band.standard_error).max(1.0),
        (2.0 * band.standard_error).to_degrees().max(1.0)
    )
}

/// The model error in words, and its possible causes with what to do; `None` without one.
pub(crate) fn suggested_checks(
    evidence: &Evidence,
    drive: &Drive<'_>,
    options: &IdentifyOptions,
    model_errors: &[BandDeparture],
) -> Option<(String, String)> {
    if model_errors.is_empty() {
        return None;
    }
    let in_band = |b: &BandDeparture| {
        let degrees = b.phase_ahead_rad.to_degrees().round() + 0.0;
        format!("×{:.2} and {degrees:+.0}° from {} to {} Hz", b.gain_ratio, b.from_hz, b.to_hz)
    };
    let all: Vec<String> = model_errors.iter().map(in_band).collect();
    let remark =
        format!("against the measured response, the model's gain and phase are {}", all.join(", "));
    let mut causes = Vec::new();
    if options.order.is_some() {
        causes.push("an order that is too low: raise it, or let the data choose it".to_owned());
    }
    if options.delay_s.is_some() {
        causes.push("a delay that is not the vehicle's: let the data determine it".to_owned());
    }
    if drive.speed_spread > 0.2 {
        let cause = "a speed that changes: use a speed window, or the structure bicycle";
        causes.push(cause.to_owned());
    }
    if fed_back(evidence) {
        let hint = "feedback by the driver, which biases the measured response and not the model: a slalom by a plan would show which";
        causes.push(hint.to_owned());
    }
    // Twice the standard deviation is what the drive's stronger turns have.
    if 2.0 * drive.speed_mps * evidence.excitation.yaw_rate_std_radps > LINEAR {
        causes.push("tyres beyond their linear range: steer less".to_owned());
    }
    if causes.is_empty() {
        causes.push("an effect that a linear model of this order leaves out".to_owned());
    }
    Some((remark, format!("check the possible causes of the model error: {}", causes.join("; "))))
}
