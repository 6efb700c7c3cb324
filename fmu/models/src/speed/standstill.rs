//! Standstill: the vehicle is held by the brake, and starts without rolling back.

use super::{
    LEAST_GAIN, Mode, SpeedControl, SpeedControlInputs, SpeedControlOutputs, SpeedControlParameters,
};
use crate::Error;

/// Share of the speed of the hold below which the reference counts as 0.
const REST: f64 = 0.5;

/// Acceleration beyond that of the grade which the drive aims at while the brake is released, m/s².
const RELEASE: f64 = 0.3;

impl SpeedControl {
    /// The outputs at standstill; `None` where the vehicle moves.
    pub(super) fn standstill(
        &mut self,
        p: &SpeedControlParameters,
        input: &SpeedControlInputs,
    ) -> Result<Option<SpeedControlOutputs>, Error> {
        let threshold = p.limits.hold_speed_mps;
        let can_hold =
            self.model.is_acceleration_commanded() || self.inverse.brake_gain > LEAST_GAIN;
        let is_slow = input.speed < threshold;
        let rests = input.speed_reference < REST * threshold && input.acceleration_reference <= 0.0;
        match self.memory.mode {
            Mode::Drive | Mode::Brake if is_slow && rests && can_hold => {
                let from = self.memory.demand.min(self.memory.held);
                self.restart(Mode::Hold, 0.0);
                self.memory.held = from;
            }
            Mode::Hold | Mode::Release if !is_slow => {
                // It was pushed, or moves: the controller takes over.
                self.restart(Mode::Drive, input.speed);
            }
            Mode::Hold if input.speed_reference >= threshold => {
                self.restart(Mode::Release, 0.0);
            }
            Mode::Release if rests => {
                self.restart(Mode::Hold, 0.0);
                self.memory.held = self.held_acceleration(p, input);
            }
            _ => {}
        }
        match self.memory.mode {
            Mode::Hold => self.hold(p, input).map(Some),
            Mode::Release => self.release(p, input),
            _ => Ok(None),
        }
    }

    /// Acceleration that the held brake causes, m/s².
    pub(super) fn held_acceleration(
        &self,
        p: &SpeedControlParameters,
        input: &SpeedControlInputs,
    ) -> f64 {
        if input.speed < p.limits.hold_speed_mps {
            -p.limits.hold_deceleration_mps2 - self.inverse.gravity(input.grade).abs()
        } else {
            0.0
        }
    }

    fn hold(
        &mut self,
        p: &SpeedControlParameters,
        input: &SpeedControlInputs,
    ) -> Result<SpeedControlOutputs, Error> {
        let wanted = self.held_acceleration(p, input);
        let increment = p.limits.max_jerk_mps3 * p.sample_time;
        let held = wanted.max(self.memory.held - increment).min(self.memory.held + increment);
        self.memory.held = held;
        let mut output = SpeedControlOutputs { holding: true, ..SpeedControlOutputs::default() };
        self.brake_by(input, held, &mut output);
        self.drive(p.sample_time, 0.0)?;
        Ok(output)
    }

    /// An acceleration below 0 by brake or command.
    fn brake_by(
        &self,
        input: &SpeedControlInputs,
        acceleration: f64,
        output: &mut SpeedControlOutputs,
    ) {
        let (brake_gain, gain) = (self.inverse.brake_gain, self.gain(input));
        if self.model.is_acceleration_commanded() {
            if gain > LEAST_GAIN {
                output.acceleration_command = acceleration.min(0.0) / gain;
            }
        } else if brake_gain > LEAST_GAIN {
            output.brake = (-acceleration / brake_gain).max(0.0).min(1.0);
        }
    }

    /// The brake carries what the drive does not carry yet; `None` as soon as the drive carries the grade.
    fn release(
        &mut self,
        p: &SpeedControlParameters,
        input: &SpeedControlInputs,
    ) -> Result<Option<SpeedControlOutputs>, Error> {
        let load = self.inverse.gravity(input.grade).max(0.0);
        let is_carried = self.memory.drive >= load;
        if self.model.is_acceleration_commanded() || is_carried {
            // The drive goes on from where it is.
            self.memory.mode = Mode::Drive;
            return Ok(None);
        }
        let gain = self.gain(input);
        let force = self.inverse.slowing(0.0, input.grade) + RELEASE;
        let mut output = SpeedControlOutputs { holding: true, ..SpeedControlOutputs::default() };
        output.accelerator =
            if gain > LEAST_GAIN { self.inverse.accelerator(force / gain) } else { 0.0 };
        self.brake_by(input, self.memory.drive - load, &mut output);
        self.drive(p.sample_time, gain * self.inverse.share_of_gain(output.accelerator))?;
        Ok(Some(output))
    }
}
