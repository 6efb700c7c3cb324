//! The outcome of a controller on a plant, and why it misses its specification.

use crate::models::Controller;
use crate::runs::ComparedRun;
use crate::truth::Limits;
use serde::Serialize;
use std::f64::consts::FRAC_PI_2;
use steerwright_formats::{Requirement, Specification, StepMetrics};
use steerwright_sweep::Class;

/// A command beyond an actuator's rate limit by less than this share is at the limit.
const AT_LIMIT: f64 = 0.02;
/// Share of a step's trace at its end in which an unstable loop is seen.
const END: f64 = 1.0 / 3.0;

/// The outcome of a run, and the requirements that it misses.
#[derive(Clone, Serialize)]
pub struct Outcome {
    /// The worst that happened.
    pub outcome: Class,
    /// Each requirement of the step that is missed, with its bound.
    pub shortfalls: Vec<String>,
    /// What may explain that.
    pub cause: Option<String>,
}

/// The outcome of a run; `limits` are those that its plant states.
pub(crate) fn outcome_of_run(
    run: &ComparedRun,
    controller: &Controller,
    limits: Limits,
) -> Outcome {
    let specification = &controller.pid.specification;
    let shortfalls = shortfalls(specification, &run.step);
    let outcome = if is_unstable(run, specification) {
        Class::Unstable
    } else if run.off_path_at_m.is_some() {
        Class::OffThePath
    } else if shortfalls.is_empty() {
        Class::Met
    } else {
        Class::SpecificationMissed
    };
    let cause = (outcome != Class::Met).then(|| at_the_limit(run, limits)).flatten();
    Outcome { outcome, shortfalls, cause }
}

/// Whether the vehicle spins, a signal is not finite, or the swing of the step grows to its end.
fn is_unstable(run: &ComparedRun, specification: &Specification) -> bool {
    // A heading error of more than a quarter turn is that of a vehicle that spins.
    let spins = |e: f64| e.is_nan() || e > FRAC_PI_2;
    if spins(run.errors.heading_max_rad) || run.errors.cross_track_max_m.is_nan() {
        return true;
    }
    let yaw = &run.response.yaw_rad;
    let part = (END * yaw.len() as f64) as usize;
    let swing = |part: &[f64]| {
        let error = |yaw: &f64| (yaw - specification.step_rad).abs();
        part.iter().map(error).fold(0.0, |most: f64, e| if e.is_nan() { e } else { most.max(e) })
    };
    let (before, end) = yaw.split_at(yaw.len().saturating_sub(part));
    let middle = &before[before.len().saturating_sub(part)..];
    let (end, middle) = (swing(end), swing(middle));
    end.is_nan() || (end > 0.5 * specification.step_rad && end > middle)
}

/// The requirements of the step that are missed.
fn shortfalls(required: &Specification, step: &StepMetrics) -> Vec<String> {
    if required.is_met_by(step) {
        return Vec::new();
    }
    let missed = |requirement: Requirement| {
        let bound = requirement.required(required)?;
        let reached = match requirement.of_step(step)? {
            Some(reached) if reached <= bound * (1.0 + 1e-9) => return None,
            Some(reached) => format!("{reached:.3}{}", requirement.unit()),
            None => "not reached".to_owned(),
        };
        let (name, bound) = (requirement.label(), requirement.text(bound));
        Some(format!("{name} {reached} (at most {bound})"))
    };
    Requirement::ALL.into_iter().filter_map(missed).collect()
}

/// Reports commands faster than the actuator of the plant.
fn at_the_limit(run: &ComparedRun, limits: Limits) -> Option<String> {
    let limit = limits.rate_radps?;
    let response = &run.response;
    let rates = response.steering_rad.windows(2).zip(response.time_s.windows(2));
    let fastest = rates.map(|(u, t)| ((u[1] - u[0]) / (t[1] - t[0])).abs()).fold(0.0, f64::max);
    if fastest > limit * (1.0 + AT_LIMIT) {
        Some(format!(
            "the step commands up to {:.0} deg/s of steering, the actuator does {:.1} deg/s",
            fastest.to_degrees(),
            limit.to_degrees()
        ))
    } else {
        None
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shortfalls_name_the_figure_and_its_bound() {
        let required = Specification::default();
        let step = StepMetrics {
            overshoot_percent: 3.1,
            settling_time_s: None,
            steady_state_error_percent: 0.5,
            rise_time_s: Some(0.3),
            largest_angle_rad: 0.1,
            largest_increment_rad: 0.01,
            integral_absolute_error_s: 0.2,
        };
        let expected =
            ["overshoot 3.100 % (at most 1 %)", "settling time not reached (at most 1 s)"];
        assert_eq!(shortfalls(&required, &step), expected);
        let good = StepMetrics { overshoot_percent: 0.5, settling_time_s: Some(0.9), ..step };
        assert!(shortfalls(&required, &good).is_empty());
    }
}
