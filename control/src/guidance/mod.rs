//! How a path follower is set up around a designed yaw loop.

pub(crate) mod track;

use crate::Error;
use steerwright_formats::{Bicycle, Document, Guidance, Pid, Plant};
pub use steerwright_models::Sideslip;

/// Look-ahead time over the lag of the yaw loop: with a loop of the response `1/(1 + λs)` the
/// cross-track error follows `λ·T·s² + T·s + 1`, damped by ½·√(T/λ): 1 for T = 4λ.
const LOOKAHEAD_PER_LAG: f64 = 4.0;
/// Shortest look-ahead time, s.
const LEAST_LOOKAHEAD: f64 = 1.0;

/// Guidance for a controller's loop at a speed.
///
/// The sideslip is 0: [`sideslip`] returns that of a vehicle, and [`with_sideslip`] adds it.
#[must_use]
pub fn guidance_for(pid: &Pid, speed: f64) -> Guidance {
    let advice = &pid.guidance;
    // Delays of the outer loop count as lag.
    let late = pid.designed_for.estimator_delay_s - pid.designed_for.path_delay_s;
    let lag = advice.preview_time_s + late.max(0.0);
    let lookahead_time_s = LEAST_LOOKAHEAD.max(LOOKAHEAD_PER_LAG * lag);
    Guidance {
        lookahead_time_s: (lookahead_time_s * 100.0).round() / 100.0,
        lookahead_min_m: (0.5 * lookahead_time_s * speed).clamp(2.0, 5.0),
        preview_time_s: advice.preview_time_s,
        feedforward_gain_radm: advice.feedforward_gain_radm,
        yaw_acceleration_gain_s2: advice.yaw_acceleration_gain_s2,
        yaw_jerk_gain_s3: advice.yaw_jerk_gain_s3,
        ..Guidance::default()
    }
}

/// The guidance of a vehicle with a sideslip, at the speed (m/s) of the path.
#[must_use]
pub fn with_sideslip(guidance: Guidance, sideslip: &Sideslip, speed: f64) -> Guidance {
    let here = sideslip.at(speed);
    Guidance {
        sideslip_per_yaw_rate_s: here.per_yaw_rate,
        sideslip_per_yaw_acceleration_s2: here.per_yaw_acceleration,
        sideslip_growth_s5pm2: here.growth,
        distance_rear_m: here.distance_rear,
        ..guidance
    }
}

/// The sideslip that a plant's document states: the measured one of `plant.json`, or that of the model in
/// `bicycle.json`; at a speed (m/s), by default the document's. `None` where the document states none.
///
/// # Errors
/// [`Error::Document`] where a document of these kinds is invalid.
pub fn sideslip(document: &str, file: &str, speed: Option<f64>) -> Result<Option<Sideslip>, Error> {
    match steerwright_formats::schema_of(document).as_deref() {
        Some(Plant::SCHEMA) => {
            let stated = plant_sideslip(&Plant::from_json(document, file)?);
            Ok(stated.map(|s| s.at(speed.unwrap_or(s.reference_speed))))
        }
        Some(Bicycle::SCHEMA) => {
            let vehicle = Bicycle::from_json(document, file)?.vehicle;
            let speed = speed.unwrap_or(vehicle.speed_mps);
            let parameters = steerwright_loading::bicycle_parameters(&vehicle);
            Ok((speed > 0.0).then(|| parameters.sideslip(speed)))
        }
        _ => Ok(None),
    }
}

/// The sideslip of an identified plant, where it was measured.
#[must_use]
pub fn plant_sideslip(plant: &Plant) -> Option<Sideslip> {
    steerwright_loading::sideslip(plant)
}
