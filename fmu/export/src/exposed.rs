//! The states that every slave with [`Slave::states`](crate::Slave::states) exposes: state i is
//! `state[i+1]` and `der(state[i+1])`, with value references above those of tables.

use crate::Slave;
use crate::calls::Class;

/// The first value reference that belongs to states; tables stay below it.
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
    /// What a reference means, given which states are settable.
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
            Self::State { settable: false, .. } => Class::FollowingState,
            Self::Derivative { .. } => Class::Derivative,
        }
    }

    pub(crate) fn name(self) -> String {
        match self {
            Self::State { index, .. } => format!("state[{}]", index + 1),
            Self::Derivative { index } => format!("der(state[{}])", index + 1),
        }
    }

    pub(crate) fn value<S: Slave>(self, slave: &mut S) -> f64 {
        match self {
            Self::State { index, .. } => slave.state(index),
            Self::Derivative { index } => slave.state_derivative(index),
        }
    }

    pub(crate) fn set<S: Slave>(self, slave: &mut S, value: f64) {
        if let Self::State { index, .. } = self {
            slave.set_state(index, value);
        }
    }
}
