//! Tests of the checker, in one binary: linking is most of what a small test costs.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

mod corpus;
mod faults;
mod hostile;
mod others;
mod running;
