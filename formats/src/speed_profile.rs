//! The speed profile of a path: speed and acceleration over the distance, and the limits that they keep.

use crate::document::Checker;
use serde::{Deserialize, Serialize};

/// A speed profile over a path.
///
/// Between two points the acceleration is linear in the distance, so the square of the speed is quadratic. Between a point
/// at standstill with acceleration 0 and its neighbour the jerk is constant: the square of the speed is proportional to the
/// distance to the power of 4/3.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SpeedProfile {
    /// The limits that it keeps.
    pub limits: ProfileLimits,
    /// Time from the first point to the last, s; of a lap on a closed path.
    pub time_s: f64,
    /// Where which limit binds, in the order of the path. No limit binds between these segments.
    pub binding: Vec<BindingSegment>,
    /// At least two, at increasing distance from the first point of the path to its last, on a closed path to where the
    /// second lap begins.
    pub points: Vec<ProfilePoint>,
}

/// One point, in the file an array `[distance_m, speed_mps, acceleration_mps2]`.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(from = "[f64; 3]", into = "[f64; 3]")]
pub struct ProfilePoint {
    /// Arc length, as in the points of the path, m.
    pub distance_m: f64,
    /// Speed, m/s.
    pub speed_mps: f64,
    /// Acceleration along the path, m/s².
    pub acceleration_mps2: f64,
}

impl From<[f64; 3]> for ProfilePoint {
    fn from([distance_m, speed_mps, acceleration_mps2]: [f64; 3]) -> Self {
        Self { distance_m, speed_mps, acceleration_mps2 }
    }
}

impl From<ProfilePoint> for [f64; 3] {
    fn from(p: ProfilePoint) -> Self {
        [p.distance_m, p.speed_mps, p.acceleration_mps2]
    }
}

impl ProfilePoint {
    /// Whether the vehicle stands still here and starts, or has stopped, with a limited jerk.
    #[must_use]
    pub fn is_at_rest(&self) -> bool {
        self.speed_mps == 0.0 && self.acceleration_mps2 == 0.0
    }
}

/// The limits of a speed profile.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ProfileLimits {
    /// Largest speed, m/s.
    pub max_speed_mps: f64,
    /// Largest lateral acceleration v²·κ, m/s².
    pub max_lateral_acceleration_mps2: f64,
    /// Largest acceleration along the path, m/s².
    pub max_acceleration_mps2: f64,
    /// Largest deceleration, m/s².
    pub max_deceleration_mps2: f64,
    /// Largest jerk along the path to either side, m/s³; absent if it is not limited.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub max_jerk_mps3: Option<f64>,
    /// Friction coefficient μ: the vector sum of lateral and longitudinal acceleration is at most μ·g; absent if it is not
    /// limited.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub friction: Option<f64>,
    /// The limits of the steering; absent if it is not limited.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub steering: Option<SteeringLimits>,
    /// Speed at the first and at the last point, m/s; absent on a closed path, where the lap ends as it begins.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub end_speeds_mps: Option<[f64; 2]>,
}

/// Limits of the steering angle δ = (L + K·v²)·κ of a steady turn and of its rate dδ/dt, in steering coordinates.
// L and K are those of `LateralAcceleration` where the controller states one: there they bound the angle by the speed, here
// the speed by angle and rate.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SteeringLimits {
    /// L, steering angle per curvature in a slow turn, rad·m.
    pub steering_per_curvature_radm: f64,
    /// K, steering angle per lateral acceleration beyond that, rad·s²/m.
    pub understeer_gradient_rads2pm: f64,
    /// Largest angle to either side, rad; absent if it is not limited.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub max_angle_rad: Option<f64>,
    /// Largest rate, rad/s; absent if it is not limited.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub max_rate_radps: Option<f64>,
}

/// A limit of a speed profile.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum ProfileLimit {
    /// The largest speed.
    Speed,
    /// The lateral acceleration.
    LateralAcceleration,
    /// The acceleration.
    Acceleration,
    /// The deceleration.
    Deceleration,
    /// The jerk.
    Jerk,
    /// The friction.
    Friction,
    /// The steering angle.
    SteeringAngle,
    /// The steering rate.
    SteeringRate,
}

crate::words!(ProfileLimit {
    Speed = "speed",
    LateralAcceleration = "lateral-acceleration",
    Acceleration = "acceleration",
    Deceleration = "deceleration",
    Jerk = "jerk",
    Friction = "friction",
    SteeringAngle = "steering-angle",
    SteeringRate = "steering-rate",
});

/// A part of the path on which one limit binds.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct BindingSegment {
    /// The limit.
    pub limit: ProfileLimit,
    /// Where it begins to bind, m.
    pub from_m: f64,
    /// Where it ceases to bind, m.
    pub to_m: f64,
    /// Time on this part, s.
    pub time_s: f64,
}

/// Share by which speed and acceleration of neighbouring points may contradict each other: numbers that a person has
/// rounded to four digits pass.
const CONTRADICTION: f64 = 1e-3;

