//! One plant, at one latency and one speed, on which a controller is evaluated.

use crate::Error;
use crate::closed_loop::early_stopping::{Decay, StoppingBounds};
use crate::closed_loop::feedforward::Advice;
use crate::closed_loop::margins::ResponseGrid;
use crate::closed_loop::metrics::{Metrics, error_percent, metrics};
use crate::closed_loop::simulate::{Excitation, Simulator};
use crate::plants::design_plant::DesignPlant;
use crate::plants::sampled::Sampled;
use crate::requirement::Reached;
use steerwright_formats::{Margins, OnACurve, Specification};
use steerwright_models::PidParameters;

/// Points of the frequency grid.
const GRID_POINTS: usize = 120;
/// Share of the specification's step that the small step is.
const SMALL: f64 = 0.1;

#[derive(Debug, Clone)]
pub(crate) struct Scenario {
    pub(crate) plant: Sampled,
    pub(crate) speed: f64,
    /// Whether the search evaluates the response to a steering offset, which hardly differs by plant.
    pub(crate) with_offset: bool,
    ratio: f64,
    pub(crate) grid: ResponseGrid,
}

#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct View {
    /// End of the responses, s.
    pub(crate) until: f64,
    /// Share of the settling band within which a response must stay.
    pub(crate) band: f64,
    /// Whether a margin other than the modulus margin is required.
    pub(crate) all_margins: bool,
    /// Whether the response to the steering offset is required.
    pub(crate) with_offset: bool,
    /// Whether a response that has come to rest, or decays as one mode, is extrapolated to its end.
    pub(crate) early: bool,
}

impl Scenario {
    /// A plant with a delay of the loop; `scale` is about how long a response takes, s.
    pub(crate) fn new(
        plant: &DesignPlant,
        sample_time: f64,
        loop_delay: f64,
        scale: f64,
    ) -> Result<Self, Error> {
        let sampled = Sampled::new(plant, sample_time, loop_delay)?;
        Ok(Self {
            grid: ResponseGrid::coarse(&sampled, 0.1 / scale, GRID_POINTS),
            plant: sampled,
            speed: plant.speed,
            with_offset: true,
            ratio: plant.steering_ratio,
        })
    }

    /// The same on another grid.
    pub(crate) fn at_scale(self, scale: f64) -> Self {
        Self { grid: ResponseGrid::coarse(&self.plant, 0.1 / scale, GRID_POINTS), ..self }
    }

    /// The same for a search that evaluates only the start of the step.
    pub(crate) fn without_offset(self) -> Self {
        Self { with_offset: false, ..self }
    }

    /// The figures of a controller, with the margins of the grid.
    pub(crate) fn reached(
        &self,
        simulator: &mut Simulator,
        pid: &PidParameters,
        spec: &Specification,
        view: View,
        margins: Margins,
    ) -> Reached {
        let excitation = step_of(spec, view).excitation();
        let trace = simulator.run(&self.plant, pid, &excitation);
        let step = metrics(trace, spec.step_rad, view.band * spec.settling_band_percent).step;
        let with_offset = match view.with_offset {
            true => self.error_with_offset(simulator, pid, spec, view),
            false => step.steady_state_error_percent,
        };
        Reached { step, with_offset, on_curve: 0.0, margins, end: view.until }
    }

    /// The metrics of the step alone; `None` where a bound is exceeded.
    pub(crate) fn step(
        &self,
        simulator: &mut Simulator,
        pid: &PidParameters,
        spec: &Specification,
        view: View,
        bounds: &StoppingBounds,
    ) -> Option<Metrics> {
        let excitation = step_of(spec, view).excitation();
        let band = view.band * spec.settling_band_percent;
        let followed = simulator.follow(&self.plant, pid, &excitation, bounds);
        if followed { Some(metrics(&simulator.trace, spec.step_rad, band)) } else { None }
    }

