//! The design of a PID controller (eq 14) to a specification.

use crate::Error;
use crate::evaluate::evidence;
use crate::objective::{BARELY, Objective, VARIABLES, WITH_RESERVE};
use crate::optimise::minimise;
use crate::options::DesignOptions;
use crate::plant::DesignPlant;
use crate::sampled::Sampled;
use crate::simulate::{Excitation, Simulator};
use formats::{DesignedFor, Document, GuidanceAdvice, Pid, PidGains, Provenance, SourceFile};
use std::collections::BTreeMap;
use vehicle_models::PidParameters;

/// Designs a controller for a plant. `source` names the model's file.
///
/// Requirements that cannot be met do not fail the design: the best found is returned with its
/// shortfalls in the evidence.
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
    let t = options.settling_time_s;
    let ts = options.sample_time_s;
    // A crossover that settles in time, a reset that forgets an offset within the 5 s, a little
    // lead; and the lag of a fast pole at the crossover, which cancels the slow pole of the reset.
    let guess = [5.0 / t, 0.8 / t, 0.05 * t, 0.01 * t + ts, 0.2 * t].map(f64::ln);
    let starts = [(3.0, 10.0), (0.5, 1.5), (0.02, 0.3), (0.01, 0.05), (0.1, 0.4)];
    let mut box_ = [(0.0, 0.0); VARIABLES];
    for (i, ((low, high), bounds)) in starts.into_iter().zip(objective.bounds()).enumerate() {
        let unit = if i < 2 { 1.0 / t } else { t };
        box_[i] = ((low * unit).max(bounds.0).ln(), (high * unit).min(bounds.1).max(bounds.0).ln());
    }
    let (best, _) = minimise(&|x| objective.cost(x, &WITH_RESERVE), &guess, &box_, options.seed)?;
    // Rounded to what a person can read; the evidence is that of the rounded gains.
    let finish = |x: &[f64]| {
        let pid = rounded(&objective.controller(x).0);
        (pid, evidence(&objective.plant, plant.steering_ratio, &pid, &objective.spec))
    };
    let (mut pid, mut evidence) = finish(&best);
    if !evidence.met {
        let (best, _) = minimise(&|x| objective.cost(x, &BARELY), &best, &box_, options.seed)?;
        (pid, evidence) = finish(&best);
    }
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

fn rounded(pid: &PidParameters) -> PidParameters {
    PidParameters {
        kp: significant(pid.kp, 5),
        ki: significant(pid.ki, 5),
        kd: significant(pid.kd, 5),
        derivative_filter_time: significant(pid.derivative_filter_time, 5),
        setpoint_weight_proportional: significant(pid.setpoint_weight_proportional, 5),
        anti_windup_time: significant(pid.anti_windup_time, 5),
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
