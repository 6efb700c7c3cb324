//! The built libraries of all FMUs, called through their C interface alone.
//!
//! The archives are packed and unpacked as an importer meets them, the libraries loaded by name of
//! each C function. What is expected stands here a second time, from the text of the standard and
//! from the descriptions in the archives, not from the code under test.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)] // tests, and helpers of tests

mod api;
mod benchmark;
mod c_host;
mod locations;
mod logging;
mod many;
mod matrix;
mod memory;
mod samples;
mod states;
mod time;
mod unit;
