//! The evidence at constant speeds, at the entries of the table and between them.

use crate::Error;
use crate::closed_loop::evaluate::{advice_at, evidence};
use crate::design::ensemble::Ensemble;
use crate::design::objective::Objective;
use crate::design::options::DesignOptions;
use crate::plants::design_plant::DesignPlant;
use steerwright_formats::{DesignEvidence, FrozenSpeed, Pid, Specification};
use steerwright_models::PidParameters;
use steerwright_models::files::pid_parameters_at;

/// Evaluated speeds between two entries.
const BETWEEN: u32 = 3;
/// Share of a limit at which it acts.
const ACTS: f64 = 0.999;

/// The loop at each entry of a table and at speeds between them.
pub(super) fn frozen(
    plant: &DesignPlant,
    pid: &Pid,
    options: &DesignOptions,
) -> Result<Vec<FrozenSpeed>, Error> {
    let speeds: Vec<f64> = pid.schedule.iter().map(|entry| entry.speed_mps).collect();
    let mut rows = Vec::new();
    for (k, speed) in speeds.iter().enumerate() {
        rows.push(frozen_speed(plant, pid, options, *speed, true)?);
        let Some(next) = speeds.get(k + 1) else { break };
        for part in 1..=BETWEEN {
            let share = f64::from(part) / f64::from(BETWEEN + 1);
            let between = super::readable(speed + share * (next - speed));
            rows.push(frozen_speed(plant, pid, options, between, false)?);
        }
    }
    Ok(rows)
}

fn frozen_speed(
    plant: &DesignPlant,
    pid: &Pid,
    options: &DesignOptions,
    speed: f64,
    breakpoint: bool,
) -> Result<FrozenSpeed, Error> {
    let plant = plant.at_speed(speed)?;
    let objective = Objective::new(&plant, options)?;
    let (parameters, advice) = (pid_parameters_at(pid, speed), advice_at(pid, speed));
    let sampled = &objective.scenarios[0].plant;
    let e = evidence(sampled, &plant, &parameters, &objective.spec, &advice);
    let ensemble = Ensemble::new(&plant, options, &objective);
    let kept = ensemble.map(|e| e.kept(&objective, &parameters, &advice)).transpose()?;
    Ok(FrozenSpeed {
        speed_mps: speed,
        breakpoint,
        kp: parameters.gains.kp,
        ki: parameters.gains.ki,
        kd: parameters.gains.kd,
        max_angle_rad: parameters.largest_angle(speed),
        step: e.step,
        step_with_offset: e.step_with_offset,
        curve: e.curve.unwrap_or_default(),
        margins: e.margins,
        met: e.met,
        reason: if e.met {
            None
        } else {
            Some(reason(&e, &objective.spec, &parameters, speed, breakpoint))
        },
        shortfalls: e.shortfalls,
        plants: kept.map_or(0, |(plants, _)| plants),
        share_kept: kept.map(|(_, share)| share),
    })
}

/// Why requirements are not met, in words.
fn reason(
    e: &DesignEvidence,
    spec: &Specification,
    parameters: &PidParameters,
    speed: f64,
    breakpoint: bool,
) -> String {
    let largest = parameters.largest_angle(speed);
    let bound = &parameters.lateral_acceleration;
    let per_acceleration =
        bound.steering_per_curvature_radm / (speed * speed) + bound.understeer_gradient_rads2pm;
    let on_curve = spec.curve_lateral_acceleration_mps2 * per_acceleration;
    let mut words = Vec::new();
    if e.step.largest_angle_rad >= ACTS * largest {
        words.push("the step steers at the largest angle that is allowed at this speed");
    }
    if e.step.largest_increment_rad >= ACTS * parameters.largest_increment() {
        words.push("the step steers at the largest rate");
    }
    if on_curve > largest {
        words.push("the curve needs more than the largest angle");
    }
    match (words.is_empty(), breakpoint) {
        (false, _) => words.join(", "),
        (true, true) => "no limit acts: the gains found for this speed do not reach it".into(),
        (true, false) => "no limit acts: the gains are interpolated".into(),
    }
}
