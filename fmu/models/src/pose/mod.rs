//! The pose of the vehicle: an extended Kalman filter of GNSS fixes, a gyro with bias, and speed.
//!
//! States: position of the centre of gravity (X, Y), yaw ψ, gyro bias b. Equations and sources are in
//! `docs/methods/estimator.md`, the rules for fixes in the README of `fmu/pose-estimator`.
//!
//! There are two filters, one as of when a fix that arrives now was valid and one at present, and the
//! readings between them ([`history`]). A fix corrects the first; the second is predicted from it with
//! those readings. If the fix is at a communication point, the estimate equals that of a filter without
//! latency bit for bit. A fix beyond [`GATE`] is an outlier; after [`MOST_OUTLIERS`] in a row, and after
//! a start with an unknown yaw, the yaw is determined by [`alignment`].

pub mod alignment;
mod estimator;
pub mod filter;
pub mod history;
mod parameters;
mod saved;

pub use estimator::{GATE, MOST_OUTLIERS, PoseEstimator, PoseInput};
pub use parameters::PoseParameters;
pub use saved::SavedPose;
