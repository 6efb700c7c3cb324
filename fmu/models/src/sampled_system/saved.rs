//! The state of a sampled system as it is saved: all that is not in its document.

use super::{SampledSystem, delays};
use crate::Error;
use crate::error::finite;
use crate::ticks::Ticks;
use serde::{Deserialize, Serialize};
use std::collections::VecDeque;

/// Inputs, parameters and states of a [`SampledSystem`].
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct SavedSampledSystem {
    inputs: Vec<f64>,
    noise_scale: f64,
    noise_seed: i32,
    states: Vec<f64>,
    past: Vec<VecDeque<f64>>,
    latest: Vec<f64>,
    held: Vec<f64>,
    grid: Ticks,
    scale: f64,
    seed: i32,
    drawn: u64,
}

impl SampledSystem {
    /// All that differs from a new system of this document.
    #[must_use]
    pub fn save(&self) -> SavedSampledSystem {
        SavedSampledSystem {
            inputs: self.inputs.clone(),
            noise_scale: self.noise_scale,
            noise_seed: self.noise_seed,
            states: self.states.clone(),
            past: self.past.clone(),
            latest: self.latest.clone(),
            held: self.held.clone(),
            grid: self.grid,
            scale: self.scale,
            seed: self.seed,
            drawn: self.drawn,
        }
    }

    /// Restores a saved state.
    ///
    /// # Errors
    /// Where a system of this document cannot be in that state; this one is then as it was.
    pub fn restore(&mut self, saved: SavedSampledSystem) -> Result<(), Error> {
        let lengths = [
            ("the number of inputs", saved.inputs.len(), self.inputs.len()),
            ("the number of states", saved.states.len(), self.states.len()),
            ("the number of past inputs", saved.past.len(), self.past.len()),
            ("the number of inputs at the grid point", saved.latest.len(), self.latest.len()),
            ("the number of outputs", saved.held.len(), self.held.len()),
        ];
        let of_past = saved.past.iter().zip(delays(&self.plant));
        let of_past =
            of_past.map(|(past, delay)| ("the length of a past input", past.len(), delay));
        for (name, got, need) in lengths.into_iter().chain(of_past) {
            if got != need {
                let value = got as f64;
                return Err(Error::SavedState { name, value, expected: "that of the document" });
            }
        }
        for values in [&saved.inputs, &saved.latest] {
            finite("an input", values)?;
        }
        finite("a state", &saved.states)?;
        finite("a held output", &saved.held)?;
        for past in &saved.past {
            finite("a past input", &past.iter().copied().collect::<Vec<f64>>())?;
        }
        finite("the noise's scale", &[saved.noise_scale, saved.scale])?;
        saved.grid.check()?;
        self.inputs = saved.inputs;
        self.noise_scale = saved.noise_scale;
        self.noise_seed = saved.noise_seed;
        self.states = saved.states;
        self.past = saved.past;
        self.latest = saved.latest;
        self.held = saved.held;
        self.grid = saved.grid;
        self.scale = saved.scale;
        self.seed = saved.seed;
        self.drawn = saved.drawn;
        self.innovation = self.innovation_at(self.drawn.wrapping_sub(1));
        Ok(())
    }
}
