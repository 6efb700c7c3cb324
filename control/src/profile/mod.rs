//! The time-optimal speed profile over a path within limits.
//!
//! ```text
//! minimise    ∫ ds/v
//! such that   v ≤ v_max,  v²·|κ| ≤ a_y,  −D ≤ a ≤ A,  |da/dt| ≤ j,  (v²·κ)² + a² ≤ (μ·g)²
//!             |δ| ≤ δ_max,  |dδ/dt| ≤ ω,   δ = (L + K·v²)·κ,  dδ/dt = v·((L + K·v²)·κ′ + 2·K·κ·a)
//! ```
//!
//! Without jerk and understeer the problem is convex in z = v² (Verscheure and others, *Time-optimal path tracking for robots:
//! a convex optimization approach*, 2009), and its solution is that of a forward and a backward pass. All limits are
//! solved for at once (`problem`, `solver`): with them the problem is not convex, and the profile is a local optimum, reached
//! from a slow start at constant speed. Steering is that of a steady turn at the place of the centre of gravity.
//!
//! | module | content |
//! |---|---|
//! | `grid` | the nodes along the path |
//! | `pointwise` | the largest speed at a place |
//! | `problem` | unknowns, conditions and their derivatives |
//! | `solver`, `banded` | the interior-point method |
//! | `binding` | which limit binds where |

mod banded;
mod binding;
mod grid;
mod pointwise;
mod problem;
mod solver;

use crate::Error;
use crate::error::{positive, require};
use crate::guidance::demand::{LARGEST_SHARE, largest_rate};
use crate::model::evidence_acceleration;
use crate::plants::design_plant::DesignPlant;
use crate::plants::family::SteadyTurn;
use binding::binding;
use grid::Grid;
use pointwise::GRAVITY;
use problem::Problem;
use steerwright_formats::{
    Longitudinal, Model, Path, Pid, ProfileLimits, SpeedProfile, SteeringLimits,
};
use steerwright_models::SpeedReference;

/// A stated speed at an end is reached where the profile has at least this share of it.
const REACHED: f64 = 0.995;
/// Largest share of a limit between the nodes, where the conditions are not required.
const LARGEST_EXCESS: f64 = 1.01;

/// Preview times of a profile for a vehicle of a longitudinal model, s: delay and lag of the drive, and of the brake. What is
/// demanded acts so much later; without a brake the drive brakes.
#[must_use]
pub fn speed_preview_times(model: &Longitudinal) -> [f64; 2] {
    let drive = model.delay_s.value + model.time_constant_s.value;
    match &model.brake {
        Some(brake) => [drive, brake.delay_s.value + brake.time_constant_s.value],
        None => [drive, drive],
    }
}

/// The time-optimal speed profile over a path. `limits` must state the speeds at both ends of an open path and none of a
/// closed one.
///
/// # Errors
/// [`Error::Option`] for limits that are not positive; [`Error::ProfileStandstill`] where a limit allows no speed at a
/// place; [`Error::ProfileEnd`] where the speed at an end is not feasible; [`Error::Model`] where the points are no path.
pub fn speed_profile(path: &Path, limits: &ProfileLimits) -> Result<SpeedProfile, Error> {
    check(path, limits)?;
    let grid = Grid::new(path, rest_lengths(limits), tight(limits))?;
    pointwise::check(&grid, limits)?;
    let problem = Problem::new(&grid, limits);
    let points = problem.points(&solver::solve(&problem)?);
    if let Some([start, end]) = limits.end_speeds_mps {
        let ends = [("start", start, points[0]), ("end", end, points[points.len() - 1])];
        for (name, stated_mps, point) in ends {
            let reached_mps = point.speed_mps;
            if reached_mps < REACHED * stated_mps {
                return Err(Error::ProfileEnd { end: name, stated_mps, reached_mps });
            }
        }
    }
    let (binding, excess) = binding(&grid, limits, &points);
    if excess.share > LARGEST_EXCESS {
        let (share, distance_m) = (excess.share, excess.distance_m);
        return Err(Error::ProfileExcess { limit: excess.limit.name(), share, distance_m });
    }
    let times = SpeedReference::from_points(points.clone(), path.closed).times();
    let time_s = times[times.len() - 1];
    Ok(SpeedProfile { limits: *limits, time_s, binding, points })
}

