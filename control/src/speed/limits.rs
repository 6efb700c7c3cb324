//! What limits a design, and what would allow it.

use steerwright_formats::{Longitudinal, Shortfall, SpeedController};
use steerwright_models::files::longitudinal_parameters;

/// Acceleration that is left on the grade that a drive holds, so that it regains the speed, m/s².
const RESERVE: f64 = 0.05;

/// Points of the range at which the drive is compared with the grade.
const POINTS: u32 = 200;

/// Advice on the shortfalls of a design.
pub(crate) fn advice(controller: &SpeedController) -> Vec<String> {
    let mut all = Vec::new();
    let model = &controller.model;
    let s = &controller.specification;
    if !controller.evidence.shortfalls.is_empty() && !model.is_acceleration_commanded() {
        all.extend(weak_drive(model, s.speeds_mps, s.grade_percent, s.step_mps));
    }
    for shortfall in &controller.evidence.shortfalls {
        all.extend(limited(controller, shortfall));
    }
    all
}

/// Acceleration at the full accelerator on a level road, m/s².
fn largest_acceleration(model: &Longitudinal, speed: f64) -> f64 {
    model.gain_in(0, speed) - longitudinal_parameters(model).slowing(speed, 0.0)
}

/// The speeds and the grade at which the drive is too weak.
fn weak_drive(
    model: &Longitudinal,
    [low, high]: [f64; 2],
    grade_percent: f64,
    step: f64,
) -> Vec<String> {
    let gravity = longitudinal_parameters(model).gravity((0.01 * grade_percent).atan());
    let (mut fastest, mut least) = (None, f64::INFINITY);
    for k in 0..=POINTS {
        let speed = low + (high - step - low) * f64::from(k) / f64::from(POINTS);
        let acceleration = largest_acceleration(model, speed);
        if acceleration < gravity {
            least = least.min(acceleration);
        } else if least == f64::INFINITY {
            fastest = Some(speed);
        }
    }
    if least == f64::INFINITY {
        return Vec::new();
    }
    let share = ((least - RESERVE) / gravity * (0.01 * grade_percent).atan().sin()).max(0.0);
    // Rounded down: the grade that is stated must be held.
    let possible = (1000.0 * share / (1.0 - share * share).sqrt()).floor() / 10.0;
    let mut text = format!(
        "the drive limits the grade: at the full accelerator it accelerates by {least:.2} m/s² on a level road at the worst \
         speed, and a grade of {grade_percent} % requires {gravity:.2} m/s²; it holds the \
         speed up to a grade of {possible:.1} %"
    );
    if let Some(speed) = fastest {
        text += &format!(
            "; on the whole grade the range ends at {:.1} m/s, reference included",
            speed + step
        );
    }
    vec![text]
}

/// What bounds a settling time or an overshoot.
fn limited(controller: &SpeedController, shortfall: &Shortfall) -> Option<String> {
    if shortfall.requirement != "settling_time_s" {
        return None;
    }
    let (s, limits) = (&controller.specification, &controller.limits);
    let mut least = limits.max_acceleration_mps2;
    if !controller.model.is_acceleration_commanded() {
        for speed in s.speeds_mps {
            least = least.min(largest_acceleration(&controller.model, speed));
        }
    }
    let least = least.max(1e-3);
    // A step with a trapezoid of the acceleration.
    let time = s.step_mps / least + least / limits.max_jerk_mps3;
    Some(format!(
        "a step of {} m/s takes at least {time:.1} s with an acceleration of at most {least:.2} m/s² and a jerk of at most \
         {} m/s³; allow a settling time of {:.1} s, a lower range of speeds, or larger limits",
        s.step_mps,
        limits.max_jerk_mps3,
        shortfall.reached + 0.05
    ))
}
