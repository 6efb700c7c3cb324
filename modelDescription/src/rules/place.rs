//! Where in a description a rule is breached. Positions count from 0 in document order.

use crate::description::{ModelDescription, Unknown};

/// The element that a finding is about.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Place {
    /// `fmiModelDescription`.
    Root,
    /// `CoSimulation`.
    CoSimulation,
    /// `DefaultExperiment`.
    DefaultExperiment,
    /// A `Category` of `LogCategories`.
    LogCategory(usize),
    /// A `Unit` of `UnitDefinitions`.
    Unit(usize),
    /// A `DisplayUnit` of a `Unit`.
    DisplayUnit {
        /// Position of the unit.
        unit: usize,
        /// Position within the unit.
        position: usize,
    },
    /// A `Tool` of `VendorAnnotations`.
    VendorAnnotation(usize),
    /// A `ScalarVariable`.
    Variable(usize),
    /// A list of `ModelStructure`.
    List(List),
    /// An `Unknown` of a list of `ModelStructure`.
    Unknown {
        /// The list.
        list: List,
        /// Position within the list.
        position: usize,
    },
}

/// The lists of `ModelStructure`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum List {
    /// `Outputs`.
    Outputs,
    /// `Derivatives`.
    Derivatives,
    /// `InitialUnknowns`.
    InitialUnknowns,
}

impl List {
    /// The element's name.
    #[must_use]
    pub const fn as_str(self) -> &'static str {
        match self {
            Self::Outputs => "Outputs",
            Self::Derivatives => "Derivatives",
            Self::InitialUnknowns => "InitialUnknowns",
        }
    }

    /// Its entries.
    #[must_use]
    pub fn of(self, description: &ModelDescription) -> &[Unknown] {
        match self {
            Self::Outputs => &description.outputs,
            Self::Derivatives => &description.derivatives,
            Self::InitialUnknowns => &description.initial_unknowns,
        }
    }
}

impl std::fmt::Display for List {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(self.as_str())
    }
}
