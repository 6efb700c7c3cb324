//! Known systems and what tells them apart: for the tests of `sysid` and for its evaluation.

mod absorbed;
pub mod bias;
mod distance;
mod drive;
pub mod driver;
mod halves;
mod linear_car;
pub mod measure;
mod order;
mod parallel;
pub mod parsim;
pub mod peers;
mod python;
mod random;
mod recorded;

pub use absorbed::{AbsorbedSignals, OfFactor};
pub use distance::{markov_distance, pole_distance, response_distance};
pub use drive::{Drive, Recording};
pub use halves::swapped_halves;
pub use linear_car::{Course, LinearCar, LinearDrive, LinearLog, STEERING_RATIO, Steering};
pub use order::{Experiment, LARGEST_ORDER, LEAST_SHARE};
pub use parallel::on_all_cores;
pub use python::{ask, python, single_threaded};
pub use random::Random;
pub use recorded::{halves, recording};
