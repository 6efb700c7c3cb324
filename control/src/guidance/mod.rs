//! How a path follower is set up around a designed yaw loop.

pub(crate) mod track;

use crate::Error;
use steerwright_formats::{Bicycle, Document, Guidance, Pid, Plant, VehicleData};

/// Look-ahead time over the lag of the yaw loop: with a loop of the response `1/(1 + λs)` the
/// cross-track error follows `λ·T·s² + T·s + 1`, damped by ½·√(T/λ): 1 for T = 4λ.
const LOOKAHEAD_PER_LAG: f64 = 4.0;
/// Shortest look-ahead time, s.
const LEAST_LOOKAHEAD: f64 = 1.0;

/// Guidance for a controller's loop at a speed.
///
/// The sideslip is 0: [`sideslip`] returns that of a vehicle, and [`Sideslip::guide`] adds it.
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
        sideslip_per_yaw_rate_s: 0.0,
        sideslip_per_yaw_acceleration_s2: 0.0,
        yaw_acceleration_gain_s2: advice.yaw_acceleration_gain_s2,
        yaw_jerk_gain_s3: advice.yaw_jerk_gain_s3,
        sideslip_growth_s5pm2: 0.0,
        cross_track_integral_gain_per_s: 0.0,
    }
}

/// The sideslip of a path follower's vehicle: `(S + Q·a²)·r + C·dr/dt` at the yaw rate r and the
/// lateral acceleration a.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Sideslip {
    /// S, s.
    pub per_yaw_rate_s: f64,
    /// C, s²; 0 where it is not known.
    pub per_yaw_acceleration_s2: f64,
    /// Q, s⁵/m²; 0 where it is not known.
    pub growth_s5pm2: f64,
}

impl Sideslip {
    /// The sideslip of an identified plant, where it was measured.
    #[must_use]
    pub fn of(plant: &Plant) -> Option<Self> {
        plant.sideslip.map(|s| Self {
            per_yaw_rate_s: s.sideslip_per_yaw_rate_s,
            per_yaw_acceleration_s2: s.per_yaw_acceleration(),
            growth_s5pm2: s.growth(),
        })
    }

    /// The sideslip of eq 13 at a speed (m/s) above zero.
    #[must_use]
    pub fn of_vehicle(vehicle: &VehicleData, speed: f64) -> Self {
        let parameters = steerwright_loading::bicycle_parameters(vehicle);
        Self {
            per_yaw_rate_s: parameters.sideslip_per_yaw_rate(speed),
            per_yaw_acceleration_s2: parameters.sideslip_per_yaw_acceleration(speed),
            growth_s5pm2: 0.0,
        }
    }

    /// The sideslip that a guidance contains.
    #[must_use]
    pub fn in_guidance(guidance: &Guidance) -> Self {
        Self {
            per_yaw_rate_s: guidance.sideslip_per_yaw_rate_s,
            per_yaw_acceleration_s2: guidance.sideslip_per_yaw_acceleration_s2,
            growth_s5pm2: guidance.sideslip_growth_s5pm2,
        }
    }

    /// The guidance of a vehicle with this sideslip.
    #[must_use]
    pub fn guide(&self, guidance: Guidance) -> Guidance {
        Guidance {
            sideslip_per_yaw_rate_s: self.per_yaw_rate_s,
            sideslip_per_yaw_acceleration_s2: self.per_yaw_acceleration_s2,
            sideslip_growth_s5pm2: self.growth_s5pm2,
            ..guidance
        }
    }
}

/// The sideslip that a plant's document states: the measured one of `plant.json`, or that of the model in
/// `bicycle.json` at a speed (m/s), by default its own. `None` where the document states none.
///
/// # Errors
/// [`Error::Document`] where a document of these kinds is invalid.
pub fn sideslip(document: &str, file: &str, speed: Option<f64>) -> Result<Option<Sideslip>, Error> {
    match steerwright_formats::schema_of(document).as_deref() {
        Some(Plant::SCHEMA) => Ok(Sideslip::of(&Plant::from_json(document, file)?)),
        Some(Bicycle::SCHEMA) => {
            let vehicle = Bicycle::from_json(document, file)?.vehicle;
            let speed = speed.unwrap_or(vehicle.speed_mps);
            Ok((speed > 0.0).then(|| Sideslip::of_vehicle(&vehicle, speed)))
        }
        _ => Ok(None),
    }
}
