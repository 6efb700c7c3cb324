//! Tests of archives and packages, in one binary: linking is most of what a small test costs.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

mod archive;
mod icons;
mod licenses;
mod readme;
mod reference;
mod support;
