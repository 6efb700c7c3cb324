//! What a controller reaches on a plant, whichever it was designed on.

use crate::Error;
use crate::margins::margins;
use crate::metrics::{Metrics, metrics};
use crate::plant::DesignPlant;
use crate::sampled::Sampled;
use crate::simulate::{Excitation, Simulator, Trace};
use formats::{DesignEvidence, Pid, Shortfall, Specification, StepMetrics};
use model_loading::pid_parameters;
use vehicle_models::PidParameters;

/// The evidence for a controller on a plant: its specification's step, the same with the steering
/// offset, and the margins. With another plant than the one designed on, this compares models.
///
/// # Errors
/// [`Error::SteeringRatio`] where the plant's steering angle is another one, and what sampling the
/// plant may say.
pub fn evaluate(plant: &DesignPlant, pid: &Pid) -> Result<DesignEvidence, Error> {
    let sampled = sampled_for(plant, pid)?;
    let parameters = pid_parameters(pid);
    Ok(evidence(&sampled, plant.steering_ratio, &parameters, &pid.specification))
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
    if !(until.is_finite() && until > 0.0 && until <= 3600.0) {
        return Err(Error::Option { option: "time", value: until, must: "between 0 and 3600 s" });
    }
    let sampled = sampled_for(plant, pid)?;
    let offset = if with_offset { plant.steering_ratio } else { 0.0 };
    let excitation = Excitation {
        step: pid.specification.step_rad,
        ramp: 0.0,
        feedforward: 0.0,
        offset: offset * pid.specification.steering_offset_rad,
        until,
    };
    let mut simulator = Simulator::default();
    simulator.run(&sampled, &pid_parameters(pid), &excitation);
    Ok(simulator.trace)
}

fn sampled_for(plant: &DesignPlant, pid: &Pid) -> Result<Sampled, Error> {
    let ratio = pid.designed_for.steering_ratio;
    // Ratios of one car may be known to a few percent; 1 and 15 are two places.
    let same_place = (plant.steering_ratio / ratio - 1.0).abs() <= 0.25;
    if !same_place {
        return Err(Error::SteeringRatio { pid: ratio, plant: plant.steering_ratio });
    }
    Sampled::new(plant, pid.sample_time_s, pid.designed_for.loop_delay_s)
}

/// Both steps of a specification.
pub(crate) fn steps(
    simulator: &mut Simulator,
    plant: &Sampled,
    ratio: f64,
    pid: &PidParameters,
    spec: &Specification,
) -> [Metrics; 2] {
    [0.0, ratio * spec.steering_offset_rad].map(|offset| {
        let excitation = Excitation {
            step: spec.step_rad,
            ramp: 0.0,
            feedforward: 0.0,
            offset,
            until: spec.steady_state_time_s,
        };
        let trace = simulator.run(plant, pid, &excitation);
        metrics(trace, spec.step_rad, spec.steady_state_error_percent)
    })
}

/// Share of the specification's step that the small step is.
const SMALL: f64 = 0.1;

/// The metrics of a tenth of the step. A loop whose overshoot is kept down by a limit that acts on
/// the whole step shows it here.
pub(crate) fn small_step(
    simulator: &mut Simulator,
    plant: &Sampled,
    pid: &PidParameters,
    spec: &Specification,
) -> Metrics {
    let step = SMALL * spec.step_rad;
    let until = spec.steady_state_time_s;
    let excitation = Excitation { step, ramp: 0.0, feedforward: 0.0, offset: 0.0, until };
    metrics(simulator.run(plant, pid, &excitation), step, spec.steady_state_error_percent)
}

pub(crate) fn evidence(
    plant: &Sampled,
    ratio: f64,
    pid: &PidParameters,
    spec: &Specification,
) -> DesignEvidence {
    let [step, step_with_offset] = steps(&mut Simulator::default(), plant, ratio, pid, spec);
    let margins = margins(plant, pid);
    let shortfalls: Vec<Shortfall> =
        requirements(&step.step, &step_with_offset.step, margins.modulus_margin, spec)
            .into_iter()
            .filter(|r| !r.met())
            .map(|r| Shortfall {
                requirement: r.name.into(),
                required: r.required,
                reached: r.reached,
            })
            .collect();
    DesignEvidence {
        met: shortfalls.is_empty(),
        shortfalls,
        step: step.step,
        step_with_offset: step_with_offset.step,
        small_step: Some(small_step(&mut Simulator::default(), plant, pid, spec).step),
        margins,
    }
}

/// A requirement with what is reached.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Requirement {
    pub(crate) name: &'static str,
    pub(crate) required: f64,
    pub(crate) reached: f64,
    /// Whether `reached` must not be below, rather than not above, `required`.
    pub(crate) at_least: bool,
}

impl Requirement {
    fn met(&self) -> bool {
        if self.at_least { self.reached >= self.required } else { self.reached <= self.required }
    }
}

/// The five requirements. A response that never settles is told as the end of the simulation plus
/// the share by which it is off, so that better ones have less.
pub(crate) fn requirements(
    step: &StepMetrics,
    offset: &StepMetrics,
    modulus_margin: f64,
    spec: &Specification,
) -> [Requirement; 5] {
    let upper = |name, required, reached| Requirement { name, required, reached, at_least: false };
    let never = spec.steady_state_time_s * (1.0 + 0.01 * step.steady_state_error_percent);
    let settling = step.settling_time_s.unwrap_or(never);
    let error = spec.steady_state_error_percent;
    [
        upper("overshoot_percent", spec.overshoot_percent, step.overshoot_percent),
        upper("settling_time_s", spec.settling_time_s, settling),
        upper("steady_state_error_percent", error, step.steady_state_error_percent),
        upper("steady_state_error_with_offset_percent", error, offset.steady_state_error_percent),
        Requirement {
            name: "modulus_margin",
            required: spec.modulus_margin,
            reached: modulus_margin,
            at_least: true,
        },
    ]
}
