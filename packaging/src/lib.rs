//! FMI 2.0 archives from the stages' files and the libraries' bytes.
//!
//! [`package`] takes a document (`plant.json`, `bicycle.json`, `vehicle.json`, `pid.json`, `path.json`
//! or `estimator.json`) and the libraries of its FMU, one for each platform, and returns the archive's
//! bytes. Equal inputs produce equal bytes. [`ssp`] wires packed FMUs into a system structure package.

mod archive;
mod documentation;
mod error;
mod platform;
mod provenance;
mod reference;
pub mod ssp;
mod terminals;

pub use archive::{Binary, Packed, fmu_of, package};
pub use documentation::{table_markdown, with_variables};
pub use error::Error;
pub use steerwright_units::Fmu;
