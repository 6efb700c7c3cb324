//! The trajectory of an instance's outputs, and the comparison of trajectories.

use model_description::{Causality, ModelDescription, Value};
use steerwright_host::{Error, Instance, Status};

/// The experiment that an FMU recommends, with a limited number of steps.
#[derive(Debug, Clone, Copy)]
pub(super) struct Plan {
    /// Start time, s.
    pub(super) start: f64,
    /// Communication step, s.
    pub(super) step: f64,
    /// Number of steps.
    pub(super) count: u32,
}

/// The largest number of steps of a run.
const MOST_STEPS: u32 = 100;

impl Plan {
    /// Start, step and stop of `DefaultExperiment`, or 100 steps of 10 ms.
    pub(super) fn from_description(description: &ModelDescription) -> Self {
        let experiment = description.default_experiment.unwrap_or_default();
        let start = experiment.start_time.filter(|t| t.is_finite()).unwrap_or(0.0);
        let positive = |value: &f64| value.is_finite() && *value > 0.0;
        let span = experiment.stop_time.map(|stop| stop - start).filter(positive);
        let step = experiment.step_size.filter(positive);
        let step = step.or_else(|| span.map(|span| span / 100.0)).unwrap_or(0.01);
        let steps = span.map_or(f64::from(MOST_STEPS), |span| (span / step + 1e-9).floor());
        // In range by the clamp.
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
        let count = steps.clamp(1.0, f64::from(MOST_STEPS)) as u32;
        Self { start, step, count }
    }

    /// The time of a communication point.
    pub(super) fn time(self, point: u32) -> f64 {
        self.start + f64::from(point) * self.step
    }
}

/// The number of steps to the stop time of `DefaultExperiment`, where it has one.
pub(super) fn steps_to_stop(description: &ModelDescription, plan: Plan) -> Option<u32> {
    let stop = description.default_experiment?.stop_time?;
    let steps = ((stop - plan.start) / plan.step + 1e-9).floor();
    // In range by the clamp.
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
    if steps >= 1.0 { Some(steps.min(f64::from(u32::MAX)) as u32) } else { None }
}

/// The outputs after each step, up to the first discarded step.
pub(super) type Trajectory = Vec<Vec<Value>>;

/// Steps from one communication point on and reads all outputs after each step, up to a discarded step.
pub(super) fn drive(
    instance: &mut Instance,
    plan: Plan,
    from: u32,
    count: u32,
) -> Result<Trajectory, Error> {
    let outputs = outputs(instance);
    let mut trajectory = Trajectory::new();
    for point in from..from + count {
        match instance.do_step(plan.time(point), plan.step) {
            // The standard allows an FMU to reject this step.
            Err(Error::Step { status: Status::Discard, .. } | Error::Terminated { .. }) => break,
            other => other?,
        }
        let values = outputs.iter().map(|name| instance.value(name));
        trajectory.push(values.collect::<Result<_, _>>()?);
    }
    Ok(trajectory)
}

pub(super) fn outputs(instance: &Instance) -> Vec<String> {
    let variables = instance.model().variables().iter();
    variables.filter(|v| v.causality == Causality::Output).map(|v| v.name.clone()).collect()
}

/// The first difference of two trajectories; `names` are the outputs.
pub(super) fn difference(one: &Trajectory, other: &Trajectory, names: &[String]) -> Option<String> {
    if one.len() != other.len() {
        return Some(format!("{} steps succeed, then {}", one.len(), other.len()));
    }
    for (step, (a, b)) in one.iter().zip(other).enumerate() {
        for ((a, b), name) in a.iter().zip(b).zip(names) {
            if !same(a, b) {
                let (a, b, step) = (show(a), show(b), step + 1);
                return Some(format!("`{name}` is {a} and then {b} after step {step}"));
            }
        }
    }
    None
}

/// Relative difference of equal Reals: an FMU may use other mathematical libraries than its exporter.
const RELATIVE: f64 = 1e-9;

/// Whether two values are the same, Reals up to rounding; NaN is the same as NaN.
pub(super) fn same(a: &Value, b: &Value) -> bool {
    match (a, b) {
        (Value::Real(a), Value::Real(b)) => {
            a == b
                || a.is_nan() && b.is_nan()
                || (a - b).abs() <= RELATIVE * a.abs().max(b.abs()).max(1e-3)
        }
        (a, b) => a == b,
    }
}

/// Relative difference of a number that was stored in single precision.
const SINGLE: f64 = 1e-6;

pub(super) fn is_rounding(a: &Value, b: &Value) -> bool {
    matches!((a, b), (Value::Real(a), Value::Real(b)) if (a - b).abs() <= SINGLE * a.abs().max(b.abs()))
}

pub(super) fn show(value: &Value) -> String {
    match value {
        Value::Real(value) => format!("{value:?}"),
        Value::Integer(value) => value.to_string(),
        Value::Boolean(value) => value.to_string(),
        Value::String(value) => format!("{value:?}"),
    }
}
