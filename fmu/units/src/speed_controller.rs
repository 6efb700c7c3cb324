//! `SpeedController`: the glue from [`steerwright_models::SpeedControl`] to the export trait.

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
use std::f64::consts::{FRAC_PI_2, TAU};
use std::sync::Arc;
use steerwright_models::speed::speed_control_parameters;
use steerwright_models::{
    SavedSpeedControl, SpeedControl, SpeedControlInputs, SpeedControlOutputs,
    SpeedControlParameters, Ticks,
};

variables! {
    /// Variables of the speed controller. Its outputs are held between ticks, so at a communication point they depend
    /// on no input.
    Variable of SpeedController, "SpeedController", "speed controller: speed reference and speed in, accelerator and brake or acceleration command out";
    SpeedReference = 0, real "speed_reference", Input, Continuous, at inputs.speed_reference,
        .unit("m/s").display_unit("km/h").min(0.0).nominal(10.0).description("speed to reach; 0 holds the vehicle at standstill");
    AccelerationReference = 1, real "acceleration_reference", Input, Continuous, at inputs.acceleration_reference,
        .unit("m/s2").description("derivative of the speed reference; 0 where it is unknown");
    Speed = 2, real "speed", Input, Continuous, at inputs.speed,
        .unit("m/s").display_unit("km/h").min(0.0).nominal(10.0).description("speed of the vehicle");
    Grade = 3, real "grade", Input, Continuous, at inputs.grade,
        .unit("rad").display_unit("deg").min(-FRAC_PI_2).max(FRAC_PI_2).nominal(0.1)
        .description("angle of the road, positive uphill; 0 where it is unknown");
    Gear = 4, integer "gear", Input, Discrete,
        .description("number of the gear; one without a gain of its own has the mean gain");
    Enabled = 5, boolean "enabled", Input, Discrete,
        .description("whether the controller acts; otherwise its outputs are 0");
    Accelerator = 10, real "accelerator", Output, Discrete,
        .unit("1").display_unit("%").depends_on(Nothing).description("accelerator from 0 to 1; 0 where the model has an acceleration command");
    Brake = 11, real "brake", Output, Discrete,
        .unit("1").display_unit("%").depends_on(Nothing).description("brake from 0 to 1; 0 where the model has no brake");
    AccelerationCommand = 12, real "acceleration_command", Output, Discrete,
        .unit("m/s2").depends_on(Nothing).description("acceleration command; 0 where the model has an accelerator");
    Saturated = 13, boolean "saturated", Output, Discrete,
        .depends_on(Nothing).description("whether acceleration or pedal were at a limit at the last tick");
    Holding = 14, boolean "holding", Output, Discrete,
        .depends_on(Nothing).description("whether the vehicle is held at standstill");
    Kp = 20, real "kp", Parameter, Tunable, at parameters.gains.kp_per_s,
        .unit("1/s").min(0.0).description("proportional gain, acceleration per error of the speed");
    Ki = 21, real "ki", Parameter, Tunable, at parameters.gains.ki_per_s2,
        .unit("1/s2").min(0.0).description("integral gain");
    ReferenceRate = 22, real "reference_rate", Parameter, Tunable, at parameters.gains.reference_rate_per_s,
        .unit("1/s").min(1e-3).max(1e3).description("rate at which the reference model approaches the speed reference");
    MaxAcceleration = 23, real "max_acceleration", Parameter, Tunable, at parameters.limits.max_acceleration_mps2,
        .unit("m/s2").min(0.0).description("largest acceleration");
    MaxDeceleration = 24, real "max_deceleration", Parameter, Tunable, at parameters.limits.max_deceleration_mps2,
        .unit("m/s2").min(0.0).description("largest deceleration");
    MaxJerk = 25, real "max_jerk", Parameter, Tunable, at parameters.limits.max_jerk_mps3,
        .unit("m/s3").min(0.0).description("largest jerk to either side");
    PedalHysteresis = 26, real "pedal_hysteresis", Parameter, Tunable, at parameters.limits.pedal_hysteresis_mps2,
        .unit("m/s2").min(0.0).nominal(0.1).description("demand beyond 0 at which the other pedal is used");
    HoldSpeed = 27, real "hold_speed", Parameter, Tunable, at parameters.limits.hold_speed_mps,
        .unit("m/s").min(0.0).description("speed below which the vehicle is held where the speed reference is 0");
    HoldDeceleration = 28, real "hold_deceleration", Parameter, Tunable, at parameters.limits.hold_deceleration_mps2,
        .unit("m/s2").min(0.0).description("deceleration of the held brake in addition to that which the grade requires");
    SampleTime = 30, real "sample_time", Parameter, Fixed, at parameters.sample_time,
        .unit("s").min(1e-6).max(1.0).nominal(0.01).description("time between ticks");
}

/// The speed controller.
#[derive(Debug, Clone)]
pub struct SpeedController {
    parameters: SpeedControlParameters,
    inputs: SpeedControlInputs,
    control: SpeedControl,
    phase: Phase,
}

#[derive(Debug, Clone, Copy, Serialize, Deserialize)]
enum Phase {
    /// Before the first step: outputs are those of tick 0 for the present inputs, evaluated on a copy at each read.
    /// `last_read` is what the first step commits.
    BeforeFirstStep { last_read: SpeedControlInputs },
    /// From then on: outputs are those of the last tick.
    Running { ticks: Ticks, output: SpeedControlOutputs, warned_of_long_step: bool },
}

