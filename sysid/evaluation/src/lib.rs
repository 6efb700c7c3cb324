//! Known systems and what tells them apart: for the tests of `sysid` and for its evaluation.

pub mod bias;
mod distance;
mod halves;
pub mod measure;
pub mod peers;
pub mod driver;
pub mod parsim;
mod random;

pub use distance::{markov_distance, pole_distance, response_distance};
pub use halves::swapped_halves;
mod order;
mod python;
mod random;
mod recorded;

pub use distance::{markov_distance, pole_distance, response_distance};
pub use order::Experiment;
pub use python::ask;
pub use random::Random;
pub use recorded::{halves, recording};
