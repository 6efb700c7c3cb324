//! Tests of figures and pages, in one binary: linking is most of what a small test costs.

mod common;
mod figures;
mod page;
