//! Tests of the models, in one binary: linking is most of what a small test costs.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

mod bicycle;
mod common;
mod exact_steps;
mod files;
mod identified_plant;
mod longitudinal;
mod nonlinear;
mod nonlinear_reference;
mod path;
mod pid;
mod pid_reference;
#[path = "pose/main.rs"]
mod pose;
mod pose_reference;
mod schedule;
mod sideslip;
