//! Tests of the checker, in one binary, since linking dominates the build time of small tests.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

mod corpus;
mod faults;
mod hostile;
mod others;
mod running;
