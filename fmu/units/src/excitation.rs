//! `Excitation`: the glue from [`steerwright_models::DrivenManoeuvre`] to the export trait.

use self::Variable as V;
use crate::fmu::{Definition, Role};
use crate::resources::{required, with_start_values};
use crate::saved::{check_settable, decode, encode, outputs_are_finite, refuse};
use crate::scenario::{Moment, Scenario};
use crate::ticking::{ticks_in, warn_of_long_step};
use fmi2_export::{Capabilities, CoSimulationUnit, Log, Resources, variables};
use model_description::DependsOn::Nothing;
use model_description::{Table, Value};
use serde::{Deserialize, Serialize};
use std::sync::Arc;
use steerwright_formats::Manoeuvre;
use steerwright_models::{
    DrivenManoeuvre, ManoeuvreInputs, ManoeuvreOutputs, ManoeuvreParameters, SavedManoeuvre, Ticks,
};

variables! {
    /// Variables of the excitation. Its outputs are held between ticks, so at a communication point they depend on no
    /// input.
    Variable of Excitation, "Excitation", "steering manoeuvre that identifies a vehicle: speed and lateral acceleration in, steering angle out";
    Enabled = 0, boolean "enabled", Input, Discrete,
        .description("whether the manoeuvre is driven; after an interruption a block is driven again once this was false");
    Speed = 1, real "speed", Input, Continuous, at inputs.speed,
        .unit("m/s").display_unit("km/h").min(0.0).nominal(10.0).description("speed of the vehicle");
    LateralAcceleration = 2, real "lateral_acceleration", Input, Continuous, at inputs.lateral_acceleration,
        .unit("m/s2").description("lateral acceleration of the vehicle; 0 where it is not measured: it then interrupts nothing");
    SteeringAngle = 10, real "steering_angle", Output, Discrete,
        .unit("rad").display_unit("deg").nominal(0.1).depends_on(Nothing).description("steering angle");
    SpeedReference = 11, real "speed_reference", Output, Discrete,
        .unit("m/s").display_unit("km/h").nominal(10.0).depends_on(Nothing).description("speed of the block that is driven or waits for it");
    Active = 12, boolean "active", Output, Discrete,
        .depends_on(Nothing).description("whether a block is driven");
    Finished = 13, boolean "finished", Output, Discrete,
        .depends_on(Nothing).description("whether all blocks have been driven");
    Block = 14, integer "block", Output, Discrete,
        .depends_on(Nothing).description("number of the block that is driven or waits for its speed, from 1");
    Interruption = 15, integer "interruption", Output, Discrete,
        .depends_on(Nothing).description("what interrupted the block: 0 nothing, 1 the lateral acceleration, 2 the speed, 3 it was disabled");
    MaxLateralAcceleration = 20, real "max_lateral_acceleration", Parameter, Tunable, at parameters.max_lateral_acceleration,
        .unit("m/s2").min(0.01).description("lateral acceleration that interrupts a block");
    SpeedTolerance = 21, real "speed_tolerance", Parameter, Tunable, at parameters.speed_tolerance,
        .unit("m/s").min(0.0).description("how far the speed may be from that of the block, to begin it and while it is driven");
    ReturnRate = 22, real "return_rate", Parameter, Tunable, at parameters.return_rate,
        .unit("rad/s").display_unit("deg/s").min(0.0).description("rate at which the steering angle of an interrupted block returns to 0");
    SampleTime = 30, real "sample_time", Parameter, Fixed, at parameters.sample_time,
        .unit("s").min(1e-6).max(1.0).nominal(0.01).description("time between ticks: that of the signals");
}

/// How far the speed may be from that of the block, as a share of it.
const TOLERANCE: f64 = 0.1;

/// A manoeuvre that is driven.
#[derive(Debug, Clone)]
pub struct Excitation {
    parameters: ManoeuvreParameters,
    inputs: ManoeuvreInputs,
    manoeuvre: DrivenManoeuvre,
    phase: Phase,
}

#[derive(Debug, Clone, Copy, Serialize, Deserialize)]
enum Phase {
    /// Before the first step: outputs are those of tick 0 for the present inputs, evaluated on a copy at each read.
    /// `last_read` is what the first step commits.
    BeforeFirstStep { last_read: ManoeuvreInputs },
    /// From then on: outputs are those of the last tick.
    Running { ticks: Ticks, output: ManoeuvreOutputs, warned_of_long_step: bool },
}

impl Excitation {
    fn output(&mut self) -> ManoeuvreOutputs {
        match &mut self.phase {
            Phase::Running { output, .. } => *output,
            Phase::BeforeFirstStep { last_read } => {
                *last_read = self.inputs;
                self.manoeuvre.clone().tick(&self.parameters, &self.inputs)
            }
        }
    }
}

impl Definition for Excitation {
    type File = Manoeuvre;
    const RESOURCE: &'static str = "excitation.json";
    const ROLE: Role = Role::Controller;

    fn step_s(file: &Self::File) -> Option<f64> {
        Some(file.sample_time_s)
    }