impl SpeedController {
    fn output(&mut self) -> SpeedControlOutputs {
        match &mut self.phase {
            Phase::Running { output, .. } => *output,
            Phase::BeforeFirstStep { last_read } => {
                *last_read = self.inputs;
                // What fails here is reported by the first step.
                self.control.clone().tick(&self.parameters, &self.inputs).unwrap_or_default()
            }
        }
    }
}

impl Definition for SpeedController {
    type File = steerwright_formats::SpeedController;
    const RESOURCE: &'static str = "speed_controller.json";
    const ROLE: Role = Role::Controller;

    fn step_s(file: &Self::File) -> Option<f64> {
        Some(file.sample_time_s)
    }

    /// A start, a step up and down with a speed that lags the reference, a hill, one second disabled, and standstill.
    fn scenario(file: steerwright_formats::SpeedController) -> Scenario {
        let gear = file.model.gear_gains.first().map(|row| row.gear as f64);
        let step = file.specification.step_mps;
        Scenario::new(move |input, Moment { course: t, .. }| match input {
            "speed_reference" => Some(match t {
                t if t < 2.0 => 10.0,
                t if t < 5.0 => 10.0 + step,
                t if t < 8.0 => 10.0 - step,
                _ => 0.0,
            }),
            "speed" => Some(match t {
                t if t < 2.5 => 10.0,
                t if t < 5.5 => 10.0 + step * (1.0 - (-(t - 2.5)).exp()),
                t if t < 8.5 => 10.0 - step + 2.0 * step * (-(t - 5.5)).exp(),
                _ => 0.0,
            }),
            "acceleration_reference" => Some(if (2.0..3.0).contains(&t) { 0.5 } else { 0.0 }),
            "grade" => Some(0.05 * (TAU * 0.1 * t).sin()),
            "gear" => gear,
            "enabled" if (6.5..7.5).contains(&t) => Some(0.0),
            "enabled" => Some(1.0),
            _ => None,
        })
    }
}

impl CoSimulationUnit for SpeedController {
    type Variable = V;
    const TABLE: &'static Table = V::TABLE;
    /// The outputs are held between ticks and jump at them, so no derivative is useful.
    const CAPABILITIES: Capabilities = Capabilities { serializes: true, ..Capabilities::NONE };

    fn open(resources: &Resources) -> Result<Self, String> {
        let file = required::<steerwright_formats::SpeedController>(resources, Self::RESOURCE)?;
        let parameters = speed_control_parameters(&file);
        let control = SpeedControl::new(Arc::new(file.model))
            .map_err(|e| format!("speed_controller.json: {e}; hint: {}", e.hint()))?;
        let inputs = SpeedControlInputs { enabled: true, ..SpeedControlInputs::default() };
        let phase = Phase::BeforeFirstStep { last_read: inputs };
        with_start_values(Self { parameters, inputs, control, phase }, resources)
    }

    #[inline]
    fn get(&mut self, variable: V) -> Value {
        Value::Real(match variable {
            V::Gear => return Value::Integer(self.inputs.gear),
            V::Enabled => return Value::Boolean(self.inputs.enabled),
            V::Saturated => return Value::Boolean(self.output().saturated),
            V::Holding => return Value::Boolean(self.output().holding),
            V::Accelerator => self.output().accelerator,
            V::Brake => self.output().brake,
            V::AccelerationCommand => self.output().acceleration_command,
            other => other.place(self).map_or(0.0, |value| *value),
        })
    }

    #[inline]
    fn set(&mut self, variable: V, value: &Value) {
        match (variable, value) {
            (V::Gear, Value::Integer(gear)) => self.inputs.gear = *gear,
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
            let output = self.control.tick(&self.parameters, &last_read).map_err(|e| refuse(&e))?;
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
                "they see the same inputs; step by sample_time for the loop that was designed",
            );
        }
        for _ in 0..count {
            *output = self.control.tick(&self.parameters, &self.inputs).map_err(|e| refuse(&e))?;
        }
        Ok(())
    }

    fn save(&self) -> Vec<u8> {
        encode(&(self.parameters, self.inputs, self.control.save(), self.phase))
    }

    fn load(&mut self, bytes: &[u8]) -> Result<(), String> {
        let (parameters, inputs, saved, phase): (_, _, SavedSpeedControl, Phase) = decode(bytes)?;
        let control = self.control.restored(saved).map_err(|e| refuse(&e))?;
        let mut loaded = Self { parameters, inputs, control, phase };
        check_settable(&mut loaded)?;
        match &loaded.phase {
            Phase::BeforeFirstStep { last_read: read } => {
                let values =
                    [read.speed_reference, read.acceleration_reference, read.speed, read.grade];
                if values.iter().any(|value| !value.is_finite()) {
                    return Err("an input of the saved state is not finite".into());
                }
            }
            Phase::Running { ticks, output, .. } => {
                ticks.check().map_err(|e| refuse(&e))?;
                let values = [output.accelerator, output.brake, output.acceleration_command];
                if values.iter().any(|value| !value.is_finite()) {
                    return Err("an output of the saved state is not finite".into());
                }
            }
        }
        *self = loaded;
        Ok(())
    }
}
