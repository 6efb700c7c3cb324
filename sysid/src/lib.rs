//! From drive logs to an identified lateral model with evidence.
//!
//! [`identify`] makes of a [`steerwright_drivelog::DriveLog`]
//! a discrete state-space model from steering angle to yaw rate (eq 1–5) with Kalman gain,
//! its continuous counterpart (eq 6–11), and the evidence of how far it can be trusted, all as
//! [`steerwright_formats::Plant`].
//!
//! The pieces are public: [`subspace`] (block Hankel → LQ → weighted SVD → eq 12), [`pem`],
//! [`model`], [`delay`]. They take
//! any number of inputs and outputs; signals are matrices with time along columns.
//!
//! ```
//! # fn main() -> Result<(), steerwright_sysid::Error> {
//! # let mut csv = String::from("time_s,roadwheel_command_rad,yaw_rate_radps,speed_mps\n");
//! # let mut r = 0.0;
//! # for k in 0..3000 {
//! #     let u = 0.03 * f64::sin(1e-5 * (k * k) as f64);
//! #     csv += &format!("{:.2},{u:.6},{r:.6},15\n", 0.01 * k as f64);
//! #     r += 0.01 * (40.0 * u - 8.0 * r);
//! # }
//! # let bytes = csv.into_bytes();
//! let files = [("drive.csv".to_string(), bytes)];
//! let log = steerwright_drivelog::read_log(&files, &steerwright_drivelog::LogOptions::default())?;
//! let found = steerwright_sysid::identify(&log, &steerwright_sysid::IdentifyOptions::default())?;
//! assert!(found.plant.evidence.fit.validation > 99.0);
//! # Ok(())
//! # }
//! ```
//!
//! This crate opens no files, and contains no design and no FMUs.

mod actuator;
mod data;
mod error;
mod excitation;
mod linalg;
pub mod model;
pub mod pem;
mod selection;
pub mod sideslip;
mod structures;
pub mod subspace;
mod validation;

pub use data::scaled::Detrend;
pub use data::split::{ValidationData, ValidationPlace};
pub use data::{DataSet, Segment, Signals, fit_percent, variance_accounted_for};
pub use error::Error;
pub use excitation::{ExcitationOptions, excite, excite_vehicle};
pub use model::{Innovation, StateSpace, simulate};
pub use selection::delay;
pub use selection::options::{IdentifyOptions, Method};
pub use steerwright_formats::{InputKind, Intersample};
pub use structures::state_space::accumulated::{AccumulateOptions, Accumulated};
pub use structures::state_space::plant::{Identified, Traces};
pub use structures::state_space::{Automatic, TriedOrder, automatic, identify};
pub use structures::*;
pub use subspace::Weighting;
pub use validation::validate::{Validated, held_as, validate, validate_plant};
