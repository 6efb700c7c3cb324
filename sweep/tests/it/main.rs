//! Studies of a loop of FMUs in C.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)] // tests, and their helpers

mod faults;
mod pieces;
mod runs;
mod same_numbers;
mod support;
