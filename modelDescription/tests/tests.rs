//! Tests of model descriptions, in one binary: linking is most of what a small test costs.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

mod common;
mod legality;
mod reader;
mod round_trip;
