//! The state of a longitudinal plant as it is saved.

use super::{LongitudinalInputs, LongitudinalParameters, LongitudinalPlant, State};
use crate::Error;
use crate::delay::{DelayLine, History};
use crate::error::finite;
use crate::ticks::Ticks;
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// Everything of a [`LongitudinalPlant`] that is not in its document.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct SavedLongitudinalPlant {
    parameters: LongitudinalParameters,
    started: LongitudinalParameters,
    inputs: LongitudinalInputs,
    initial: [f64; 2],
    state: State,
    drive_history: History,
    brake_history: History,
    grid: Ticks,
}

impl LongitudinalPlant {
    /// All that differs from a new plant of this document.
    #[must_use]
    pub fn save(&self) -> SavedLongitudinalPlant {
        SavedLongitudinalPlant {
            parameters: self.parameters,
            started: self.started,
            inputs: self.inputs,
            initial: [self.initial_speed, self.initial_distance],
            state: self.state,
            drive_history: self.drive_delay.save(),
            brake_history: self.brake_delay.save(),
            grid: self.grid,
        }
    }

    /// The plant of this document in a saved state.
    ///
    /// # Errors
    /// Where no plant of this document can be in that state.
    pub fn restored(&self, saved: SavedLongitudinalPlant) -> Result<Self, Error> {
        // Parameters that were set but not started with may be any numbers.
        finite("a parameter", &saved.parameters.numbers())?;
        saved.started.check()?;
        let inputs = &saved.inputs;
        let reals = [inputs.accelerator, inputs.acceleration_command, inputs.brake, inputs.grade];
        finite("an input", &reals)?;
        finite("an initial value", &saved.initial)?;
        finite("a state", &saved.state.numbers())?;
        if saved.state.speed_of_grid < 0.0 {
            let (name, value) = ("the speed at a grid point", saved.state.speed_of_grid);
            return Err(Error::SavedState { name, value, expected: "zero or more" });
        }
        saved.grid.check()?;
        let mut drive_delay = DelayLine::new(saved.started.delay, 0.0);
        drive_delay.restore(saved.drive_history)?;
        let mut brake_delay = DelayLine::new(saved.started.brake_delay, 0.0);
        brake_delay.restore(saved.brake_history)?;
        let [initial_speed, initial_distance] = saved.initial;
        Ok(Self {
            document: Arc::clone(&self.document),
            parameters: saved.parameters,
            inputs: saved.inputs,
            initial_speed,
            initial_distance,
            started: saved.started,
            state: saved.state,
            drive_delay,
            brake_delay,
            grid: saved.grid,
        })
    }
}
