//! The state of a speed controller as it is saved.

use super::{Memory, SpeedControl};
use crate::Error;
use crate::delay::History;
use crate::error::finite;
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// Everything of a [`SpeedControl`] that is not in its document.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct SavedSpeedControl {
    memory: Memory,
    drive_reference: History,
    brake_reference: History,
    drive_delay: History,
}

impl SpeedControl {
    /// All that differs from a new controller of this document.
    #[must_use]
    pub fn save(&self) -> SavedSpeedControl {
        SavedSpeedControl {
            memory: self.memory,
            drive_reference: self.drive_reference.save(),
            brake_reference: self.brake_reference.save(),
            drive_delay: self.drive_delay.save(),
        }
    }

    /// The controller of this document in a saved state.
    ///
    /// # Errors
    /// Where no controller of this document can be in that state.
    pub fn restored(&self, saved: SavedSpeedControl) -> Result<Self, Error> {
        finite("the memory of the controller", &saved.memory.numbers())?;
        let mut restored = Self::new(Arc::clone(&self.model))?;
        restored.memory = saved.memory;
        restored.drive_reference.restore(saved.drive_reference)?;
        restored.brake_reference.restore(saved.brake_reference)?;
        restored.drive_delay.restore(saved.drive_delay)?;
        Ok(restored)
    }
}