/// The steering of a controller: angle and rate as far as a path may need them, 0.9 of its limits.
#[must_use]
pub fn steering_limits(pid: &Pid) -> SteeringLimits {
    SteeringLimits {
        max_angle_rad: Some(LARGEST_SHARE * pid.limits.max_angle_rad),
        max_rate_radps: Some(LARGEST_SHARE * largest_rate(pid)),
        ..without_limits(SteadyTurn::new(pid))
    }
}

/// The steering of a plant in a steady turn, without limits of its angle and rate.
#[must_use]
pub fn unlimited_steering(plant: &DesignPlant) -> SteeringLimits {
    without_limits(plant.steady_turn())
}

fn without_limits(turn: SteadyTurn) -> SteeringLimits {
    SteeringLimits {
        steering_per_curvature_radm: turn.slow,
        understeer_gradient_rads2pm: turn.understeer,
        max_angle_rad: None,
        max_rate_radps: None,
    }
}

/// The lateral acceleration that a path may need, m/s²: 0.9 of the limit of the controller, otherwise of that which the
/// evidence of the model covers; `None` where neither states one.
#[must_use]
pub fn lateral_acceleration_limit(pid: Option<&Pid>, model: Option<&Model>) -> Option<f64> {
    let stated = pid.and_then(|pid| pid.limits.lateral_acceleration);
    let largest = match stated {
        Some(bound) => Some(bound.max_mps2),
        None => model.and_then(evidence_acceleration),
    };
    largest.map(|largest| LARGEST_SHARE * largest)
}

/// The curvature above which the lateral acceleration or the friction may bind, 1/m.
fn tight(limits: &ProfileLimits) -> f64 {
    let friction = limits.friction.map_or(f64::INFINITY, |friction| friction * GRAVITY);
    let lateral = limits.max_lateral_acceleration_mps2.min(friction);
    0.5 * lateral / limits.max_speed_mps.powi(2)
}

/// The distances on which the jerk is constant from standstill and to it, until the acceleration has its limit:
/// s = a³/(6·j²), m.
fn rest_lengths(limits: &ProfileLimits) -> [Option<f64>; 2] {
    let (Some(jerk), Some(speeds)) = (limits.max_jerk_mps3, limits.end_speeds_mps) else {
        return [None; 2];
    };
    let largest = [limits.max_acceleration_mps2, limits.max_deceleration_mps2];
    [0, 1].map(|end| {
        let length = largest[end].powi(3) / (6.0 * jerk * jerk);
        if speeds[end] == 0.0 { Some(length) } else { None }
    })
}

fn check(path: &Path, limits: &ProfileLimits) -> Result<(), Error> {
    positive([
        ("largest speed", limits.max_speed_mps, " m/s"),
        ("largest lateral acceleration", limits.max_lateral_acceleration_mps2, " m/s²"),
        ("largest acceleration", limits.max_acceleration_mps2, " m/s²"),
        ("largest deceleration", limits.max_deceleration_mps2, " m/s²"),
        ("largest jerk", limits.max_jerk_mps3.unwrap_or(1.0), " m/s³"),
        ("friction", limits.friction.unwrap_or(1.0), ""),
    ])?;
    if let Some(steering) = &limits.steering {
        positive([
            ("steering per curvature", steering.steering_per_curvature_radm, " rad·m"),
            ("largest steering angle", steering.max_angle_rad.unwrap_or(1.0), " rad"),
            ("largest steering rate", steering.max_rate_radps.unwrap_or(1.0), " rad/s"),
        ])?;
    }
    for (name, speed) in
        ["start speed", "end speed"].into_iter().zip(limits.end_speeds_mps.unwrap_or_default())
    {
        let is_speed = speed >= 0.0 && speed.is_finite();
        require(is_speed, name, (speed, " m/s"), "0 or more")?;
    }
    if limits.end_speeds_mps.is_some() == path.closed {
        return Err(Error::Contradiction {
            one: "the ends of the path".into(),
            other: "the speeds there".into(),
            why: "a closed path has no ends, and an open one requires a speed at both",
        });
    }
    Ok(())
}
