//! Warnings before a road is driven: it needs more than the controller has, or another speed.

use crate::failure::Failure;
use steerwright_control::{Demand, OtherSpeed, Quantity, demands, paths};
use steerwright_formats::{Model, Path as PathFile, Pid, SpeedProfile};

/// Largest lateral acceleration of the standard road of a design, m/s²: that of `path` and `build`.
pub(crate) const STANDARD_ACCELERATION: f64 = 4.0;

/// What is reported of a controller on a path.
#[derive(Default)]
pub(crate) struct Feasibility {
    pub(crate) warnings: Vec<String>,
    /// What could not be compared, and why.
    pub(crate) note: Option<String>,
}

impl Feasibility {
    /// Of a path with the guidance of the controller; `model` is that of the vehicle, where it is known.
    pub(crate) fn new(path: &PathFile, pid: &Pid, model: Option<&Model>) -> Result<Self, Failure> {
        let mut warnings = Vec::new();
        if let Some(other) = OtherSpeed::find(pid, path.speed_mps) {
            warnings.push(of_speed(&other));
        }
        if let Some(profile) = &path.profile {
            // The profile keeps to the limits; no constant speed is driven.
            warnings.extend(above_design(pid, profile));
            return Ok(Self { warnings, note: None });
        }
        let acceleration = model.and_then(steerwright_control::evidence_acceleration);
        let needed = demands(path, pid, acceleration)?;
        let excessive = needed.iter().filter(|demand| demand.is_excessive());
        warnings.extend(excessive.map(|demand| format!("the road {demand}")));
        let is_acceleration = |demand: &Demand| demand.quantity == Quantity::LateralAcceleration;
        let note = if needed.iter().any(is_acceleration) {
            None
        } else {
            Some("the lateral acceleration is compared with no limit: neither the controller nor the evidence of the \
             model (--plant vehicle.json) states one"
                .to_owned())
        };
        Ok(Self { warnings, note })
    }
}

/// A profile that is faster than the controller was designed for.
fn above_design(pid: &Pid, profile: &SpeedProfile) -> Option<String> {
    let speeds = profile.points.iter().map(|point| point.speed_mps);
    let other = OtherSpeed::find(pid, speeds.fold(0.0, f64::max))?;
    let [_, highest] = other.design_mps;
    if other.path_mps > highest {
        Some(format!(
            "the profile reaches {:.1} m/s, the controller is for {highest:.1} m/s: design it for a range (design \
             --speeds), or limit the profile with --max-speed {highest:.2}m/s",
            other.path_mps
        ))
    } else {
        None
    }
}

fn of_speed(other: &OtherSpeed) -> String {
    let [lowest, highest] = other.design_mps;
    let nearest = other.path_mps.clamp(lowest, highest);
    format!(
        "{other}: design it for {:.1} m/s (design --speeds for a range), or make the path with --speed \
         {nearest:.2}m/s",
        other.path_mps
    )
}

/// Warnings of a design about the standard road at the speeds that it was designed for: of each quantity, at the speed at
/// which the road needs most of it.
pub(crate) fn on_standard_road(pid: &Pid, model: &Model) -> Result<Vec<String>, Failure> {
    let mut speeds: Vec<f64> = pid.schedule.iter().map(|entry| entry.speed_mps).collect();
    if speeds.is_empty() {
        speeds.push(pid.designed_for.speed_mps);
    }
    let mut worst: Vec<(f64, Demand)> = Vec::new();
    for speed_mps in speeds {
        for demand in demands_of_standard_road(pid, model, speed_mps)? {
            match worst.iter_mut().find(|(_, other)| other.quantity == demand.quantity) {
                Some(largest) if demand.share() > largest.1.share() => {
                    *largest = (speed_mps, demand)
                }
                Some(_) => {}
                None => worst.push((speed_mps, demand)),
            }
        }
    }
    let excessive = worst.iter().filter(|(_, demand)| demand.is_excessive());
    let road = format!("the standard road of {STANDARD_ACCELERATION} m/s² at");
    Ok(excessive.map(|(speed, demand)| format!("{road} {speed:.1} m/s {demand}")).collect())
}

/// None at the lowest speeds, at which a road of this lateral acceleration has no lane change.
fn demands_of_standard_road(
    pid: &Pid,
    model: &Model,
    speed_mps: f64,
) -> Result<Vec<Demand>, Failure> {
    let Ok(mut road) = paths::reference_road(speed_mps, STANDARD_ACCELERATION) else {
        return Ok(Vec::new());
    };
    let sideslip = steerwright_control::model_sideslip(model, Some(speed_mps))?.unwrap_or_default();
    let guidance = steerwright_control::guidance_for(pid, speed_mps);
    road.guidance = steerwright_control::with_sideslip(guidance, &sideslip, speed_mps);
    Ok(demands(&road, pid, steerwright_control::evidence_acceleration(model))?)
}
