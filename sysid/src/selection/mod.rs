//! Which model: candidates of every order and method, the noise model they are compared with, order,
//! feedthrough and delay.

pub(crate) mod candidate;
pub(crate) mod choose;
pub mod delay;
pub(crate) mod filter;
pub(crate) mod in_memory;
pub(crate) mod initial_conditions;
pub(crate) mod initial_estimates;
pub(crate) mod noise_model;
pub(crate) mod options;
pub(crate) mod order;
pub(crate) mod predicted;
pub(crate) mod search;
pub(crate) mod two_stage;
pub(crate) mod vehicle;
