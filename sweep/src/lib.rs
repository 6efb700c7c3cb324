//! Monte Carlo studies over closed loops of FMUs: one system, many runs, a row of numbers for each.
//!
//! A study is a TOML file ([`Study`]): a system structure package or FMU files, what is varied and
//! how, disturbances that are added to inputs, metrics with their requirements.
//! [`Sweep::prepare`] opens the FMUs and resolves every name; [`Sweep::run`] does the remaining runs on
//! some threads and appends the rows, in order, to a CSV file that a later call can continue;
//! [`Summary`] is the statistics over the rows.
//!
//! The numbers of a run depend on the study and the run's index alone ([`draws`]), so neither the
//! number of threads nor an interruption changes a byte of the results. Any FMU for FMI 2.0
//! Co-Simulation can be used: nothing here is specific to this project's FMUs, but for the names of
//! two variables (`metric`). Times are in s, values in the units of the FMUs' variables unless the
//! study states others.

mod connect;
mod distribution;
mod disturbance;
pub mod draws;
mod error;
mod explain;
mod isolate;
mod make;
mod memory;
mod metric;
mod plan;
mod prepare;
mod resolve;
mod results;
mod rig;
mod run;
mod study;
mod summary;
mod values;
mod watch;

pub use error::{Error, Place};
pub use explain::{Cause, Condition, Failing, Relation};
pub use make::Options;
pub use metric::Class;
pub use prepare::Sweep;
pub use run::Finished;
pub use study::Study;
pub use summary::{ClassSummary, FailureSummary, MetricSummary, Requirement, Summary};
