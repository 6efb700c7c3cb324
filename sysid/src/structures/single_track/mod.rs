//! The structure `single track`: a vehicle up to its limits of grip, from a whole drive.
//!
//! ```text
//! v̇_y = (F_f·cos δ + F_r)/m − v·r              α_f = δ − atan((v_y + L_f·r)/v)
//! ṙ   = (L_f·F_f·cos δ − L_r·F_r)/J            α_r =   − atan((v_y − L_r·r)/v)
//! σ·α̇′ = v·(α − α′)                            T·δ̇ = s·c(t − τ) + δ_0 − δ
//! F   = D·sin(C·atan(B·α′ − E·(B·α′ − atan(B·α′))))      B = C_α/(C·D)
//! D   = μ(F_z)·F_z·√(1 − (F_x/(μ(F_z)·F_z))²)
//! ```
//!
//! States: lateral velocity v_y, yaw rate r, relaxed slip angles α′ of both axles and road-wheel angle δ.
//! The speed v and the longitudinal acceleration are measured and known functions of time; c is the
//! steering angle over the stated steering ratio. Axle loads F_z follow from longitudinal load transfer and
//! lift; the longitudinal force F_x of an axle is its share of the driving or braking force. Friction and
//! cornering stiffness depend on the load as in the NonlinearVehicle, whose parameters
//! [`SingleTrackModel::vehicle`] fills; the lateral load transfer is part of the axles' characteristics. The
//! magic formula is that of H. B. Pacejka, *Tire and Vehicle Dynamics*, section 4.3; the first-order
//! relaxation is of its chapter 7.
//!
//! Yaw rate and, where measured, lateral acceleration are fitted, each weighted by the density of its errors
//! at low frequency, with a normal prior for every parameter. What decides is the free simulation: from
//! steering, speed and longitudinal acceleration alone, over minutes. A model that spins there where the
//! vehicle did not is rejected; `search` describes how the estimate is reached nevertheless.
//!
//! The vehicle has to be stable without its driver: of one that spins in free simulation although its
//! parameters are right no estimate is found.

mod directions;
mod drive;
mod dynamics;
mod fit;
mod identify;
mod log;
mod log_options;
mod model;
mod noise;
mod options;
mod parameters;
mod prepared;
mod problem;
pub(crate) mod quality;
mod search;
mod simulate;
mod step;
mod uncertainty;
mod unusual_parameters;
mod vehicle;

pub use drive::{Drive, DriveSegment};
pub use identify::{ParameterEstimate, SingleTrack, identify_single_track};
pub(crate) use log::identify_moving;
pub use log::{IdentifiedVehicle, identify_vehicle};
pub use log_options::IdentifyVehicleOptions;
pub use model::{SimulatedSegment, SingleTrackModel};
pub use options::SingleTrackOptions;
pub use parameters::{Parameter, Scale};
pub use steerwright_formats::{Prior, SimulationFit};
pub use vehicle::VehicleOptions;
