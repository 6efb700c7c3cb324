//! Tests of the files of the models, in one binary: linking is most of what a small test costs.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

mod estimator;
mod places;
mod vehicle;
