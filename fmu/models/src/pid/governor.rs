//! Large yaw errors: the part of an error on which the controller acts, and the steering rate of an actuator
//! that is slower than stated.
//!
//! The README of `fmu/lateral-pid` has the reasons and the limits. With `E = max_yaw_error`, e the yaw
//! error, v the speed and a the lateral acceleration allowed:
//!
//! ```text
//! λ  = kp·(1−b)/ki                              lag behind a ramp of the reference; 0 where ki = 0
//! |w| falls at the rate p,  p → min(0.7·a/v, √(2α|w|)) with |dp/dt| ≤ α,  α = ½·sustained_rate·G(v)
//! ω += Ts/(λ+Ts)·(clamp(Δr/Ts, ±a/v) + p·sgn(w) − ω)    rate of the reference that the loop sees
//! w += (e − w − λω) − clamp(e − w − λω, ±E)     and the loop acts on e − w
//! ```
//!
//! So of a step at most E is seen at once, and the rest is released as a ramp, no sooner than within λ.
//! Errors up to E, and smooth references, are untouched bit by bit.

use super::actuator::Actuator;
use super::parameters::PidParameters;
use serde::{Deserialize, Serialize};
use std::f64::consts::PI;

/// Share of the yaw rate of the acceleration allowed at which a withheld reference is released, and of the
/// sustained rate that its beginning and its end take: the rest is for the feedback.
const RELEASE_SHARE: f64 = 0.7;
const RATE_SHARE: f64 = 0.5;
/// Steering rate of the largest error with a slow actuator, over the sustained rate.
const ROOM: f64 = 1.2;
/// Time constant with which the rate of the steering is read, s, share of the largest rate that counts as
/// such, and how fast a time at that rate is forgotten.
const RATE_FILTER: f64 = 0.05;
const FULL_RATE: f64 = 0.9;
const FORGOTTEN: f64 = 0.1;
/// Anti-windup time with a slow actuator, or once the reserve of time at the largest rate is overdrawn, over the
/// usual one.
const QUICKER: f64 = 0.3;

/// See the module.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub(crate) struct Governor {
    /// Yaw error w that is not acted on, rad.
    pub(crate) withheld: f64,
    /// Rate p at which it is released, rad/s.
    release: f64,
    /// Rate ω of the reference that the loop sees, rad/s.
    reference_rate: f64,
    /// Rate of the steering, smoothed, rad/s.
    steering_rate: f64,
    /// Time at the largest rate that is not forgotten, s.
    spent: f64,
    actuator: Actuator,
}

impl Governor {
    /// The part of a yaw error that is acted on; `moved` is the change of the reference since the tick
    /// before, where there was one.
    #[inline(always)]
    pub(crate) fn acted_on(
        &mut self,
        p: &PidParameters,
        speed: f64,
        error: f64,
        moved: Option<f64>,
    ) -> f64 {
        if p.large_errors.max_yaw_error_rad >= PI {
            self.withheld = 0.0;
            return error;
        }
        let (ts, lag) = (p.sample_time, p.lag());
        let fastest = p.largest_yaw_rate(speed);
        let released = self.released(p, speed, fastest, lag);
        if let Some(moved) = moved {
            let seen = (moved / ts).min(fastest).max(-fastest) + released / ts;
            self.reference_rate += ts / (lag + ts) * (seen - self.reference_rate);
        }
        let beyond = error - self.withheld - lag * self.reference_rate;
        let largest = self.largest_error(p, speed);
        if beyond.abs() > largest {
            self.withheld += beyond - beyond.min(largest).max(-largest);
        }
        // The remaining error has the sign of the error.
        if self.withheld > 0.0 {
            self.withheld = self.withheld.min(error.max(0.0));
        } else if self.withheld < 0.0 {
            self.withheld = self.withheld.max(error.min(0.0));
        }
        error - self.withheld
    }

    /// Releases withheld error for one tick; returns the amount, rad.
    #[inline(always)]
    fn released(&mut self, p: &PidParameters, speed: f64, fastest: f64, lag: f64) -> f64 {
        if self.withheld == 0.0 {
            self.release = 0.0;
            return 0.0;
        }
        let ts = p.sample_time;
        let rate = RELEASE_SHARE * fastest;
        let acceleration =
            (RATE_SHARE * p.large_errors.sustained_rate_radps * p.steady_gain(speed))
                .min(rate / lag.max(ts));
        let wanted = rate.min((2.0 * acceleration * self.withheld.abs()).sqrt());
        let wanted = wanted.copysign(self.withheld);
        let change = acceleration * ts;
        self.release += (wanted - self.release).min(change).max(-change);
        let released = (self.release * ts).min(self.withheld.max(0.0)).max(self.withheld.min(0.0));
        self.withheld -= released;
        released
    }

