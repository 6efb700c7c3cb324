//! A controller of a model without an actuator: its promise holds for the steering angle that the drive has, and not for
//! the one that it commands.

use crate::Error;
use crate::closed_loop::evaluate::step_metrics;
use crate::plants::design_plant::DesignPlant;
use steerwright_formats::{Grade, Pid, Quality, Reason, ReasonCode, StatedActuator};

/// Time constants of steering actuators from a fast servo to a robot that turns the steering wheel, s.
const USUAL_LAGS_S: [f64; 2] = [0.03, 0.1];

/// A reason why a controller of a model without an actuator may not keep its promise: on the vehicle behind one that is
/// usual it misses the overshoot or the settling time.
pub(crate) fn no_actuator(plant: &DesignPlant, pid: &Pid) -> Result<Option<Reason>, Error> {
    // Of another controller it is no news that it keeps no promise.
    let is_promised = pid.evidence.met && plant.quality.allows_design();
    if !(is_promised && plant.lacks_actuator()) {
        return Ok(None);
    }
    let delay = pid.designed_for.loop_delay_s;
    let required = &pid.specification;
    let (mut is_kept, mut overshoot) = (true, 0.0_f64);
    let mut settling = Some(0.0_f64);
    for time_constant_s in USUAL_LAGS_S {
        let actuator = StatedActuator { time_constant_s, delay_s: 0.0 };
        let reached = step_metrics(&plant.behind(Some(actuator)), pid, delay)?;
        overshoot = overshoot.max(reached.overshoot_percent);
        settling = settling.zip(reached.settling_time_s).map(|(a, b)| a.max(b));
        let settles = |longest: f64| reached.settling_time_s.is_some_and(|time| time <= longest);
        is_kept &= required.overshoot_percent.is_none_or(|most| reached.overshoot_percent <= most)
            && required.settling_time_s.is_none_or(settles);
    }
    if is_kept {
        return Ok(None);
    }
    let [short, long] = USUAL_LAGS_S.map(|lag| 1000.0 * lag);
    let settling = match settling {
        Some(time) => format!("a settling time of {time:.2} s"),
        None => "a step that does not settle".into(),
    };
    let message = format!(
        "the steering of the drive is a measured angle, and behind an actuator with a lag of {short:.0} to {long:.0} ms the controller reaches an overshoot of {overshoot:.0} % and {settling}: state the actuator (--actuator-lag, --actuator-delay) and design again, or identify it from the command beside the angle (identify --channel steering_command=CHANNEL)"
    );
    Ok(Some(Reason::new(ReasonCode::NoActuator, Grade::Warn, message)))
}

/// The quality with that reason.
pub(crate) fn without_actuator(quality: Quality, reason: Reason) -> Quality {
    let Quality { summary, mut reasons, remarks, advice, .. } = quality;
    let lacking = format!("The model has no actuator: {}.", reason.message);
    // The summary of a pass says that the model is fit to design on.
    let summary = if reasons.is_empty() { lacking } else { format!("{summary} {lacking}") };
    reasons.push(reason);
    Quality::new(summary, reasons, advice).with_remarks(remarks)
}
