//! The closed loop of a speed controller and a longitudinal model, with the functions that run in their FMUs.
//!
//! Timing as under a Gauss–Seidel coupling: at tick k the controller sees the speed of tick k, and its output acts from
//! tick k on.

use crate::Error;
use crate::closed_loop::metrics::metrics_of;
use crate::closed_loop::simulate::Trace;
use std::sync::Arc;
use steerwright_formats::{
    Longitudinal, Requirement, SpeedController, SpeedResponses, SpeedSpecification, SpeedStep,
    StepMetrics,
};
use steerwright_models::speed::speed_control_parameters;
use steerwright_models::{
    LongitudinalPlant, SpeedControl, SpeedControlInputs, SpeedControlParameters,
};

/// A controller and a vehicle, each of its own model.
pub(crate) struct SpeedLoop {
    parameters: SpeedControlParameters,
    control: SpeedControl,
    plant: LongitudinalPlant,
    sample_time: f64,
}

impl SpeedLoop {
    /// At a speed, m/s, on a level road.
    pub(crate) fn new(
        controller: &SpeedController,
        inverted: &Arc<Longitudinal>,
        vehicle: &Arc<Longitudinal>,
        speed: f64,
    ) -> Result<Self, Error> {
        let model = &controller.model.name;
        let failed = |source| Error::Identified { model: model.clone(), source };
        let control = SpeedControl::new(Arc::clone(inverted)).map_err(failed)?;
        let mut plant = LongitudinalPlant::new(Arc::clone(vehicle)).map_err(failed)?;
        let failed = |source| Error::Identified { model: model.clone(), source };
        plant.initial_speed = speed;
        plant.start().map_err(failed)?;
        let parameters = speed_control_parameters(controller);
        Ok(Self { parameters, control, plant, sample_time: controller.sample_time_s })
    }

    /// The speeds at the ticks of a time, s, from now to its end, with a speed reference and an unmeasured grade, rad.
    pub(crate) fn run(
        &mut self,
        seconds: f64,
        speed_reference: f64,
        grade: f64,
    ) -> Result<Vec<f64>, Error> {
        let count = (seconds / self.sample_time).round() as usize;
        let mut speeds = Vec::with_capacity(count + 1);
        for _ in 0..count {
            let speed = self.plant.speed();
            speeds.push(speed);
            let input = SpeedControlInputs {
                speed_reference,
                speed,
                enabled: true,
                ..SpeedControlInputs::default()
            };
            let failed = |source| Error::Identified { model: "the loop".into(), source };
            let output = self.control.tick(&self.parameters, &input).map_err(failed)?;
            let inputs = &mut self.plant.inputs;
            inputs.accelerator = output.accelerator;
            inputs.brake = output.brake;
            inputs.acceleration_command = output.acceleration_command;
            inputs.grade = grade;
            let failed = |source| Error::Identified { model: "the loop".into(), source };
            self.plant.step(self.sample_time).map_err(failed)?;
        }
        speeds.push(self.plant.speed());
        Ok(speeds)
    }
}

/// The responses at a speed, one after the other: step up, step down, and the grade.
pub(crate) fn responses(
    controller: &SpeedController,
    inverted: &Arc<Longitudinal>,
    vehicle: &Arc<Longitudinal>,
    speed: f64,
) -> Result<SpeedResponses, Error> {
    let mut of = SpeedLoop::new(controller, inverted, vehicle, speed)?;
    responses_of(controller, speed, |seconds, speed_reference, grade| {
        of.run(seconds, speed_reference, grade)
    })
}

/// The responses of any loop with the controller at a speed, m/s, one after the other: step up, step down, and the grade.
///
/// `run` advances the loop, which is at that speed, by a time, s, with a speed reference, m/s, and a grade that is not
/// measured, rad; it returns the speeds, m/s, at the ticks from the first with this reference to the end.
///
/// # Errors
/// Those of `run`.
pub fn responses_of<E>(
    controller: &SpeedController,
    speed: f64,
    mut run: impl FnMut(f64, f64, f64) -> Result<Vec<f64>, E>,
) -> Result<SpeedResponses, E> {
    let s = &controller.specification;
    let seconds = s.steady_state_time_s;
    run(seconds, speed, 0.0)?;
    let up = run(seconds, speed + s.step_mps, 0.0)?;
    let down = run(seconds, speed, 0.0)?;
    let on_grade = run(seconds, speed, (0.01 * s.grade_percent).atan())?;
    let sample_time = controller.sample_time_s;
    let off = on_grade.last().map_or(0.0, |last| (last - speed).abs());
    let lowest = on_grade.iter().copied().fold(speed, f64::min);
    Ok(SpeedResponses {
        speed_mps: speed,
        up: step(&up, speed, s.step_mps, sample_time, s),
        down: step(&down, speed + s.step_mps, -s.step_mps, sample_time, s),
        error_on_grade_percent: 100.0 * off / s.step_mps,
        largest_loss_on_grade_mps: speed - lowest,
    })
}

/// The speeds of the nominal model at a speed, m/s: after the step up, after the step down, and on the grade, at ticks.
///
/// # Errors
/// Where the model or the controller is invalid.
pub fn speed_traces(controller: &SpeedController, speed: f64) -> Result<[Vec<f64>; 3], Error> {
    let model = Arc::new(controller.model.clone());
    let mut of = SpeedLoop::new(controller, &model, &model, speed)?;
    let mut runs = Vec::new();
    responses_of(controller, speed, |seconds, speed_reference, grade| {
        let speeds = of.run(seconds, speed_reference, grade)?;
        runs.push(speeds.clone());
        Ok::<_, Error>(speeds)
    })?;
    // The first run is at the steady speed.
    let mut runs = runs.into_iter().skip(1);
    Ok(std::array::from_fn(|_| runs.next().unwrap_or_default()))
}

/// The metrics of a step from `before` by `height`, both m/s.
#[must_use]
pub fn step(
    speeds: &[f64],
    before: f64,
    height: f64,
    sample_time: f64,
    s: &SpeedSpecification,
) -> SpeedStep {
    let trace = Trace {
        time: (0..speeds.len()).map(|k| k as f64 * sample_time).collect(),
        yaw: speeds.iter().map(|speed| speed - before).collect(),
        ..Trace::default()
    };
    let metrics = metrics_of(&trace, height, s.settling_band_percent);
    let step = match metrics {
        Some(metrics) => metrics.step,
        None => StepMetrics::default(),
    };
    SpeedStep {
        overshoot_percent: step.overshoot_percent,
        settling_time_s: step.settling_time_s,
        steady_state_error_percent: step.steady_state_error_percent,
    }
}

/// The value of a requirement, the worst of the responses; a response that never settles has a settling time beyond the
/// end.
pub(crate) fn reached(
    requirement: Requirement,
    responses: &[SpeedResponses],
    s: &SpeedSpecification,
) -> f64 {
    let mut worst = 0.0_f64;
    for r in responses {
        for step in [&r.up, &r.down] {
            let never = s.steady_state_time_s * (1.0 + 0.01 * step.steady_state_error_percent);
            worst = worst.max(match requirement {
                Requirement::Overshoot => step.overshoot_percent,
                Requirement::Settling => step.settling_time_s.unwrap_or(never),
                _ => step.steady_state_error_percent.max(r.error_on_grade_percent),
            });
        }
    }
    worst
}