    /// The whole manoeuvre.
    fn experiment_s(file: &Self::File, _step_s: f64) -> f64 {
        file.time_s().max(10.0)
    }

    /// A second of the first block, a lateral acceleration at the limit, half a second disabled, the block again, and at last
    /// a speed that leaves its range.
    fn scenario(file: Manoeuvre) -> Scenario {
        let speed = first_speed(&file);
        let limit = file.limits.max_lateral_acceleration_mps2;
        Scenario::new(move |input, Moment { course: t, .. }| match input {
            "enabled" => Some(if (1.5..2.0).contains(&t) { 0.0 } else { 1.0 }),
            "speed" => Some(if t < 9.0 { speed } else { 0.8 * speed }),
            "lateral_acceleration" => {
                Some(if (1.0..1.2).contains(&t) { limit } else { 0.3 * limit })
            }
            _ => None,
        })
    }
}

/// The speed of the first block, m/s.
fn first_speed(file: &Manoeuvre) -> f64 {
    let first = file.schedule.first().and_then(|block| file.signals.get(block.signal));
    first.map_or(0.0, |signal| signal.speed_mps)
}

impl CoSimulationUnit for Excitation {
    type Variable = V;
    const TABLE: &'static Table = V::TABLE;
    /// The outputs are held between ticks and jump at them, so no derivative is useful.
    const CAPABILITIES: Capabilities = Capabilities { serializes: true, ..Capabilities::NONE };

    fn open(resources: &Resources) -> Result<Self, String> {
        let file = required::<Manoeuvre>(resources, Self::RESOURCE)?;
        let speed = first_speed(&file);
        let slowest = file.signals.iter().map(|s| s.speed_mps).fold(f64::INFINITY, f64::min);
        let fastest = file.signals.iter().map(|s| s.peaks.rate_radps).fold(0.0, f64::max);
        let parameters = ManoeuvreParameters {
            max_lateral_acceleration: file.limits.max_lateral_acceleration_mps2,
            speed_tolerance: TOLERANCE * slowest.min(speed),
            return_rate: file.limits.max_rate_radps.unwrap_or(fastest),
            sample_time: file.sample_time_s,
        };
        let manoeuvre = DrivenManoeuvre::new(Arc::new(file)).map_err(|e| {
            format!("{}: {e}; hint: design one with: steerwright excite", Self::RESOURCE)
        })?;
        let inputs = ManoeuvreInputs { enabled: true, speed, lateral_acceleration: 0.0 };
        let phase = Phase::BeforeFirstStep { last_read: inputs };
        with_start_values(Self { parameters, inputs, manoeuvre, phase }, resources)
    }

    #[inline]
    fn get(&mut self, variable: V) -> Value {
        Value::Real(match variable {
            V::Enabled => return Value::Boolean(self.inputs.enabled),
            V::Active => return Value::Boolean(self.output().active),
            V::Finished => return Value::Boolean(self.output().finished),
            V::Block => return Value::Integer(self.output().block),
            V::Interruption => return Value::Integer(self.output().interruption as i32),
            V::SteeringAngle => self.output().steering_angle,
            V::SpeedReference => self.output().speed_reference,
            other => other.place(self).map_or(0.0, |value| *value),
        })
    }

    #[inline]
    fn set(&mut self, variable: V, value: &Value) {
        match (variable, value) {
            (V::Enabled, Value::Boolean(enabled)) => self.inputs.enabled = *enabled,
            (_, Value::Real(value)) => {
                if let Some(place) = variable.place(self) {
                    *place = *value;
                }
            }
            _ => {}
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
            let output = self.manoeuvre.tick(&self.parameters, &last_read);
            self.phase = Phase::Running { ticks: Ticks::new(), output, warned_of_long_step: false };
        }
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
                "all but the last are left out; step by sample_time",
            );
        }
        for _ in 0..count {
            *output = self.manoeuvre.tick(&self.parameters, &self.inputs);
        }
        Ok(())
    }

    fn save(&self) -> Vec<u8> {
        encode(&(self.parameters, self.inputs, self.manoeuvre.save(), self.phase))
    }

    fn load(&mut self, bytes: &[u8]) -> Result<(), String> {
        let (parameters, inputs, saved, phase): (_, _, SavedManoeuvre, Phase) = decode(bytes)?;
        let manoeuvre = self.manoeuvre.restored(saved).map_err(|e| refuse(&e))?;
        let mut loaded = Self { parameters, inputs, manoeuvre, phase };
        check_settable(&mut loaded)?;
        match &loaded.phase {
            Phase::BeforeFirstStep { last_read: read } => {
                if !(read.speed.is_finite() && read.lateral_acceleration.is_finite()) {
                    return Err("an input of the saved state is not finite".into());
                }
            }
            Phase::Running { ticks, output, .. } => {
                ticks.check().map_err(|e| refuse(&e))?;
                if !(output.steering_angle.is_finite() && output.speed_reference.is_finite()) {
                    return Err("an output of the saved state is not finite".into());
                }
            }
        }
        *self = loaded;
        Ok(())
    }
}
