#![doc = include_str!("../README.md")]
#![deny(unsafe_code)]

// The only modules that hold unsafe code are those that are allowed to here.
#[allow(unsafe_code)]
pub mod boundary;
pub mod calls;
pub mod types;

mod access;
#[allow(unsafe_code)]
mod arguments;
mod contain;
mod describe;
mod export;
mod instance;
mod log;
#[allow(unsafe_code)]
mod logger;
mod resources;
mod slave;
mod uri;

#[cfg(test)]
#[allow(unsafe_code)]
mod tests;

pub use describe::{CAPABILITIES, DescribeError, describe, guid};
pub use log::{Level, Log};
pub use logger::LOG_CATEGORIES;
pub use model_description;
pub use resources::{ResourceError, Resources};
pub use slave::{Capabilities, Known, Slave, StateSpec, Unknown, VariableId};
