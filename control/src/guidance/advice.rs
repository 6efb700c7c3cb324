//! Feedforward and preview for a path follower around the loop.
//!
//! With preview p and feedforward f/G₀ of the reference's rate, yaw follows the path's heading by
//! `T(s)·e^{ps}`, `T = (ki + b·kp·s + f·s²/G₀)/(ki + kp·s + (1/G₀ + kd)·s² + …)`; delays and lags
//! of the plant enter with s³. The terms in s and s² vanish, so that neither a circle nor a
//! clothoid leaves an error of yaw, for
//!
//! ```text
//! p = kp·(1 − b)/ki        f = 1 + G₀·(kd − b·kp·p − ki·p²/2)
//! ```
//!
//! f = 1, the whole steering of the curve, is right only without preview (b = 1). A loop whose
//! setpoint weight hides the slow pole of its integral action answers like a lag already, and what
//! is left of f is small: the whole feedforward would be counted twice.

use crate::closed_loop::simulate::{Excitation, Simulator};
use crate::plants::sampled::Sampled;
use vehicle_models::PidParameters;

/// What a path follower should use.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct Advice {
    /// Steering angle per curvature, rad·m.
    pub(crate) feedforward_gain: f64,
    /// How far ahead the path is read, s.
    pub(crate) preview_time: f64,
}

impl Advice {
    /// By the formula above, for a plant's gain G₀ and speed.
    pub(crate) fn by_theory(pid: &PidParameters, gain: f64, speed: f64) -> Self {
        let lag = pid.kp * (1.0 - pid.setpoint_weight_proportional) / pid.ki;
        let lag = if lag.is_finite() { lag.max(0.0) } else { 0.0 };
        Self::with_preview(pid, gain, speed, lag)
    }

    /// With the feedforward that belongs to a preview.
    pub(crate) fn with_preview(
        pid: &PidParameters,
        gain: f64,
        speed: f64,
        preview_time: f64,
    ) -> Self {
        let weight = pid.setpoint_weight_proportional;
        let previewed = weight * pid.kp * preview_time + 0.5 * pid.ki * preview_time.powi(2);
        let share = 1.0 + gain * (pid.kd - previewed);
        // Steering per yaw rate is 1/G₀, yaw rate per curvature is the speed.
        Self { feedforward_gain: share * speed / gain, preview_time }
    }
}

/// The time by which yaw lags a ramp in the long run, with feedforward of the ramp's rate.
///
/// kp·(1 − b)/ki in theory: the integral action is at rest where ki·e = kp·(1 − b)·ṙ. Measured by
/// simulating a slow ramp, which no limit touches, until the slowest modes have died out.
pub(crate) fn ramp_lag(gain: f64, sampled: &Sampled, pid: &PidParameters) -> f64 {
    let reset_time = if pid.ki > 0.0 { pid.kp / pid.ki } else { 1.0 };
    let until = (20.0 * reset_time).clamp(20.0, 400.0);
    let ramp = 1e-4;
    let excitation =
        Excitation { step: 0.0, ramp, feedforward: ramp / gain, offset: 0.0, until, quiet: 0.0 };
    let mut simulator = Simulator::default();
    let trace = simulator.run(sampled, pid, &excitation);
    let last = trace.yaw.len() - 1;
    (trace.yaw_reference[last] - trace.yaw[last]) / ramp
}
