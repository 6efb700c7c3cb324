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
//! Where the curvature of a road begins to change, terms in s³ and beyond count, too: the reference may
//! contain `G·s² + J·s³` of the heading in addition to it. With f lower by G₀·ki·G the terms in s and s²
//! still vanish; G and J are those of [`on_roads`](Advice::on_roads).

use crate::closed_loop::margins::{controller, from_reference};
use crate::closed_loop::simulate::{Excitation, Simulator};
use crate::plants::sampled::Sampled;
use nalgebra::{Complex, Matrix2, Vector2};
use std::f64::consts::PI;
use steerwright_models::PidParameters;

/// ω₀ and the highest frequency of the grid, rad/s, and its points.
const LOOKAHEAD_FREQUENCY: f64 = 1.0;
const HIGHEST: f64 = 20.0;
const POINTS: i32 = 400;
/// The largest G, s², and J, s³: beyond them the reference would depend on differences of headings 0.2 s apart.
const LARGEST: f64 = 0.02;
const LARGEST_JERK: f64 = 0.004;

/// Preview and feedforward of a path follower.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct Advice {
    /// Steering angle per curvature, rad·m.
    pub(crate) feedforward_gain: f64,
    /// How far ahead the path is read, s.
    pub(crate) preview_time: f64,
    /// Gain from the path's yaw acceleration to the yaw reference, s².
    pub(crate) yaw_acceleration_gain: f64,
    /// Gain from its yaw jerk, s³.
    pub(crate) yaw_jerk_gain: f64,
}

impl Advice {
    /// By the formula above, for a plant's gain G₀ and speed.
    pub(crate) fn by_theory(pid: &PidParameters, gain: f64, speed: f64) -> Self {
        let lag = pid.gains.kp * (1.0 - pid.gains.setpoint_weight_proportional) / pid.gains.ki;
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
        let weight = pid.gains.setpoint_weight_proportional;
        let previewed =
            weight * pid.gains.kp * preview_time + 0.5 * pid.gains.ki * preview_time.powi(2);
        let share = 1.0 + gain * (pid.gains.kd - previewed);
        // Steering per yaw rate is 1/G₀, yaw rate per curvature is the speed.
        let feedforward_gain = share * speed / gain;
        Self { feedforward_gain, preview_time, ..Self::default() }
    }

    /// With the G, its feedforward, and the J of the least cross-track error on roads.
    ///
    /// Yaw misses the path's heading by `E₀ + G·E₁ + J·E₂`,
    ///
    /// ```text
    /// E₀ = e^{jωp}·P·(R + jω·f/G₀)/(1 + PC) − 1      E₁ = −e^{jωp}·P·(ω²·R + jω·ki)/(1 + PC)
    /// E₂ = −jω³·e^{jωp}·P·R/(1 + PC)
    /// ```
    ///
    /// with the sampled plant P, the controller R from the reference and C from the yaw. This error becomes
    /// cross-track error through `v/(s + ω₀)`, 1/ω₀ the look-ahead time, and the heading is white noise
    /// thrice through a lag of that time, a road of clothoids. G and J are real: linear least squares.
    pub(crate) fn on_roads(self, pid: &PidParameters, plant: &Sampled, speed: f64) -> Self {
        let ts = plant.sample_time;
        let (mut square, mut product) = (Matrix2::zeros(), Vector2::zeros());
        let highest = HIGHEST.min(PI / ts);
        for k in 1..=POINTS {
            let frequency = highest * f64::from(k) / f64::from(POINTS);
            let j_omega = Complex::new(0.0, frequency);
            let z = Complex::from_polar(1.0, frequency * ts);
            let response = plant.response(z);
            let closed = Complex::from_polar(1.0, frequency * self.preview_time) * response
                / (response * controller(pid, z) + 1.0);
            let reference = from_reference(pid, z);
            let zeroth = closed * (reference + j_omega * (self.feedforward_gain / speed)) - 1.0;
            let first = closed * (j_omega * j_omega * reference - j_omega * pid.gains.ki);
            let second = closed * j_omega.powi(3) * reference;
            let weight = (frequency.powi(2) + LOOKAHEAD_FREQUENCY.powi(2)).powi(-4);
            // The real part of a product is the scalar product of two complex numbers as vectors.
            let [first, second, zeroth] = [first, second, zeroth].map(|e| Vector2::new(e.re, e.im));
            let both = Matrix2::from_columns(&[first, second]);
            square += both.transpose() * both * weight;
            product += both.transpose() * zeroth * weight;
        }
        let Some(inverse) = square.try_inverse() else { return self };
        let found = -(inverse * product);
        if !found.iter().all(|gain| gain.is_finite()) {
            return self;
        }
        // With one at its bound, the other that belongs to it.
        let jerk = found.y.clamp(-LARGEST_JERK, LARGEST_JERK);
        let gain = -(product.x + square.m12 * jerk) / square.m11;
        let gain = gain.clamp(-LARGEST, LARGEST);
        let jerk = -(product.y + square.m12 * gain) / square.m22;
        let jerk = jerk.clamp(-LARGEST_JERK, LARGEST_JERK);
        Self {
            feedforward_gain: self.feedforward_gain - gain * pid.gains.ki * speed,
            yaw_acceleration_gain: gain,
            yaw_jerk_gain: jerk,
            ..self
        }
    }
}

/// The time by which yaw lags a ramp in the long run, with feedforward of the ramp's rate.
///
/// kp·(1 − b)/ki in theory; measured on a slow ramp, which no limit touches, until the modes have died out.
pub(crate) fn ramp_lag(gain: f64, sampled: &Sampled, pid: &PidParameters) -> f64 {
    let reset_time = if pid.gains.ki > 0.0 { pid.gains.kp / pid.gains.ki } else { 1.0 };
    let until = (20.0 * reset_time).clamp(20.0, 400.0);
    let ramp = 1e-4;
    let excitation =
        Excitation { step: 0.0, ramp, feedforward: ramp / gain, offset: 0.0, until, quiet: 0.0 };
    let mut simulator = Simulator::default();
    let trace = simulator.run(sampled, pid, &excitation);
    let last = trace.yaw.len() - 1;
    (trace.yaw_reference[last] - trace.yaw[last]) / ramp
}
