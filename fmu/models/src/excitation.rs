//! A steering manoeuvre as it is driven: block after block at their speeds, ended where a limit is reached.
//!
//! At a tick, with the speed `v`, the lateral acceleration `a`, the block's speed `v_b` and its signal `s`:
//!
//! ```text
//! waiting    δ = 0; drives from this tick on where enabled and |v − v_b| ≤ Δv
//! driving    δ = s(k), k = 0, 1, …; after the block the next one waits, after the last the manoeuvre is finished;
//!            returns where |a| ≥ a_max, |v − v_b| > Δv or not enabled
//! returning  |δ| falls by at most rate·Ts; at δ = 0 and not enabled, the interrupted block waits again
//! ```

use crate::Error;
use serde::{Deserialize, Serialize};
use std::sync::Arc;
use steerwright_formats::Manoeuvre;

/// Parameters, which can be changed while it runs.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct ManoeuvreParameters {
    /// Lateral acceleration that ends the manoeuvre, m/s².
    pub max_lateral_acceleration: f64,
    /// How far the speed may be from that of the block, m/s.
    pub speed_tolerance: f64,
    /// Rate at which an interrupted signal returns to 0, rad/s.
    pub return_rate: f64,
    /// Time between ticks, s.
    pub sample_time: f64,
}

/// Inputs at a tick.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct ManoeuvreInputs {
    /// Whether the manoeuvre is driven.
    pub enabled: bool,
    /// Speed, m/s.
    pub speed: f64,
    /// Lateral acceleration, m/s².
    pub lateral_acceleration: f64,
}

/// What ended a block before its end.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub enum Interruption {
    /// Nothing did.
    #[default]
    None = 0,
    /// The lateral acceleration reached its limit.
    LateralAcceleration = 1,
    /// The speed left the range of the block.
    Speed = 2,
    /// It was disabled.
    Disabled = 3,
}

/// Outputs, held until the next tick.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct ManoeuvreOutputs {
    /// Steering angle, rad, in steering coordinates.
    pub steering_angle: f64,
    /// Speed of the block that is driven or waits, m/s; of the last one after the end.
    pub speed_reference: f64,
    /// Whether a signal is driven.
    pub active: bool,
    /// Whether all blocks have been driven.
    pub finished: bool,
    /// Number of the block that is driven or waits, from 1.
    pub block: i32,
    /// What interrupted the block; nothing from when it is driven again.
    pub interruption: Interruption,
}

#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
enum Phase {
    Waiting,
    /// The sample to drive at the next tick.
    Driving {
        sample: usize,
    },
    Returning,
    Finished,
}

/// What changes while it is driven.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct SavedManoeuvre {
    phase: Phase,
    block: usize,
    angle: f64,
    interruption: Interruption,
}

/// A manoeuvre while it is driven.
#[derive(Debug, Clone)]
pub struct DrivenManoeuvre {
    manoeuvre: Arc<Manoeuvre>,
    state: SavedManoeuvre,
}

impl DrivenManoeuvre {
    /// Before its first block.
    ///
    /// # Errors
    /// Without a block.
    pub fn new(manoeuvre: Arc<Manoeuvre>) -> Result<Self, Error> {
        if manoeuvre.schedule.is_empty() {
            return Err(Error::Shape { name: "schedule", got: 0, need: 1 });
        }
        let state = SavedManoeuvre {
            phase: Phase::Waiting,
            block: 0,
            angle: 0.0,
            interruption: Interruption::None,
        };
        Ok(Self { manoeuvre, state })
    }

    /// One tick.
    pub fn tick(
        &mut self,
        parameters: &ManoeuvreParameters,
        inputs: &ManoeuvreInputs,
    ) -> ManoeuvreOutputs {
        let is_at_speed = (inputs.speed - self.speed()).abs() <= parameters.speed_tolerance;
        let mut is_driven = false;
        if self.state.phase == Phase::Waiting && inputs.enabled && is_at_speed {
            self.state.phase = Phase::Driving { sample: 0 };
            self.state.interruption = Interruption::None;
        }
        if let Phase::Driving { sample } = self.state.phase {
            let interruption = if !inputs.enabled {
                Interruption::Disabled
            } else if inputs.lateral_acceleration.abs() >= parameters.max_lateral_acceleration {
                Interruption::LateralAcceleration
            } else if !is_at_speed {
                Interruption::Speed
            } else {
                Interruption::None
            };
            if interruption == Interruption::None {
                is_driven = true;
                self.drive(sample);
            } else {
                self.state.phase = Phase::Returning;
                self.state.interruption = interruption;
            }
        }
        if self.state.phase == Phase::Returning {
            let most = parameters.return_rate * parameters.sample_time;
            let angle = self.state.angle;
            self.state.angle = if angle.abs() <= most { 0.0 } else { angle - most.copysign(angle) };
            if self.state.angle == 0.0 && !inputs.enabled {
                self.state.phase = Phase::Waiting;
            }
        }
        if !is_driven && matches!(self.state.phase, Phase::Waiting | Phase::Finished) {
            self.state.angle = 0.0;
        }
        ManoeuvreOutputs {
            steering_angle: self.state.angle,
            speed_reference: self.speed(),
            active: is_driven,
            finished: self.state.phase == Phase::Finished && !is_driven,
            block: i32::try_from(self.state.block + 1).unwrap_or(i32::MAX),
            interruption: self.state.interruption,
        }
    }

    /// Drives a sample of the block, and moves on.
    fn drive(&mut self, sample: usize) {
        let Some(block) = self.manoeuvre.schedule.get(self.state.block) else { return };
        self.state.angle = self.manoeuvre.steering_rad(block, sample);
        self.state.phase = if sample + 1 < self.manoeuvre.block_samples() {
            Phase::Driving { sample: sample + 1 }
        } else if self.state.block + 1 < self.manoeuvre.schedule.len() {
            self.state.block += 1;
            Phase::Waiting
        } else {
            Phase::Finished
        };
    }

    /// The speed of the present block, m/s.
    fn speed(&self) -> f64 {
        let block = self.manoeuvre.schedule.get(self.state.block);
        let signal = block.and_then(|block| self.manoeuvre.signals.get(block.signal));
        signal.map_or(0.0, |signal| signal.speed_mps)
    }

    /// What changes.
    #[must_use]
    pub fn save(&self) -> SavedManoeuvre {
        self.state
    }

    /// The same manoeuvre in a saved state.
    ///
    /// # Errors
    /// A state that this manoeuvre cannot have.
    pub fn restored(&self, state: SavedManoeuvre) -> Result<Self, Error> {
        let refused = |name, value: f64, expected| Err(Error::SavedState { name, value, expected });
        if state.block >= self.manoeuvre.schedule.len() {
            return refused("the block", state.block as f64, "one of the manoeuvre");
        }
        if let Phase::Driving { sample } = state.phase
            && sample >= self.manoeuvre.block_samples()
        {
            return refused("the sample", sample as f64, "one of the block");
        }
        if !state.angle.is_finite() {
            return refused("the angle", state.angle, "a finite number");
        }
        Ok(Self { manoeuvre: Arc::clone(&self.manoeuvre), state })
    }
}
