//! What a path needs of a controller at its speed, compared with what the controller has: before it is driven.
//!
//! ```text
//! lateral acceleration   a(s) = v²·κ(s)
//! steering angle         δ(s) = (L + K·v²)·κ(s − v·S),    the steady turn of eq 13
//! steering rate          δ̇(s) = (δ(s + v·T) − δ(s))/T,    T the sample time of the controller
//! ```
//!
//! L and K are those of the controller's limits by speed. δ is what the path follower puts out as feedforward with the
//! gain L + K·v² and no preview, on the path and along it. Its own feedforward is only a part of the steering: the
//! controller adds the rest, which the previewed yaw reference causes. S is the sideslip per yaw rate.
//!
//! This is what a vehicle needs that is on the path. A loop needs more where the curvature begins to change: on a
//! bend of straight, clothoid and arc a car turns its steering by a third more (`control/tests/it/demand.rs`).
//!
//! The limits of angle and rate are those of the controller at every speed. The limit of the lateral acceleration is
//! that of its limits by speed; a controller without one has that of the evidence of its model
//! ([`evidence_acceleration`](crate::evidence_acceleration)), and none where that states none either.

use crate::Error;
use crate::plants::family::SteadyTurn;
use crate::plants::plant_model::model_error;
use std::fmt;
use std::sync::Arc;
use steerwright_formats::{Path, Pid};
use steerwright_models::files::{guidance_parameters, path_geometry};
use steerwright_models::{GuidanceParameters, PathFollower, PathGeometry, PathOutput};

/// Largest share of a limit that a path may need: the rest is for errors and disturbances.
pub(crate) const LARGEST_SHARE: f64 = 0.9;
/// Most places between the points of a path.
const MOST_PLACES: f64 = 20_000.0;
/// Values of a road within this share of the largest count as the same.
const SAME_SHARE: f64 = 1e-3;
/// Lowest speed that is advised, m/s, and as a share of the path's.
const LEAST_SPEED_MPS: f64 = 1.0;
const LEAST_SPEED_SHARE: f64 = 0.1;
/// Accuracy of that speed, as a share of the path's.
const SPEED_ACCURACY: f64 = 1e-3;
/// A speed within this share of the design's is that of the design.
const SPEED_TOLERANCE: f64 = 0.02;

/// What a path needs.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Quantity {
    /// m/s².
    LateralAcceleration,
    /// rad, in steering coordinates.
    SteeringAngle,
    /// rad/s, in steering coordinates.
    SteeringRate,
}

/// The largest value of a quantity along a path.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Demand {
    /// What is needed.
    pub quantity: Quantity,
    /// The largest value, in the unit of the quantity.
    pub needed: f64,
    /// What the controller has.
    pub limit: f64,
    /// Where along the path the vehicle needs it, m.
    pub distance_m: f64,
    /// For more than 0.9 of the limit: the highest speed, m/s, at which the path needs no more than that;
    /// `None` where no lower speed does.
    pub feasible_speed_mps: Option<f64>,
}

impl Demand {
    /// The needed share of the limit.
    #[must_use]
    pub fn share(&self) -> f64 {
        self.needed / self.limit
    }

    /// Whether the path needs more than 0.9 of the limit.
    #[must_use]
    pub fn is_excessive(&self) -> bool {
        self.share() > LARGEST_SHARE
    }
}

impl fmt::Display for Demand {
    /// Such as `needs 0.37 rad/s of steering rate at 212 m, 0.93 of the 0.40 rad/s that the controller has: drive
    /// it at 13.9 m/s or slower`.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let value = |value: f64| match self.quantity {
            Quantity::LateralAcceleration => format!("{value:.1} m/s²"),
            Quantity::SteeringAngle => format!("{:.1}°", value.to_degrees()),
            Quantity::SteeringRate => format!("{value:.2} rad/s"),
        };
        let name = match self.quantity {
            Quantity::LateralAcceleration => "lateral acceleration",
            Quantity::SteeringAngle => "steering angle",
            Quantity::SteeringRate => "steering rate",
        };
        write!(
            f,
            "needs {} of {name} at {:.0} m, {:.2} of the {} that the controller has: ",
            value(self.needed),
            self.distance_m,
            self.share(),
            value(self.limit)
        )?;
        match self.feasible_speed_mps {
            Some(speed) if speed < 1.0 => write!(f, "drive it at {speed:.2} m/s or slower"),
            Some(speed) => write!(f, "drive it at {speed:.1} m/s or slower"),
            None => write!(f, "no lower speed is enough, widen the curve there"),
        }
    }
}

