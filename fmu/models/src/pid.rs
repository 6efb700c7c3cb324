//! The yaw controller of eq 14, `K(s) = Kp + Ki/s + Kd·s`, sampled.
//!
//! One [`Pid::tick`] is one sample. With `e = wrap(r − y)` (reference r, yaw y), sample time `Ts`
//! and wrapped increments `Δr`, `Δy` since the tick before:
//!
//! ```text
//! P  = kp·e
//! I += ki·Ts·e − kp·(1−b)·Δr                    backward Euler; at tick 0: I = ki·Ts·e − kp·(1−b)·e
//! D  = (Tf·D + kd·(c·Δr − Δy)) / (Tf + Ts)      backward Euler of kd·s/(Tf·s + 1)
//! v  = P + I + D + feedforward
//! u  = v limited to u_before ± min(max_increment, max_rate·Ts), then to ± max_angle
//! I += min(Ts/Tt, 1)·(u − v)                    anti-windup by back-calculation, where ki > 0
//! ```
//!
//! - **Setpoint weights** b and c. `kp·(b·r − y)` would depend on the absolute yaw, hence on where
//!   north is. Written by increments inside the integral term it does not: at constant gains
//!   `P + I` above equals the textbook's `kp·(b·r − y) + I`, with angles counted from the yaw at
//!   tick 0. A reference that winds around several turns is followed turn by turn.
//! - **Filter** with `Tf = 0`: D is the plain backward difference.
//! - **Limits**: the angle wins over the increment, so a `max_angle` lowered below the present
//!   angle is obeyed at once. `u_before` is 0 before tick 0.
//! - **Anti-windup** needs an integral action that forgets: with `ki = 0` the back-calculation
//!   would leave a lasting bias in I, so it is left out. `Tt = 0` resets I at once.
//! - **Disabled**, the output is the limited feedforward; the memory of r, y and D goes on.
//! - **Enabling** with `ki > 0` chooses I such that the output continues from the one before;
//!   with `ki = 0` that bias would never go away, so the controller starts as at tick 0 and the
//!   increment limit alone softens it.
//! - **Gain changes** while running with `ki > 0` move the change of P (kp) and of the tick's new
//!   part of D (kd, c) into I. ki, b and Tt act on increments and are bumpless as they are.

use crate::angle::wrap_angle;
use crate::error::{Error, diverged, finite};
use serde::{Deserialize, Serialize};
use std::f64::consts::PI;

/// Gains, weights and limits; read anew at each tick, so they may be tuned while running.
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
    /// Time between ticks Ts, s.
    pub sample_time: f64,
}

impl Default for PidParameters {
    /// A proportional controller at 100 Hz with the paper's limits, 22° and 15° a sample.
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
}

/// What the controller sees at a tick.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct PidInput {
    /// Reference r, rad; may be wrapped or not.
    pub yaw_reference: f64,
    /// Yaw y, rad; may be wrapped or not.
    pub yaw: f64,
    /// Steering angle added to the controller's, rad.
    pub steering_feedforward: f64,
    /// Whether the controller acts.
    pub enabled: bool,
}

/// What the controller answers, held until the next tick.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct PidOutput {
    /// Steering angle u, rad.
    pub steering_angle: f64,
    /// Whether a limit acted at this tick.
    pub saturated: bool,
}

/// What ticks before left behind; [`Pid::default`] is the controller before tick 0.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct Pid {
    integral: f64,
    derivative: f64,
    steering_angle: f64,
    before: Option<Before>,
}

/// Inputs and gains of the tick before.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
struct Before {
    yaw_reference: f64,
    yaw: f64,
    enabled: bool,
    kp: f64,
    kd: f64,
    setpoint_weight_derivative: f64,
}

