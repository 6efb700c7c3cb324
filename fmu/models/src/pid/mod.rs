//! The yaw controller of eq 14, `K(s) = Kp + Ki/s + Kd·s`, sampled: one [`Pid::tick`] is one sample.
//!
//! The README of `fmu/lateral-pid` has the equations of a tick. Beyond them:
//!
//! - **Setpoint weights** act by increments inside the integral term: `kp·(b·r − y)` would depend on the
//!   absolute yaw, hence on where north is. At tick 0, `I = ki·Ts·e − kp·(1−b)·e`.
//! - **Large errors** beyond `max_yaw_error` are withheld: see `governor`. The reference moves with the
//!   actual yaw, so nothing winds up while a vehicle cannot follow.
//! - **Filter** with `Tf = 0`: D is the plain backward difference.
//! - **Limits**: the angle wins over the increment, so a `max_angle` lowered below the present
//!   angle is obeyed at once. The angle before tick 0 is 0.
//! - **Anti-windup** needs an integral action that forgets: with `ki = 0` the back-calculation
//!   would leave a lasting bias in I, so it is left out. `Tt = 0` resets I at once.
//! - **Standstill**: where the limits follow the speed v, the integral action is ki·min(v/(1 m/s), 1): a vehicle that
//!   stands does not turn, and an integral that went on would turn its wheels to their end.
//! - **Disabled**, the output is the limited feedforward; the memory of r, y and D goes on.
//! - **Enabling** with `ki > 0` chooses I such that the output continues from the one before;
//!   with `ki = 0` that bias would never go away, so the controller starts as at tick 0 and the
//!   increment limit alone softens it.
//! - **Gain changes** while running with `ki > 0` move the change of P (kp) and of the tick's new
//!   part of D (kd, c) into I. ki, b and Tt act on increments and are bumpless as they are.

mod actuator;
mod governor;
mod parameters;

pub use governor::time_at_largest_rate;
pub use parameters::PidParameters;

use crate::Error;
use crate::angle::wrap_angle;
use crate::error::{diverged, finite};
use governor::Governor;
use serde::{Deserialize, Serialize};

/// Inputs of the controller at a tick.
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
    /// Speed that the limits follow, m/s.
    pub speed: f64,
}

/// Outputs of the controller, held until the next tick.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct PidOutput {
    /// Steering angle u, rad.
    pub steering_angle: f64,
    /// Whether a limit acted at this tick.
    pub saturated: bool,
}

/// The state of the controller; [`Pid::default`] is the controller before tick 0.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct Pid {
    integral: f64,
    derivative: f64,
    steering_angle: f64,
    governor: Governor,
    before: Option<Before>,
}

/// Inputs and gains of the tick before.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
struct Before {
    yaw_reference: f64,
    yaw: f64,
    /// Yaw error that was not acted on, rad.
    withheld: f64,
    enabled: bool,
    kp: f64,
    kd: f64,
    setpoint_weight_derivative: f64,
}