/// What a path needs of a controller at the path's speed, with the path's guidance: lateral acceleration, steering
/// angle, steering rate. `acceleration_mps2` is the limit of the lateral acceleration of a controller that
/// states none; without either there is no such row.
///
/// # Errors
/// [`Error::Model`] where the points are no path.
pub fn demands(
    path: &Path,
    pid: &Pid,
    acceleration_mps2: Option<f64>,
) -> Result<Vec<Demand>, Error> {
    let stated = pid.limits.lateral_acceleration.map(|bound| bound.max_mps2);
    let limits = [
        (Quantity::LateralAcceleration, stated.or(acceleration_mps2)),
        (Quantity::SteeringAngle, Some(pid.limits.max_angle_rad)),
        (Quantity::SteeringRate, Some(largest_rate(pid))),
    ];
    let mut road = Road::new(path, pid)?;
    let mut all = Vec::new();
    for (quantity, limit) in limits {
        let Some(limit) = limit else { continue };
        let (needed, distance_m) = road.largest(quantity, path.speed_mps);
        let mut demand = Demand { quantity, needed, limit, distance_m, feasible_speed_mps: None };
        if demand.is_excessive() {
            demand.feasible_speed_mps = road.feasible_speed(quantity, limit, path.speed_mps);
        }
        all.push(demand);
    }
    Ok(all)
}

/// The largest rate of a controller's steering, also by its largest change in a sample, rad/s.
pub(crate) fn largest_rate(pid: &Pid) -> f64 {
    pid.limits.max_rate_radps.min(pid.limits.max_increment_rad / pid.sample_time_s)
}

/// A path, and the steering of a vehicle along it.
struct Road {
    geometry: Arc<PathGeometry>,
    follower: PathFollower,
    /// The guidance of the path, whose feedforward is the whole steering but for its gain.
    law: GuidanceParameters,
    steady_turn: SteadyTurn,
    sample_time: f64,
    /// Distances of the points, and between them so densely that no sample time is left out, m.
    places: Vec<f64>,
}

impl Road {
    fn new(path: &Path, pid: &Pid) -> Result<Self, Error> {
        let geometry = Arc::new(path_geometry(path).map_err(model_error(&path.name))?);
        let (start, end) = (geometry.start(), geometry.end());
        let spacing = (path.speed_mps * pid.sample_time_s).max((end - start) / MOST_PLACES);
        let mut places = vec![start];
        let mut before = start;
        // The end of a closed path lies beyond its last point.
        for point in path.points.iter().map(|point| point.distance_m).chain([end]) {
            let pieces = ((point - before) / spacing).ceil();
            for piece in 1..=pieces as usize {
                places.push(before + (point - before) * piece as f64 / pieces);
            }
            before = point;
        }
        let mut law = guidance_parameters(&path.guidance, path.speed_mps);
        law.guidance.preview_time_s = 0.0;
        Ok(Self {
            follower: PathFollower::new(Arc::clone(&geometry)),
            geometry,
            law,
            steady_turn: SteadyTurn::new(pid),
            sample_time: pid.sample_time_s,
            places,
        })
    }

    /// The largest size of a quantity at a speed, m/s, and the first place where it is about that, m.
    fn largest(&mut self, quantity: Quantity, speed: f64) -> (f64, f64) {
        let mut sizes = Vec::with_capacity(self.places.len());
        for index in 0..self.places.len() {
            let distance = self.places[index];
            let value = match quantity {
                Quantity::LateralAcceleration => {
                    speed * speed * self.geometry.point_at(distance).curvature_per_m
                }
                Quantity::SteeringAngle => self.steering(distance, speed),
                Quantity::SteeringRate if !self.is_within(distance, speed) => 0.0,
                Quantity::SteeringRate => {
                    let next = self.steering(distance + speed * self.sample_time, speed);
                    (next - self.steering(distance, speed)) / self.sample_time
                }
            };
            sizes.push(value.abs());
        }
        let largest = sizes.iter().copied().fold(0.0, f64::max);
        let first = sizes.iter().position(|size| *size >= largest * (1.0 - SAME_SHARE));
        (largest, first.map_or(self.geometry.start(), |index| self.places[index]))
    }

