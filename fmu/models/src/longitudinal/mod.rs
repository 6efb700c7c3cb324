//! The response of the speed: accelerator and brake, or an acceleration command, and the grade in; speed out.
//!
//! The equations are in the README of `fmu/longitudinal-plant`. The model is stepped as it was identified
//! (`docs/methods/longitudinal.md`): on its own grid `t0 + k·Ts`, Ts that of the document, gain and resistances are
//! those of the speed at the last grid point, and the speed is restricted to `v ≥ 0`. Between grid points lags and
//! delays of held inputs have a closed form, hence no result depends on the communication step.

use crate::Error;
use crate::delay::DelayLine;
use crate::error::diverged;
use crate::identified_plant::LONGEST_STEP;
use crate::ticks::Ticks;
use serde::{Deserialize, Serialize};
use std::sync::Arc;
use steerwright_formats::Longitudinal;

mod parameters;
mod saved;

pub use parameters::LongitudinalParameters;
pub use saved::SavedLongitudinalPlant;

/// Most grid points in a step: about a second of computing.
const MOST_GRID_POINTS: f64 = 1e7;

/// The inputs, held within a step.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct LongitudinalInputs {
    /// u of a model of the accelerator, from 0 to 1.
    pub accelerator: f64,
    /// u of a model of an acceleration command, m/s².
    pub acceleration_command: f64,
    /// w, from 0 to 1.
    pub brake: f64,
    /// Grade of the road, rad, positive uphill.
    pub grade: f64,
    /// Number of the gear; one without a gain of its own has the mean gain.
    pub gear: i32,
}

/// What moves.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
struct State {
    /// v, m/s; below 0 only between two grid points, where the vehicle stands.
    speed: f64,
    /// The speed at the last grid point, m/s, of which gain and resistances are.
    speed_of_grid: f64,
    /// Travelled distance, m.
    distance: f64,
    /// p, m/s².
    drive: f64,
    /// b, m/s².
    brake: f64,
}

impl State {
    fn numbers(&self) -> [f64; 5] {
        [self.speed, self.speed_of_grid, self.distance, self.drive, self.brake]
    }
}

/// The speed of a vehicle. Its clone is its whole state.
#[derive(Debug, Clone, PartialEq)]
pub struct LongitudinalPlant {
    document: Arc<Longitudinal>,
    /// Read at the start.
    pub parameters: LongitudinalParameters,
    /// The inputs.
    pub inputs: LongitudinalInputs,
    /// Speed at the start, m/s.
    pub initial_speed: f64,
    /// Travelled distance at the start, m.
    pub initial_distance: f64,
    started: LongitudinalParameters,
    state: State,
    drive_delay: DelayLine,
    brake_delay: DelayLine,
    grid: Ticks,
}

impl LongitudinalPlant {
    /// A vehicle at the mean speed of its identification, started, with the parameters of the document.
    ///
    /// # Errors
    /// Where a lag or delay is out of its bounds.
    pub fn new(document: Arc<Longitudinal>) -> Result<Self, Error> {
        let parameters = crate::files::longitudinal_parameters(&document);
        let mut plant = Self {
            parameters,
            inputs: LongitudinalInputs::default(),
            initial_speed: document.evidence.speed_mps[1].max(0.0),
            initial_distance: 0.0,
            started: parameters,
            state: State::default(),
            drive_delay: DelayLine::new(0.0, 0.0),
            brake_delay: DelayLine::new(0.0, 0.0),
            grid: Ticks::new(),
            document,
        };
        plant.start()?;
        Ok(plant)
    }

