//! The structures of models: a folder for each. `model` is what they have in common, and `choice` chooses one.

pub mod bicycle;
mod choice;
pub(crate) mod held;
mod limited_wheel;
pub mod longitudinal;
mod model;
pub mod multivariable;
mod rate_limit;
pub mod single_track;
pub(crate) mod state_space;
pub mod torque;

pub use choice::{Choice, ChoiceOptions, StructureRow, identify_structure};
pub use model::{IdentifiedModel, StructureOptions};
