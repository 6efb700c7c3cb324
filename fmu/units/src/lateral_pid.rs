//! `LateralPid`: the glue from [`steerwright_models::Pid`] to the export trait.

use self::Variable as V;
use crate::fmu::{Definition, Role};
use crate::resources::{optional, with_start_values};
use crate::saved::{check_settable, decode, encode, outputs_are_finite, refuse};
use crate::scenario::{Moment, Scenario};
use crate::ticking::{ticks_in, warn_of_long_step};
use fmi2_export::{Capabilities, CoSimulationUnit, Log, Resources, variables};
use model_description::DependsOn::Nothing;
use model_description::{Table, Value};
use serde::{Deserialize, Serialize};
use std::borrow::Cow;
use std::f64::consts::TAU;
use steerwright_models::{Pid, PidInput, PidOutput, PidParameters, PidSchedule, Ticks};

variables! {
    /// Variables of the steering controller. Its outputs are held between ticks, so at a
    /// communication point they depend on no input.
    Variable of LateralPid, "LateralPid", "PID steering controller: yaw reference and yaw in, steering angle out";
    YawReference = 0, real "yaw_reference", Input, Continuous, at inputs.pid.yaw_reference,
        .unit("rad").display_unit("deg").description("yaw to reach, positive to the left, not wrapped");
    Yaw = 1, real "yaw", Input, Continuous, at inputs.pid.yaw,
        .unit("rad").display_unit("deg").description("yaw of the vehicle, positive to the left");
    SteeringFeedforward = 2, real "steering_feedforward", Input, Continuous, at inputs.pid.steering_feedforward,
        .unit("rad").display_unit("deg").nominal(0.1).description("steering angle added to the controller's own");
    Enabled = 3, boolean "enabled", Input, Discrete,
        .description("whether the controller acts; otherwise the limited feedforward is put out");
    Speed = 4, real "speed", Input, Continuous, at inputs.pid.speed,
        .unit("m/s").min(0.0).nominal(10.0).description("speed that the limits follow; unconnected, that of the design");
    SteeringAngle = 10, real "steering_angle", Output, Discrete,
        .unit("rad").display_unit("deg").nominal(0.1).depends_on(Nothing)
        .description("steering angle to command, in steering coordinates");
    Saturated = 11, boolean "saturated", Output, Discrete,
        .depends_on(Nothing).description("whether a limit acted at the last tick");
    Kp = 20, real "kp", Parameter, Tunable, at parameters.gains.kp,
        .unit("1").min(0.0).description("proportional gain, steering angle per yaw error");
    Ki = 21, real "ki", Parameter, Tunable, at parameters.gains.ki,
        .unit("1/s").min(0.0).description("integral gain");
    Kd = 22, real "kd", Parameter, Tunable, at parameters.gains.kd,
        .unit("s").min(0.0).description("derivative gain");
    DerivativeFilterTime = 23, real "derivative_filter_time", Parameter, Tunable, at parameters.gains.derivative_filter_time_s,
        .unit("s").min(0.0).nominal(0.01).description("time constant of the derivative's filter");
    SetpointWeightProportional = 24, real "setpoint_weight_proportional", Parameter, Tunable, at parameters.gains.setpoint_weight_proportional,
        .unit("1").description("weight of the reference in the proportional action");
    SetpointWeightDerivative = 25, real "setpoint_weight_derivative", Parameter, Tunable, at parameters.gains.setpoint_weight_derivative,
        .unit("1").description("weight of the reference in the derivative action");
    AntiWindupTime = 26, real "anti_windup_time", Parameter, Tunable, at parameters.gains.anti_windup_time_s,
        .unit("s").min(0.0).description("time constant of the anti-windup back-calculation");
    MaxAngle = 27, real "max_angle", Parameter, Tunable, at parameters.max_angle,
        .unit("rad").display_unit("deg").min(0.0).description("largest steering angle to either side");
    MaxIncrement = 28, real "max_increment", Parameter, Tunable, at parameters.max_increment,
        .unit("rad").display_unit("deg").min(0.0).nominal(0.1).description("largest change of the steering angle in a tick");
    MaxRate = 29, real "max_rate", Parameter, Tunable, at parameters.max_rate,
        .unit("rad/s").display_unit("deg/s").min(0.0).nominal(10.0).description("largest rate of the steering angle");
    SampleTime = 30, real "sample_time", Parameter, Fixed, at parameters.sample_time,
        .unit("s").min(1e-6).nominal(0.01).description("time between ticks");
    MaxYawError = 31, real "max_yaw_error", Parameter, Tunable, at parameters.large_errors.max_yaw_error_rad,
        .unit("rad").display_unit("deg").min(0.0).description("largest yaw error acted on at once, beyond the lag behind a ramp; pi for any");
    MaxLateralAcceleration = 32, real "max_lateral_acceleration", Parameter, Tunable, at parameters.lateral_acceleration.max_mps2,
        .unit("m/s2").min(0.0).nominal(10.0).description("lateral acceleration that the steering angle may cause in a steady turn");
    SteeringPerCurvature = 33, real "steering_per_curvature", Parameter, Tunable, at parameters.lateral_acceleration.steering_per_curvature_radm,
        .unit("rad.m").min(0.0).description("steering angle per curvature in a slow turn, for that bound");
    UndersteerGradient = 34, real "understeer_gradient", Parameter, Tunable, at parameters.lateral_acceleration.understeer_gradient_rads2pm,
        .unit("rad.s2/m").min(0.0).nominal(0.01).description("steering angle per lateral acceleration beyond that, for that bound");
    SustainedRate = 35, real "sustained_rate", Parameter, Tunable, at parameters.large_errors.sustained_rate_radps,
        .unit("rad/s").display_unit("deg/s").min(0.0).nominal(10.0).description("rate of the steering angle with the slowest actuator looked for");
    RateReserveTime = 36, real "rate_reserve_time", Parameter, Tunable, at parameters.large_errors.rate_reserve_time_s,
        .unit("s").min(0.0).nominal(0.1).description("reserve of time at the largest rate, after which the anti-windup is quicker");
    YawRateLag = 37, real "yaw_rate_lag", Parameter, Tunable, at parameters.large_errors.yaw_rate_lag_s,
        .unit("s").min(0.0).nominal(0.1).description("lag of the yaw rate behind the steering angle sent, by which a slow actuator is noticed; 0 for not");
}

