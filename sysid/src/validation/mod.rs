//! Whether a model and the recording it was identified from can be relied on: fits, whiteness, coherence, the
//! measured frequency response, faults of channels and clocks, and the quality with its reasons.

pub(crate) mod bands;
pub(crate) mod clocks;
pub(crate) mod correlation;
pub(crate) mod faults;
pub(crate) mod fit;
pub(crate) mod frequencies;
pub(crate) mod model_error;
pub(crate) mod model_error_reasons;
pub(crate) mod modelled;
pub(crate) mod one_sided;
pub(crate) mod open_hold;
pub(crate) mod pairs;
pub(crate) mod plausible;
pub(crate) mod play;
pub(crate) mod poles;
pub(crate) mod prediction;
pub(crate) mod prewhitening;
pub(crate) mod quality;
pub(crate) mod rate;
pub(crate) mod response;
pub(crate) mod spectra;
pub(crate) mod spread;
pub(crate) mod steering_faults;
pub(crate) mod sweep;
pub(crate) mod uncertain_response;
pub(crate) mod validate;
pub(crate) mod vehicle_class;
