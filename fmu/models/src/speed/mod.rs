//! The controller of the speed: a reference model with limited jerk, feedforward by the inverse of the longitudinal model,
//! a PI controller of the remaining error, the choice of the pedal, and standstill.
//!
//! The README of `fmu/speed-controller` has the equations of a tick. Beyond them:
//!
//! - **The error** is that to the speed which the model predicts for the accelerations demanded so far, with the lag and
//!   the delay of the pedal that acts: the PI controller does not act on what the vehicle cannot do yet.
//! - **Large errors**: beyond 1 m/s the reference model waits for the vehicle, so nothing winds up while the
//!   vehicle cannot follow.
//! - **Anti-windup**: the integral stays where acceleration or pedal are at their limit and the error drives beyond it.
//! - **Release**: from standstill uphill the brake is released as the drive takes over, by the drive that the model predicts.
//! - **Disabled**, the outputs are 0, and the controller starts from the present speed when it is enabled.

// `clamp` returns NaN, which the difference of two numbers near the largest can be; `min` and `max` return a bound.
#![allow(clippy::manual_clamp)]

mod saved;
mod standstill;

pub use saved::SavedSpeedControl;

use crate::Error;
use crate::delay::DelayLine;
use crate::error::{diverged, numbers};
use crate::files::longitudinal_parameters;
use crate::longitudinal::{LongitudinalParameters, follow};
use serde::{Deserialize, Serialize};
use std::sync::Arc;
use steerwright_formats::{Longitudinal, SpeedController, SpeedGains, SpeedLimits};

/// Error of the speed beyond which the reference model waits for the vehicle, m/s.
const LARGEST_ERROR: f64 = 1.0;

/// Share of the jerk that the reference model uses; the rest is for the PI controller.
const REFERENCE_JERK: f64 = 0.8;

/// Gain of the drive below which the accelerator has no effect, m/s² per unit.
const LEAST_GAIN: f64 = 1e-3;

/// Parameters of the controller, which can be changed while it runs.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct SpeedControlParameters {
    /// Gains.
    pub gains: SpeedGains,
    /// Limits and thresholds.
    pub limits: SpeedLimits,
    /// Time between ticks, s.
    pub sample_time: f64,
}

/// Inputs at a tick.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct SpeedControlInputs {
    /// Speed to reach, m/s.
    pub speed_reference: f64,
    /// Derivative of the speed reference, m/s²; 0 where it is unknown.
    pub acceleration_reference: f64,
    /// Speed, m/s.
    pub speed: f64,
    /// Grade of the road, rad, positive uphill; 0 where it is unknown.
    pub grade: f64,
    /// Number of the gear; one without a gain of its own has the mean gain.
    pub gear: i32,
    /// Whether the controller acts.
    pub enabled: bool,
}

/// Outputs, held until the next tick.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct SpeedControlOutputs {
    /// From 0 to 1; 0 where the model has an acceleration command.
    pub accelerator: f64,
    /// From 0 to 1; 0 where the model has no brake.
    pub brake: f64,
    /// m/s²; 0 where the model has an accelerator.
    pub acceleration_command: f64,
    /// Whether acceleration or pedal were at a limit.
    pub saturated: bool,
    /// Whether the vehicle is held at standstill.
    pub holding: bool,
}

/// What the controller does.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
enum Mode {
    /// Nothing: it is disabled, or before its first tick.
    #[default]
    Off,
    /// Uses the accelerator.
    Drive,
    /// Uses the brake.
    Brake,
    /// Holds the vehicle at standstill.
    Hold,
    /// Releases the brake while the drive builds up.
    Release,
}

/// What changes from tick to tick, without the histories of the delays.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
struct Memory {
    mode: Mode,
    /// Speed of the reference model, m/s, and its acceleration, m/s².
    reference: [f64; 2],
    /// Predicted speed, m/s, and acceleration, m/s², by the lag and delay of the drive.
    by_drive: [f64; 2],
    /// The same by those of the brake.
    by_brake: [f64; 2],
    /// Integral action, m/s².
    integral: f64,
    /// Acceleration demanded, m/s².
    demand: f64,
    /// Acceleration that the held brake causes, m/s², below 0.
    held: f64,
    /// Predicted acceleration of the drive, m/s².
    drive: f64,
}

impl Memory {
    fn numbers(&self) -> [f64; 10] {
        let [v, a] = self.reference;
        let ([vd, ad], [vb, ab]) = (self.by_drive, self.by_brake);
        [v, a, vd, ad, vb, ab, self.integral, self.demand, self.held, self.drive]
    }
}

