//! Tests of the checker, in one binary: linking is most of what a small test costs.

mod corpus;
mod faults;
mod hostile;
mod others;
mod running;
