//! The structure `single track`: a vehicle up to its limits of grip, from a whole drive.
//!
//! ```text
//! v̇_y = (F_f·cos δ + F_r)/m − v·r              α_f = δ − atan((v_y + L_f·r)/v)
//! ṙ   = (L_f·F_f·cos δ − L_r·F_r)/J            α_r =   − atan((v_y − L_r·r)/v)
//! F   = D·sin(C·atan(B·α − E·(B·α − atan(B·α))))         B = C_α/(C·D),   D = μ·F_z
//! T·δ̇ = s·c(t − τ) + δ_0 − δ,   |δ̇| ≤ ρ
//! ```
//!
//! States: lateral velocity v_y, yaw rate r and road-wheel angle δ. The speed v is measured and a known function of
//! time; c is the steering angle over the stated steering ratio; the largest rate ρ is a parameter where the drive shows one. The loads F_z are the static ones. These are the
//! equations of the NonlinearVehicle without lateral load transfer, which is part of the axles' characteristics;
//! [`SingleTrackModel::vehicle`] is its document. The magic formula is that of H. B. Pacejka, *Tire and Vehicle
//! Dynamics*, section 4.3.
//!
//! Yaw rate and, where measured, lateral acceleration are fitted, each weighted by the density of its errors
//! at low frequency, with a normal prior for every parameter. What decides is the free simulation: from
//! steering and speed alone, over minutes. A model that spins there where the
//! vehicle did not is rejected; `search` describes how the estimate is reached nevertheless.
//!
//! The vehicle has to be stable without its driver: of one that spins in free simulation although its
//! parameters are right no estimate is found.

mod directions;
mod drive;
mod dynamics;
mod fit;
mod identify;
pub(crate) mod information;
mod log;
mod log_options;
mod margin;
mod model;
mod noise;
mod options;
mod parameters;
mod prepared;
mod problem;
pub(crate) mod quality;
mod rate_limit;
mod search;
mod simulate;
mod step;
mod uncertainty;
mod unusual_parameters;
pub(crate) mod vehicle;

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
