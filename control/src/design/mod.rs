//! The design of a PID controller (eq 14) to a specification.
//!
//! ```text
//! options ──▶ objective (requirements, plants) ─┐
//!             target (bounds of a search) ──────┴▶ cost ──▶ optimiser ──▶ search
//! search ──▶ nominal ──▶ robust (over the plants of the ensemble) ──▶ design ◀── evidence
//! ```
//!
//! The evidence is computed with the gains as they are written.

mod bandwidth_limit;
mod cost;
mod ensemble;
mod evidence;
pub(crate) mod limits;
mod nominal;
mod objective;
mod optimiser;
pub(crate) mod options;
pub(crate) mod over_speed;
pub(crate) mod parallel;
mod robust;
mod search;
mod target;

use crate::Error;
use crate::closed_loop::evaluate::evidence;
use crate::closed_loop::feedforward::{Advice, ramp_lag};
use crate::design::ensemble::Ensemble;
use crate::design::evidence::advice;
use crate::design::evidence::engagement::engagement;
use crate::design::evidence::infeasibility::infeasibility;
use crate::design::evidence::no_actuator::{no_actuator, without_actuator};
use crate::design::limits::large_errors;
use crate::design::objective::Objective;
use crate::design::options::DesignOptions;
use crate::design::robust::Robust;
use crate::design::search::{FoundDesign, significant};
use crate::plants::design_plant::DesignPlant;
use std::collections::BTreeMap;
use steerwright_formats::{
    DesignedFor, Document, GuidanceAdvice, Limits, Pid, PidGains, Provenance, Requirement,
    ScheduleEntry, SourceFile,
};
use steerwright_models::PidParameters;
use steerwright_models::files::controller_parameters;

/// Designs a controller for a plant. `source` names the model's file.
///
/// Requirements that cannot be met are no error: the fastest loop that keeps the other requirements is
/// returned with its shortfalls in the evidence, and an infeasibility diagnosis in words.
///
/// # Errors
/// [`Error::Option`] and similar for options, [`Error::SampleTimeMismatch`] and similar for plants that
/// do not allow a design.
pub fn design(
    plant: &DesignPlant,
    source: &SourceFile,
    options: &DesignOptions,
) -> Result<Pid, Error> {
    options.check()?;
    let options = &options.with_actuator_of(plant);
    let plant = &plant.behind(options.actuator);
    documented(plant, source, options, Tuned::new(plant, options, &[])?, Vec::new())
}

/// The document of gains, with a table over speed or none, and with the evidence at the plant's speed.
fn documented(
    plant: &DesignPlant,
    source: &SourceFile,
    options: &DesignOptions,
    tuned: Tuned,
    schedule: Vec<ScheduleEntry>,
) -> Result<Pid, Error> {
    let Tuned { found, objective, common_settling_s, stable, gains, limits, pid, feedforward } =
        tuned;
    let ensemble = Ensemble::new(plant, options, &objective);
    let sampled = &objective.scenarios[0].plant;
    let mut evidence = evidence(sampled, plant, &pid, &objective.spec, &feedforward);
    let fixed = schedule.is_empty();
    evidence.robustness =
        ensemble.map(|e| e.evidence(&objective, &pid, &feedforward, fixed)).transpose()?;
    evidence.trade_off = nominal::trade_off(&objective, &found, options.seed)?;
    evidence.advice = infeasibility(&objective, plant, options, &found)?;
    evidence.advice.extend(advice::non_minimum_phase(plant, evidence.margins.crossover_radps));
    if options.max_rate_radps.is_none() {
        evidence.advice.push(advice::assumed_rate(limits.max_rate_radps));
    }
    evidence.advice.extend(advice::beyond_the_drive(plant, sampled, &pid, &objective.spec));
    let not_robust = evidence.robustness.iter().flat_map(|r| advice::not_robust(r, evidence.met));
    evidence.advice.extend(not_robust);
    if evidence.robustness.as_ref().is_some_and(|r| !r.met) {
        evidence.advice.extend(common_settling_s.map(advice::common_settling));
    }
    let [path_delay_s, estimator_delay_s] = options.outer_delays();
    let guidance = advised(&feedforward, options);
    let mut document = Pid {
        schema: Pid::SCHEMA.into(),
        name: format!("PID for {}", plant.name),
        sample_time_s: options.sample_time_s,
        gains,
        limits,
        designed_for: DesignedFor {
            model: plant.model.clone(),
            name: plant.name.clone(),
            sha256: source.sha256.clone(),
            speed_mps: plant.speed,
            steering_ratio: plant.steering_ratio,
            loop_delay_s: options.loop_delay_s,
            path_delay_s,
            estimator_delay_s,
            actuator: plant.actuator,
            quality: plant.quality.clone(),
        },
        specification: objective.spec,
        guidance,
        schedule,
        evidence,
        provenance: provenance(source, options),
    };
    if stable {
        document.evidence.engagement = engagement(plant, &document)?;
    }
    if let Some(reason) = no_actuator(plant, &document)? {
        document.designed_for.quality = without_actuator(document.designed_for.quality, reason);
    }
    document.checked("the designed controller")?;
    Ok(document)
}