    /// The error at the end of the step with the steering offset, percent.
    pub(crate) fn error_with_offset(
        &self,
        simulator: &mut Simulator,
        pid: &PidParameters,
        spec: &Specification,
        view: View,
    ) -> f64 {
        let offset = spec.steering_offset_within(pid.largest_angle(self.plant.speed), self.ratio);
        let step = Step { offset, until: view.until, ..Step::from_specification(spec) };
        let decay = Decay::new(step.height, view.until, self.plant.sample_time);
        let bounds = StoppingBounds {
            decay: if view.early { Some(decay) } else { None },
            ..StoppingBounds::NONE
        };
        let whole = simulator.follow(&self.plant, pid, &step.excitation(), &bounds);
        let known = if whole { None } else { decay.error(&simulator.trace.yaw) };
        match known {
            Some(share) => 100.0 * share,
            None => error_percent(&simulator.trace, step.height),
        }
    }

    /// The metrics of a tenth of the step, which show an overshoot that a limit conceals.
    pub(crate) fn small_step(
        &self,
        simulator: &mut Simulator,
        pid: &PidParameters,
        spec: &Specification,
        until: f64,
    ) -> Metrics {
        let step = Step { until, quiet: SMALL * quiet(spec), ..Step::small(spec) };
        simulated_step(simulator, &self.plant, pid, spec, step)
    }
}

#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Step {
    pub(crate) height: f64,
    /// Steering offset in steering coordinates, rad.
    pub(crate) offset: f64,
    pub(crate) until: f64,
    /// See [`Excitation::quiet`].
    pub(crate) quiet: f64,
}

impl Step {
    pub(crate) fn from_specification(spec: &Specification) -> Self {
        Self { height: spec.step_rad, offset: 0.0, until: spec.steady_state_time_s, quiet: 0.0 }
    }

    pub(crate) fn small(spec: &Specification) -> Self {
        Self { height: SMALL * spec.step_rad, ..Self::from_specification(spec) }
    }

    fn excitation(self) -> Excitation {
        let Self { height: step, offset, until, quiet } = self;
        Excitation { step, ramp: 0.0, feedforward: 0.0, offset, until, quiet }
    }
}

fn step_of(spec: &Specification, view: View) -> Step {
    let quiet = if view.early { quiet(spec) } else { 0.0 };
    Step { until: view.until, quiet, ..Step::from_specification(spec) }
}

/// The distance from the step at rest, rad: a quarter of the tightest requirement.
fn quiet(spec: &Specification) -> f64 {
    let error = spec.steady_state_error_percent.unwrap_or(f64::INFINITY);
    let overshoot = spec.overshoot_percent.unwrap_or(f64::INFINITY);
    0.0025 * spec.settling_band_percent.min(error).min(overshoot) * spec.step_rad
}

pub(crate) fn simulated_step(
    simulator: &mut Simulator,
    plant: &Sampled,
    pid: &PidParameters,
    spec: &Specification,
    step: Step,
) -> Metrics {
    let trace = simulator.run(plant, pid, &step.excitation());
    metrics(trace, step.height, spec.settling_band_percent)
}

/// The error of yaw on a curve that begins at time 0, read ahead by the preview. The reference is a
/// ramp that begins that much earlier, and so does the feedforward.
pub(crate) fn on_curve(
    simulator: &mut Simulator,
    plant: &Sampled,
    speed: f64,
    pid: &PidParameters,
    spec: &Specification,
    advice: &Advice,
) -> OnACurve {
    let rate = spec.curve_lateral_acceleration_mps2 / speed;
    let curvature = rate / speed;
    let excitation = Excitation {
        step: 0.0,
        ramp: rate,
        feedforward: advice.feedforward_gain * curvature,
        offset: 0.0,
        until: spec.steady_state_time_s + advice.preview_time,
        quiet: 0.0,
    };
    let trace = simulator.run(plant, pid, &excitation);
    let error = |k: usize| {
        let heading = rate * (trace.time[k] - advice.preview_time).max(0.0);
        100.0 * (trace.yaw[k] - heading).abs() / spec.step_rad
    };
    let last = trace.time.len() - 1;
    // A loop that diverges has no steady state.
    let whole = trace.time[last] >= excitation.until - pid.sample_time;
    OnACurve {
        curvature_1pm: curvature,
        steady_state_error_percent: if whole { error(last).min(1e4) } else { 1e4 },
        largest_error_percent: (0..=last).map(error).fold(0.0, f64::max).min(1e4),
    }
}
