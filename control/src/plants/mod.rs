//! The plants that a controller is designed on: yaw rate from steering, one input and one output.

pub(crate) mod behind_actuator;
pub(crate) mod design_plant;
pub(crate) mod dynamics;
pub(crate) mod family;
mod logarithm;
pub(crate) mod plant_model;
pub(crate) mod sampled;
