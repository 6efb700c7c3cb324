//! The evidence of a design beyond the figures on the nominal plant, and the advice in words.

pub(crate) mod advice;
pub(crate) mod engagement;
pub(crate) mod infeasibility;
pub(crate) mod no_actuator;
pub(crate) mod robustness;
