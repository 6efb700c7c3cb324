//! The quality of a speed controller: that of its model, and of its design.

use steerwright_formats::{Grade, Quality, Reason, ReasonCode, Requirement, SpeedController};

/// Shares of the drawn vehicles that must keep every requirement for `pass` and for `warn`.
const PASS_SHARE: f64 = 0.95;
const WARN_SHARE: f64 = 0.5;
/// How far beyond the speeds of the drive a design may reach, relative to these.
const BEYOND_DRIVE: f64 = 0.1;

/// The quality that follows from model and evidence.
pub(crate) fn quality(controller: &SpeedController) -> Quality {
    let (evidence, model) = (&controller.evidence, &controller.model);
    let mut reasons = model.quality.reasons.clone();
    let mut advice = model.quality.advice.clone();
    for shortfall in &evidence.shortfalls {
        let Some(r) = Requirement::from_name(&shortfall.requirement) else { continue };
        let message = format!(
            "the {} on the model is {}, above {}",
            r.label(),
            r.text(shortfall.reached),
            r.text(shortfall.required)
        );
        let reason = Reason::new(ReasonCode::MissedRequirement, Grade::Fail, message);
        let unit = r.unit().trim();
        reasons.push(reason.compared(shortfall.reached, shortfall.required, unit));
    }
    if let Some(ensemble) = evidence.ensemble {
        let share = ensemble.keeping as f64 / ensemble.vehicles.max(1) as f64;
        if share < PASS_SHARE {
            let grade = if share < WARN_SHARE { Grade::Fail } else { Grade::Warn };
            let message = format!(
                "{} of {} vehicles drawn from the uncertainty of the model keep every requirement",
                ensemble.keeping, ensemble.vehicles
            );
            let reason = Reason::new(ReasonCode::NotRobust, grade, message);
            reasons.push(reason.compared(100.0 * share, 100.0 * PASS_SHARE, "%"));
            advice.push(
                "identify with a longer drive that uses both pedals at all speeds, or allow more \
                 overshoot or settling time"
                    .into(),
            );
        }
    }
    if !model.is_acceleration_commanded() && model.brake.is_none() {
        let message = "the model has no brake: the vehicle slows down by coasting, and is not held at standstill";
        reasons.push(Reason::new(ReasonCode::NoBrake, Grade::Warn, message));
        advice.push("identify with a log that has the brake".into());
    }
    let [driven_low, _, driven_high] = model.evidence.speed_mps;
    let [low, high] = controller.specification.speeds_mps;
    let is_beyond =
        high > (1.0 + BEYOND_DRIVE) * driven_high || low < (1.0 - BEYOND_DRIVE) * driven_low;
    if is_beyond {
        let message = format!(
            "the design is for {low:.1} to {high:.1} m/s, and the model is of a drive at {driven_low:.1} to {driven_high:.1} m/s: beyond these its gain is held constant, and that of a vehicle is not"
        );
        reasons.push(Reason::new(ReasonCode::NotValidated, Grade::Warn, message));
        advice.push(
            "identify with a drive at all speeds of the design, or design for the speeds of the drive"
                .into(),
        );
    }
    let summary = match (&evidence.ensemble, evidence.met) {
        (Some(e), true) => format!(
            "The model keeps every requirement, and so do {} of {} vehicles drawn from its uncertainty.",
            e.keeping, e.vehicles
        ),
        (None, true) => "The model keeps every requirement; no other vehicles were drawn.".into(),
        (_, false) => "The controller misses requirements on its model.".into(),
    };
    Quality::new(summary, reasons, advice).with_remarks(model.quality.remarks.clone())
}
