//! Known systems and what tells them apart: for the tests of `sysid` and for its evaluation.

mod distance;
mod halves;
mod random;

pub use distance::{markov_distance, pole_distance, response_distance};
pub use halves::swapped_halves;
pub use random::Random;