    /// Takes over the parameters and puts the vehicle at its initial speed. The present inputs have been as they are
    /// for ever: lags are in their steady state.
    ///
    /// # Errors
    /// Where a parameter is none of a vehicle.
    pub fn start(&mut self) -> Result<(), Error> {
        self.parameters.check()?;
        self.started = self.parameters;
        let (speed, command, brake) = (self.initial_speed, self.command(), self.inputs.brake);
        self.state = State {
            speed,
            speed_of_grid: speed,
            distance: self.initial_distance,
            drive: self.gain(speed) * command,
            brake: -self.started.brake_gain * brake,
        };
        self.drive_delay = DelayLine::new(self.started.delay, command);
        self.brake_delay = DelayLine::new(self.started.brake_delay, brake);
        self.grid = Ticks::new();
        Ok(())
    }

    /// The document of the model.
    #[must_use]
    pub fn document(&self) -> &Longitudinal {
        &self.document
    }

    /// Whether the command is an acceleration, otherwise an accelerator.
    #[must_use]
    pub fn is_acceleration_commanded(&self) -> bool {
        self.document.is_acceleration_commanded()
    }

    /// Speed, m/s, never below 0.
    #[must_use]
    pub fn speed(&self) -> f64 {
        self.state.speed.max(0.0)
    }

    /// Travelled distance, m.
    #[must_use]
    pub fn distance(&self) -> f64 {
        self.state.distance
    }

    /// Acceleration at the present inputs, m/s²; 0 where the vehicle stands.
    #[must_use]
    pub fn acceleration(&self) -> f64 {
        let acceleration = self.state.drive + self.state.brake - self.slowing();
        if self.state.speed < 0.0 || (self.state.speed == 0.0 && acceleration <= 0.0) {
            return 0.0;
        }
        acceleration
    }

    /// Derivative of the acceleration between grid points, m/s³.
    #[must_use]
    pub fn jerk(&self) -> f64 {
        if self.state.speed <= 0.0 && self.acceleration() == 0.0 {
            return 0.0;
        }
        self.state_rate(2) + self.state_rate(3)
    }

    /// A state: v (m/s), distance (m), p and b (m/s²).
    #[must_use]
    pub fn state(&self, index: usize) -> f64 {
        match index {
            0 => self.speed(),
            1 => self.state.distance,
            2 => self.state.drive,
            _ => self.state.brake,
        }
    }

    /// Its derivative by time, at the present inputs.
    #[must_use]
    pub fn state_rate(&self, index: usize) -> f64 {
        let state = &self.state;
        match index {
            0 => self.acceleration(),
            1 => self.speed(),
            2 => {
                let (command, _) = self.drive_delay.output(self.command(), 0.0);
                let target = self.gain(state.speed_of_grid) * command;
                (target - state.drive) / self.started.time_constant
            }
            _ => {
                let (brake, _) = self.brake_delay.output(self.inputs.brake, 0.0);
                let target = -self.started.brake_gain * brake;
                (target - state.brake) / self.started.brake_time_constant
            }
        }
    }

    /// The derivative of the rate of a state by a state, of the equations at the present speed.
    #[must_use]
    pub fn partial(&self, rate: usize, state: usize) -> f64 {
        let (p, v) = (&self.started, self.speed());
        let stands = v <= 0.0 && self.acceleration() == 0.0;
        match (rate, state) {
            (0, _) if stands => 0.0,
            (0, 0) => -(p.resistance_per_speed + 2.0 * p.drag * v),
            (0, 2 | 3) | (1, 0) => 1.0,
            (2, 0) => {
                // The gain is linear between the speeds of its table.
                let width = 1e-3;
                let slope = (self.gain(v + width) - self.gain(v - width)) / (2.0 * width);
                slope * self.drive_delay.output(self.command(), 0.0).0 / p.time_constant
            }
            (2, 2) => -1.0 / p.time_constant,
            (3, 3) => -1.0 / p.brake_time_constant,
            _ => 0.0,
        }
    }

    /// u, the input that the model has, behind the curve of the pedal.
    fn command(&self) -> f64 {
        if self.is_acceleration_commanded() {
            self.inputs.acceleration_command
        } else {
            self.started.share_of_gain(self.inputs.accelerator)
        }
    }

    /// G at a speed, in the present gear.
    fn gain(&self, speed: f64) -> f64 {
        self.document.gain_in(self.inputs.gear, speed)
    }

