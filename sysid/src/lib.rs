//! From drive logs to an identified lateral model with evidence.
//!
//! [`identify`] makes of a [`drivelog::DriveLog`]
//! a discrete state-space model from steering angle to yaw rate (eq 1–5) with Kalman gain,
//! its continuous counterpart (eq 6–11), and the evidence of how far it can be trusted, all as
//! [`formats::Plant`].
//!
//! The pieces are public: [`subspace`] (block Hankel → LQ → weighted SVD → eq 12), [`riccati`],
//! [`conversion`], [`stability`], [`reduction`], [`refine`], [`statistics`], [`model`]. They take
//! any number of inputs and outputs; signals are matrices with time along columns.
//!
//! ```
//! # fn main() -> Result<(), sysid::Error> {
//! # let mut csv = String::from("time_s,roadwheel_command_rad,yaw_rate_radps,speed_mps\n");
//! # let mut r = 0.0;
//! # for k in 0..3000 {
//! #     let u = 0.03 * f64::sin(1e-5 * (k * k) as f64);
//! #     csv += &format!("{:.2},{u:.6},{r:.6},15\n", 0.01 * k as f64);
//! #     r += 0.01 * (40.0 * u - 8.0 * r);
//! # }
//! # let bytes = csv.into_bytes();
//! let files = [("drive.csv".to_string(), bytes)];
//! let log = drivelog::read_log(&files, &drivelog::LogOptions::default())?;
//! let found = sysid::identify(&log, &sysid::IdentifyOptions::default())?;
//! assert!(found.plant.evidence.fit.validation > 99.0);
//! # Ok(())
//! # }
//! ```
//!
//! This crate opens no files, and knows nothing of design or FMUs.

mod absorbed;
pub mod bicycle;
pub mod closed_loop;
mod columns;
pub mod conversion;
mod dataset;
pub mod delay;
mod dense;
mod elimination;
mod error;
mod identify;
pub mod model;
pub mod reduction;
pub mod refine;
pub mod riccati;
pub mod sideslip;
mod signals;
pub mod stability;
pub mod statistics;
pub mod subspace;
mod triangle;
mod validation;

pub use absorbed::{AbsorbOptions, Absorbed};
pub use dataset::{DataSet, Segment};
pub use error::Error;
pub use formats::{InputKind, Intersample};
pub use identify::{
    Approach, Automatic, Detrend, Identified, IdentifyOptions, Judged, Traces, TriedOrder,
    automatic, identify, judge, judge_plant,
};
pub use model::{Innovation, StateSpace, simulate};
pub use signals::Signals;
pub use statistics::fit_percent;
pub use subspace::Method;