/// The steering controller (eq 14).
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct LateralPid {
    parameters: PidParameters,
    /// The gains over speed, where the archive has them.
    #[serde(skip)]
    schedule: Option<PidSchedule>,
    inputs: Inputs,
    pid: Pid,
    phase: Phase,
}

/// The inputs, and whether the importer has given the two that the error needs.
#[derive(Debug, Clone, Copy, Serialize, Deserialize)]
struct Inputs {
    pid: PidInput,
    yaw_given: bool,
    reference_given: bool,
}

#[derive(Debug, Clone, Serialize, Deserialize)]
enum Phase {
    /// Before the first step: outputs are those of tick 0 for the present inputs, evaluated on a
    /// copy at each read. `last_read` is what the first step commits.
    BeforeFirstStep { last_read: Inputs },
    /// From then on: outputs are those of the last tick.
    Running { ticks: Ticks, output: PidOutput, warned_of_long_step: bool },
}

impl LateralPid {
    /// The parameters that act at a speed, m/s.
    fn acting(&self, speed: f64) -> Cow<'_, PidParameters> {
        match &self.schedule {
            Some(schedule) => Cow::Owned(schedule.parameters_at(&self.parameters, speed)),
            None => Cow::Borrowed(&self.parameters),
        }
    }

    /// Tick 0 with these inputs, on a copy of the memory.
    fn tick_zero(&self, inputs: &Inputs) -> (Pid, PidOutput) {
        let mut pid = self.pid;
        let parameters = self.acting(inputs.pid.speed);
        let output = if inputs.yaw_given && inputs.reference_given {
            pid.tick(&parameters, &inputs.pid)
        } else {
            pid.prime(&parameters, &inputs.pid)
        };
        (pid, output)
    }

    fn output(&mut self) -> PidOutput {
        let (_, output) = match &mut self.phase {
            Phase::Running { output, .. } => return *output,
            Phase::BeforeFirstStep { last_read } => {
                *last_read = self.inputs;
                let inputs = self.inputs;
                self.tick_zero(&inputs)
            }
        };
        output
    }
}

impl Definition for LateralPid {
    type File = steerwright_formats::Pid;
    const RESOURCE: &'static str = "pid.json";
    const ROLE: Role = Role::Controller;

    fn step_s(file: &Self::File) -> Option<f64> {
        Some(file.sample_time_s)
    }

    /// A step of the reference with a yaw that lags it, feedforward, and one second disabled.
    fn scenario(file: steerwright_formats::Pid) -> Scenario {
        let step = file.specification.step_rad;
        let feedforward = 0.1 * file.limits.max_angle_rad;
        Scenario::new(move |input, Moment { course: t, .. }| {
            let from = |start: f64, value: f64| if t < start { 0.0 } else { value };
            match input {
                "yaw_reference" => Some(from(1.0, step)),
                "yaw" => Some(from(1.2, step * (1.0 - (-(t - 1.2) / 0.5).exp()))),
                "steering_feedforward" => {
                    Some(from(5.0, feedforward * (TAU * 0.5 * (t - 5.0)).sin()))
                }
                "enabled" if (7.0..8.0).contains(&t) => Some(0.0),
                "enabled" => Some(1.0),
                _ => None,
            }
        })
    }
}

