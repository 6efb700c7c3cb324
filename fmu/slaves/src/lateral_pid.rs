//! `LateralPid`: the glue from [`steerwright_models::Pid`] to the export trait.

use crate::finite::outputs_are_finite;
use crate::resources::optional;
use crate::saved::{check_settable, decode, encode, refuse};
use crate::start::with_start_values;
use crate::tables::lateral_pid::Variable;
use fmi2_export::{Capabilities, Log, Resources, Slave};
use model_description::{Table, Value};
use serde::{Deserialize, Serialize};
use steerwright_models::{Pid, PidInput, PidOutput, PidParameters, Ticks};

/// Most ticks in one step: ten hours at 100 Hz. A longer step is a slip of the importer, which
/// gets an error instead of a long wait.
const MOST_TICKS: f64 = 3_600_000.0;

/// The steering controller (eq 14).
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct LateralPid {
    parameters: PidParameters,
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
    /// Tick 0 with these inputs, on a copy of the memory.
    fn tick_zero(&self, inputs: &Inputs) -> (Pid, PidOutput) {
        let mut pid = self.pid;
        let output = if inputs.yaw_given && inputs.reference_given {
            pid.tick(&self.parameters, &inputs.pid)
        } else {
            pid.prime(&self.parameters, &inputs.pid)
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

impl Slave for LateralPid {
    type Variable = Variable;
    const TABLE: &'static Table = Variable::TABLE;
    /// The outputs are held between ticks and jump at them, so no derivative is useful.
    const CAPABILITIES: Capabilities = Capabilities { serializes: true, ..Capabilities::NONE };

    fn open(resources: &Resources) -> Result<Self, String> {
        let file = optional::<steerwright_formats::Pid>(resources, "pid.json")?;
        let parameters =
            file.as_ref().map_or_else(PidParameters::default, steerwright_loading::pid_parameters);
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
        with_start_values(Self { parameters, inputs, pid: Pid::default(), phase }, resources)
    }

    #[inline]
    fn get(&mut self, variable: Variable) -> Value {
        let p = &self.parameters;
        let input = &self.inputs.pid;
        Value::Real(match variable {
            Variable::SteeringAngle => self.output().steering_angle,
            Variable::Saturated => return Value::Boolean(self.output().saturated),
            Variable::Enabled => return Value::Boolean(input.enabled),
            Variable::YawReference => input.yaw_reference,
            Variable::Yaw => input.yaw,
            Variable::SteeringFeedforward => input.steering_feedforward,
            Variable::Speed => input.speed,
            Variable::Kp => p.kp,
            Variable::Ki => p.ki,
            Variable::Kd => p.kd,
            Variable::DerivativeFilterTime => p.derivative_filter_time,
            Variable::SetpointWeightProportional => p.setpoint_weight_proportional,
            Variable::SetpointWeightDerivative => p.setpoint_weight_derivative,
            Variable::AntiWindupTime => p.anti_windup_time,
            Variable::MaxAngle => p.max_angle,
            Variable::MaxIncrement => p.max_increment,
            Variable::MaxRate => p.max_rate,
            Variable::MaxYawError => p.max_yaw_error,
            Variable::SustainedRate => p.sustained_rate,
            Variable::RateReserveTime => p.rate_reserve_time,
            Variable::MaxLateralAcceleration => p.max_lateral_acceleration,
            Variable::SteeringPerCurvature => p.steering_per_curvature,
            Variable::UndersteerGradient => p.understeer_gradient,
            Variable::SampleTime => p.sample_time,
        })
    }

    #[inline]
    fn set(&mut self, variable: Variable, value: &Value) {
        if let (Variable::Enabled, Value::Boolean(enabled)) = (variable, value) {
            self.inputs.pid.enabled = *enabled;
        }
        let Value::Real(value) = *value else { return };
        let p = &mut self.parameters;
        let input = &mut self.inputs;
        *match variable {
            Variable::YawReference => {
                input.reference_given = true;
                &mut input.pid.yaw_reference
            }
            Variable::Yaw => {
                input.yaw_given = true;
                &mut input.pid.yaw
            }
            Variable::SteeringFeedforward => &mut input.pid.steering_feedforward,
            Variable::Speed => &mut input.pid.speed,
            Variable::Kp => &mut p.kp,
            Variable::Ki => &mut p.ki,
            Variable::Kd => &mut p.kd,
            Variable::DerivativeFilterTime => &mut p.derivative_filter_time,
            Variable::SetpointWeightProportional => &mut p.setpoint_weight_proportional,
            Variable::SetpointWeightDerivative => &mut p.setpoint_weight_derivative,
            Variable::AntiWindupTime => &mut p.anti_windup_time,
            Variable::MaxAngle => &mut p.max_angle,
            Variable::MaxIncrement => &mut p.max_increment,
            Variable::MaxRate => &mut p.max_rate,
            Variable::MaxYawError => &mut p.max_yaw_error,
            Variable::SustainedRate => &mut p.sustained_rate,
            Variable::RateReserveTime => &mut p.rate_reserve_time,
            Variable::MaxLateralAcceleration => &mut p.max_lateral_acceleration,
            Variable::SteeringPerCurvature => &mut p.steering_per_curvature,
            Variable::UndersteerGradient => &mut p.understeer_gradient,
            Variable::SampleTime => &mut p.sample_time,
            Variable::Enabled | Variable::SteeringAngle | Variable::Saturated => return,
        } = value;
    }

    fn exit_initialization(&mut self, _start_time: f64, _log: &mut Log) -> Result<(), String> {
        self.phase = Phase::BeforeFirstStep { last_read: self.inputs };
        outputs_are_finite(self)
    }

    fn step(&mut self, _time: f64, step: f64, log: &mut Log) -> Result<(), String> {
        let ticks_in_step = step / self.parameters.sample_time;
        if ticks_in_step > MOST_TICKS {
            return Err(format!(
                "the step of {step} s spans {ticks_in_step:.3e} ticks of {} s, at most \
                 {MOST_TICKS:e} are taken; hint: step by sample_time",
                self.parameters.sample_time
            ));
        }
        if let Phase::BeforeFirstStep { last_read } = self.phase {
            let (pid, output) = self.tick_zero(&last_read);
            self.pid = pid;
            self.phase = Phase::Running { ticks: Ticks::new(), output, warned_of_long_step: false };
        }
        let Phase::Running { ticks, output, warned_of_long_step } = &mut self.phase else {
            return Ok(());
        };
        let count = ticks.advance(ticks_in_step);
        if count > 1 && !*warned_of_long_step {
            *warned_of_long_step = true;
            log.warning(format!(
                "the step of {step} s spans {count} ticks of {} s: they see the same inputs; \
                 step by sample_time for the loop that was designed",
                self.parameters.sample_time
            ));
        }
        for _ in 0..count {
            *output = self.pid.tick(&self.parameters, &self.inputs.pid);
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
        *self = loaded;
        Ok(())
    }
}
