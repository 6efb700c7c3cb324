//! The pure step functions that run inside the FMUs.
//!
//! No clocks and no FMI calls: a step maps parameters, inputs and states to new states and outputs. The parameters that
//! a file has too are those of the file ([`steerwright_formats`]). The controller that is tuned is the function that runs in the FMU.
//!
//! | module | content |
//! |---|---|
//! | [`pid`] | the yaw controller of eq 14, tick by tick; `governor`: its large errors |
//! | [`ticks`] | counts samples by a phase, whatever the communication step |
//! | [`linear`] | exact stepping of linear states by the matrix exponential |
//! | [`identified`], [`identified_plant`] | the identified model, and the plant made of it: yaw rate, yaw, position |
//! | [`bicycle`], [`bicycle_plant`] | eq 13, its body-frame form, and the plant made of it |
//! | [`nonlinear`] | a vehicle up to its limits: load transfer, saturating tyres, a real actuator |
//! | [`sampled_system`] | the plant of named channels, on the grid of its sample time |
//! | [`longitudinal`] | the speed that accelerator and brake, or an acceleration command, cause |
//! | [`speed`] | the controller of that speed |
//! | [`excitation`] | the manoeuvre that identifies a vehicle, as it is driven |
//! | [`path`], [`guidance`] | the geometry of a reference path, and line-of-sight guidance on it |
//! | [`sideslip`] | sideslip as a law of the speed |
//! | [`pose`] | the vehicle's pose from GNSS fixes, gyro and speed: an extended Kalman filter |
//! | [`files`] | from the files of the stages to these models |
//! | [`sensitivity`] | partial derivatives of the plants, and which of them are always zero |
//! | [`quadrature`], [`trigonometry`], [`noise`], [`delay`], [`angle`] | shared by those |
//!
//! Equation numbers are those of Yoon, Hwang, Ryu and Lee, *System Identification and Controller
//! Design for Lateral Control of an Unmanned Vehicle*. SI units and radians throughout, axes and
//! signs of ISO 8855: x forward, y left, z up; yaw, steering and curvature positive to the left.

pub mod angle;
pub mod bicycle;
pub mod bicycle_plant;
pub mod delay;
pub mod error;
pub mod excitation;
pub mod files;
pub mod guidance;
pub mod identified;
pub mod identified_plant;
mod intervals;
pub mod limits;
pub mod linear;
pub mod longitudinal;
pub mod noise;
pub mod nonlinear;
mod numbers;
pub mod path;
pub mod pid;
pub mod pose;
pub mod quadrature;
pub mod sampled_system;
pub mod schedule;
pub mod sensitivity;
pub mod sideslip;
pub mod speed;
pub mod ticks;
pub mod trigonometry;

pub use angle::wrap_angle;
pub use bicycle::{BicycleParameters, bicycle_body_frame};
pub use bicycle_plant::{BicyclePlant, SavedBicyclePlant};
pub use error::Error;
pub use excitation::{
    DrivenManoeuvre, Interruption, ManoeuvreInputs, ManoeuvreOutputs, ManoeuvreParameters,
    SavedManoeuvre,
};
pub use guidance::{GuidanceParameters, GuidanceState, PathFollower, PathOutput};
pub use identified::{Continuous, IdentifiedData, IdentifiedModel};
pub use identified_plant::{IdentifiedPlant, SavedIdentifiedPlant};
pub use longitudinal::{
    LongitudinalInputs, LongitudinalParameters, LongitudinalPlant, SavedLongitudinalPlant,
};
pub use nonlinear::{NonlinearParameters, NonlinearVehicle};
pub use path::{PathGeometry, Projection, SpeedReference};
pub use pid::{Pid, PidInput, PidOutput, PidParameters, time_at_largest_rate};
pub use pose::{PoseEstimator, PoseInput, PoseParameters, SavedPose};
pub use sampled_system::{SampledSystem, SavedSampledSystem};
pub use schedule::{GuidanceSchedule, PidSchedule};
pub use sideslip::Sideslip;
pub use speed::{
    SavedSpeedControl, SpeedControl, SpeedControlInputs, SpeedControlOutputs,
    SpeedControlParameters,
};
pub use ticks::Ticks;
