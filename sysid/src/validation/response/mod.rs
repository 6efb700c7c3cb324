//! The frequency response that was measured and that of a model, with their bands.

pub(crate) mod bands;
pub(crate) mod frequencies;
pub(crate) mod measured;
pub(crate) mod modelled;
pub(crate) mod multiple;
pub(crate) mod poles;
pub(crate) mod spectra;
pub(crate) mod spread;
pub(crate) mod sweep;
pub(crate) mod uncertain_response;
