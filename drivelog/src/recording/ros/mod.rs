//! Messages of ROS 2: their definitions, and their numbers in Common Data Representation (CDR).

mod cdr;
mod definitions;
mod meaning;
mod schema;

pub(super) use cdr::{Encapsulation, Layout};
pub(super) use definitions::Definitions;
pub(super) use meaning::describe;
pub(super) use schema::Schema;

/// Instants and durations in s, from the nanoseconds that they are logged in.
pub(super) fn seconds(nanoseconds: i64) -> f64 {
    nanoseconds as f64 / 1e9
}
