//! Monte Carlo studies over closed loops of FMUs: one system, many runs, a row of numbers for each.
//!
//! A study is a TOML file ([`Study`]). [`Sweep::prepare`] opens the FMUs and resolves every name;
//! [`Sweep::run`] does the remaining runs on some threads and appends the rows, in order, to a CSV file that
//! a later call can continue; [`Summary`] is the statistics over the rows. The numbers of a run depend on
//! the study and the run's index alone ([`draws`], `docs/decisions/0035-sweep-rows.md`). Any FMU for FMI 2.0
//! Co-Simulation can be used. Times are in s, values in the units of the FMUs' variables unless the study
//! states others.

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
mod pieces;
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

pub use error::{Error, StudyPlace};
pub use explain::{Cause, Condition, Failing, Relation};
pub use make::Options;
pub use metric::Class;
pub use pieces::SweepPiece;
pub use prepare::Sweep;
pub use run::Finished;
pub use study::Study;
pub use summary::{ClassSummary, FailureSummary, MetricSummary, Requirement, Summary};
