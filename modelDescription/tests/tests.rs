//! Tests of model descriptions, in one binary: linking is most of what a small test costs.

mod common;
mod legality;
mod reader;
mod round_trip;
