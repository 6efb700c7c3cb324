//! Tests of figures and pages, in one binary: linking is most of what a small test costs.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

mod common;
mod figures;
mod page;
mod sections;
