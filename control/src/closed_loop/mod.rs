//! The sampled loop of a controller around a plant: its response, margins, and what they amount to.

mod decay;
pub(crate) mod evaluate;
pub(crate) mod margins;
pub(crate) mod metrics;
pub(crate) mod scenario;
pub(crate) mod simulate;
