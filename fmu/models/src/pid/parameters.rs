//! Gains and limits of the yaw controller.

// `clamp` returns NaN for NaN; `min` and `max` return a bound.
#![allow(clippy::manual_clamp)]

use crate::numbers::as_numbers;
use std::f64::consts::PI;
use steerwright_formats::{LargeErrors, LateralAcceleration, PidGains};

/// A lateral acceleration that bounds no vehicle's steering, m/s².
const NO_ACCELERATION_BOUND: f64 = 1e6;

/// Gains, weights and limits; read at each tick, so they may be tuned while running.
///
/// The limits are those of [`steerwright_formats::Limits`] one by one: a file may leave out the two groups of them, while an
/// FMU has a variable for each number.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PidParameters {
    /// Gains and weights. Without a derivative filter its time constant is 0.
    pub gains: PidGains,
    /// Largest steering angle to either side, rad.
    pub max_angle: f64,
    /// Largest change of the steering angle in one tick, rad.
    pub max_increment: f64,
    /// Largest rate of the steering angle, rad/s.
    pub max_rate: f64,
    /// The limits for large yaw errors; with a largest error of π there are none, and the other three numbers are not
    /// read.
    pub large_errors: LargeErrors,
    /// The bound on the lateral acceleration that the steering angle may cause in a steady turn.
    pub lateral_acceleration: LateralAcceleration,
    /// Time between ticks Ts, s.
    pub sample_time: f64,
}

as_numbers!(PidParameters: gains.kp gains.ki gains.kd gains.derivative_filter_time_s
    gains.setpoint_weight_proportional gains.setpoint_weight_derivative gains.anti_windup_time_s
    max_angle max_increment max_rate
    large_errors.max_yaw_error_rad large_errors.yaw_rate_lag_s large_errors.sustained_rate_radps
    large_errors.rate_reserve_time_s
    lateral_acceleration.max_mps2 lateral_acceleration.steering_per_curvature_radm
    lateral_acceleration.understeer_gradient_rads2pm
    sample_time);

impl Default for PidParameters {
    /// A proportional controller at 100 Hz with the paper's limits, 22° and 15° a sample, at any speed.
    fn default() -> Self {
        let max_increment = 15.0 / 180.0 * PI;
        let max_rate = max_increment / 0.01;
        Self {
            gains: PidGains {
                kp: 1.0,
                ki: 0.0,
                kd: 0.0,
                derivative_filter_time_s: 0.0,
                setpoint_weight_proportional: 1.0,
                setpoint_weight_derivative: 0.0,
                anti_windup_time_s: 1.0,
            },
            max_angle: 22.0 / 180.0 * PI,
            max_increment,
            max_rate,
            large_errors: Self::any_error(max_rate),
            lateral_acceleration: Self::ANY_ACCELERATION,
            sample_time: 0.01,
        }
    }
}

impl PidParameters {
    /// A bound on the lateral acceleration that bounds nothing.
    pub const ANY_ACCELERATION: LateralAcceleration = LateralAcceleration {
        max_mps2: NO_ACCELERATION_BOUND,
        steering_per_curvature_radm: 1.0,
        understeer_gradient_rads2pm: 0.0,
    };

    /// Limits for large yaw errors that limit nothing, for a largest rate of the steering angle, rad/s.
    #[must_use]
    pub fn any_error(max_rate: f64) -> LargeErrors {
        LargeErrors {
            max_yaw_error_rad: PI,
            yaw_rate_lag_s: 0.0,
            sustained_rate_radps: max_rate,
            rate_reserve_time_s: 1.0,
        }
    }

    /// Largest change in one tick that both `max_increment` and `max_rate` allow, rad.
    #[must_use]
    pub fn largest_increment(&self) -> f64 {
        self.max_increment.min(self.max_rate * self.sample_time)
    }

    /// Largest steering angle to either side at a speed in m/s, rad.
    #[must_use]
    #[inline(always)]
    pub fn largest_angle(&self, speed: f64) -> f64 {
        self.lateral_acceleration.largest_angle_rad(speed, self.max_angle)
    }

    /// Yaw rate per steering angle of a steady turn at a speed in m/s, 1/s.
    #[inline(always)]
    pub(crate) fn steady_gain(&self, speed: f64) -> f64 {
        let v = speed.max(LateralAcceleration::LEAST_SPEED_MPS);
        let bound = &self.lateral_acceleration;
        v / (bound.steering_per_curvature_radm + bound.understeer_gradient_rads2pm * v * v)
    }

    /// Share of the integral action at a speed in m/s. A vehicle at standstill does not turn however it is steered; where
    /// the speed is known, as for a bound of the lateral acceleration, the integral waits there.
    #[inline(always)]
    pub(crate) fn integral_share(&self, speed: f64) -> f64 {
        if self.lateral_acceleration.max_mps2 >= NO_ACCELERATION_BOUND {
            1.0
        } else {
            (speed / LateralAcceleration::LEAST_SPEED_MPS).max(0.0).min(1.0)
        }
    }

    /// Largest yaw rate that the lateral acceleration allows at a speed in m/s, rad/s.
    #[inline(always)]
    pub(crate) fn largest_yaw_rate(&self, speed: f64) -> f64 {
        self.lateral_acceleration.max_mps2 / speed.max(LateralAcceleration::LEAST_SPEED_MPS)
    }

    /// Time by which the loop lags a ramp of the reference, s.
    #[inline(always)]
    pub(crate) fn lag(&self) -> f64 {
        let PidGains { kp, ki, setpoint_weight_proportional, .. } = self.gains;
        let weight = 1.0 - setpoint_weight_proportional;
        if ki > 0.0 { (kp * weight / ki).max(0.0) } else { 0.0 }
    }
}
