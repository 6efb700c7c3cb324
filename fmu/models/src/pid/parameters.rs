//! Gains and limits of the yaw controller.

use serde::{Deserialize, Serialize};
use std::f64::consts::PI;

/// A lateral acceleration that bounds no vehicle's steering, m/s².
const NO_ACCELERATION_BOUND: f64 = 1e6;
/// Speed below which limits do not follow it, m/s.
const LEAST_SPEED: f64 = 1.0;

/// Gains, weights and limits; read at each tick, so they may be tuned while running.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct PidParameters {
    /// Proportional gain, steering angle per yaw error.
    pub kp: f64,
    /// Integral gain, 1/s.
    pub ki: f64,
    /// Derivative gain, s.
    pub kd: f64,
    /// Time constant Tf of the derivative's filter, s; 0 for none.
    pub derivative_filter_time: f64,
    /// Weight b of the reference in the proportional action.
    pub setpoint_weight_proportional: f64,
    /// Weight c of the reference in the derivative action.
    pub setpoint_weight_derivative: f64,
    /// Time constant Tt of the anti-windup, s.
    pub anti_windup_time: f64,
    /// Largest steering angle to either side, rad.
    pub max_angle: f64,
    /// Largest change of the steering angle in one tick, rad.
    pub max_increment: f64,
    /// Largest rate of the steering angle, rad/s.
    pub max_rate: f64,
    /// Largest yaw error that is acted on at once, beyond the lag behind a ramp, rad; π for any, and the three
    /// that follow are then not looked at.
    pub max_yaw_error: f64,
    /// Lag of the yaw rate behind the steering angle that was sent, s; 0 where it is not known, and an actuator
    /// slower than its largest rate is then not looked for.
    pub yaw_rate_lag: f64,
    /// Rate of the steering angle with the slowest actuator that is looked for, rad/s.
    pub sustained_rate: f64,
    /// Time at the largest rate after which the anti-windup is quicker, s.
    pub rate_reserve_time: f64,
    /// Largest lateral acceleration that the steering angle may cause in a steady turn, m/s².
    pub max_lateral_acceleration: f64,
    /// Steering angle per curvature in a slow steady turn, rad·m: wheelbase times steering ratio.
    pub steering_per_curvature: f64,
    /// Additional steering angle per lateral acceleration in a steady turn, rad·s²/m.
    pub understeer_gradient: f64,
    /// Time between ticks Ts, s.
    pub sample_time: f64,
}

impl Default for PidParameters {
    /// A proportional controller at 100 Hz with the paper's limits, 22° and 15° a sample, at any speed.
    fn default() -> Self {
        let max_increment = 15.0 / 180.0 * PI;
        Self {
            kp: 1.0,
            ki: 0.0,
            kd: 0.0,
            derivative_filter_time: 0.0,
            setpoint_weight_proportional: 1.0,
            setpoint_weight_derivative: 0.0,
            anti_windup_time: 1.0,
            max_angle: 22.0 / 180.0 * PI,
            max_increment,
            max_rate: max_increment / 0.01,
            max_yaw_error: PI,
            yaw_rate_lag: 0.0,
            sustained_rate: max_increment / 0.01,
            rate_reserve_time: 1.0,
            max_lateral_acceleration: NO_ACCELERATION_BOUND,
            steering_per_curvature: 1.0,
            understeer_gradient: 0.0,
            sample_time: 0.01,
        }
    }
}

impl PidParameters {
    /// Largest change in one tick that both `max_increment` and `max_rate` allow, rad.
    #[must_use]
    pub fn largest_increment(&self) -> f64 {
        self.max_increment.min(self.max_rate * self.sample_time)
    }

    /// Largest steering angle to either side at a speed in m/s, rad.
    #[must_use]
    #[inline(always)]
    pub fn largest_angle(&self, speed: f64) -> f64 {
        // `max` and `min` return the other bound for NaN.
        let v = speed.max(LEAST_SPEED);
        let per_acceleration = self.steering_per_curvature / (v * v) + self.understeer_gradient;
        (self.max_lateral_acceleration * per_acceleration).max(0.0).min(self.max_angle)
    }

    /// Yaw rate per steering angle of a steady turn at a speed in m/s, 1/s.
    #[inline(always)]
    pub(crate) fn steady_gain(&self, speed: f64) -> f64 {
        let v = speed.max(LEAST_SPEED);
        v / (self.steering_per_curvature + self.understeer_gradient * v * v)
    }

    /// Largest yaw rate that the lateral acceleration allows at a speed in m/s, rad/s.
    #[inline(always)]
    pub(crate) fn largest_yaw_rate(&self, speed: f64) -> f64 {
        self.max_lateral_acceleration / speed.max(LEAST_SPEED)
    }

    /// Time by which the loop lags a ramp of the reference, s.
    #[inline(always)]
    pub(crate) fn lag(&self) -> f64 {
        let weight = 1.0 - self.setpoint_weight_proportional;
        if self.ki > 0.0 { (self.kp * weight / self.ki).max(0.0) } else { 0.0 }
    }
}