impl Pid {
    /// One sample: advances the memory and returns the steering angle to hold until the next.
    #[inline(always)]
    pub fn tick(&mut self, p: &PidParameters, input: &PidInput) -> PidOutput {
        let error = wrap_angle(input.yaw_reference - input.yaw);
        let proportional = p.kp * error;
        let unweighted = p.kp * (1.0 - p.setpoint_weight_proportional);
        let from_rest = -unweighted * error;

        let filter = 1.0 / (p.derivative_filter_time + p.sample_time);
        let (reference_increment, yaw_increment) = match &self.before {
            Some(b) => {
                (wrap_angle(input.yaw_reference - b.yaw_reference), wrap_angle(input.yaw - b.yaw))
            }
            None => (0.0, 0.0),
        };
        let pulse = |kd: f64, c: f64| kd * (c * reference_increment - yaw_increment) * filter;
        let new_pulse = pulse(p.kd, p.setpoint_weight_derivative);
        self.derivative = p.derivative_filter_time * filter * self.derivative + new_pulse;

        let without_integral = proportional + self.derivative + input.steering_feedforward;
        let unlimited = if input.enabled {
            match &self.before {
                Some(b) if b.enabled => {
                    self.integral +=
                        p.ki * p.sample_time * error - unweighted * reference_increment;
                    let same = b.kp == p.kp
                        && b.kd == p.kd
                        && b.setpoint_weight_derivative == p.setpoint_weight_derivative;
                    if p.ki > 0.0 && !same {
                        self.integral += (b.kp - p.kp) * error
                            + (pulse(b.kd, b.setpoint_weight_derivative) - new_pulse);
                    }
                    without_integral + self.integral
                }
                Some(_) if p.ki > 0.0 => {
                    self.integral = self.steering_angle - without_integral;
                    self.steering_angle
                }
                _ => {
                    self.integral = p.ki * p.sample_time * error + from_rest;
                    without_integral + self.integral
                }
            }
        } else {
            self.integral = 0.0;
            input.steering_feedforward
        };

        let output = self.limit(p, unlimited);
        if input.enabled && p.ki > 0.0 {
            let share = (p.sample_time / p.anti_windup_time).min(1.0);
            self.integral += share * (output.steering_angle - unlimited);
        }
        self.before = Some(Before {
            yaw_reference: input.yaw_reference,
            yaw: input.yaw,
            enabled: input.enabled,
            kp: p.kp,
            kd: p.kd,
            setpoint_weight_derivative: p.setpoint_weight_derivative,
        });
        output
    }

    /// A first tick whose yaw or reference nobody has set yet: the output is the limited
    /// feedforward, and the next tick still counts as the first one of the controller, so that
    /// neither a proportional nor a derivative kick comes from a value that was never real.
    pub fn prime(&mut self, p: &PidParameters, input: &PidInput) -> PidOutput {
        self.before = None;
        self.integral = 0.0;
        self.derivative = 0.0;
        self.limit(p, input.steering_feedforward)
    }

    /// Refuses a memory that is not finite, which inputs or gains near the largest numbers leave.
    ///
    /// # Errors
    /// Names the value.
    pub fn check(&self) -> Result<(), Error> {
        diverged([
            ("the integral action", self.integral),
            ("the derivative action", self.derivative),
            ("the steering angle", self.steering_angle),
        ])?;
        let Some(b) = &self.before else { return Ok(()) };
        finite(
            "an input or gain of the tick before",
            &[b.yaw_reference, b.yaw, b.kp, b.kd, b.setpoint_weight_derivative],
        )
    }

    /// Limits the steering angle and remembers it.
    #[inline(always)]
    fn limit(&mut self, p: &PidParameters, unlimited: f64) -> PidOutput {
        let increment = p.largest_increment();
        let (low, high) = (self.steering_angle - increment, self.steering_angle + increment);
        // Asked first, so that a loop does not wait for four limits at each tick that none acts at.
        let free = low < unlimited && unlimited < high && unlimited.abs() < p.max_angle;
        let steering_angle = if free {
            unlimited
        } else {
            // Not `clamp`, which panics on limits out of order.
            unlimited.min(high).max(low).min(p.max_angle).max(-p.max_angle)
        };
        self.steering_angle = steering_angle;
        PidOutput { steering_angle, saturated: steering_angle != unlimited }
    }
}
