//! Whether a model and the recording it was identified from can be relied on: fits, whiteness, coherence, the
//! measured frequency response, faults of channels and clocks, and the quality with its reasons.

pub(crate) mod faults;
pub(crate) mod plausible;
pub(crate) mod quality;
pub(crate) mod residuals;
pub(crate) mod response;
pub(crate) mod validate;
pub(crate) mod vehicle_class;
