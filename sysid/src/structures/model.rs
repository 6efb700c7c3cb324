//! What all structures have in common.

use crate::Error;
use crate::structures::multivariable::traces::ChannelTraces;
use crate::structures::single_track::quality::LEAST_SPIN_MARGIN;
use crate::structures::state_space::plant::Traces;
use steerwright_drivelog::{DriveLog, Response};
use steerwright_formats::{Model, Structure};

/// An identified model with the signals behind its plots.
#[derive(Debug, Clone, PartialEq)]
pub struct IdentifiedModel {
    /// The document.
    pub model: Model,
    /// Measured and simulated signals, where the structure simulates them.
    pub traces: Option<Traces>,
    /// The same of a structure whose inputs and outputs have names.
    pub channels: Option<ChannelTraces>,
}

impl IdentifiedModel {
    /// Why it is not chosen whatever its fit.
    pub(crate) fn exclusion(&self) -> Option<&'static str> {
        let Model::SingleTrack(vehicle) = &self.model else { return None };
        let margin = vehicle.evidence.as_ref()?.spin_margin;
        if margin < LEAST_SPIN_MARGIN {
            return Some("with hardly less friction at the rear axle it spins on its own drive");
        }
        None
    }
}

/// A structure, by its options.
pub trait StructureOptions: std::fmt::Debug {
    /// Which one.
    fn structure(&self) -> Structure;

    /// The channel of the log that answers to the steering.
    fn response(&self) -> Response;

    /// Identifies a model of this structure.
    ///
    /// # Errors
    /// Those of the structure.
    fn identify(&self, log: &DriveLog) -> Result<IdentifiedModel, Error>;
}
