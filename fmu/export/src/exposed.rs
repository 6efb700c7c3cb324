//! The exposed states of a unit with [`CoSimulationUnit::states`](crate::CoSimulationUnit::states): state i has the
//! variables `state[i+1]` and `der(state[i+1])`, with value references above those of the table.

use crate::access_rules::Class;
use crate::unit::CoSimulationUnit;

/// The first value reference of the states; the value references of tables are smaller.
pub(crate) const FIRST: u32 = 0x1000_0000;

/// The value reference of `state[index + 1]`.
#[must_use]
pub const fn state_reference(index: u32) -> u32 {
    FIRST + 2 * index
}

/// The value reference of `der(state[index + 1])`.
#[must_use]
pub const fn derivative_reference(index: u32) -> u32 {
    FIRST + 2 * index + 1
}

/// A state or its derivative, by index from 0.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Exposed {
    State { index: usize, settable: bool },
    Derivative { index: usize },
}

impl Exposed {
    /// The state or derivative with a value reference; `settable` has a flag for each state.
    pub(crate) fn find(reference: u32, settable: &[bool]) -> Option<Self> {
        let place = reference.checked_sub(FIRST)?;
        let index = usize::try_from(place / 2).ok()?;
        let settable = *settable.get(index)?;
        Some(if place % 2 == 0 {
            Self::State { index, settable }
        } else {
            Self::Derivative { index }
        })
    }

    pub(crate) const fn class(self) -> Class {
        match self {
            Self::State { settable: true, .. } => Class::SettableState,
            Self::State { settable: false, .. } => Class::CalculatedState,
            Self::Derivative { .. } => Class::Derivative,
        }
    }

    pub(crate) fn name(self) -> String {
        match self {
            Self::State { index, .. } => format!("state[{}]", index + 1),
            Self::Derivative { index } => format!("der(state[{}])", index + 1),
        }
    }

    pub(crate) fn value<S: CoSimulationUnit>(self, unit: &mut S) -> f64 {
        match self {
            Self::State { index, .. } => unit.state(index),
            Self::Derivative { index } => unit.state_derivative(index),
        }
    }

    pub(crate) fn set<S: CoSimulationUnit>(self, unit: &mut S, value: f64) {
        if let Self::State { index, .. } = self {
            unit.set_state(index, value);
        }
    }
}
