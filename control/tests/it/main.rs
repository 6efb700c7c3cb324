//! The crate from outside: bicycle files, designs, paths and closed loops.

#![allow(clippy::expect_used, clippy::unwrap_used, clippy::panic)]

mod actuator;
mod bicycle;
mod common;
mod demand;
mod design;
mod margins;
mod over_speed;
mod profile;
mod recorded_fixes;
mod recorded_paths;
mod rejected_plants;
mod robust;
mod tracking;