impl Pid {
    /// One sample: advances the memory and returns the steering angle to hold until the next.
    #[inline(always)]
    pub fn tick(&mut self, p: &PidParameters, input: &PidInput) -> PidOutput {
        let whole = wrap_angle(input.yaw_reference - input.yaw);
        let moved = self.before.as_ref().map(|b| wrap_angle(input.yaw_reference - b.yaw_reference));
        let turned = self.before.as_ref().map_or(0.0, |b| wrap_angle(input.yaw - b.yaw));
        let error = if input.enabled {
            if self.before.is_some() {
                self.governor.turned(p, input.speed, self.steering_angle, turned);
            }
            self.governor.acted_on(p, input.speed, whole, moved)
        } else {
            self.governor = Governor::resting_at(self.steering_angle);
            whole
        };
        let withheld = self.governor.withheld;
        let proportional = p.gains.kp * error;
        let unweighted = p.gains.kp * (1.0 - p.gains.setpoint_weight_proportional);
        let from_rest = -unweighted * error;

        let filter = 1.0 / (p.gains.derivative_filter_time_s + p.sample_time);
        // Of the reference that the loop sees.
        let reference_increment = match &self.before {
            Some(b) if withheld == 0.0 && b.withheld == 0.0 => moved.unwrap_or(0.0),
            Some(b) => wrap_angle(moved.unwrap_or(0.0) - (withheld - b.withheld)),
            None => 0.0,
        };
        let pulse = |kd: f64, c: f64| kd * (c * reference_increment - turned) * filter;
        let new_pulse = pulse(p.gains.kd, p.gains.setpoint_weight_derivative);
        self.derivative = p.gains.derivative_filter_time_s * filter * self.derivative + new_pulse;

        let without_integral = proportional + self.derivative + input.steering_feedforward;
        let integrated = p.gains.ki * p.sample_time * error * p.integral_share(input.speed);
        let unlimited = if input.enabled {
            match &self.before {
                Some(b) if b.enabled => {
                    self.integral += integrated - unweighted * reference_increment;
                    let same = b.kp == p.gains.kp
                        && b.kd == p.gains.kd
                        && b.setpoint_weight_derivative == p.gains.setpoint_weight_derivative;
                    if p.gains.ki > 0.0 && !same {
                        self.integral += (b.kp - p.gains.kp) * error
                            + (pulse(b.kd, b.setpoint_weight_derivative) - new_pulse);
                    }
                    without_integral + self.integral
                }
                Some(_) if p.gains.ki > 0.0 => {
                    self.integral = self.steering_angle - without_integral;
                    self.steering_angle
                }
                _ => {
                    self.integral = integrated + from_rest;
                    without_integral + self.integral
                }
            }
        } else {
            self.integral = 0.0;
            input.steering_feedforward
        };

        let output = self.limit(p, unlimited, input.speed);
        if input.enabled && p.gains.ki > 0.0 {
            let share = (p.sample_time / self.governor.anti_windup_time(p)).min(1.0);
            self.integral += share * (output.steering_angle - unlimited);
        }
        self.before = Some(Before {
            yaw_reference: input.yaw_reference,
            yaw: input.yaw,
            withheld,
            enabled: input.enabled,
            kp: p.gains.kp,
            kd: p.gains.kd,
            setpoint_weight_derivative: p.gains.setpoint_weight_derivative,
        });
        output
    }

    /// A first tick before both yaw and reference are set: the output is the limited
    /// feedforward, and the next tick still counts as the first one of the controller, so that
    /// neither a proportional nor a derivative kick comes from a value that was never real.
    pub fn prime(&mut self, p: &PidParameters, input: &PidInput) -> PidOutput {
        self.before = None;
        self.integral = 0.0;
        self.derivative = 0.0;
        self.governor = Governor::default();
        self.limit(p, input.steering_feedforward, input.speed)
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
        diverged(self.governor.memory())?;
        diverged(self.governor.actuator().memory())?;
        let Some(b) = &self.before else { return Ok(()) };
        finite(
            "an input or gain of the tick before",
            &[b.yaw_reference, b.yaw, b.withheld, b.kp, b.kd, b.setpoint_weight_derivative],
        )
    }

    /// Limits the steering angle and remembers it.
    #[inline(always)]
    fn limit(&mut self, p: &PidParameters, unlimited: f64, speed: f64) -> PidOutput {
        let (increment, largest) = (self.governor.largest_increment(p), p.largest_angle(speed));
        let before = self.steering_angle;
        let (low, high) = (before - increment, before + increment);
        // Asked first, so that a loop does not wait for four limits at each tick that none acts at.
        let free = low < unlimited && unlimited < high && unlimited.abs() < largest;
        let steering_angle = if free {
            unlimited
        } else {
            // Not `clamp`, which panics on limits out of order.
            unlimited.min(high).max(low).min(largest).max(-largest)
        };
        self.governor.steered(p, steering_angle - before, increment);
        self.steering_angle = steering_angle;
        PidOutput { steering_angle, saturated: steering_angle != unlimited }
    }
}
