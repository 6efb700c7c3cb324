//! Where in a description a rule is breached. Positions count from 0 in document order.

use crate::description::{ModelDescription, Unknown};
use crate::vocabulary::words;

/// The element that a finding is about.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[allow(missing_docs)] // named as the elements; numbers are positions
pub enum FindingPlace {
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

words! {
    /// The lists of `ModelStructure`.
    #[allow(missing_docs)]
    List {
        Outputs = "Outputs",
        Derivatives = "Derivatives",
        InitialUnknowns = "InitialUnknowns",
    }
}

impl List {
    /// Its entries.
    #[must_use]
    pub fn unknowns(self, description: &ModelDescription) -> &[Unknown] {
        match self {
            Self::Outputs => &description.outputs,
            Self::Derivatives => &description.derivatives,
            Self::InitialUnknowns => &description.initial_unknowns,
        }
    }
}
