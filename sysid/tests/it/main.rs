//! The crate's integration tests, as one binary.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

mod accumulated;
mod actuator;
mod bicycle;
mod closed_loop;
mod common;
mod delay;
mod delivered;
mod drives;
mod dryer2;
mod evidence;
mod excitation;
mod excitation_goals;
mod factor;
mod faults;
mod held_input;
#[allow(dead_code, unreachable_pub, unused_imports)] // the evaluation uses the rest
#[path = "../known/mod.rs"]
mod known;
mod known_drives;
mod limited_servo;
mod linear_car;
mod open_hold;
mod recovery;
mod refine;
mod selection;
mod short_logs;
mod sideslip;
mod single_track;
mod steering_faults;
mod validate;
mod vehicle_class;
