//! Known systems and what tells them apart: for the tests of `sysid` and for its evaluation.

mod distance;
mod halves;
pub mod measure;
pub mod peers;
mod random;

pub use distance::{markov_distance, pole_distance, response_distance};
pub use halves::swapped_halves;
pub use random::Random;
