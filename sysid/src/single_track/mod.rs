//! The structure `single track`: a vehicle up to its limits of grip, from a whole drive.

mod drive;
mod dynamics;
mod fit;
mod identify;
mod model;
mod noise;
mod options;
mod parameters;
mod prepared;
mod problem;
mod search;
mod simulate;
mod step;
mod uncertainty;
mod vehicle;

pub use drive::{Drive, DriveSegment};
pub use fit::SimulationFit;
pub use identify::{ParameterEstimate, SingleTrack, identify_single_track};
pub use model::{SimulatedSegment, SingleTrackModel};
pub use options::SingleTrackOptions;
pub use parameters::{Parameter, Prior, Scale};
pub use vehicle::VehicleOptions;
