//! Known systems, drives of which the truth is known, and distances between models: for the tests and, by
//! path, for the evaluation.

mod accumulated;
pub mod bias;
mod distance;
mod drive;
pub mod driver;
pub mod limit_drive;
mod order;
mod random;
mod recorded;

pub use accumulated::{AccumulatedSignals, OfFactor};
pub use distance::{markov_distance, pole_distance, response_distance};
pub use drive::{Drive, Recording};
pub use order::{Experiment, LARGEST_ORDER, LEAST_SHARE};
pub use random::Random;
pub use recorded::{halves, recording};
