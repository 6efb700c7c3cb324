//! `LateralPid`: the glue from [`steerwright_models::Pid`] to the export trait.

use crate::resources::{optional, with_start_values};
use crate::saved::{check_settable, decode, encode, outputs_are_finite, refuse};
use crate::tables::lateral_pid::Variable as V;
use fmi2_export::{Capabilities, Log, Resources, Slave};
use model_description::{Table, Value};
use serde::{Deserialize, Serialize};
use std::borrow::Cow;
use steerwright_models::{Pid, PidInput, PidOutput, PidParameters, PidSchedule, Ticks};

/// Most ticks in one step: ten hours at 100 Hz. A longer step is a slip of the importer, which
/// gets an error instead of a long wait.
const MOST_TICKS: f64 = 3_600_000.0;

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
    /// A parameter or an input that is a Real; `None` for the others and for outputs.
    #[inline]
    fn number(&mut self, variable: V) -> Option<&mut f64> {
        let (p, input) = (&mut self.parameters, &mut self.inputs.pid);
        Some(match variable {
            V::YawReference => &mut input.yaw_reference,
            V::Yaw => &mut input.yaw,
            V::SteeringFeedforward => &mut input.steering_feedforward,
            V::Speed => &mut input.speed,
            V::Kp => &mut p.kp,
            V::Ki => &mut p.ki,
            V::Kd => &mut p.kd,
            V::DerivativeFilterTime => &mut p.derivative_filter_time,
            V::SetpointWeightProportional => &mut p.setpoint_weight_proportional,
            V::SetpointWeightDerivative => &mut p.setpoint_weight_derivative,
            V::AntiWindupTime => &mut p.anti_windup_time,
            V::MaxAngle => &mut p.max_angle,
            V::MaxIncrement => &mut p.max_increment,
            V::MaxRate => &mut p.max_rate,
            V::MaxYawError => &mut p.max_yaw_error,
            V::YawRateLag => &mut p.yaw_rate_lag,
            V::SustainedRate => &mut p.sustained_rate,
            V::RateReserveTime => &mut p.rate_reserve_time,
            V::MaxLateralAcceleration => &mut p.max_lateral_acceleration,
            V::SteeringPerCurvature => &mut p.steering_per_curvature,
            V::UndersteerGradient => &mut p.understeer_gradient,
            V::SampleTime => &mut p.sample_time,
            V::Enabled | V::SteeringAngle | V::Saturated => return None,
        })
    }

    /// The parameters that act at a speed, m/s.
    fn acting(&self, speed: f64) -> Cow<'_, PidParameters> {
        match &self.schedule {
            Some(schedule) => Cow::Owned(schedule.at(&self.parameters, speed)),
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

impl Slave for LateralPid {
    type Variable = V;
    const TABLE: &'static Table = V::TABLE;
    /// The outputs are held between ticks and jump at them, so no derivative is useful.
    const CAPABILITIES: Capabilities = Capabilities { serializes: true, ..Capabilities::NONE };

    fn open(resources: &Resources) -> Result<Self, String> {
        let file = optional::<steerwright_formats::Pid>(resources, "pid.json")?;
        let parameters =
            file.as_ref().map_or_else(PidParameters::default, steerwright_loading::pid_parameters);
        let schedule = file.as_ref().and_then(steerwright_loading::pid_schedule);
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
            other => self.number(other).map_or(0.0, |value| *value),
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
        if let (Value::Real(value), Some(place)) = (value, self.number(variable)) {
            *place = *value;
        }
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
        let parameters = self.acting(self.inputs.pid.speed).into_owned();
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
