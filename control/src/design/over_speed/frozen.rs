//! The evidence at constant speeds, at the entries of the table and between them.

use crate::Error;
use crate::closed_loop::evaluate::{advice_at, evidence};
use crate::design::ensemble::Ensemble;
use crate::design::objective::Objective;
use crate::design::options::DesignOptions;
use crate::plants::design_plant::DesignPlant;
use steerwright_formats::{DesignEvidence, FrozenSpeed, Pid};
use steerwright_loading::pid_parameters_at;
use steerwright_models::PidParameters;

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
        rows.push(at(plant, pid, options, *speed, true)?);
        let Some(next) = speeds.get(k + 1) else { break };
        for part in 1..=BETWEEN {
            let share = f64::from(part) / f64::from(BETWEEN + 1);
            let between = super::readable(speed + share * (next - speed));
            rows.push(at(plant, pid, options, between, false)?);
        }
    }
    Ok(rows)
}

fn at(
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
    let ensemble = Ensemble::of(&plant, options, &objective);
    let kept = ensemble.map(|e| e.kept(&objective, &parameters, &advice)).transpose()?;
    let max_angle_rad = parameters.largest_angle(speed);
    Ok(FrozenSpeed {
        speed_mps: speed,
        breakpoint,
        kp: parameters.kp,
        ki: parameters.ki,
        kd: parameters.kd,
        max_angle_rad,
        step: e.step,
        step_with_offset: e.step_with_offset,
        curve: e.curve.unwrap_or_default(),
        margins: e.margins,
        met: e.met,
        reason: (!e.met).then(|| reason(&e, &parameters, max_angle_rad, breakpoint)),
        shortfalls: e.shortfalls,
        plants: kept.map_or(0, |(plants, _)| plants),
        share_kept: kept.map(|(_, share)| share),
    })
}

/// Why requirements are not met, in words.
fn reason(
    e: &DesignEvidence,
    parameters: &PidParameters,
    max_angle_rad: f64,
    breakpoint: bool,
) -> String {
    let angle = e.step.largest_angle_rad >= ACTS * max_angle_rad;
    let rate = e.step.largest_increment_rad >= ACTS * parameters.largest_increment();
    let fastest = parameters.largest_increment() / parameters.sample_time;
    match (angle, rate) {
        (true, _) => format!(
            "the step steers at the largest angle that is allowed at this speed, {:.1}°",
            max_angle_rad.to_degrees()
        ),
        (false, true) => {
            format!("the step steers at the largest rate, {:.0}°/s", fastest.to_degrees())
        }
        (false, false) if breakpoint => {
            "no limit acts: the gains found for this speed do not reach it".into()
        }
        (false, false) => "no limit acts: the gains are interpolated".into(),
    }
}
