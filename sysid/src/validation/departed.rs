//! What is to be said, and done, where the model departs from the measured response.

use crate::selection::options::IdentifyOptions;
use crate::validation::sweep::{Drive, LINEAR, swept};
use formats::{BandDeparture, Evidence, Grade, Reason, ReasonCode, ResidualTest};

/// Beyond that share, less what chance can do, no controller should be designed on the model: a sixth
/// of a turn of the margins' usual 60° is 17°, and as much in gain (see [`crate::validation::departure`]).
pub(crate) const LARGEST_DEPARTURE: f64 = 0.3;
/// Beyond that share it is told.
const NOTICED: f64 = 0.1;

/// Bands in which the model departs from the measured response beyond chance.
pub(crate) fn departed(evidence: &Evidence) -> Vec<BandDeparture> {
    let bands = evidence.frequency_response.iter().flat_map(|r| &r.bands);
    bands.filter(|b| b.departure > NOTICED).copied().collect()
}

/// The departure that forbids a design, or leaves it in doubt where feedback biases what was measured; `None`
/// where there is none.
pub(crate) fn too_far(evidence: &Evidence, departed: &[BandDeparture]) -> Option<Reason> {
    let far =
        departed.iter().filter(|b| swept(b.from_hz, b.to_hz) && b.departure > LARGEST_DEPARTURE);
    let worst = far.max_by(|a, b| a.departure.total_cmp(&b.departure))?;
    let message = format!("it departs from the measured frequency response: {}", in_words(worst));
    let grade = if fed_back(evidence) { Grade::Warn } else { Grade::Fail };
    let reason = Reason::new(ReasonCode::ModelError, grade, message);
    Some(reason.compared(100.0 * worst.departure, 100.0 * LARGEST_DEPARTURE, "%"))
}

/// How near the model is to the measurement in the swept bands that are coherent, percent, with
/// twice the standard error, and these bands' ends.
pub(crate) fn nearness(evidence: &Evidence) -> Option<(f64, f64, f64)> {
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

/// Whether the steering answers to the yaw rate, so that the response from one to the other is biased towards the
/// inverse of the driver's (Ljung 1999, section 13.5).
fn fed_back(evidence: &Evidence) -> bool {
    let detected = |t: &ResidualTest| !t.pass;
    evidence.feedback.as_ref().is_some_and(detected)
        || evidence.residuals.as_ref().is_some_and(|r| detected(&r.feedback))
}

fn in_words(band: &BandDeparture) -> String {
    let degrees = band.phase_ahead_rad.to_degrees();
    format!(
        "from {} to {} Hz its gain is {:.2} times the measured, its phase {:.0}° {} (each known to ±{:.0} % or {:.0}°)",
        band.from_hz,
        band.to_hz,
        band.gain_ratio,
        degrees.abs(),
        if degrees >= 0.0 { "ahead" } else { "behind" },
        (200.0 * band.standard_error).max(1.0),
        (2.0 * band.standard_error).to_degrees().max(1.0)
    )
}

/// Each departure, and what may lie behind it.
pub(crate) fn mend(
    evidence: &Evidence,
    drive: &Drive<'_>,
    options: &IdentifyOptions,
    departed: &[BandDeparture],
) -> Vec<String> {
    if departed.is_empty() {
        return Vec::new();
    }
    let told = |b: &BandDeparture| {
        let degrees = b.phase_ahead_rad.to_degrees().round() + 0.0;
        format!("×{:.2} and {degrees:+.0}° from {} to {} Hz", b.gain_ratio, b.from_hz, b.to_hz)
    };
    let all: Vec<String> = departed.iter().map(told).collect();
    let mut out = vec![format!(
        "against the measured response, the model's gain and phase are {}",
        all.join(", ")
    )];
    let mut causes = Vec::new();
    if options.order.is_some() {
        causes.push("an order that is too low: leave --order out, or raise it".to_owned());
    }
    if options.delay_s.is_some() {
        causes.push("a delay that is not the vehicle's: leave --delay out".to_owned());
    }
    if drive.speed_spread > 0.2 {
        let cause = "a speed that changes: take a --speed-window, or --structure bicycle";
        causes.push(cause.to_owned());
    }
    if fed_back(evidence) {
        causes.push(
            "feedback by the driver, which biases the measured response and not the model: a slalom by a plan would tell"
                .to_owned(),
        );
    }
    // Twice the standard deviation is what the drive's stronger turns have.
    if 2.0 * drive.speed_mps * evidence.excitation.yaw_rate_std_radps > LINEAR {
        causes.push("tyres beyond their linear range: steer less".to_owned());
    }
    if causes.is_empty() {
        causes.push("an effect that a linear model of this order leaves out".to_owned());
    }
    out.push(format!("behind such a departure may stand {}", causes.join("; ")));
    out
}
