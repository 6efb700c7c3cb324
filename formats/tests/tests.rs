//! Tests of the files, in one binary: linking is most of what a small test costs.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

mod documents;
mod estimator;
mod uncertainty;
mod vehicle;
