//! The design of a PID controller (eq 14) to a specification.

use crate::Error;
use crate::evaluate::evidence;
use crate::objective::{
    Aim, BARELY, CROSSOVER_TIMES_SETTLING, Objective, QUICKEST, VARIABLES, WITH_RESERVE,
};
use crate::optimise::{minimise, sequence};
use crate::options::DesignOptions;
use crate::plant::DesignPlant;
use crate::sampled::Sampled;
use crate::simulate::{Excitation, Simulator};
use formats::{
    DesignEvidence, DesignedFor, Document, GuidanceAdvice, Pid, PidGains, Provenance, SourceFile,
};
use std::collections::BTreeMap;
use vehicle_models::PidParameters;

/// Digits of the gains, and where those just miss a requirement.
const READABLE_DIGITS: i32 = 5;
const EXACT_DIGITS: i32 = 12;
/// Multiples of the plant's scale about which the quickest loop is looked for: the settling time
/// jumps where a response just leaves its band again, and has many minima.
const SCALES: [f64; 3] = [1.0, 1.5, 2.25];
/// Responses longer than this, s, are looked at for fewer loops.
const LONG: f64 = 10.0;
/// Where the quickest loop misses the settling time by less than this factor, another one may be
/// looked for that just keeps it.
const NEARLY: f64 = 1.1;

/// Designs a controller for a plant. `source` names the model's file.
///
/// Requirements that cannot be met do not fail the design: the quickest loop that keeps the other
/// requirements is returned with its shortfalls in the evidence.
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
    let (Found { pid, evidence, .. }, objective) = find(objective, plant, options.seed)?;
    let document = Pid {
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
        limits: objective.limits,
        designed_for: DesignedFor {
            model: plant.model.clone(),
            name: plant.name.clone(),
            sha256: source.sha256.clone(),
            speed_mps: plant.speed,
            steering_ratio: plant.steering_ratio,
            loop_delay_s: options.loop_delay_s,
        },
        specification: objective.spec,
        guidance: advice(plant, &objective.plant, &pid, evidence.margins.modulus_margin > 0.0),
        evidence,
        provenance: provenance(source, options),
    };
    document.checked("the designed controller")?;
    Ok(document)
}

/// A controller, what it reaches, and its decision variables.
struct Found {
    pid: PidParameters,
    evidence: DesignEvidence,
    variables: Vec<f64>,
}

/// With some reserve; or else the quickest loop, or one that just keeps everything.
fn find(objective: Objective, plant: &DesignPlant, seed: u64) -> Result<(Found, Objective), Error> {
    let own = starts(&objective, 1.0, 6, seed);
    let found = search(&objective, plant, &WITH_RESERVE, &own, 2)?;
    if found.evidence.met {
        return Ok((found, objective));
    }
    let (own_scale, plants_scale) = (objective.scale, objective.plants_scale());
    let objective = objective.at_scale(plants_scale);
    let (others, keep) = if objective.spec.steady_state_time_s > LONG { (0, 1) } else { (3, 3) };
    let all = SCALES.map(|multiple| starts(&objective, multiple, others, seed)).concat();
    let quickest = search(&objective, plant, &QUICKEST, &all, keep)?;
    let settling = quickest.evidence.step.settling_time_s.unwrap_or(f64::INFINITY);
    if quickest.evidence.met || settling > NEARLY * objective.spec.settling_time_s {
        return Ok((quickest, objective));
    }
    let objective = objective.at_scale(own_scale);
    let near = [own, vec![found.variables, quickest.variables.clone()]].concat();
    let barely = search(&objective, plant, &BARELY, &near, 2)?;
    Ok((if barely.evidence.met { barely } else { quickest }, objective))
}

/// Where a search begins, about a multiple of the objective's scale: a guess and `count` others.
fn starts(objective: &Objective, multiple: f64, count: u32, seed: u64) -> Vec<Vec<f64>> {
    let (t, ts) = (multiple * objective.scale, objective.plant.sample_time);
    // A crossover that settles in time, a reset that forgets an offset within the 5 s, a little
    // lead; and the lag of a fast pole at the crossover, which cancels the slow pole of the reset.
    let crossover = CROSSOVER_TIMES_SETTLING / t;
    let guess = [crossover, 0.8 / t, 0.05 * t, 0.01 * t + ts, 0.2 * t].map(f64::ln);
    let ranges = [(3.0, 10.0), (0.5, 1.5), (0.02, 0.3), (0.01, 0.05), (0.1, 0.4)];
    let mut box_ = [(0.0, 0.0); VARIABLES];
    for (i, ((low, high), bounds)) in ranges.into_iter().zip(objective.bounds()).enumerate() {
        let unit = if i < 2 { 1.0 / t } else { t };
        box_[i] = ((low * unit).max(bounds.0).ln(), (high * unit).min(bounds.1).max(bounds.0).ln());
    }
    let mut starts = vec![guess.to_vec()];
    starts.extend(sequence(&box_, count, seed));
    starts
}

