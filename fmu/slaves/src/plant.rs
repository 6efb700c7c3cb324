//! What the glue of the plants shares: kinds of dependencies, and states of a pose.

use fmi2_export::StateSpec;
use model_description::DependencyKind;
use vehicle_models::sensitivity::Factor;

/// Said once where the derivative of a speed is set.
pub(crate) const SPEED_IS_HELD: &str =
    "the derivative of speed has no effect: the speed is held within a step";

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
