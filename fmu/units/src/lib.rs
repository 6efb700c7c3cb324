//! Each FMU's variable table, written once, and the glue from the pure model to the export trait.
//!
//! From a table come the enum that the glue must match exhaustively, the XML, the documentation
//! page and the tables in the READMEs. The glue holds no physics and no C symbol: the cdylib crates
//! next to this one add the symbols, one crate an FMU, since two crates that export the same symbols
//! must never be linked into one binary.
//!
//! [`Fmu`] is the one list of the units: who does something for each of them goes through it.
//!
//! Times are seconds, angles radians; signs are ISO 8855.

mod bicycle_plant;
mod excitation;
mod fmu;
mod identified_plant;
mod lateral_pid;
mod longitudinal_plant;
mod multivariable_plant;
mod nonlinear_vehicle;
mod plant;
mod pose_estimator;
mod reference_path;
mod resources;
mod run;
mod saved;
mod scenario;
mod speed_controller;
mod ticking;

pub use bicycle_plant::BicyclePlant;
pub use excitation::Excitation;
pub use fmu::{Definition, Error, Icon, Role, Visitor};
pub use identified_plant::IdentifiedPlant;
pub use lateral_pid::LateralPid;
pub use longitudinal_plant::LongitudinalPlant;
pub use multivariable_plant::MultivariablePlant;
pub use nonlinear_vehicle::NonlinearVehicle;
pub use pose_estimator::PoseEstimator;
pub use reference_path::ReferencePath;
pub use run::Running;
pub use scenario::{Moment, Scenario};
pub use speed_controller::SpeedController;

use fmi2_export::{CoSimulationUnit, Resources, describe};
use model_description::{DefaultExperiment, ModelDescription, Table};
use steerwright_formats::{Described, Document, Error as DocumentError, Facts};

fmu::fmus! {
    /// The identified lateral dynamics.
    IdentifiedPlant in "identified-plant";
    /// The two-wheel bicycle model.
    BicyclePlant in "bicycle-plant";
    /// The identified plant of named channels.
    MultivariablePlant in "multivariable-plant";
    /// The vehicle with saturating tyres.
    NonlinearVehicle in "nonlinear-vehicle";
    /// The identified response of the speed.
    LongitudinalPlant in "longitudinal-plant";
    /// The steering controller.
    LateralPid in "lateral-pid";
    /// The speed controller.
    SpeedController in "speed-controller";
    /// The reference road and its guidance.
    ReferencePath in "reference-path";
    /// The filter for the pose.
    PoseEstimator in "pose-estimator";
    /// The manoeuvre that identifies a vehicle.
    Excitation in "excitation";
}
