//! The FMUs by name, for those who pack them.

use fmi2_export::{CoSimulationUnit, DescribeError};
use steerwright_formats::{Described, Document};

use crate::scenario::Scenario;

/// Why an FMU could not be described.
pub type Error = DescribeError;

/// What an FMU does in a loop, in the order in which a Gauss–Seidel coupling steps them without a delay.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Role {
    /// A plant of any kind.
    Plant,
    /// The speed that the vehicle moves at.
    Speed,
    /// The vehicle that is steered.
    Vehicle,
    /// The pose, from measurements.
    Estimator,
    /// The road, and where to go on it.
    Guidance,
    /// What steers.
    Controller,
}

/// What is stated of an FMU once, beside its unit.
pub trait Definition: CoSimulationUnit {
    /// The document that it is made from.
    type File: Document + Described;
    /// The name of that document in `resources/`.
    const RESOURCE: &'static str;
    /// Its part in a loop.
    const ROLE: Role;

    /// The inputs of its reference run.
    fn scenario(file: Self::File) -> Scenario;

    /// The step that its document asks for, s: the time between ticks. `None` of what any step suits.
    fn step_s(_file: &Self::File) -> Option<f64> {
        None
    }

    /// The time that an experiment with that step takes to show what is in its document, s.
    fn experiment_s(_file: &Self::File, _step_s: f64) -> f64 {
        10.0
    }
}

/// What is done with the unit of an FMU, whichever it is; see [`Fmu::visit`](crate::Fmu::visit).
pub trait Visitor {
    /// What comes of it.
    type Output;

    /// Does it with this unit.
    fn visit<S: Definition>(self) -> Self::Output;
}

/// An FMU's picture.
#[derive(Debug, Clone, Copy)]
pub struct Icon {
    /// Pixels, 128 a side, made from the drawing.
    pub png: &'static [u8],
    /// The drawing.
    pub svg: &'static [u8],
}

/// Declares `Fmu` from one list: the units and their folders in `fmu/`.
macro_rules! fmus {
    ($($(#[$doc:meta])* $name:ident in $folder:literal;)*) => {
        /// An FMU of this project.
        #[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
        pub enum Fmu { $($(#[$doc])* $name,)* }

        impl Fmu {
            /// Every FMU.
            pub const ALL: [Self; [$($folder),*].len()] = [$(Self::$name),*];

            /// Does something with its unit.
            pub fn visit<V: Visitor>(self, visitor: V) -> V::Output {
                match self { $(Self::$name => visitor.visit::<$name>()),* }
            }

            /// The variable table.
            #[must_use]
            pub fn table(self) -> &'static Table {
                match self { $(Self::$name => $name::TABLE),* }
            }

            /// The schema of the file it is made from.
            #[must_use]
            pub fn schema(self) -> &'static str {
                match self { $(Self::$name => <$name as Definition>::File::SCHEMA),* }
            }

            /// The name that file has in `resources/`.
            #[must_use]
            pub fn resource(self) -> &'static str {
                match self { $(Self::$name => $name::RESOURCE),* }
            }

            /// Its part in a loop.
            #[must_use]
            pub fn role(self) -> Role {
                match self { $(Self::$name => $name::ROLE),* }
            }

            /// The name of its folder in `fmu/`.
            #[must_use]
            pub fn folder(self) -> &'static str {
                match self { $(Self::$name => $folder),* }
            }

            /// Its README: its equations and its variables, in Markdown.
            #[must_use]
            pub fn readme(self) -> &'static str {
                match self {
                    $(Self::$name => include_str!(concat!("../../", $folder, "/README.md"))),*
                }
            }

            /// A small document that it can be made from.
            #[must_use]
            pub fn example(self) -> &'static str {
                match self {
                    $(Self::$name => include_str!(concat!("../../", $folder, "/example.json"))),*
                }
            }

            /// Its picture.
            #[must_use]
            pub fn icon(self) -> Icon {
                match self {
                    $(Self::$name => Icon {
                        png: include_bytes!(concat!("../../", $folder, "/icon.png")),
                        svg: include_bytes!(concat!("../../", $folder, "/icon.svg")),
                    }),*
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
                match self { $(Self::$name => describe::<$name>(resources, experiment)),* }
            }

            /// Opens the unit on its resources.
            ///
            /// # Errors
            /// The message of the unit about invalid resources.
            pub fn open(
                self,
                resources: Vec<(String, Vec<u8>)>,
            ) -> Result<Box<dyn Running>, String> {
                let resources = &Resources::from(resources);
                let unit: Box<dyn Running> =
                    match self { $(Self::$name => Box::new($name::open(resources)?)),* };
                Ok(unit)
            }

            /// What the document says of itself; `file` is named in errors.
            ///
            /// # Errors
            /// Where it is no document of this FMU.
            pub fn facts(self, document: &str, file: &str) -> Result<Facts, DocumentError> {
                match self {
                    $(Self::$name => {
                        <$name as Definition>::File::from_json(document, file).map(Described::facts)
                    })*
                }
            }

            /// The step of an experiment, s, by default the one that the document asks for, or 0.01 s, and the time that it
            /// takes, s; `file` is named in errors.
            ///
            /// # Errors
            /// Where it is no document of this FMU.
            pub fn times_s(
                self,
                document: &str,
                file: &str,
                step: Option<f64>,
            ) -> Result<(f64, f64), DocumentError> {
                match self {
                    $(Self::$name => {
                        let file = <$name as Definition>::File::from_json(document, file)?;
                        let step = step.or_else(|| $name::step_s(&file)).unwrap_or(0.01);
                        Ok((step, $name::experiment_s(&file, step)))
                    })*
                }
            }

            /// The inputs of the reference run with that document; `file` is named in errors.
            ///
            /// # Errors
            /// Where it is no document of this FMU.
            pub fn scenario(self, document: &str, file: &str) -> Result<Scenario, DocumentError> {
                match self {
                    $(Self::$name => {
                        <$name as Definition>::File::from_json(document, file).map($name::scenario)
                    })*
                }
            }
        }
    };
}
pub(crate) use fmus;

impl crate::Fmu {
    /// The FMU's name, which is also its archive's and its `modelIdentifier`.
    #[must_use]
    pub fn name(self) -> &'static str {
        self.table().model_name
    }

    /// Whether it is a vehicle that is steered.
    #[must_use]
    pub fn is_plant(self) -> bool {
        self.role() == Role::Vehicle
    }
}