    /// One that starts with the actuator at rest at an angle, rad.
    pub(crate) fn resting_at(angle: f64) -> Self {
        Self { actuator: Actuator::resting_at(angle), ..Self::default() }
    }

    /// Takes in the angle sent at the tick before and the change of the yaw since, rad.
    #[inline(always)]
    pub(crate) fn turned(&mut self, p: &PidParameters, speed: f64, sent: f64, change: f64) {
        if p.large_errors.max_yaw_error_rad < PI && p.large_errors.yaw_rate_lag_s > 0.0 {
            self.actuator.turned(p, speed, sent, change);
        }
    }

    /// Counts a tick's change of the steering angle.
    #[inline(always)]
    pub(crate) fn steered(&mut self, p: &PidParameters, change: f64, largest: f64) {
        if p.large_errors.max_yaw_error_rad >= PI {
            return;
        }
        let ts = p.sample_time;
        self.steering_rate += ts / (RATE_FILTER + ts) * (change / ts - self.steering_rate);
        let spent = if self.steering_rate.abs() * ts > FULL_RATE * largest {
            self.spent + ts
        } else {
            self.spent - FORGOTTEN * ts
        };
        self.spent = spent.min(2.0 * reserve(p)).max(0.0);
    }

    /// The anti-windup time, s.
    #[inline(always)]
    pub(crate) fn anti_windup_time(&self, p: &PidParameters) -> f64 {
        let slow = self.slow(p);
        if p.large_errors.max_yaw_error_rad >= PI || (self.spent <= reserve(p) && slow == 0.0) {
            return p.gains.anti_windup_time_s;
        }
        let overdrawn = (self.spent / reserve(p) - 1.0).max(slow).min(1.0);
        p.gains.anti_windup_time_s * (1.0 - (1.0 - QUICKER) * overdrawn)
    }

    /// Largest change of the steering angle in one tick, rad.
    #[inline(always)]
    pub(crate) fn largest_increment(&self, p: &PidParameters) -> f64 {
        if p.large_errors.max_yaw_error_rad >= PI {
            p.largest_increment()
        } else {
            self.actuator.increment(p)
        }
    }

    #[inline(always)]
    fn largest_error(&self, p: &PidParameters, speed: f64) -> f64 {
        let (slow, largest) = (self.slow(p), p.large_errors.max_yaw_error_rad);
        if slow > 0.0 {
            let crossover = p.gains.kp * p.steady_gain(speed);
            let per_error =
                p.gains.kp * p.gains.setpoint_weight_proportional * crossover + p.gains.ki;
            let followed =
                (ROOM * p.large_errors.sustained_rate_radps / per_error).max(0.0).min(largest);
            largest - slow * (largest - followed)
        } else {
            largest
        }
    }

    /// How far the rate is reduced, from 0 to 1.
    #[inline(always)]
    fn slow(&self, p: &PidParameters) -> f64 {
        if p.large_errors.max_yaw_error_rad >= PI { 0.0 } else { self.actuator.reduction(p) }
    }

    /// The numbers that must be finite.
    pub(crate) fn memory(&self) -> [(&'static str, f64); 5] {
        [
            ("the yaw error withheld", self.withheld),
            ("the rate of its release", self.release),
            ("the rate of the reference", self.reference_rate),
            ("the rate of the steering", self.steering_rate),
            ("the time at the largest rate", self.spent),
        ]
    }

    /// The memory of the actuator.
    pub(crate) fn actuator(&self) -> &Actuator {
        &self.actuator
    }
}

/// The reserve of time at the largest rate: none at all is a tick.
#[inline(always)]
fn reserve(p: &PidParameters) -> f64 {
    p.large_errors.rate_reserve_time_s.max(p.sample_time)
}

/// Largest count of the time at the largest rate for these steering angles, one per tick, s: the
/// required reserve. `before` is the angle before the first.
#[must_use]
pub fn time_at_largest_rate(p: &PidParameters, before: f64, steering: &[f64]) -> f64 {
    let mut p = *p;
    p.large_errors.max_yaw_error_rad = 0.0;
    p.large_errors.rate_reserve_time_s = f64::INFINITY;
    let (mut governor, mut before, mut most) = (Governor::default(), before, 0.0_f64);
    for &angle in steering {
        governor.steered(&p, angle - before, p.largest_increment());
        before = angle;
        most = most.max(governor.spent);
    }
    most
}
