//! A vehicle up to its limits: single track, load transfer, tyres that saturate, a real actuator.
//!
//! States (v_y, r, δ, a_φ) and the pose (ψ, X, Y); the speed v is an input. Equations, assumptions and
//! sources are in `docs/methods/nonlinear.md`.
//!
//! Below 1 m/s the states approach the steady turn of the present speed, as in
//! [`crate::bicycle_plant`], with a mean, by v, of tyres and linear bicycle:
//!
//! ```text
//! (v̇_y, ṙ) = v·f(w − s(v)·tan δ + s(1)·tan δ, δ) + (1 − v)·F(1 m/s)·(w − s(v)·tan δ)
//! ```
//!
//! with w = (v_y, r), f the right-hand sides at 1 m/s, and F and s of the bicycle. At 1 m/s this is f;
//! for small steering it is the bicycle plant at every speed.

pub mod actuator;
mod dynamics;
mod parameters;
mod play;
mod runge_kutta;
mod saved;
pub mod tyre;
mod vehicle;

pub use parameters::NonlinearParameters;
pub use saved::SavedVehicle;
pub use vehicle::NonlinearVehicle;
