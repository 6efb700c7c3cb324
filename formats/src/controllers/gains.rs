//! The gains of the steering controller, and the settings that it recommends to a path follower.

use crate::document::Checker;
use crate::is_zero;
use serde::{Deserialize, Serialize};

/// Gains of `K(s) = Kp + Ki/s + Kd·s` (eq 14), parallel form, with setpoint weights and filter.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PidGains {
    /// Kp, steering angle per yaw error.
    pub kp: f64,
    /// Ki, 1/s.
    pub ki: f64,
    /// Kd, s.
    pub kd: f64,
    /// Time constant of the derivative filter, s.
    pub derivative_filter_time_s: f64,
    /// Weight of the reference in the proportional action.
    pub setpoint_weight_proportional: f64,
    /// Weight of the reference in the derivative action.
    pub setpoint_weight_derivative: f64,
    /// Time constant of the anti-windup back-calculation, s.
    pub anti_windup_time_s: f64,
}

/// Recommended settings of a path follower around this loop.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct GuidanceAdvice {
    /// Steering angle per path curvature, rad·m, in addition to the steering that the previewed yaw
    /// reference causes. It is not the whole steering of a steady turn, so use it together with the
    /// preview.
    pub feedforward_gain_radm: f64,
    /// Time by which the closed loop lags a yaw ramp, kp·(1 − b)/ki, s.
    pub preview_time_s: f64,
    /// Gain from the path's yaw acceleration to the yaw reference, s²; part of the feedforward. 0 may be
    /// omitted.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub yaw_acceleration_gain_s2: f64,
    /// Gain from the path's yaw jerk to the yaw reference, s³. 0 may be omitted.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub yaw_jerk_gain_s3: f64,
}

impl PidGains {
    pub(crate) fn check(&self, c: &mut Checker, at: &str) {
        check_fields!(c.not_negative(self, at): kp ki kd derivative_filter_time_s);
        check_fields!(c.finite(self, at): setpoint_weight_proportional setpoint_weight_derivative);
        check_fields!(c.positive(self, at): anti_windup_time_s);
    }
}

impl GuidanceAdvice {
    pub(crate) fn check(&self, c: &mut Checker, at: &str) {
        check_fields!(c.finite(self, at): feedforward_gain_radm);
        check_fields!(c.not_negative(self, at): preview_time_s);
        check_fields!(c.finite(self, at): yaw_acceleration_gain_s2 yaw_jerk_gain_s3);
    }
}
