//! The sampled loop of a controller around a plant: responses, margins, and feedforward.

pub(crate) mod early_stopping;
pub(crate) mod evaluate;
pub(crate) mod feedforward;
pub(crate) mod margins;
pub(crate) mod metrics;
pub(crate) mod scenario;
pub(crate) mod simulate;
