//! The identified plant's state as it is saved: all that is not in the model's file.

use super::IdentifiedPlant;
use crate::Error;
use crate::delay::History;
use crate::error::finite;
use crate::quadrature::Pose;
use crate::ticks::Ticks;
use serde::{Deserialize, Serialize};

/// Inputs, parameters and states of an [`IdentifiedPlant`].
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct SavedIdentifiedPlant {
    steering_angle: f64,
    steering_rate: f64,
    speed: f64,
    initial_pose: Pose,
    initial_states: Vec<f64>,
    noise_scale: f64,
    noise_seed: i32,
    pose: Pose,
    states: Vec<f64>,
    input: f64,
    history: History,
    grid: Ticks,
    scale: f64,
    seed: i32,
    drawn: u64,
    held: f64,
}

impl IdentifiedPlant {
    /// All that differs from a new plant of this model.
    #[must_use]
    pub fn save(&self) -> SavedIdentifiedPlant {
        SavedIdentifiedPlant {
            steering_angle: self.steering_angle,
            steering_rate: self.steering_rate,
            speed: self.speed,
            initial_pose: Pose { x: self.initial_x, y: self.initial_y, yaw: self.initial_yaw },
            initial_states: self.initial.clone(),
            noise_scale: self.noise_scale,
            noise_seed: self.noise_seed,
            pose: self.pose,
            states: self.states.clone(),
            input: self.input,
            history: self.delay.save(),
            grid: self.grid,
            scale: self.scale,
            seed: self.seed,
            drawn: self.drawn,
            held: self.held,
        }
    }

    /// Restores a saved state.
    ///
    /// # Errors
    /// Where a plant of this model cannot be in that state; this one is then half changed.
    pub fn restore(&mut self, saved: SavedIdentifiedPlant) -> Result<(), Error> {
        let n = self.model.order();
        for (name, states) in [
            ("the number of states", &saved.states),
            ("the number of initial states", &saved.initial_states),
        ] {
            if states.len() != n {
                let value = states.len() as f64;
                return Err(Error::SavedState { name, value, expected: "the order of the model" });
            }
            finite("a state", states)?;
        }
        finite("an input", &[saved.steering_angle, saved.steering_rate, saved.speed])?;
        finite("the noise's scale", &[saved.noise_scale, saved.scale])?;
        finite("the held output or input", &[saved.held, saved.input])?;
        saved.initial_pose.check()?;
        saved.pose.check()?;
        saved.grid.check()?;
        self.delay.restore(saved.history)?;

        self.steering_angle = saved.steering_angle;
        self.steering_rate = saved.steering_rate;
        self.speed = saved.speed;
        let Pose { x, y, yaw } = saved.initial_pose;
        (self.initial_x, self.initial_y, self.initial_yaw) = (x, y, yaw);
        self.initial = saved.initial_states;
        self.noise_scale = saved.noise_scale;
        self.noise_seed = saved.noise_seed;
        self.pose = saved.pose;
        self.states = saved.states;
        self.input = saved.input;
        self.grid = saved.grid;
        self.scale = saved.scale;
        self.seed = saved.seed;
        self.drawn = saved.drawn;
        self.held = saved.held;
        self.on_grid = self.scale != 0.0 || self.model.continuous().is_none();
        self.innovation = self.innovation_at(self.drawn.wrapping_sub(1));
        Ok(())
    }
}
