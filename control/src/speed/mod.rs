//! The design of a speed controller to a specification.
//!
//! ```text
//! options ──▶ tuning rule ──▶ search, where the rule misses ──▶ nominal responses ──▶ ensemble ──▶ quality
//! ```
//!
//! Every response is that of the nonlinear model and the controller as they run in their FMUs.

pub(crate) mod design;
mod ensemble;
mod limits;
pub(crate) mod options;
mod quality;
pub(crate) mod simulate;
