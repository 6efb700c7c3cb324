//! An importer of FMI 2.0 Co-Simulation: opens archives, steps their FMUs, runs loops of them.
//!
//! - [`Archive`] opens a `.fmu`: safe extraction, modelDescription.xml, the platform's binary.
//! - [`Instance`] is one instance: get and set by name or value reference, step, save and restore.
//! - [`System`] wires instances and runs them, coupled by Gauss–Seidel or Jacobi, into a
//!   [`Recording`]. [`System::plan`] compiles it for many runs, made by [`Cosimulation`].
//! - [`process`] runs FMUs in processes that end with their parent.
//! - [`SystemPackage`] opens a `.ssp`: FMUs, and the file that wires them into a [`System`].
//!
//! Units are those of the FMUs' variables; times are in s. This crate has no vehicle-specific code.
//! `unsafe` is limited to the C boundary: `library`, `log`, `instance` and the signals of `process`.

mod archive;
mod c_types;
mod error;
mod experiment;
mod instance;
mod library;
mod log;
mod model;
mod names;
pub mod process;
mod scratch;
mod ssp;
mod system;
mod units;

pub use archive::{Archive, Limits, binary_name, platform_folders};
pub use c_types::Status;
pub use error::Error;
pub use experiment::recommended_experiment;
pub use instance::{FmuState, Instance, InstanceOptions, Phase};
pub use library::FUNCTION_NAMES;
pub use log::{LogLine, MAX_LOG_LINES};
pub use model::Model;
/// Types of the description of a [`Model`].
pub use model_description::{Causality, DefaultExperiment, Kind, Value, Variability, Variable};
pub use names::near;
pub use scratch::Scratch;
pub use ssp::{
    Component, Connector, Parameter, SspPlace, SystemInput, SystemPackage, SystemStructure,
};
pub use system::{
    Assigned, Composition, Connection, Cosimulation, Coupling, Grid, InputTable, Key, Linear,
    Measurement, Plan, PlanOptions, Recording, Settled, Signals, System, Unit, grid, wires_by_name,
};
