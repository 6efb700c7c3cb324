//! Whether a recording and the model identified from it can be right: faults of channels, plausible
//! gain and sign, play of the steering, clocks, and data that can validate.

mod bandwidth;
mod lead;
mod plausible;
mod play;
mod regression;
pub(crate) mod spectra;
mod split;

pub(crate) use bandwidth::bandwidth_hz;
pub(crate) use lead::{yaw_rate_lag, yaw_rate_lead};
pub(crate) use plausible::{Response, implausible, opposite};
pub(crate) use play::steering_play;
pub(crate) use regression::Pair;
pub(crate) use split::{Selection, Split};
