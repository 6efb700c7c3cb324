//! Tests of the FMUs in Rust, in one binary: linking is most of what a small test costs.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

mod common;
mod derivatives;
mod excitation;
mod extremes;
mod longitudinal;
mod multivariable;
mod nonlinear_vehicle;
mod over_speed;
mod saved;
