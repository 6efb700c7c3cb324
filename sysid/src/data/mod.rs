//! Data sets: signals in segments, estimation and validation data, offsets, trends and scaling.

pub(crate) mod dataset;
pub(crate) mod held_input;
pub(crate) mod moving;
pub(crate) mod moving_pieces;
pub(crate) mod recording;
pub(crate) mod scaled;
pub(crate) mod signals;
pub(crate) mod split;
pub(crate) mod statistics;

pub use dataset::{DataSet, Segment};
pub use signals::Signals;
pub use statistics::{fit_percent, variance_accounted_for};
