//! From the files of the stages to the models.

mod estimator;
mod places;
mod vehicle;