/// The best controller for an aim, and what it reaches.
fn search(
    objective: &Objective,
    plant: &DesignPlant,
    aim: &Aim,
    starts: &[Vec<f64>],
    keep: usize,
) -> Result<Found, Error> {
    let (variables, _) = minimise(&|x| objective.cost(x, aim), starts, keep)?;
    // Rounded to what a person can read, unless that breaks what was just kept; the evidence is
    // that of the rounded gains.
    let finish = |digits| {
        let pid = rounded(&objective.controller(&variables).0, digits);
        let evidence = evidence(&objective.plant, plant.steering_ratio, &pid, &objective.spec);
        (pid, evidence)
    };
    let (mut pid, mut evidence) = finish(READABLE_DIGITS);
    if !evidence.met {
        let exact = finish(EXACT_DIGITS);
        if exact.1.shortfalls.len() < evidence.shortfalls.len() {
            (pid, evidence) = exact;
        }
    }
    Ok(Found { pid, evidence, variables })
}

/// Feedforward and preview for a path follower around the loop.
///
/// With preview p and feedforward f/G₀ of the reference's rate, yaw follows the path's heading by
/// `T(s)·e^{ps}`, `T = (ki + b·kp·s + f·s²/G₀)/(ki + kp·s + (1/G₀ + kd)·s² + …)`; delays and lags
/// of the plant enter with s³. The terms in s and s² vanish, so that neither a circle nor a
/// clothoid leaves an error of yaw, for
///
/// ```text
/// p = kp·(1 − b)/ki        f = 1 + G₀·(kd − b·kp·p − ki·p²/2)
/// ```
///
/// f = 1, the whole steering of the curve, is right only without preview (b = 1). A loop whose
/// setpoint weight hides the slow pole of its integral action answers like a lag already, and what
/// is left of f is small: the whole feedforward would be counted twice.
fn advice(
    plant: &DesignPlant,
    sampled: &Sampled,
    pid: &PidParameters,
    stable: bool,
) -> GuidanceAdvice {
    // The lag of an unstable loop is no number to advise.
    let lag = if stable { ramp_lag(plant, sampled, pid).max(0.0) } else { 0.0 };
    let preview = significant(lag, 4);
    let weight = pid.setpoint_weight_proportional;
    let previewed = weight * pid.kp * preview + 0.5 * pid.ki * preview * preview;
    let share = 1.0 + plant.gain() * (pid.kd - previewed);
    GuidanceAdvice {
        // Steering per yaw rate is 1/G₀, yaw rate per curvature is the speed.
        feedforward_gain_radm: significant(share * plant.speed / plant.gain(), 5),
        preview_time_s: preview,
    }
}

/// The time by which yaw lags a ramp in the long run, with feedforward of the ramp's rate.
///
/// kp·(1 − b)/ki in theory: the integral action is at rest where ki·e = kp·(1 − b)·ṙ. Measured by
/// simulating a slow ramp, which no limit touches, until the slowest modes have died out.
pub(crate) fn ramp_lag(plant: &DesignPlant, sampled: &Sampled, pid: &PidParameters) -> f64 {
    let reset_time = if pid.ki > 0.0 { pid.kp / pid.ki } else { 1.0 };
    let until = (20.0 * reset_time).clamp(20.0, 400.0);
    let ramp = 1e-4;
    let excitation =
        Excitation { step: 0.0, ramp, feedforward: ramp / plant.gain(), offset: 0.0, until };
    let mut simulator = Simulator::default();
    let trace = simulator.run(sampled, pid, &excitation);
    let last = trace.yaw.len() - 1;
    (trace.yaw_reference[last] - trace.yaw[last]) / ramp
}

fn rounded(pid: &PidParameters, digits: i32) -> PidParameters {
    let round = |value| significant(value, digits);
    PidParameters {
        kp: round(pid.kp),
        ki: round(pid.ki),
        kd: round(pid.kd),
        derivative_filter_time: round(pid.derivative_filter_time),
        setpoint_weight_proportional: round(pid.setpoint_weight_proportional),
        anti_windup_time: round(pid.anti_windup_time),
        ..*pid
    }
}

/// A number to some significant digits.
fn significant(value: f64, digits: i32) -> f64 {
    if value == 0.0 || !value.is_finite() {
        return value;
    }
    let scale = 10.0_f64.powi(digits - 1 - value.abs().log10().floor() as i32);
    // Dividing keeps decimal numbers short: 0.3 and not 0.30000000000000004.
    (value * scale).round() / scale
}

fn provenance(source: &SourceFile, options: &DesignOptions) -> Provenance {
    let mut all: BTreeMap<String, String> = [
        ("overshoot_percent", options.overshoot_percent),
        ("settling_time_s", options.settling_time_s),
        ("steady_state_error_percent", options.steady_state_error_percent),
        ("sample_time_s", options.sample_time_s),
        ("loop_delay_s", options.loop_delay_s),
        ("modulus_margin", options.modulus_margin),
    ]
    .into_iter()
    .map(|(key, value)| (key.to_owned(), value.to_string()))
    .collect();
    for (key, value) in [
        ("max_angle_rad", options.max_angle_rad),
        ("max_increment_rad", options.max_increment_rad),
        ("max_rate_radps", options.max_rate_radps),
    ] {
        all.insert(key.into(), value.map_or("default".into(), |v| v.to_string()));
    }
    all.insert("seed".into(), options.seed.to_string());
    Provenance {
        version: env!("CARGO_PKG_VERSION").into(),
        sources: vec![source.clone()],
        options: all,
    }
}
