//! What moves the steering to a commanded angle.
//!
//! A drive with the measured steering angle determines the vehicle from that angle on: the actuator is not in its model.

use steerwright_formats::Pid;

/// What moves the steering: `T δ̇ + δ = u(t − τ)`.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Actuator {
    /// Time constant T, s.
    pub time_constant_s: f64,
    /// Delay τ, s.
    pub delay_s: f64,
}

impl Actuator {
    /// Time constants of steering actuators from a fast servo to a robot that turns the steering wheel, s.
    pub const USUAL_LAGS_S: [f64; 2] = [0.03, 0.1];

    /// The one that a controller was designed for before its model.
    #[must_use]
    pub fn of(pid: &Pid) -> Self {
        let on = &pid.designed_for;
        Self { time_constant_s: on.actuator_lag_s, delay_s: on.actuator_delay_s }
    }
}
