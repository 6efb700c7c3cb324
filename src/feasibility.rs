//! Warnings before a road is driven: it needs more than the controller has, or another speed.

use crate::failure::Failure;
use steerwright_control::{Demand, OtherSpeed, Quantity, demands, paths};
use steerwright_formats::{Model, Path as PathFile, Pid};

/// Largest lateral acceleration of the standard road of a design, m/s²: that of `path` and `build`.
const STANDARD_ACCELERATION: f64 = 4.0;

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
        let acceleration = model.and_then(steerwright_control::evidence_acceleration);
        let needed = demands(path, pid, acceleration)?;
        let excessive = needed.iter().filter(|demand| demand.is_excessive());
        warnings.extend(excessive.map(|demand| format!("the road {demand}")));
        let is_acceleration = |demand: &Demand| demand.quantity == Quantity::LateralAcceleration;
        let note = (!needed.iter().any(is_acceleration)).then(|| {
            "the lateral acceleration is compared with no limit: neither the controller nor the evidence of the \
             model (--plant vehicle.json) states one"
                .to_owned()
        });
        Ok(Self { warnings, note })
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

/// Warnings of a design about the standard road at its speed.
pub(crate) fn on_standard_road(pid: &Pid, model: &Model) -> Result<Vec<String>, Failure> {
    let speed = pid.designed_for.speed_mps;
    // A road of this lateral acceleration has no lane change at the lowest speeds.
    let Ok(mut road) = paths::reference_road(speed, STANDARD_ACCELERATION) else {
        return Ok(Vec::new());
    };
    let sideslip = steerwright_control::model_sideslip(model, Some(speed))?.unwrap_or_default();
    let guidance = steerwright_control::guidance_for(pid, speed);
    road.guidance = steerwright_control::with_sideslip(guidance, &sideslip, speed);
    let needed = demands(&road, pid, steerwright_control::evidence_acceleration(model))?;
    let excessive = needed.iter().filter(|demand| demand.is_excessive());
    let road = format!("the standard road of {STANDARD_ACCELERATION} m/s² at {speed:.1} m/s");
    Ok(excessive.map(|demand| format!("{road} {demand}")).collect())
}
