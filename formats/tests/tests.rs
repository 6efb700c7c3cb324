//! Tests of the files, in one binary: linking is most of what a small test costs.

mod documents;
mod estimator;
mod uncertainty;
mod vehicle;
