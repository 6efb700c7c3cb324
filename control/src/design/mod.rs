//! The design of a PID controller (eq 14) to a specification.
//!
//! On the nominal plant first (`nominal`), then for all plants that it may stand for (`robust`); the
//! evidence is that of the gains as they are written.

mod aim;
mod beyond;
mod blocked;
mod breaking;
mod cost;
mod evolve;
mod large_errors;
mod nominal;
mod objective;
pub(crate) mod optimise;
pub(crate) mod options;
mod over_plants;
mod quickest;
mod robust;
mod search;
mod simplex;
mod trade_off;

use crate::Error;
use crate::closed_loop::evaluate::evidence;
use crate::design::beyond::beyond_the_drive;
use crate::design::blocked::{blocked, wrong_way};
use crate::design::large_errors::large_errors;
use crate::design::objective::Objective;
use crate::design::options::DesignOptions;
use crate::design::robust::{Ensemble, Robust};
use crate::design::search::significant;
use crate::design::trade_off::trade_off;
use crate::guidance::advice::{Advice, ramp_lag};
use crate::guidance::engagement::engagement;
use crate::plants::DesignPlant;
use crate::requirement::Requirement;
use formats::{
    DesignedFor, Document, GuidanceAdvice, Limits, Pid, PidGains, Provenance, Robustness,
    SourceFile,
};
use std::collections::BTreeMap;
use vehicle_models::PidParameters;

/// Designs a controller for a plant. `source` names the model's file.
///
/// Requirements that cannot be met do not fail the design: the quickest loop that keeps the other
/// requirements is returned with its shortfalls in the evidence, and what blocks them in words.
///
/// # Errors
/// [`Error::Option`] and its like for options and plants that no design can start from.
pub fn design(
    plant: &DesignPlant,
    source: &SourceFile,
    options: &DesignOptions,
) -> Result<Pid, Error> {
    options.check()?;
    let objective = Objective::new(plant, options)?;
    let ensemble = options.robust.map(|r| Ensemble::new(plant, options, r, objective.scale));
    let Robust { found, objective, kept_by } = match &ensemble {
        Some(ensemble) => ensemble.find(objective)?,
        None => {
            let found = nominal::find(&objective, options.seed, false)?;
            Robust { found, objective, kept_by: None }
        }
    };
    let sampled = &objective.scenarios[0].plant;
    let stable = found.reached.margins.modulus_margin > 0.0;
    // A loop that is unstable has no large errors to speak of.
    let large = stable.then(|| large_errors(sampled, &found.pid, &objective.spec));
    let limits = Limits { large_errors: large, ..objective.limits };
    let pid = large.map_or(found.pid, |l| PidParameters {
        max_yaw_error: l.max_yaw_error_rad,
        sustained_rate: l.sustained_rate_radps,
        rate_reserve_time: l.rate_reserve_time_s,
        ..found.pid
    });
    let lag = if stable {
        ramp_lag(plant.gain(), sampled, &pid).max(0.0)
    } else {
        // The lag of an unstable loop is no number to advise.
        0.0
    };
    let advice = Advice::with_preview(&pid, plant.gain(), plant.speed, significant(lag, 4));
    let advice = match stable {
        true => advice.on_roads(&pid, sampled, plant.speed),
        false => advice,
    };
    let advice = Advice {
        feedforward_gain: significant(advice.feedforward_gain, 5),
        yaw_acceleration_gain: significant(advice.yaw_acceleration_gain, 4),
        yaw_jerk_gain: significant(advice.yaw_jerk_gain, 4),
        ..advice
    };
    let mut evidence = evidence(sampled, plant, &pid, &objective.spec, &advice);
    evidence.robustness = ensemble.map(|e| e.evidence(&objective, &pid, &advice)).transpose()?;
    evidence.trade_off = trade_off(&objective, &found, options.seed)?;
    evidence.advice = blocked(&objective, plant, options, &found)?;
    evidence.advice.extend(wrong_way(plant, evidence.margins.crossover_radps));
    if options.max_rate_radps.is_none() {
        evidence.advice.push(format!(
            "no rate of the steering was stated: the loop is designed for {:.0}°/s, twice the fastest \
             steering of the drive",
            objective.limits.max_rate_radps.to_degrees()
        ));
    }
    evidence.advice.extend(beyond_the_drive(plant, sampled, &pid, &objective.spec));
    let not_kept = evidence.robustness.iter().flat_map(|r| not_everywhere(r, evidence.met));
    evidence.advice.extend(not_kept);
    if evidence.robustness.as_ref().is_some_and(|r| !r.met) {
        evidence.advice.extend(kept_by.map(all_could_keep));
    }
    let [path_delay_s, estimator_delay_s] = options.outer_delays();
    let mut document = Pid {
        schema: Pid::SCHEMA.into(),
        name: format!("PID for {}", plant.name),
        sample_time_s: options.sample_time_s,
        gains: PidGains {
            kp: pid.kp,
            ki: pid.ki,
            kd: pid.kd,
            derivative_filter_time_s: pid.derivative_filter_time,
            setpoint_weight_proportional: pid.setpoint_weight_proportional,
            setpoint_weight_derivative: pid.setpoint_weight_derivative,
            anti_windup_time_s: pid.anti_windup_time,
        },
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
            quality: plant.quality.clone(),
        },
        specification: objective.spec,
        guidance: GuidanceAdvice {
            feedforward_gain_radm: advice.feedforward_gain,
            // What the path sees is later than what the controller sees, and read as much ahead.
            preview_time_s: advice.preview_time + (path_delay_s - options.loop_delay_s),
            yaw_acceleration_gain_s2: advice.yaw_acceleration_gain,
            yaw_jerk_gain_s3: advice.yaw_jerk_gain,
        },
        evidence,
        provenance: provenance(source, options),
    };
    if stable {
        document.evidence.engagement = engagement(plant, &document)?;
    }
    document.checked("the designed controller")?;
    Ok(document)
}

/// The settling time of the slowest plant, with a little to spare and as people write it.
fn all_could_keep(settling_time_s: f64) -> String {
    const SPARE: f64 = 1.03;
    let settling = (20.0 * SPARE * settling_time_s).ceil() / 20.0;
    format!(
        "all plants could keep a settling time of {}, with everything else as asked for",
        Requirement::Settling.text(settling)
    )
}

/// What the nominal plant keeps and others do not.
fn not_everywhere(r: &Robustness, met: bool) -> Vec<String> {
    if r.met || !met {
        return Vec::new();
    }
    r.requirements
        .iter()
        .filter(|x| x.share_kept < 1.0)
        .filter_map(|x| Some((Requirement::of(&x.requirement)?, x)))
        .map(|(requirement, x)| {
            format!(
                "over {} plants within the uncertainty and the latency of {:.0} to {:.0} ms the {} \
                 goes to {}, and {:.0} % of them keep it",
                r.plants,
                1e3 * r.loop_delay_range_s[0],
                1e3 * r.loop_delay_range_s[1],
                requirement.label(),
                requirement.text(x.worst),
                100.0 * x.share_kept
            )
        })
        .collect()
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
