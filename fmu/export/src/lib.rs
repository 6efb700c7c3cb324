#![doc = include_str!("../README.md")]
#![deny(unsafe_code)]

// Only the modules marked here contain unsafe code.
#[allow(unsafe_code)]
pub mod boundary;
pub mod calls;
pub mod types;

mod access;
mod access_rules;
#[allow(unsafe_code)]
mod arguments;
mod blob;
#[allow(unsafe_code)]
mod contain;
mod describe;
mod differentials;
mod export;
mod exposed;
mod instance;
mod log;
#[allow(unsafe_code)]
mod logger;
mod resources;
mod structure;
mod unit;
pub mod uri;
mod variables;

#[cfg(test)]
#[allow(unsafe_code)]
mod tests;

pub use describe::{DescribeError, capabilities, describe, guid};
pub use exposed::{derivative_reference, state_reference};
pub use log::{Level, Log};
pub use logger::LOG_CATEGORIES;
pub use model_description;
pub use resources::{ResourceError, Resources};
pub use unit::{
    Capabilities, CoSimulationUnit, Known, StateSpec, StatedVariable, Unknown, VariableId,
};