/// The gains found for a plant, with the limits and the settings of a path follower that belong to them.
pub(crate) struct Tuned {
    found: FoundDesign,
    objective: Objective,
    common_settling_s: Option<f64>,
    stable: bool,
    gains: PidGains,
    limits: Limits,
    pid: PidParameters,
    feedforward: Advice,
}

impl Tuned {
    /// `near` holds gains of nearly the same plants, where there are any.
    fn new(
        plant: &DesignPlant,
        options: &DesignOptions,
        near: &[PidParameters],
    ) -> Result<Self, Error> {
        let objective = Objective::new(plant, options)?;
        let Robust { found, objective, common_settling_s } =
            match &Ensemble::new(plant, options, &objective) {
                Some(ensemble) => ensemble.find(objective, near)?,
                None => {
                    let found = nominal::find(&objective, options.seed, false)?;
                    Robust { found, objective, common_settling_s: None }
                }
            };
        let sampled = &objective.scenarios[0].plant;
        let stable = found.reached.margins.modulus_margin > 0.0;
        // Neither large errors nor the lag behind a ramp are defined for an unstable loop.
        let large_errors =
            if stable { Some(large_errors(sampled, &found.pid, &objective.spec)) } else { None };
        let limits = Limits { large_errors, ..objective.limits };
        let gains = found.pid.gains;
        let pid = controller_parameters(&gains, &limits, options.sample_time_s);
        let lag = if stable { ramp_lag(plant.gain(), sampled, &pid).max(0.0) } else { 0.0 };
        let feedforward =
            Advice::with_preview(&pid, plant.gain(), plant.speed, significant(lag, 4));
        let feedforward =
            if stable { feedforward.on_roads(&pid, sampled, plant.speed) } else { feedforward };
        let feedforward = Advice {
            feedforward_gain: significant(feedforward.feedforward_gain, 5),
            yaw_acceleration_gain: significant(feedforward.yaw_acceleration_gain, 4),
            yaw_jerk_gain: significant(feedforward.yaw_jerk_gain, 4),
            ..feedforward
        };
        Ok(Self { found, objective, common_settling_s, stable, gains, limits, pid, feedforward })
    }
}

/// Settings of a path follower around the loop.
fn advised(feedforward: &Advice, options: &DesignOptions) -> GuidanceAdvice {
    let [path_delay_s, _] = options.outer_delays();
    GuidanceAdvice {
        feedforward_gain_radm: feedforward.feedforward_gain,
        // The loop through the path is later than the yaw loop; the path is read as much further ahead.
        preview_time_s: feedforward.preview_time + (path_delay_s - options.loop_delay_s),
        yaw_acceleration_gain_s2: feedforward.yaw_acceleration_gain,
        yaw_jerk_gain_s3: feedforward.yaw_jerk_gain,
    }
}

fn provenance(source: &SourceFile, options: &DesignOptions) -> Provenance {
    let mut all: BTreeMap<String, String> = Requirement::ALL
        .into_iter()
        .filter_map(|r| Some((r.name().to_owned(), r.required(&options.requirements)?.to_string())))
        .collect();
    for (key, value) in [
        ("max_lateral_acceleration_mps2", options.max_lateral_acceleration_mps2),
        ("sample_time_s", options.sample_time_s),
        ("loop_delay_s", options.loop_delay_s),
        ("path_delay_s", options.path_delay_s),
        ("estimator_delay_s", options.estimator_delay_s),
    ] {
        all.insert(key.into(), value.to_string());
    }
    for (key, value) in [
        ("max_angle_rad", options.max_angle_rad),
        ("max_increment_rad", options.max_increment_rad),
        ("max_rate_radps", options.max_rate_radps),
    ] {
        all.insert(key.into(), value.map_or("default".into(), |v| v.to_string()));
    }
    if let Some(actuator) = options.actuator {
        all.insert("actuator_lag_s".into(), actuator.time_constant_s.to_string());
        all.insert("actuator_delay_s".into(), actuator.delay_s.to_string());
    }
    let robust = options.robust.map_or("off".into(), |r| {
        format!("{} plants, {} s, {} of the speed", r.members, r.latency_s, r.speed_share)
    });
    all.insert("robust".into(), robust);
    all.insert("seed".into(), options.seed.to_string());
    Provenance {
        version: env!("CARGO_PKG_VERSION").into(),
        sources: vec![source.clone()],
        options: all,
    }
}
