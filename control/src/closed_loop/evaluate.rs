//! The evaluation of a controller on any plant.

use crate::Error;
use crate::closed_loop::feedforward::Advice;
use crate::closed_loop::margins::{controller, margins};
use crate::closed_loop::metrics::{Metrics, metrics};
use crate::closed_loop::scenario::{Step, on_curve, simulated_step};
use crate::closed_loop::simulate::{Excitation, Simulator, Trace};
use crate::error::require;
use crate::guidance::guidance_for;
use crate::plants::design_plant::DesignPlant;
use crate::plants::sampled::Sampled;
use crate::requirement::Reached;
use nalgebra::Complex;
use std::f64::consts::PI;
use steerwright_formats::{DesignEvidence, HeightStep, Pid, Specification, StepMetrics};
use steerwright_models::PidParameters;
use steerwright_models::files::pid_parameters_at;

/// Heights of the steps that are reported, degrees, and how long they are followed, s: the largest yaw
/// error acted on makes them a matter of many seconds at low speed.
const HEIGHTS_DEG: [f64; 7] = [1.0, 2.0, 5.0, 10.0, 20.0, 45.0, 90.0];
const LARGE_STEPS_S: f64 = 30.0;

/// The evidence for a controller on a plant: its specification's step, the same with the steering offset, the
/// curve, and the margins. With another plant than the one designed on, this compares models.
///
/// # Errors
/// [`Error::SteeringRatio`] where the plant's steering angle is another one, and the errors of sampling
/// the plant.
pub fn evaluate(plant: &DesignPlant, pid: &Pid) -> Result<DesignEvidence, Error> {
    let sampled = sampled_for(plant, pid, pid.designed_for.loop_delay_s)?;
    let parameters = pid_parameters_at(pid, plant.speed);
    let advice = advice_at(pid, plant.speed);
    Ok(evidence(&sampled, plant, &parameters, &pid.specification, &advice))
}

/// Preview, feedforward and path gains of a file at a speed, m/s. The preview of the file contains the additional
/// delay of the loop through the path, which is not simulated here.
pub(crate) fn advice_at(pid: &Pid, speed: f64) -> Advice {
    let late = (pid.designed_for.path_delay_s - pid.designed_for.loop_delay_s).max(0.0);
    let guidance = guidance_for(pid, speed);
    Advice {
        feedforward_gain: guidance.feedforward_gain_radm,
        preview_time: guidance.preview_time_s - late,
        yaw_acceleration_gain: guidance.yaw_acceleration_gain_s2,
        yaw_jerk_gain: guidance.yaw_jerk_gain_s3,
    }
}

/// The response to the specification's step, for plots; with the steering offset or without.
///
/// # Errors
/// As [`evaluate`].
pub fn step_response(
    plant: &DesignPlant,
    pid: &Pid,
    with_offset: bool,
    until: f64,
) -> Result<Trace, Error> {
    require(until > 0.0 && until <= 3600.0, "time", (until, " s"), "between 0 and 3600 s")?;
    let sampled = sampled_for(plant, pid, pid.designed_for.loop_delay_s)?;
    let parameters = pid_parameters_at(pid, plant.speed);
    let largest = parameters.largest_angle(plant.speed);
    let offset = match with_offset {
        true => pid.specification.steering_offset_within(largest, plant.steering_ratio),
        false => 0.0,
    };
    let excitation = Excitation {
        step: pid.specification.step_rad,
        ramp: 0.0,
        feedforward: 0.0,
        offset,
        until,
        quiet: 0.0,
    };
    let mut simulator = Simulator::default();
    simulator.run(&sampled, &parameters, &excitation);
    Ok(simulator.trace)
}

/// The metrics of the specification's step with another delay of the loop than the one designed for,
/// such as that of another coupling.
///
/// # Errors
/// As [`evaluate`].
pub fn step_metrics(plant: &DesignPlant, pid: &Pid, loop_delay: f64) -> Result<StepMetrics, Error> {
    let sampled = sampled_for(plant, pid, loop_delay)?;
    let (parameters, spec) = (pid_parameters_at(pid, plant.speed), &pid.specification);
    let step = Step::from_specification(spec);
    Ok(simulated_step(&mut Simulator::default(), &sampled, &parameters, spec, step).step)
}

/// One point of the open loop's frequency response.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LoopPoint {
    /// Frequency, Hz.
    pub frequency_hz: f64,
    /// Real part.
    pub real: f64,
    /// Imaginary part.
    pub imaginary: f64,
}

