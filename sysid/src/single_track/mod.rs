//! The structure `single track`: a vehicle up to its limits of grip, from a whole drive.

mod drive;
mod dynamics;
mod estimate;
mod options;
mod parameters;
mod prepared;
mod problem;
mod result;
mod simulate;

pub use drive::{Drive, DriveSegment};
pub use options::SingleTrackOptions;
pub use parameters::{Parameter, Prior, Scale};
pub use result::{ParameterEstimate, SimulationFit, SingleTrack, identify_single_track};