    /// Resistances at the last grid point, and gravity on the present grade, m/s².
    fn slowing(&self) -> f64 {
        self.started.slowing(self.state.speed_of_grid, self.inputs.grade)
    }

    /// Advances by `h` seconds with the inputs as they are.
    ///
    /// # Errors
    /// Where h is not in (0, [`LONGEST_STEP`]] or spans more grid points than can be walked, or the states grow beyond
    /// all numbers.
    pub fn step(&mut self, h: f64) -> Result<(), Error> {
        if !(h > 0.0 && h <= LONGEST_STEP) {
            return Err(Error::Step { step: h, limit: LONGEST_STEP });
        }
        let period = self.document.evidence.sample_time_s;
        let points = h / period;
        if points > MOST_GRID_POINTS {
            return Err(Error::TooManyGridPoints { step: h, points, limit: MOST_GRID_POINTS });
        }
        self.drive_delay.push(h, self.command(), 0.0)?;
        self.brake_delay.push(h, self.inputs.brake, 0.0)?;
        let to_first = (1.0 - self.grid.phase()) * period;
        let count = self.grid.advance(points);
        let ends_on_grid = self.grid.phase() == 0.0;
        let mut left = h;
        for k in 1..=count {
            let mut length = (if k == 1 { to_first } else { period }).min(left);
            if k == count && ends_on_grid {
                // All that is left, whatever rounding made of it.
                length = left;
            }
            self.walk(length)?;
            left -= length;
            self.state.speed = self.state.speed.max(0.0);
            self.state.speed_of_grid = self.state.speed;
        }
        if !ends_on_grid && left > 0.0 {
            self.walk(left)?;
        }
        Ok(())
    }

    /// A time without grid points within.
    fn walk(&mut self, length: f64) -> Result<(), Error> {
        let gain = self.gain(self.state.speed_of_grid);
        let slowing = self.slowing();
        let (p, state) = (&self.started, &mut self.state);
        let [drive, drive_moment] =
            follow(&mut self.drive_delay, &mut state.drive, gain, p.time_constant, length);
        let [brake, brake_moment] = follow(
            &mut self.brake_delay,
            &mut state.brake,
            -p.brake_gain,
            p.brake_time_constant,
            length,
        );
        let before = state.speed;
        state.speed += drive + brake - slowing * length;
        if before >= 0.0 && state.speed >= 0.0 {
            state.distance +=
                before * length + drive_moment + brake_moment - 0.5 * slowing * length * length;
        } else {
            // Stops or starts: the part of a straight line between the two speeds that is above 0.
            let highest = before.max(state.speed).max(0.0);
            let rise = (before - state.speed).abs();
            if highest > 0.0 {
                state.distance += 0.5 * highest * length * (highest / rise);
            }
        }
        // Before `max`, which would turn NaN into 0.
        diverged([
            ("the speed", state.speed),
            ("the distance", state.distance),
            ("the acceleration of the drive", state.drive),
            ("the acceleration of the brake", state.brake),
        ])
    }
}

/// Follows a delayed input times a gain with a lag for a time; returns the integral of the state, and the integral of
/// that from the beginning.
pub(crate) fn follow(
    delay: &mut DelayLine,
    state: &mut f64,
    gain: f64,
    time_constant: f64,
    duration: f64,
) -> [f64; 2] {
    let (mut area, mut moment) = (0.0, 0.0);
    let mut left = duration;
    while left > 0.0 {
        let piece = delay.next(left);
        left -= piece.duration;
        let t = piece.duration;
        let target = gain * piece.value;
        let away = *state - target;
        let approached = -(-t / time_constant).exp_m1();
        let lagged = time_constant * approached;
        moment += area * t + 0.5 * target * t * t + away * time_constant * (t - lagged);
        area += target * t + away * lagged;
        *state = target + away * (1.0 - approached);
    }
    [area, moment]
}