/// The open loop, sampled and with its delay, at `points` frequencies from a thousandth of the Nyquist
/// frequency to it.
///
/// # Errors
/// As [`evaluate`].
pub fn loop_response(
    plant: &DesignPlant,
    pid: &Pid,
    points: usize,
) -> Result<Vec<LoopPoint>, Error> {
    let sampled = sampled_for(plant, pid, pid.designed_for.loop_delay_s)?;
    let parameters = pid_parameters_at(pid, plant.speed);
    let step = 1000.0_f64.powf(1.0 / (points.max(2) - 1) as f64);
    let angles = (0..points).map(|i| 1e-3 * PI * step.powf(i as f64));
    Ok(angles
        .map(|angle| {
            let z = Complex::from_polar(1.0, angle);
            let l = controller(&parameters, z) * sampled.response(z);
            let frequency_hz = angle / (2.0 * PI * pid.sample_time_s);
            LoopPoint { frequency_hz, real: l.re, imaginary: l.im }
        })
        .collect())
}

fn sampled_for(plant: &DesignPlant, pid: &Pid, loop_delay: f64) -> Result<Sampled, Error> {
    let ratio = pid.designed_for.steering_ratio;
    // Ratios of one car may be known to a few percent; 1 and 15 are two places.
    let same_place = (plant.steering_ratio / ratio - 1.0).abs() <= 0.25;
    if !same_place {
        return Err(Error::SteeringRatio { pid: ratio, plant: plant.steering_ratio });
    }
    Sampled::new(plant, pid.sample_time_s, loop_delay)
}

pub(crate) fn evidence(
    sampled: &Sampled,
    plant: &DesignPlant,
    pid: &PidParameters,
    spec: &Specification,
    advice: &Advice,
) -> DesignEvidence {
    let mut simulator = Simulator::default();
    let largest = pid.largest_angle(sampled.speed);
    let offset = spec.steering_offset_within(largest, plant.steering_ratio);
    let step = simulated_step(&mut simulator, sampled, pid, spec, Step::from_specification(spec));
    let with_offset = simulated_step(
        &mut simulator,
        sampled,
        pid,
        spec,
        Step { offset, ..Step::from_specification(spec) },
    );
    let small = simulated_step(&mut simulator, sampled, pid, spec, Step::small(spec));
    let mut evidence = DesignEvidence {
        step: step.step,
        step_with_offset: with_offset.step,
        small_step: Some(small.step),
        without_limits: Some(linear_step(sampled, pid, spec).step),
        curve: Some(on_curve(&mut simulator, sampled, plant.speed, pid, spec, advice)),
        margins: margins(sampled, pid),
        ..DesignEvidence::default()
    };
    evidence.steps = HEIGHTS_DEG
        .map(|degrees: f64| {
            let height = degrees.to_radians();
            let step = Step { height, until: LARGE_STEPS_S, ..Step::from_specification(spec) };
            let step = simulated_step(&mut simulator, sampled, pid, spec, step).step;
            HeightStep { height_rad: height, step }
        })
        .to_vec();
    evidence.shortfalls = Reached::new(&evidence, spec).shortfalls(spec);
    evidence.met = evidence.shortfalls.is_empty();
    evidence
}

/// The step by linear theory: the closed loop's difference equation, without the controller's tick
/// function and without limits.
///
/// ```text
/// z⁺ = Φ z + Γ_old u(k−d−1) + Γ_new u(k−d)
/// u = kp·(b·r − ψ) + I + D,   I⁺ = I + ki·T·(r − ψ),   D⁺ = (Tf·D − kd·Δψ)/(Tf + T)
/// ```
pub(crate) fn linear_step(plant: &Sampled, pid: &PidParameters, spec: &Specification) -> Metrics {
    let (n, ts, r) = (plant.order, plant.sample_time, spec.step_rad);
    let last = (spec.steady_state_time_s / ts).round() as usize;
    let mut z = vec![0.0; n];
    let (mut integral, mut derivative, mut before) = (0.0, 0.0, 0.0);
    let mut trace = Trace::default();
    for k in 0..=last {
        let yaw = z[n - 1];
        let tf = pid.gains.derivative_filter_time_s;
        derivative = (tf * derivative - pid.gains.kd * (yaw - before)) / (tf + ts);
        integral += pid.gains.ki * ts * (r - yaw);
        before = yaw;
        let u = pid.gains.kp * (pid.gains.setpoint_weight_proportional * r - yaw)
            + integral
            + derivative;
        trace.time.push(k as f64 * ts);
        trace.yaw_reference.push(r);
        trace.yaw.push(yaw);
        trace.steering.push(u);
        let ago = |d: usize| if k >= d { trace.steering[k - d] } else { 0.0 };
        let (new, old) = (ago(plant.delay), ago(plant.delay + 1));
        z = (0..n)
            .map(|i| {
                let row = &plant.phi[i * n..(i + 1) * n];
                let moved: f64 = row.iter().zip(&z).map(|(a, x)| a * x).sum();
                moved + plant.gamma_old[i] * old + plant.gamma_new[i] * new
            })
            .collect();
        if !z[n - 1].is_finite() {
            break;
        }
    }
    metrics(&trace, r, spec.settling_band_percent)
}