/// The controller. Its clone is its whole state.
#[derive(Debug, Clone, PartialEq)]
pub struct SpeedControl {
    model: Arc<Longitudinal>,
    inverse: LongitudinalParameters,
    memory: Memory,
    drive_reference: DelayLine,
    brake_reference: DelayLine,
    drive_delay: DelayLine,
}

/// The controller's parameters in `speed_controller.json`.
#[must_use]
pub fn speed_control_parameters(file: &SpeedController) -> SpeedControlParameters {
    SpeedControlParameters {
        gains: file.gains,
        limits: file.limits,
        sample_time: file.sample_time_s,
    }
}

impl SpeedControl {
    /// The controller before its first tick, of the model that it inverts.
    ///
    /// # Errors
    /// Where a lag or delay of the model is out of its bounds.
    pub fn new(model: Arc<Longitudinal>) -> Result<Self, Error> {
        let inverse = longitudinal_parameters(&model);
        inverse.check()?;
        let brake_delay = if model.brake.is_some() { inverse.brake_delay } else { inverse.delay };
        Ok(Self {
            inverse,
            memory: Memory::default(),
            drive_reference: DelayLine::new(inverse.delay, 0.0),
            brake_reference: DelayLine::new(brake_delay, 0.0),
            drive_delay: DelayLine::new(inverse.delay, 0.0),
            model,
        })
    }

    /// The model that is inverted.
    #[must_use]
    pub fn model(&self) -> &Longitudinal {
        &self.model
    }

    /// One sample: advances the memory and returns the outputs to hold until the next.
    ///
    /// # Errors
    /// An input that is no number, or a memory that grows beyond all numbers.
    pub fn tick(
        &mut self,
        p: &SpeedControlParameters,
        input: &SpeedControlInputs,
    ) -> Result<SpeedControlOutputs, Error> {
        numbers(&[
            ("the speed reference", input.speed_reference),
            ("the acceleration reference", input.acceleration_reference),
            ("the speed", input.speed),
            ("the grade", input.grade),
        ])?;
        let input = &SpeedControlInputs {
            speed: input.speed.max(0.0),
            speed_reference: input.speed_reference.max(0.0),
            ..*input
        };
        if !input.enabled {
            self.restart(Mode::Off, 0.0);
            return Ok(SpeedControlOutputs::default());
        }
        if self.memory.mode == Mode::Off {
            self.restart(Mode::Drive, input.speed);
            self.memory.held = self.held_acceleration(p, input);
        }
        let output = match self.standstill(p, input)? {
            Some(output) => output,
            None => self.moving(p, input)?,
        };
        diverged(self.memory.numbers().map(|value| ("the memory of the controller", value)))?;
        Ok(output)
    }

    /// Starts at a speed, without a demand.
    fn restart(&mut self, mode: Mode, speed: f64) {
        self.memory = Memory {
            mode,
            reference: [speed, 0.0],
            by_drive: [speed, 0.0],
            by_brake: [speed, 0.0],
            ..Memory::default()
        };
        for line in [&mut self.drive_reference, &mut self.brake_reference, &mut self.drive_delay] {
            line.reset(0.0);
        }
    }

    /// Follows the reference while the vehicle moves.
    fn moving(
        &mut self,
        p: &SpeedControlParameters,
        input: &SpeedControlInputs,
    ) -> Result<SpeedControlOutputs, Error> {
        self.memory.held = 0.0;
        let slowing = self.inverse.slowing(input.speed, input.grade);
        let [low, high] = self.bounds(p, input, slowing);
        let error = self.error(input.speed);
        self.approach(p, input, [low, high]);
        self.predict(p.sample_time)?;

        let wanted = self.memory.reference[1] + p.gains.kp_per_s * error + self.memory.integral;
        let within = wanted.min(high).max(low);
        let is_bound = (wanted > high && error > 0.0) || (wanted < low && error < 0.0);
        if !is_bound {
            self.memory.integral += p.gains.ki_per_s2 * p.sample_time * error;
        }
        let increment = p.limits.max_jerk_mps3 * p.sample_time;
        let before = self.memory.demand;
        let demand = within.min(before + increment).max(before - increment);
        self.memory.demand = demand;
        // Before the jerk limit, which acts in each start.
        let mut output = self.pedals(p, input, demand + slowing)?;
        output.saturated |= within != wanted;
        Ok(output)
    }

