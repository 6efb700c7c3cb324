//! Tests of the files of the models, in one binary: linking is most of what a small test costs.

mod estimator;
mod places;
mod vehicle;
