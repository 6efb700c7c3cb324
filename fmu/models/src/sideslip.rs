//! The sideslip of a vehicle as a law of its speed: that of the identified plant, of the path follower and
//! of the pose estimator.
//!
//! With the yaw rate r and the lateral acceleration `a = v·r`, which counts up to g since tyres carry
//! little more (this bounds the sideslip for any reading and curvature),
//!
//! ```text
//! β    = (S(v) + Q(v)·a²)·r + C(v)·ṙ
//! S(v) = b/v − κ·v,   Q(v) = Q·v/v₀,   C(v) = C + κ²·(v² − v₀²),   κ = (b/v₀ − S)/v₀
//! ```
//!
//! S, Q and C are those at the reference speed v₀, b is the distance from centre of gravity to rear axle.
//! In a steady turn of eq 13 S(v) is exact, with b = Lr and κ = m·Lf/(Cr·L). The slip of the rear tyres
//! grows by the cube of their force, a³ = v·a²·r, hence Q(v); C(v) is the difference of
//! [`crate::BicycleParameters::sideslip_per_yaw_acceleration`] between two speeds.

use crate::limits::BLEND_SPEED;
use serde::{Deserialize, Serialize};

/// Limit of the lateral acceleration, m/s².
const GRAVITY: f64 = 9.81;

/// Sideslip angle in turns: course minus yaw.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct Sideslip {
    /// S, sideslip angle per yaw rate in a steady turn, s; of small lateral acceleration where the growth
    /// is not 0.
    pub per_yaw_rate: f64,
    /// Q, growth of S per squared lateral acceleration, s⁵/m².
    pub growth: f64,
    /// C, sideslip angle per yaw acceleration, s²; 0: not known.
    pub per_yaw_acceleration: f64,
    /// v₀, the speed of S, Q and C, m/s. Below 1 m/s, where S(v) would grow without bound, all are those of
    /// 1 m/s.
    pub reference_speed: f64,
    /// b, distance from centre of gravity to rear axle, m; 0: not known, and S, Q and C are those of every
    /// speed.
    pub distance_rear: f64,
}

impl Sideslip {
    /// The same law referred to a speed, m/s: S(v), Q(v) and C(v).
    #[inline]
    #[must_use]
    pub fn at_speed(&self, speed: f64) -> Self {
        if self.distance_rear == 0.0 {
            return Self { reference_speed: speed, ..*self };
        }
        let (v, v0) = (speed.max(BLEND_SPEED), self.reference_speed.max(BLEND_SPEED));
        // Exactly 0, and S, Q and C as they are, at v = v₀.
        let squares = (v - v0) * (v + v0);
        let known = self.per_yaw_acceleration != 0.0;
        let lead = if known { self.rear_slip().powi(2) * squares } else { 0.0 };
        Self {
            per_yaw_rate: self.per_yaw_rate * (v / v0)
                - self.distance_rear * squares / (v * v0 * v0),
            growth: self.growth * (v / v0),
            per_yaw_acceleration: self.per_yaw_acceleration + lead,
            reference_speed: speed,
            distance_rear: self.distance_rear,
        }
    }

    /// κ, slip of the rear tyres per lateral acceleration, s²/m.
    fn rear_slip(&self) -> f64 {
        let v0 = self.reference_speed.max(BLEND_SPEED);
        (self.distance_rear / v0 - self.per_yaw_rate) / v0
    }

    /// `S + Q·a²`, s, of the reference speed at a lateral acceleration (m/s²).
    #[inline]
    #[must_use]
    pub fn in_turn(&self, acceleration: f64) -> f64 {
        grown(self.per_yaw_rate, self.growth, acceleration)
    }

    /// The derivative of `(S + Q·a²)·r` by r, s, at the reference speed, where a = v·r.
    #[inline]
    #[must_use]
    pub fn by_yaw_rate(&self, acceleration: f64) -> f64 {
        let grows = acceleration.abs() < GRAVITY;
        grown(self.per_yaw_rate, if grows { 3.0 * self.growth } else { self.growth }, acceleration)
    }

    /// The derivative of β by the speed, rad·s/m, at a speed, a yaw rate and its derivative.
    #[must_use]
    pub fn by_speed(&self, speed: f64, yaw_rate: f64, yaw_acceleration: f64) -> f64 {
        let grows = (speed * yaw_rate).abs() < GRAVITY;
        let growth = self.at_speed(speed).growth;
        let turning = if grows { 2.0 * growth * speed * yaw_rate.powi(3) } else { 0.0 };
        if self.distance_rear == 0.0 || speed < BLEND_SPEED {
            return turning;
        }
        let (kappa, v0) = (self.rear_slip(), self.reference_speed.max(BLEND_SPEED));
        let steady = -kappa - self.distance_rear / (speed * speed);
        let lead = if self.per_yaw_acceleration == 0.0 { 0.0 } else { 2.0 * kappa * kappa * speed };
        turning
            + grown(steady, self.growth / v0, speed * yaw_rate) * yaw_rate
            + lead * yaw_acceleration
    }
}

/// `s + q·a²` at a lateral acceleration (m/s²).
#[inline]
fn grown(s: f64, q: f64, acceleration: f64) -> f64 {
    if q == 0.0 {
        return s;
    }
    let counted = acceleration.clamp(-GRAVITY, GRAVITY);
    s + q * counted * counted
}
