//! Play (lash) of the steering, and its effect in a loop.

use serde::{Deserialize, Serialize};

/// Play between the recorded steering angle and the road wheels, as an angle at the road wheels.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SteeringPlay {
    /// Width of the play from stop to stop, rad at the road wheel.
    pub road_wheel_rad: f64,
    /// Its standard error, rad.
    pub standard_error_rad: f64,
    /// The limit cycle of a typical loop about the plant; absent if none is expected.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub limit_cycle: Option<LimitCycle>,
}

/// A self-sustained oscillation by the describing function of the play.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LimitCycle {
    /// Amplitude of the steering, rad at the road wheel.
    pub road_wheel_rad: f64,
    /// Amplitude of the yaw angle, rad.
    pub yaw_rad: f64,
    /// Period, s.
    pub period_s: f64,
}
