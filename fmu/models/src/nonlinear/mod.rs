//! A vehicle up to its limits: single track, load transfer, tyres that saturate, a real actuator.
//!
//! States (v_y, r, δ, a_φ) and the pose (ψ, X, Y); the speed v is an input. With the forces of the
//! axles F_f and F_r from [`tyre`],
//!
//! ```text
//! m·(v̇_y + v·r) = F_f·cos δ + F_r              α_f = δ − atan((v_y + L_f·r)/v)
//! J·ṙ           = L_f·F_f·cos δ − L_r·F_r      α_r =   − atan((v_y − L_r·r)/v)
//! T_φ·ȧ_φ       = a_y − a_φ                    a_y = v̇_y + v·r
//! δ̇             = clip((command − δ)/T_n, ±rate)                    (see [`actuator`])
//! ψ̇ = r,   Ẋ = v cos ψ − v_y sin ψ,   Ẏ = v sin ψ + v_y cos ψ
//! ```
//!
//! as in Pacejka, *Tire and Vehicle Dynamics*, chapter 1. Where slip is small this is the
//! body-frame form of eq 13 ([`crate::bicycle`]), with every cornering stiffness that of the static
//! wheel load.
//!
//! **Load transfer** ΔF = (share of the axle)·m·h·a_φ/(track width) goes from the inner to the outer
//! wheels of each axle. Taken from a_y itself it would close an algebraic loop, force → a_y → load →
//! force. No vehicle has that loop: its load moves as fast as its body rolls. So the load follows
//! a_φ, which lags a_y by the roll's time constant T_φ; in a steady turn both are equal, and ẇ is an
//! explicit function of the states. Springs, roll centres and roll angle are not modelled.
//!
//! **Longitudinal speed** is held within a step, as in the other plants. There are no longitudinal
//! forces, so tyres have their whole friction for the side. The front wheel's lateral force would
//! slow the vehicle by F_f·sin δ: the source of the speed is assumed to compensate for it. Sideslip
//! angles beyond 90° cannot be represented, since v is not below 0.
//!
//! **Below 1 m/s** slip angles at the true speed would be ill-defined. As in
//! [`crate::bicycle_plant`] the states approach the steady turn of the present speed with the
//! dynamics of 1 m/s, here a mean, by v, of tyres and linear bicycle:
//!
//! ```text
//! (v̇_y, ṙ) = v·f(w − s(v)·tan δ + s(1)·tan δ, δ) + (1 − v)·F(1 m/s)·(w − s(v)·tan δ)
//! ```
//!
//! with w = (v_y, r), f the right-hand sides above at 1 m/s, and F and s of the bicycle. At 1 m/s
//! this is f; for small steering it is the bicycle plant at every speed; towards standstill s·tan δ
//! becomes the kinematic `r = v·tan δ/L`, `v_y = L_r·r`, and at v = 0 the vehicle stands.

pub mod actuator;
mod dynamics;
mod parameters;
mod runge_kutta;
mod saved;
pub mod tyre;
mod vehicle;

pub use parameters::NonlinearParameters;
pub use saved::SavedVehicle;
pub use vehicle::NonlinearVehicle;
