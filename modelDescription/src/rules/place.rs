//! Where in a description a rule is breached. Positions count from 0 in document order.

use crate::description::{ModelDescription, Unknown};

/// The element that a finding is about.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[allow(missing_docs)] // named as the elements; numbers are positions
pub enum Place {
    Root,
    CoSimulation,
    DefaultExperiment,
    LogCategory(usize),
    Unit(usize),
    DisplayUnit { unit: usize, position: usize },
    VendorAnnotation(usize),
    Variable(usize),
    List(List),
    Unknown { list: List, position: usize },
}

/// The lists of `ModelStructure`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[allow(missing_docs)] // named as the elements
pub enum List {
    Outputs,
    Derivatives,
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