impl SpeedProfile {
    /// Reports impossible values; `ends_m` are the distances of the first and the last point of the path.
    pub(crate) fn check(&self, c: &mut Checker, ends_m: [f64; 2], closed: bool) {
        self.limits.check(c, closed);
        c.not_negative(self.time_s, "profile.time_s");
        for (i, segment) in self.binding.iter().enumerate() {
            let at = format!("profile.binding[{i}].");
            check_fields!(c.finite(segment, at): from_m to_m time_s);
        }
        let points = &self.points;
        c.require(points.len() >= 2, "profile.points", || {
            format!("{} points, a profile needs at least 2", points.len())
        });
        for (i, point) in points.iter().enumerate() {
            for (j, value) in <[f64; 3]>::from(*point).into_iter().enumerate() {
                c.finite(value, &format!("profile.points[{i}][{j}]"));
            }
            c.not_negative(point.speed_mps, &format!("profile.points[{i}][1]"));
            let is_end = i == 0 || i + 1 == points.len();
            c.require(point.speed_mps > 0.0 || is_end, &format!("profile.points[{i}][1]"), || {
                "the speed is 0 between the ends: a vehicle that follows the profile never goes on"
                    .into()
            });
        }
        for (i, pair) in points.windows(2).enumerate() {
            let (a, b) = (pair[0], pair[1]);
            c.require(
                b.distance_m > a.distance_m,
                &format!("profile.points[{}][0]", i + 1),
                || {
                    format!(
                        "distance {} does not increase (before it {})",
                        b.distance_m, a.distance_m
                    )
                },
            );
            c.require(agree(a, b), &format!("profile.points[{}]", i + 1), || {
                format!(
                    "from {} m/s to {} m/s in {} m contradicts the accelerations {} and {} m/s²",
                    a.speed_mps,
                    b.speed_mps,
                    b.distance_m - a.distance_m,
                    a.acceleration_mps2,
                    b.acceleration_mps2
                )
            });
        }
        if let (Some(first), Some(last)) = (points.first(), points.last()) {
            let tolerance = 1e-6 * (1.0 + (ends_m[1] - ends_m[0]).abs());
            let is_start = (first.distance_m - ends_m[0]).abs() <= tolerance;
            c.require(is_start, "profile.points[0][0]", || {
                format!("{} m, the path begins at {} m", first.distance_m, ends_m[0])
            });
            let beyond = last.distance_m - ends_m[1];
            let is_end = beyond.abs() <= tolerance || (closed && beyond > 0.0);
            c.require(is_end, &format!("profile.points[{}][0]", points.len() - 1), || {
                format!("{} m, the path ends at {} m", last.distance_m, ends_m[1])
            });
        }
    }
}

/// Whether speeds and accelerations of neighbours are those of one motion.
fn agree(a: ProfilePoint, b: ProfilePoint) -> bool {
    let length = b.distance_m - a.distance_m;
    let [from, to] = [a.speed_mps.powi(2), b.speed_mps.powi(2)];
    let change = if a.is_at_rest() {
        1.5 * length * b.acceleration_mps2
    } else if b.is_at_rest() {
        1.5 * length * a.acceleration_mps2
    } else {
        length * (a.acceleration_mps2 + b.acceleration_mps2)
    };
    let size = from + to + length * (a.acceleration_mps2.abs() + b.acceleration_mps2.abs());
    (to - from - change).abs() <= CONTRADICTION * size
}

impl ProfileLimits {
    /// Reports impossible values.
    fn check(&self, c: &mut Checker, closed: bool) {
        let at = "profile.limits.";
        check_fields!(c.positive(self, at): max_speed_mps max_lateral_acceleration_mps2
            max_acceleration_mps2 max_deceleration_mps2);
        for (value, key) in [(self.max_jerk_mps3, "max_jerk_mps3"), (self.friction, "friction")] {
            if let Some(value) = value {
                c.positive(value, &format!("{at}{key}"));
            }
        }
        if let Some(steering) = &self.steering {
            let at = format!("{at}steering.");
            check_fields!(c.positive(steering, at): steering_per_curvature_radm);
            check_fields!(c.finite(steering, at): understeer_gradient_rads2pm);
            for (value, key) in [
                (steering.max_angle_rad, "max_angle_rad"),
                (steering.max_rate_radps, "max_rate_radps"),
            ] {
                if let Some(value) = value {
                    c.positive(value, &format!("{at}{key}"));
                }
            }
        }
        for speed in self.end_speeds_mps.iter().flatten() {
            c.not_negative(*speed, &format!("{at}end_speeds_mps"));
        }
        let is_stated = self.end_speeds_mps.is_some();
        c.require(is_stated != closed, &format!("{at}end_speeds_mps"), || {
            if closed {
                "a closed path has no ends: a lap ends at the speed at which it begins".into()
            } else {
                "it is absent: an open path has a speed at each end".into()
            }
        });
    }
}
