//! Shared code of the plants: flags, kinds of dependencies, and states of a pose.

use fmi2_export::{Log, StateSpec};
use model_description::DependencyKind;
use serde::{Deserialize, Serialize};
use steerwright_models::sensitivity::Factor;

/// State besides that of the model.
#[derive(Debug, Clone, Copy, Default, Serialize, Deserialize)]
pub(crate) struct Flags {
    /// Whether initialization mode was left.
    pub(crate) started: bool,
    pub(crate) speed_rate: HeldInput,
}

/// The derivative of an input that the plant holds within a step: that it has no effect is logged once.
#[derive(Debug, Clone, Copy, Default, Serialize, Deserialize)]
pub(crate) struct HeldInput {
    given: bool,
    warned: bool,
}

impl HeldInput {
    /// Stores whether the derivative is not zero.
    pub(crate) fn set(&mut self, derivative: f64) {
        self.given = derivative != 0.0;
    }

    /// Warns before the first step in which it would have mattered, with the input's name.
    #[inline]
    pub(crate) fn warn(&mut self, name: &str, log: &mut Log) {
        if self.given && !self.warned {
            self.warned = true;
            log.warning(format!(
                "the derivative of {name} has no effect: the {name} is held within a step"
            ));
        }
    }
}

/// The word of the standard (2.2.8) for how a factor can change.
pub(crate) const fn kind(factor: Factor) -> DependencyKind {
    match factor {
        Factor::Constant(_) => DependencyKind::Constant,
        Factor::Fixed(_) => DependencyKind::Fixed,
        Factor::Dependent(_) => DependencyKind::Dependent,
    }
}

/// A state whose start value can be set.
pub(crate) fn settable(
    description: impl Into<String>,
    unit: Option<&'static str>,
    derivative_unit: Option<&'static str>,
) -> StateSpec {
    StateSpec { description: description.into(), unit, derivative_unit, settable: true }
}

/// Yaw, x and y, which follow from `initial_yaw`, `initial_x` and `initial_y`.
pub(crate) fn pose() -> [StateSpec; 3] {
    [("yaw, not wrapped", "rad", "rad/s"), ("position x", "m", "m/s"), ("position y", "m", "m/s")]
        .map(|(description, unit, derivative_unit)| StateSpec {
            description: description.into(),
            unit: Some(unit),
            derivative_unit: Some(derivative_unit),
            settable: false,
        })
}