    /// Lowest and highest acceleration: those of the limits, as far as the pedals reach.
    fn bounds(
        &self,
        p: &SpeedControlParameters,
        input: &SpeedControlInputs,
        slowing: f64,
    ) -> [f64; 2] {
        let (low, high) = (-p.limits.max_deceleration_mps2, p.limits.max_acceleration_mps2);
        if self.model.is_acceleration_commanded() {
            return [low, high];
        }
        let largest = self.gain(input) - slowing;
        let lowest = -self.inverse.brake_gain - slowing;
        let high = high.min(largest);
        [low.max(lowest).min(high), high]
    }

    fn gain(&self, input: &SpeedControlInputs) -> f64 {
        self.model.gain_in(input.gear, input.speed).max(0.0)
    }

    /// The error of the speed; where it is large, the reference model waits.
    fn error(&mut self, speed: f64) -> f64 {
        let m = &mut self.memory;
        let predicted = if m.mode == Mode::Brake { m.by_brake[0] } else { m.by_drive[0] };
        let whole = predicted - speed;
        let error = whole.min(LARGEST_ERROR).max(-LARGEST_ERROR);
        let ahead = whole - error;
        m.reference[0] -= ahead;
        m.by_drive[0] -= ahead;
        m.by_brake[0] -= ahead;
        error
    }

    /// The reference model: its acceleration is that which a steady approach to the reference requires, within the
    /// limits of acceleration and jerk.
    fn approach(
        &mut self,
        p: &SpeedControlParameters,
        input: &SpeedControlInputs,
        [low, high]: [f64; 2],
    ) {
        let [speed, acceleration] = self.memory.reference;
        let jerk = REFERENCE_JERK * p.limits.max_jerk_mps3;
        let rate = p.gains.reference_rate_per_s;
        let off = input.speed_reference - speed;
        // Within this distance the approach is exponential; farther away its jerk is the largest.
        let near = jerk / (rate * rate);
        let approach = if off.abs() <= near {
            rate * off
        } else {
            (2.0 * jerk * (off.abs() - 0.5 * near)).sqrt().copysign(off)
        };
        let wanted = (input.acceleration_reference + approach).min(high).max(low);
        let increment = jerk * p.sample_time;
        let next = wanted.min(acceleration + increment).max(acceleration - increment);
        self.memory.reference = [speed + next * p.sample_time, next];
    }

    /// The speed that the accelerations demanded so far cause until the next tick.
    fn predict(&mut self, sample_time: f64) -> Result<(), Error> {
        let acceleration = self.memory.reference[1];
        let p = &self.inverse;
        let brake_lag =
            if self.model.brake.is_some() { p.brake_time_constant } else { p.time_constant };
        let m = &mut self.memory;
        for (line, predicted, lag) in [
            (&mut self.drive_reference, &mut m.by_drive, p.time_constant),
            (&mut self.brake_reference, &mut m.by_brake, brake_lag),
        ] {
            line.push(sample_time, acceleration, 0.0)?;
            let [change, _] = follow(line, &mut predicted[1], 1.0, lag, sample_time);
            predicted[0] += change;
        }
        Ok(())
    }

    /// The pedals, or the command, that cause an acceleration of the vehicle on a level road without resistances, m/s².
    fn pedals(
        &mut self,
        p: &SpeedControlParameters,
        input: &SpeedControlInputs,
        force: f64,
    ) -> Result<SpeedControlOutputs, Error> {
        let gain = self.gain(input);
        let mut output = SpeedControlOutputs::default();
        if self.model.is_acceleration_commanded() {
            if gain > LEAST_GAIN {
                output.acceleration_command = force / gain;
            }
            return Ok(output);
        }
        let (brake_gain, hysteresis) = (self.inverse.brake_gain, p.limits.pedal_hysteresis_mps2);
        if self.memory.mode == Mode::Drive && force < -hysteresis && brake_gain > LEAST_GAIN {
            self.memory.mode = Mode::Brake;
        } else if self.memory.mode == Mode::Brake && force > hysteresis {
            self.memory.mode = Mode::Drive;
        }
        if self.memory.mode == Mode::Brake {
            output.brake = (-force / brake_gain).max(0.0).min(1.0);
            output.saturated = -force > brake_gain;
        } else if gain > LEAST_GAIN {
            output.accelerator = self.inverse.accelerator(force / gain);
            output.saturated = force > gain;
        }
        self.drive(p.sample_time, gain * self.inverse.share_of_gain(output.accelerator))?;
        Ok(output)
    }

    /// Predicts the acceleration of the drive at the next tick, of a target in m/s².
    fn drive(&mut self, sample_time: f64, target: f64) -> Result<(), Error> {
        self.drive_delay.push(sample_time, target, 0.0)?;
        let lag = self.inverse.time_constant;
        follow(&mut self.drive_delay, &mut self.memory.drive, 1.0, lag, sample_time);
        Ok(())
    }
}