impl CoSimulationUnit for LateralPid {
    type Variable = V;
    const TABLE: &'static Table = V::TABLE;
    /// The outputs are held between ticks and jump at them, so no derivative is useful.
    const CAPABILITIES: Capabilities = Capabilities { serializes: true, ..Capabilities::NONE };

    fn open(resources: &Resources) -> Result<Self, String> {
        let file = optional::<steerwright_formats::Pid>(resources, Self::RESOURCE)?;
        let parameters = match &file {
            Some(file) => steerwright_models::files::pid_parameters(file),
            None => PidParameters::default(),
        };
        let schedule = file.as_ref().and_then(steerwright_models::files::pid_schedule);
        let inputs = Inputs {
            pid: PidInput {
                yaw_reference: 0.0,
                yaw: 0.0,
                steering_feedforward: 0.0,
                enabled: true,
                // Unconnected, the limits are those of the speed designed for.
                speed: file.map_or(0.0, |pid| pid.designed_for.speed_mps),
            },
            yaw_given: false,
            reference_given: false,
        };
        let phase = Phase::BeforeFirstStep { last_read: inputs };
        with_start_values(
            Self { parameters, schedule, inputs, pid: Pid::default(), phase },
            resources,
        )
    }

    #[inline]
    fn get(&mut self, variable: V) -> Value {
        Value::Real(match variable {
            V::SteeringAngle => self.output().steering_angle,
            V::Saturated => return Value::Boolean(self.output().saturated),
            V::Enabled => return Value::Boolean(self.inputs.pid.enabled),
            other => other.place(self).map_or(0.0, |value| *value),
        })
    }

    #[inline]
    fn set(&mut self, variable: V, value: &Value) {
        match (variable, value) {
            (V::Enabled, Value::Boolean(enabled)) => self.inputs.pid.enabled = *enabled,
            (V::YawReference, Value::Real(_)) => self.inputs.reference_given = true,
            (V::Yaw, Value::Real(_)) => self.inputs.yaw_given = true,
            _ => {}
        }
        if let (Value::Real(value), Some(place)) = (value, variable.place(self)) {
            *place = *value;
        }
    }

    fn exit_initialization(&mut self, _start_time: f64, _log: &mut Log) -> Result<(), String> {
        self.phase = Phase::BeforeFirstStep { last_read: self.inputs };
        outputs_are_finite(self)
    }

    fn step(&mut self, _time: f64, step: f64, log: &mut Log) -> Result<(), String> {
        let sample_time = self.parameters.sample_time;
        let ticks_in_step = ticks_in(step, sample_time)?;
        if let Phase::BeforeFirstStep { last_read } = self.phase {
            let (pid, output) = self.tick_zero(&last_read);
            self.pid = pid;
            self.phase = Phase::Running { ticks: Ticks::new(), output, warned_of_long_step: false };
        }
        let parameters = self.acting(self.inputs.pid.speed).into_owned();
        let Phase::Running { ticks, output, warned_of_long_step } = &mut self.phase else {
            return Ok(());
        };
        let count = ticks.advance(ticks_in_step);
        if count > 1 {
            warn_of_long_step(
                warned_of_long_step,
                log,
                [step, sample_time],
                count,
                "they see the same inputs; step by sample_time for the loop that was designed",
            );
        }
        for _ in 0..count {
            *output = self.pid.tick(&parameters, &self.inputs.pid);
        }
        self.pid.check().map_err(|e| refuse(&e))
    }

    fn save(&self) -> Vec<u8> {
        encode(self)
    }

    fn load(&mut self, bytes: &[u8]) -> Result<(), String> {
        let mut loaded: Self = decode(bytes)?;
        loaded.pid.check().map_err(|e| refuse(&e))?;
        check_settable(&mut loaded)?;
        match &loaded.phase {
            Phase::BeforeFirstStep { last_read } => {
                let read = &last_read.pid;
                let values = [read.yaw_reference, read.yaw, read.steering_feedforward, read.speed];
                if values.iter().any(|value| !value.is_finite()) {
                    return Err("an input of the saved state is not finite".into());
                }
            }
            Phase::Running { ticks, output, .. } => {
                ticks.check().map_err(|e| refuse(&e))?;
                if !output.steering_angle.is_finite() {
                    return Err("the steering angle of the saved state is not finite".into());
                }
            }
        }
        *self = Self { schedule: self.schedule.take(), ..loaded };
        Ok(())
    }
}
