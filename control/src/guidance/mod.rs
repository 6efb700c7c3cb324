//! How a path follower is set up around a designed yaw loop.

pub(crate) mod demand;
pub(crate) mod track;

use crate::Error;
use crate::guidance::demand::largest_rate;
use crate::model::model_sideslip;
use crate::plants::family::SteadyTurn;
use steerwright_formats::{Guidance, GuidanceAdvice, GuidanceEntry, Model, Pid};
use steerwright_models::Sideslip;
use steerwright_models::files::{guidance_over_speed, guidance_parameters};

/// Look-ahead time over the lag of the yaw loop: with a loop of the response `1/(1 + λs)` the
/// cross-track error follows `λ·T·s² + T·s + 1`, damped by ½·√(T/λ): 1 for T = 4λ. An error of the heading or of the
/// sideslip leaves a cross-track error in proportion to T.
const LOOKAHEAD_PER_LAG: f64 = 4.0;
/// Shortest look-ahead time, s.
const LEAST_LOOKAHEAD: f64 = 0.8;
/// A cross-track error of so many metres is removed with this share of the largest steering rate, which a road that
/// needs [`demand::LARGEST_SHARE`] leaves.
const REMOVED_ERROR_M: f64 = 0.2;
const RATE_SHARE: f64 = 1.0 - demand::LARGEST_SHARE;

/// Time of the sideslip's correction over the look-ahead time. With an error ϑ of the sideslip the cross-track error
/// follows `T·ė + e = Δ·r·ϑ`, and the correction closes the loop `T·s² + s + 1/τ` around it, damped by ½·√(τ/T): 1 here.
const CORRECTION_PER_LOOKAHEAD: f64 = 4.0;

/// Guidance for a controller's loop at a speed, m/s.
///
/// The sideslip is 0: [`sideslip`] returns that of a vehicle, and [`with_sideslip`] adds it.
#[must_use]
pub fn guidance_for(pid: &Pid, speed: f64) -> Guidance {
    let of_design = by_advice(pid, &pid.guidance, speed);
    let start = guidance_parameters(&of_design, speed);
    let Some(schedule) = guidance_over_speed(start, &guidance_schedule(pid)) else {
        return of_design;
    };
    schedule.parameters_at(&start, speed).guidance
}

/// Guidance over speed for a controller's loop; empty where one set of gains holds at every speed.
#[must_use]
pub fn guidance_schedule(pid: &Pid) -> Vec<GuidanceEntry> {
    let entries = pid.schedule.iter().map(|entry| {
        let guidance = by_advice(pid, &entry.guidance, entry.speed_mps);
        GuidanceEntry {
            speed_mps: entry.speed_mps,
            lookahead_time_s: guidance.lookahead_time_s,
            lookahead_min_m: guidance.lookahead_min_m,
            preview_time_s: guidance.preview_time_s,
            feedforward_gain_radm: guidance.feedforward_gain_radm,
            yaw_acceleration_gain_s2: guidance.yaw_acceleration_gain_s2,
            yaw_jerk_gain_s3: guidance.yaw_jerk_gain_s3,
        }
    });
    entries.collect()
}

fn by_advice(pid: &Pid, advice: &GuidanceAdvice, speed: f64) -> Guidance {
    // Delays of the outer loop count as lag.
    let late = pid.designed_for.estimator_delay_s - pid.designed_for.path_delay_s;
    let lag = advice.preview_time_s + late.max(0.0);
    let lookahead_time_s = LEAST_LOOKAHEAD.max(LOOKAHEAD_PER_LAG * lag);
    let shortest = (0.5 * lookahead_time_s * speed).clamp(2.0, 5.0);
    let lookahead_min_m = shortest.max(lookahead_by_rate(pid, speed));
    Guidance {
        lookahead_time_s: (lookahead_time_s * 100.0).round() / 100.0,
        lookahead_min_m,
        preview_time_s: advice.preview_time_s,
        feedforward_gain_radm: advice.feedforward_gain_radm,
        yaw_acceleration_gain_s2: advice.yaw_acceleration_gain_s2,
        yaw_jerk_gain_s3: advice.yaw_jerk_gain_s3,
        sideslip_correction_time_s: CORRECTION_PER_LOOKAHEAD
            * lookahead_time_s.max(lookahead_min_m / speed),
        ..Guidance::default()
    }
}

/// Look-ahead length with which an error of [`REMOVED_ERROR_M`] is removed without more than its share of the steering
/// rate, m. With a double pole at 2/T, T = Δ/v, an error e₀ has a third derivative of at most `2·e₀·(2/T)³` after it has
/// been noticed, which a steering angle L per curvature makes a steering rate of `16·L·v·e₀/Δ³`.
fn lookahead_by_rate(pid: &Pid, speed: f64) -> f64 {
    let slow = SteadyTurn::new(pid).slow;
    let rate = RATE_SHARE * largest_rate(pid);
    (16.0 * slow.max(0.0) * speed * REMOVED_ERROR_M / rate).cbrt()
}

/// The guidance of a vehicle with a sideslip, at the speed (m/s) of the path.
#[must_use]
pub fn with_sideslip(guidance: Guidance, sideslip: &Sideslip, speed: f64) -> Guidance {
    let here = sideslip.at_speed(speed);
    Guidance {
        sideslip_per_yaw_rate_s: here.per_yaw_rate,
        sideslip_per_yaw_acceleration_s2: here.per_yaw_acceleration,
        sideslip_growth_s5pm2: here.growth,
        distance_rear_m: here.distance_rear,
        ..guidance
    }
}

/// The sideslip of a model's document as [`model_sideslip`] has it, at a speed (m/s), by default the document's. `None`
/// where the document is none of a model, or states none.
///
/// # Errors
/// [`Error::Document`] where a document of these kinds is invalid.
pub fn sideslip(document: &str, file: &str, speed: Option<f64>) -> Result<Option<Sideslip>, Error> {
    if !Model::is_in(document) {
        return Ok(None);
    }
    let stated = model_sideslip(&Model::from_json(document, file)?, speed)?;
    Ok(stated.map(|s| s.at_speed(speed.unwrap_or(s.reference_speed))))
}
