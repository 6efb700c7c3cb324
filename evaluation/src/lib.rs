//! Code of all evaluation programs; the known systems are those of the tests of `sysid`.

mod halves;
mod initial;
#[path = "../../sysid/tests/known/mod.rs"]
mod known;
mod linear_car;
mod linear_drive;
pub mod measure;
mod parallel;
pub mod parsim;
pub mod peers;
mod python;

pub use halves::swapped_halves;
pub use initial::initial_estimate;
pub use known::*;
pub use linear_car::LinearCar;
pub use linear_drive::{Course, LinearDrive, LinearLog, Steering};
pub use parallel::on_all_cores;
pub use python::{python, request, single_threaded};
