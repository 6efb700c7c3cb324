//! The FMUs by name, for those who pack them.

use fmi2_export::{CoSimulationUnit, DescribeError, Resources, describe};
use model_description::{DefaultExperiment, ModelDescription, Table};
use steerwright_formats::Document;

/// Why an FMU could not be described.
pub type Error = DescribeError;

/// Declares [`Fmu`] from one list: its unit, the format and the name of its file, its folder.
macro_rules! fmus {
    ($($(#[$doc:meta])* $name:ident: $format:ident in $resource:literal, $folder:literal;)*) => {
        /// An FMU of this project.
        #[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
        pub enum Fmu { $($(#[$doc])* $name,)* }

        impl Fmu {
            /// Every FMU.
            pub const ALL: [Self; 7] = [$(Self::$name),*];

            /// The variable table.
            #[must_use]
            pub fn table(self) -> &'static Table {
                match self { $(Self::$name => crate::$name::TABLE),* }
            }

            /// The schema of the file the FMU is made from.
            #[must_use]
            pub fn schema(self) -> &'static str {
                match self { $(Self::$name => steerwright_formats::$format::SCHEMA),* }
            }

            /// The name that file has in `resources/`.
            #[must_use]
            pub fn resource(self) -> &'static str {
                match self { $(Self::$name => $resource),* }
            }

            /// The name of its folder in `fmu/`.
            #[must_use]
            pub fn folder(self) -> &'static str {
                match self { $(Self::$name => $folder),* }
            }

            /// The FMU's README: its equations and its variables, in Markdown.
            #[must_use]
            pub fn readme(self) -> &'static str {
                match self {
                    $(Self::$name => include_str!(concat!("../../", $folder, "/README.md"))),*
                }
            }

            /// The model description of this FMU with these resources: start values are read from
            /// the very unit that the binary runs.
            ///
            /// # Errors
            /// Where the unit refuses the resources.
            pub fn describe(
                self,
                resources: Vec<(String, Vec<u8>)>,
                experiment: DefaultExperiment,
            ) -> Result<ModelDescription, Error> {
                let (resources, experiment) = (&Resources::from(resources), Some(experiment));
                match self { $(Self::$name => describe::<crate::$name>(resources, experiment)),* }
            }

            /// Opens the unit on its resources.
            ///
            /// # Errors
            /// The message of the unit about invalid resources.
            pub fn open(
                self,
                resources: Vec<(String, Vec<u8>)>,
            ) -> Result<Box<dyn crate::run::Running>, String> {
                let resources = &Resources::from(resources);
                let unit: Box<dyn crate::run::Running> =
                    match self { $(Self::$name => Box::new(crate::$name::open(resources)?)),* };
                Ok(unit)
            }
        }
    };
}

fmus! {
    /// The identified lateral dynamics.
    IdentifiedPlant: Plant in "plant.json", "identified-plant";
    /// The two-wheel bicycle model.
    BicyclePlant: Bicycle in "bicycle.json", "bicycle-plant";
    /// The vehicle with saturating tyres.
    NonlinearVehicle: Vehicle in "vehicle.json", "nonlinear-vehicle";
    /// The identified response of the speed.
    LongitudinalPlant: Longitudinal in "longitudinal.json", "longitudinal-plant";
    /// The steering controller.
    LateralPid: Pid in "pid.json", "lateral-pid";
    /// The reference road and its guidance.
    ReferencePath: Path in "path.json", "reference-path";
    /// The filter for the pose.
    PoseEstimator: Estimator in "estimator.json", "pose-estimator";
}

impl Fmu {
    /// The FMU's name, which is also its archive's and its `modelIdentifier`.
    #[must_use]
    pub fn name(self) -> &'static str {
        self.table().model_name
    }

    /// Whether it is a vehicle that is steered.
    #[must_use]
    pub fn is_plant(self) -> bool {
        matches!(self, Self::IdentifiedPlant | Self::BicyclePlant | Self::NonlinearVehicle)
    }
}
