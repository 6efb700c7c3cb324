//! The FMUs by name, for those who pack them.

use crate::{
    BicyclePlant, IdentifiedPlant, LateralPid, NonlinearVehicle, PoseEstimator, ReferencePath,
};
use fmi2_export::{DescribeError, Resources, Slave, describe};
use model_description::{DefaultExperiment, ModelDescription, Table};
use steerwright_formats::Document;

/// Why an FMU could not be described.
pub type Error = DescribeError;

/// An FMU of this project.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Fmu {
    /// The identified lateral dynamics.
    IdentifiedPlant,
    /// The two-wheel bicycle model.
    BicyclePlant,
    /// The vehicle with saturating tyres.
    NonlinearVehicle,
    /// The steering controller.
    LateralPid,
    /// The reference road and its guidance.
    ReferencePath,
    /// The filter for the pose.
    PoseEstimator,
}

impl Fmu {
    /// Every FMU.
    pub const ALL: [Self; 6] = [
        Self::IdentifiedPlant,
        Self::BicyclePlant,
        Self::NonlinearVehicle,
        Self::LateralPid,
        Self::ReferencePath,
        Self::PoseEstimator,
    ];

    /// The variable table.
    #[must_use]
    pub fn table(self) -> &'static Table {
        match self {
            Self::IdentifiedPlant => IdentifiedPlant::TABLE,
            Self::BicyclePlant => BicyclePlant::TABLE,
            Self::NonlinearVehicle => NonlinearVehicle::TABLE,
            Self::LateralPid => LateralPid::TABLE,
            Self::ReferencePath => ReferencePath::TABLE,
            Self::PoseEstimator => PoseEstimator::TABLE,
        }
    }

    /// The FMU's name, which is also its archive's and its `modelIdentifier`.
    #[must_use]
    pub fn name(self) -> &'static str {
        self.table().model_name
    }

    /// The schema of the file the FMU is made from.
    #[must_use]
    pub fn schema(self) -> &'static str {
        match self {
            Self::IdentifiedPlant => steerwright_formats::Plant::SCHEMA,
            Self::BicyclePlant => steerwright_formats::Bicycle::SCHEMA,
            Self::NonlinearVehicle => steerwright_formats::Vehicle::SCHEMA,
            Self::LateralPid => steerwright_formats::Pid::SCHEMA,
            Self::ReferencePath => steerwright_formats::Path::SCHEMA,
            Self::PoseEstimator => steerwright_formats::Estimator::SCHEMA,
        }
    }

    /// The name that file has in `resources/`.
    #[must_use]
    pub fn resource(self) -> &'static str {
        match self {
            Self::IdentifiedPlant => "plant.json",
            Self::BicyclePlant => "bicycle.json",
            Self::NonlinearVehicle => "vehicle.json",
            Self::LateralPid => "pid.json",
            Self::ReferencePath => "path.json",
            Self::PoseEstimator => "estimator.json",
        }
    }

    /// The FMU's README: its equations and its variables, in Markdown.
    #[must_use]
    pub fn readme(self) -> &'static str {
        match self {
            Self::IdentifiedPlant => include_str!("../../identified-plant/README.md"),
            Self::BicyclePlant => include_str!("../../bicycle-plant/README.md"),
            Self::NonlinearVehicle => include_str!("../../nonlinear-vehicle/README.md"),
            Self::LateralPid => include_str!("../../lateral-pid/README.md"),
            Self::ReferencePath => include_str!("../../reference-path/README.md"),
            Self::PoseEstimator => include_str!("../../pose-estimator/README.md"),
        }
    }

    /// The model description of this FMU with these resources: start values are read from the
    /// very slave that the binary runs.
    ///
    /// # Errors
    /// Where the slave refuses the resources.
    pub fn describe(
        self,
        resources: Vec<(String, Vec<u8>)>,
        experiment: DefaultExperiment,
    ) -> Result<ModelDescription, Error> {
        let resources = &Resources::from(resources);
        let experiment = Some(experiment);
        match self {
            Self::IdentifiedPlant => describe::<IdentifiedPlant>(resources, experiment),
            Self::BicyclePlant => describe::<BicyclePlant>(resources, experiment),
            Self::NonlinearVehicle => describe::<NonlinearVehicle>(resources, experiment),
            Self::LateralPid => describe::<LateralPid>(resources, experiment),
            Self::ReferencePath => describe::<ReferencePath>(resources, experiment),
            Self::PoseEstimator => describe::<PoseEstimator>(resources, experiment),
        }
    }
}