    /// Whether the curvature that a vehicle steers for lies on the path now and a sample later. Beyond its ends an
    /// open path is straight, which is no change of curvature that anybody drives.
    fn is_within(&self, distance: f64, speed: f64) -> bool {
        let behind = speed * self.law.sideslip().at_speed(speed).per_yaw_rate.abs();
        let next = distance + speed * self.sample_time;
        self.geometry.is_closed()
            || (distance - behind >= self.geometry.start() && next + behind <= self.geometry.end())
    }

    /// The steering angle of a vehicle on the path, rad.
    fn steering(&mut self, distance: f64, speed: f64) -> f64 {
        let on_path = self.geometry.point_at(distance);
        self.law.guidance.feedforward_gain_radm = self.steady_turn.steering_per_curvature(speed);
        self.follower.commit(&PathOutput { distance, ..PathOutput::default() });
        let (x, y, yaw) = (on_path.x_m, on_path.y_m, on_path.heading_rad);
        self.follower.evaluate(&self.law, x, y, yaw, speed).steering_feedforward
    }

    /// The highest speed below `speed` at which a path needs no more than its share of a limit, by bisection.
    fn feasible_speed(&mut self, quantity: Quantity, limit: f64, speed: f64) -> Option<f64> {
        let mut is_enough = |speed: f64| self.largest(quantity, speed).0 <= LARGEST_SHARE * limit;
        let mut low = LEAST_SPEED_MPS.min(LEAST_SPEED_SHARE * speed);
        if !is_enough(low) {
            return None;
        }
        let mut high = speed;
        while high - low > SPEED_ACCURACY * speed {
            let middle = 0.5 * (low + high);
            if is_enough(middle) { low = middle } else { high = middle }
        }
        // Rounded down, so that the speed that is printed is enough.
        let per_mps = if low < 1.0 { 100.0 } else { 10.0 };
        Some((low * per_mps).floor() / per_mps)
    }
}

impl SteadyTurn {
    /// That of the limits by speed; of a controller without them that of its gains at the speed of the design,
    /// since feedforward and previewed reference together make a steady turn (`closed_loop::feedforward`).
    pub(crate) fn new(pid: &Pid) -> Self {
        if let Some(bound) = pid.limits.lateral_acceleration {
            return Self {
                slow: bound.steering_per_curvature_radm,
                understeer: bound.understeer_gradient_rads2pm,
            };
        }
        let (gains, advice) = (&pid.gains, &pid.guidance);
        let preview = advice.preview_time_s;
        let of_reference = gains.setpoint_weight_proportional * gains.kp * preview
            + gains.ki * (0.5 * preview * preview + advice.yaw_acceleration_gain_s2)
            - gains.kd;
        let slow = advice.feedforward_gain_radm + pid.designed_for.speed_mps * of_reference;
        Self { slow, understeer: 0.0 }
    }

    /// rad·m.
    fn steering_per_curvature(self, speed: f64) -> f64 {
        self.slow + self.understeer * speed * speed
    }
}

/// A path whose speed is not that of the design.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OtherSpeed {
    /// The speed of the path, m/s.
    pub path_mps: f64,
    /// The lowest and the highest speed of the design, m/s.
    pub design_mps: [f64; 2],
}

impl OtherSpeed {
    /// Compares the speed of a path, m/s, with those of a design: within its schedule, or within 2 % of its one speed.
    #[must_use]
    pub fn find(pid: &Pid, path_mps: f64) -> Option<Self> {
        let of_design = pid.designed_for.speed_mps;
        let lowest = pid.schedule.first().map_or(of_design, |entry| entry.speed_mps);
        let highest = pid.schedule.last().map_or(of_design, |entry| entry.speed_mps);
        let is_below = path_mps < lowest * (1.0 - SPEED_TOLERANCE);
        let is_above = path_mps > highest * (1.0 + SPEED_TOLERANCE);
        if is_below || is_above {
            Some(Self { path_mps, design_mps: [lowest, highest] })
        } else {
            None
        }
    }
}

impl fmt::Display for OtherSpeed {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [lowest, highest] = self.design_mps;
        write!(f, "the path is for {:.1} m/s, the controller for {lowest:.1}", self.path_mps)?;
        if lowest < highest {
            write!(f, " to {highest:.1}")?;
        }
        write!(f, " m/s")
    }
}
