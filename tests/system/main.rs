//! The system's tests: the program from outside, and packed FMUs against the functions in them.
//!
//! One binary, so that the demo and the chain of files that most tests read are made once.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

mod bad_input;
#[allow(dead_code)]
#[path = "../../sysid/src/structures/longitudinal/tests/car.rs"]
mod car;
mod check;
mod circles;
mod closed_loop;
#[cfg(unix)]
mod cluster;
mod command_line;
mod compare;
#[path = "../../fmu/host/tests/it/support/mod.rs"]
mod crashing;
mod demo;
mod dependencies;
mod excite;
mod excite_goals;
mod export;
mod first_fmu;
mod fmus;
#[cfg(unix)]
mod folders;
mod foreign_fmus;
mod gate;
mod generated;
mod identify_bicycle;
mod identify_vehicle;
mod inspect;
mod installed;
mod jacobi_loop;
mod longitudinal;
mod longitudinal_plant;
mod model_matches;
mod multivariable;
mod nonlinear_vehicle;
#[cfg(unix)]
mod outputs;
mod path_files;
mod pose_loop;
#[cfg(unix)]
mod processes;
mod sideslip;
mod speed_control;
mod ssp;
mod stages;
mod structures;
#[path = "../support/mod.rs"]
mod support;
mod sweep;
mod tutorial;
mod whole_road;
