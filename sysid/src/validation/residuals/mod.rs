//! What a model leaves of the recording: fits, predictions, correlations of residuals, and model errors.

pub(crate) mod correlation;
pub(crate) mod fit;
pub(crate) mod model_error;
pub(crate) mod model_error_reasons;
pub(crate) mod one_sided;
pub(crate) mod pairs;
pub(crate) mod prediction;
pub(crate) mod prewhitening;
pub(crate) mod rate;
