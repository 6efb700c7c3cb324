//! Start values of the FMUs of a loop.

use crate::Fmu;
use crate::archive::Packed;
use model_description::{Causality, Value};
use steerwright_formats::{Path, Start};
use steerwright_host::Connection;

/// Start pose and speed on a road, for the variables that the FMU has. A plant that moves by itself (`drives`) starts at
/// the speed of the profile there; without one, and without a profile, the speed is that which the path was made for.
#[must_use]
pub fn start_values(packed: &Packed, path: &Path, drives: bool) -> Vec<(String, f64)> {
    let Some(first) = path.points.first() else { return Vec::new() };
    let profile = path.profile.as_ref().and_then(|profile| profile.points.first());
    let speed = match profile {
        Some(point) if drives => point.speed_mps,
        _ => path.speed_mps,
    };
    let wanted = [
        ("initial_x", Causality::Parameter, first.x_m),
        ("initial_y", Causality::Parameter, first.y_m),
        ("initial_yaw", Causality::Parameter, first.heading_rad),
        ("initial_speed", Causality::Parameter, speed),
        ("speed", Causality::Input, speed),
    ];
    let has = |name, causality| {
        packed.description.variable(name).is_some_and(|v| v.causality == causality)
    };
    let taken = wanted.into_iter().filter(|(name, causality, _)| has(name, *causality));
    taken.map(|(name, _, value)| (name.to_owned(), value)).collect()
}

/// Default period of the fixes, s.
const FIX_PERIOD: f64 = 0.1;

/// Default standard deviation of the fixes, m: a receiver with corrections.
const FIX_STD: f64 = 0.02;

/// Parameters of a pose estimator whose fixes are the connected position of a plant: periodic, without
/// latency, of the centre of gravity.
#[must_use]
pub fn receiver_values(packed: &Packed, connections: &[Connection]) -> Vec<(String, f64)> {
    let name = packed.fmu.name();
    let from_plant = |c: &Connection| c.to == name && c.input == "gnss_x" && c.output == "x";
    if packed.fmu != Fmu::PoseEstimator || !connections.iter().any(from_plant) {
        return Vec::new();
    }
    let stated = |name: &str, otherwise: f64| {
        let start = packed.description.variable(name).and_then(|v| v.start.as_ref());
        match start {
            Some(Value::Real(value)) if *value > 0.0 => *value,
            _ => otherwise,
        }
    };
    [
        ("gnss_std", stated("gnss_std", FIX_STD)),
        ("gnss_period", stated("gnss_period", FIX_PERIOD)),
        ("gnss_latency", 0.0),
        ("antenna_x", 0.0),
        ("antenna_y", 0.0),
    ]
    .map(|(name, value)| (name.to_owned(), value))
    .into()
}

/// The parameter of the speed at which the others of the sideslip hold.
pub const REFERENCE_SPEED: &str = "sideslip_reference_speed";

/// The plant's sideslip, for an FMU that uses one and states none: `sideslip` names the
/// parameters, of which the FMU takes those that it has. All or nothing, since they belong together. The
/// reference speed matters where the sideslip follows the speed.
#[must_use]
pub fn sideslip_values(packed: &Packed, sideslip: &[(&str, f64)]) -> Vec<(String, f64)> {
    let start = |name: &str| packed.description.variable(name).map(|v| v.start.as_ref());
    let states_one = |(name, _): &(&str, f64)| {
        *name != REFERENCE_SPEED
            && matches!(start(name), Some(Some(Value::Real(value))) if *value != 0.0)
    };
    if sideslip.iter().any(states_one) {
        return Vec::new();
    }
    let over_speed = sideslip.iter().any(|(name, value)| *name == "distance_rear" && *value != 0.0);
    let taken = sideslip.iter().filter(|(name, value)| {
        *value != 0.0 && start(name).is_some() && (over_speed || *name != REFERENCE_SPEED)
    });
    taken.map(|(name, value)| ((*name).to_owned(), *value)).collect()
}

/// Those of the values that the FMU does not start with by itself.
#[must_use]
pub fn own_start(packed: &Packed, values: &[(String, f64)]) -> Option<Start> {
    let differs = |(name, value): &&(String, f64)| {
        let start = packed.description.variable(name).and_then(|v| v.start.as_ref());
        start != Some(&Value::Real(*value))
    };
    let missing: Vec<_> = values.iter().filter(differs).cloned().collect();
    if missing.is_empty() { None } else { Some(Start::new(missing.into_iter().collect())) }
}
