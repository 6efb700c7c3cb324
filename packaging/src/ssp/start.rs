//! What the FMUs of a loop start with: at the first point of the road, along it, at its speed.

use crate::Packed;
use formats::{Path, Start};
use model_description::{Causality, Value};

/// The pose and speed with which an FMU starts on a road, as far as it has variables for them.
#[must_use]
pub fn start_values(packed: &Packed, path: &Path) -> Vec<(String, f64)> {
    let Some(first) = path.points.first() else { return Vec::new() };
    let wanted = [
        ("initial_x", Causality::Parameter, first.x_m),
        ("initial_y", Causality::Parameter, first.y_m),
        ("initial_yaw", Causality::Parameter, first.heading_rad),
        ("speed", Causality::Input, path.speed_mps),
    ];
    let has = |name, causality| {
        packed.description.variable(name).is_some_and(|v| v.causality == causality)
    };
    let taken = wanted.into_iter().filter(|(name, causality, _)| has(name, *causality));
    taken.map(|(name, _, value)| (name.to_owned(), value)).collect()
}

/// Those of the values that the FMU does not start with by itself.
#[must_use]
pub fn own_start(packed: &Packed, values: &[(String, f64)]) -> Option<Start> {
    let differs = |(name, value): &&(String, f64)| {
        let start = packed.description.variable(name).and_then(|v| v.start.as_ref());
        start != Some(&Value::Real(*value))
    };
    let missing: Vec<_> = values.iter().filter(differs).cloned().collect();
    (!missing.is_empty()).then(|| Start::new(missing.into_iter().collect()))
}
