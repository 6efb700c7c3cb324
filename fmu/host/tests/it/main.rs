//! The importer against FMUs in C that keep the standard, and some that break it.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)] // tests, and their helpers

mod archive;
mod instance;
mod process;
mod ssp;
mod ssp_systems;
mod ssp_units;
mod support;
mod system;
