//! State-space models: eq 1–5, their simulation, Kalman filter, stability and conversion to and from
//! continuous time (eq 6–11).

pub mod conversion;
pub mod riccati;
mod simulation;
pub mod stability;
mod state_space;

pub(crate) use simulation::{
    driven, free_response, memory, predictions, predictor, predictor_state,
};
pub use simulation::{initial_state, predict, simulate};
pub use state_space::{Innovation, StateSpace};
