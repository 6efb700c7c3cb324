//! Faults of channels, clocks and the steering.

pub(crate) mod clocks;
pub(crate) mod open_hold;
pub(crate) mod play;
pub(crate) mod recording;
pub(crate) mod steering_faults;
