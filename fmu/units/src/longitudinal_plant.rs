//! `LongitudinalPlant`: the glue from [`steerwright_models::LongitudinalPlant`] to the export trait.

use self::Variable as V;
use crate::fmu::{Definition, Role};
use crate::resources::{required, with_start_values};
use crate::saved::{check_settable, decode, encode, outputs_are_finite, refuse};
use crate::scenario::{Moment, Scenario, weave};
use fmi2_export::{
    Capabilities, CoSimulationUnit, Known, Log, Resources, StateSpec, Unknown, variables,
};
use model_description::DependsOn::{Nothing, On};
use model_description::{DependencyKind, Table, Value};
use serde::{Deserialize, Serialize};
use std::f64::consts::TAU;
use std::sync::Arc;
use steerwright_formats::Longitudinal;
use steerwright_models::SavedLongitudinalPlant;

variables! {
    /// Variables of the longitudinal plant. The states are listed by the layer, and so are the dependencies on them.
    Variable of LongitudinalPlant, "LongitudinalPlant", "response of the speed identified from a drive: accelerator and brake or acceleration command in, speed out";
    Accelerator = 0, real "accelerator", Input, Continuous, at plant.inputs.accelerator,
        .unit("1").display_unit("%").description("accelerator from 0 to 1; has no effect where the model has an acceleration command");
    Brake = 1, real "brake", Input, Continuous, at plant.inputs.brake,
        .unit("1").display_unit("%").description("brake from 0 to 1; has no effect where the model has no brake");
    AccelerationCommand = 2, real "acceleration_command", Input, Continuous, at plant.inputs.acceleration_command,
        .unit("m/s2").description("acceleration command; has no effect where the model has an accelerator");
    Grade = 3, real "grade", Input, Continuous, at plant.inputs.grade,
        .unit("rad").display_unit("deg").min(-std::f64::consts::FRAC_PI_2).max(std::f64::consts::FRAC_PI_2).nominal(0.1)
        .description("angle of the road, positive uphill");
    Gear = 4, integer "gear", Input, Discrete,
        .description("number of the gear as the log has it; one without a gain of its own has the mean gain");
    Speed = 10, real "speed", Output, Continuous,
        .unit("m/s").display_unit("km/h").min(0.0).nominal(10.0).depends_on(Nothing).initial_depends_on(On(&["initial_speed"]))
        .description("speed of the vehicle");
    Acceleration = 11, real "acceleration", Output, Continuous,
        .unit("m/s2").depends_on(On(&["grade"]))
        .initial_depends_on(On(&["accelerator", "brake", "acceleration_command", "grade", "gear", "brake_gain", "resistance",
            "resistance_per_speed", "drag", "pedal_curvature", "grade_coefficient", "initial_speed"]))
        .description("derivative of the speed; 0 while the vehicle stands");
    Distance = 12, real "distance", Output, Continuous,
        .unit("m").nominal(100.0).depends_on(Nothing).initial_depends_on(On(&["initial_distance"]))
        .description("travelled distance");
    TimeConstant = 20, real "time_constant", Parameter, Fixed, at plant.parameters.time_constant,
        .unit("s").min(1e-4).max(100.0).description("lag of the drive, tau");
    Delay = 21, real "delay", Parameter, Fixed, at plant.parameters.delay,
        .unit("s").display_unit("ms").min(0.0).max(10.0).nominal(0.1).description("delay of the drive, d");
    BrakeGain = 22, real "brake_gain", Parameter, Fixed, at plant.parameters.brake_gain,
        .unit("m/s2").nominal(10.0).description("deceleration at a brake of 1, B; 0 without a brake");
    BrakeTimeConstant = 23, real "brake_time_constant", Parameter, Fixed, at plant.parameters.brake_time_constant,
        .unit("s").min(1e-4).max(100.0).description("lag of the brake, sigma");
    BrakeDelay = 24, real "brake_delay", Parameter, Fixed, at plant.parameters.brake_delay,
        .unit("s").display_unit("ms").min(0.0).max(10.0).nominal(0.1).description("delay of the brake, e");
    Resistance = 25, real "resistance", Parameter, Fixed, at plant.parameters.resistance,
        .unit("m/s2").nominal(0.1).description("rolling resistance and drag of the engine, c0");
    ResistancePerSpeed = 26, real "resistance_per_speed", Parameter, Fixed, at plant.parameters.resistance_per_speed,
        .unit("1/s").nominal(0.001).description("resistance per speed, c1");
    Drag = 27, real "drag", Parameter, Fixed, at plant.parameters.drag,
        .unit("1/m").nominal(0.001).description("resistance per squared speed, c2");
    GradeCoefficient = 28, real "grade_coefficient", Parameter, Fixed, at plant.parameters.grade_coefficient,
        .unit("1").description("share of the gravity along the road that acts on the speed, rho");
    PedalCurvature = 29, real "pedal_curvature", Parameter, Fixed, at plant.parameters.pedal_curvature,
        .unit("1").min(-1.0).max(1.0).description("curvature of the accelerator, kappa; has no effect where the model has an acceleration command");
    InitialSpeed = 30, real "initial_speed", Parameter, Fixed, at plant.initial_speed,
        .unit("m/s").display_unit("km/h").min(0.0).nominal(10.0).description("speed at the start");
    InitialDistance = 31, real "initial_distance", Parameter, Fixed, at plant.initial_distance,
        .unit("m").nominal(100.0).description("travelled distance at the start");
}

/// Indices of the states.
const SPEED: usize = 0;
const DISTANCE: usize = 1;
const DRIVE: usize = 2;
const BRAKE: usize = 3;

/// The response of the speed of a vehicle.
#[derive(Debug, Clone)]
pub struct LongitudinalPlant {
    plant: steerwright_models::LongitudinalPlant,
    flags: LongitudinalFlags,
}

/// State besides that of the model.
#[derive(Debug, Clone, Copy, Default, Serialize, Deserialize)]
struct LongitudinalFlags {
    /// Whether initialization mode was left.
    started: bool,
    /// Whether inputs without effect were reported.
    warned: bool,
    /// Whether a pedal beyond its ends was reported.
    warned_of_pedal: bool,
}

/// Values of a pedal from which on its unit is doubted: a tenth beyond its ends, for its calibration.
const PEDAL: std::ops::RangeInclusive<f64> = -0.1..=1.1;

impl LongitudinalPlant {
    /// The plant; until the start as a start from the present settings would leave it. Parameters with which it cannot
    /// start are refused when initialization mode is left.
    #[inline]
    fn plant(&mut self) -> &mut steerwright_models::LongitudinalPlant {
        if !self.flags.started {
            let _ = self.plant.start();
        }
        &mut self.plant
    }

    /// Warns once of a pedal that is used and beyond its ends.
    fn warn_of_pedals(&mut self, log: &mut Log) {
        if self.flags.warned_of_pedal {
            return;
        }
        let inputs = &self.plant.inputs;
        let pedals = [
            ("accelerator", inputs.accelerator, !self.plant.is_acceleration_commanded()),
            ("brake", inputs.brake, self.plant.parameters.brake_gain != 0.0),
        ];
        for (name, value, is_used) in pedals {
            if is_used && !PEDAL.contains(&value) {
                self.flags.warned_of_pedal = true;
                log.warning(format!(
                    "{name} is {value}, beyond 0 and 1: its unit is 1, and 1 is the pressed pedal"
                ));
            }
        }
    }

    /// Warns once of inputs that the model does not have.
    fn warn_of_unused_inputs(&mut self, log: &mut Log) {
        if self.flags.warned {
            return;
        }
        let (model, inputs) = (self.plant.document(), &self.plant.inputs);
        let is_commanded = self.plant.is_acceleration_commanded();
        let command = if is_commanded { "an acceleration command" } else { "an accelerator" };
        let mut lines = Vec::new();
        for (name, is_set, is_used) in [
            ("accelerator", inputs.accelerator != 0.0, !is_commanded),
            ("acceleration_command", inputs.acceleration_command != 0.0, is_commanded),
        ] {
            if is_set && !is_used {
                lines.push(format!("{name} has no effect: the command of the model is {command}"));
            }
        }
        if inputs.brake != 0.0 && self.plant.parameters.brake_gain == 0.0 {
            lines.push("brake has no effect: the model has no brake".to_owned());
        }
        if inputs.gear != 0 && model.gear_gains.is_empty() {
            lines.push("gear has no effect: the gains of the model are over the speed".to_owned());
        }
        if !lines.is_empty() {
            self.flags.warned = true;
            log.warning(lines.join("; "));
        }
    }
}

impl Definition for LongitudinalPlant {
    type File = Longitudinal;
    const RESOURCE: &'static str = "longitudinal.json";
    const ROLE: Role = Role::Speed;

    /// Pedals, or an acceleration command, on hills and in two gears, until the vehicle stands.
    fn scenario(file: Longitudinal) -> Scenario {
        let is_commanded = file.command_unit == "m/s2";
        let gears = match file.gear_gains.as_slice() {
            [] => None,
            [first, .., last] => Some([first.gear, last.gear]),
            [only] => Some([only.gear, only.gear + 1]),
        };
        Scenario::new(move |input, Moment { course: t, .. }| match input {
            "accelerator" if !is_commanded => Some(weave(t).max(0.0)),
            "acceleration_command" if is_commanded => Some(2.0 * weave(t)),
            "brake" if t < 8.5 => Some(0.2 * (-weave(t)).max(0.0)),
            "brake" => Some(1.0),
            "grade" => Some(0.05 * (TAU * 0.1 * t).sin()),
            "gear" => {
                let [first, second] = gears?;
                Some((if t < 5.0 { first } else { second }) as f64)
            }
            _ => None,
        })
    }
}

impl CoSimulationUnit for LongitudinalPlant {
    type Variable = V;
    const TABLE: &'static Table = V::TABLE;
    /// Inputs are held within a step, as in the identification.
    const CAPABILITIES: Capabilities =
        Capabilities { interpolates_inputs: false, ..Capabilities::ALL };

    fn open(resources: &Resources) -> Result<Self, String> {
        let document = required::<Longitudinal>(resources, Self::RESOURCE)?;
        let plant = steerwright_models::LongitudinalPlant::new(Arc::new(document))
            .map_err(|e| format!("longitudinal.json: {e}; hint: {}", e.hint()))?;
        with_start_values(Self { plant, flags: LongitudinalFlags::default() }, resources)
    }

    #[inline]
    fn get(&mut self, variable: V) -> Value {
        Value::Real(match variable {
            V::Gear => return Value::Integer(self.plant.inputs.gear),
            V::Speed => self.plant().speed(),
            V::Acceleration => self.plant().acceleration(),
            V::Distance => self.plant().distance(),
            other => other.place(self).map_or(0.0, |value| *value),
        })
    }

    #[inline]
    fn set(&mut self, variable: V, value: &Value) {
        match (variable, value) {
            (V::Gear, Value::Integer(gear)) => self.plant.inputs.gear = *gear,
            (_, Value::Real(value)) => {
                if let Some(place) = variable.place(self) {
                    *place = *value;
                }
            }
            _ => {}
        }
    }

    fn exit_initialization(&mut self, _start_time: f64, _log: &mut Log) -> Result<(), String> {
        self.flags.started = true;
        self.plant.start().map_err(|e| refuse(&e))?;
        outputs_are_finite(self)
    }

    fn step(&mut self, _time: f64, step: f64, log: &mut Log) -> Result<(), String> {
        self.warn_of_unused_inputs(log);
        self.warn_of_pedals(log);
        self.plant.step(step).map_err(|e| refuse(&e))
    }

    fn states(&self) -> Vec<StateSpec> {
        let mut states = Vec::new();
        for (description, unit, derivative_unit) in [
            ("speed", "m/s", "m/s2"),
            ("travelled distance", "m", "m/s"),
            ("acceleration that the drive causes", "m/s2", "m/s3"),
            ("acceleration that the brake causes", "m/s2", "m/s3"),
        ] {
            states.push(StateSpec {
                description: description.into(),
                unit: Some(unit),
                derivative_unit: Some(derivative_unit),
                settable: false,
            });
        }
        states
    }

    fn state(&mut self, index: usize) -> f64 {
        self.plant().state(index)
    }

    fn state_derivative(&mut self, index: usize) -> f64 {
        self.plant().state_rate(index)
    }

    fn output_derivative(&mut self, variable: V) -> f64 {
        let p = self.plant();
        match variable {
            V::Speed => p.acceleration(),
            V::Distance => p.speed(),
            V::Acceleration => p.jerk(),
            _ => 0.0,
        }
    }

    fn dependency(&self, unknown: Unknown<V>, known: Known<V>) -> Option<DependencyKind> {
        use Known::{State, Variable};
        let is_drive = match known {
            Variable(V::Accelerator | V::PedalCurvature) => !self.plant.is_acceleration_commanded(),
            Variable(V::AccelerationCommand) => self.plant.is_acceleration_commanded(),
            Variable(V::Gear) => !self.plant.document().gear_gains.is_empty(),
            known => known == Variable(V::InitialSpeed),
        };
        let is_brake = matches!(known, Variable(V::Brake | V::BrakeGain));
        let depends = match unknown {
            Unknown::Variable(V::Speed) | Unknown::Derivative(DISTANCE) | Unknown::State(SPEED) => {
                if known == State(SPEED) {
                    return Some(DependencyKind::Constant);
                }
                known == Variable(V::InitialSpeed)
            }
            Unknown::Variable(V::Distance) | Unknown::State(DISTANCE) => {
                if known == State(DISTANCE) {
                    return Some(DependencyKind::Constant);
                }
                known == Variable(V::InitialDistance)
            }
            Unknown::Variable(V::Acceleration) => {
                matches!(known, State(SPEED | DRIVE | BRAKE) | Variable(V::Grade))
            }
            Unknown::Derivative(SPEED) => {
                let by_road_and_drag = matches!(
                    known,
                    State(SPEED | DRIVE | BRAKE)
                        | Variable(
                            V::Grade
                                | V::Resistance
                                | V::ResistancePerSpeed
                                | V::Drag
                                | V::GradeCoefficient
                        )
                );
                // Before the start the lags are in the steady state of the inputs.
                by_road_and_drag || is_drive || is_brake
            }
            Unknown::Derivative(DRIVE) => {
                matches!(known, State(SPEED | DRIVE) | Variable(V::TimeConstant | V::Delay))
                    || is_drive
            }
            Unknown::Derivative(_) => {
                matches!(known, State(BRAKE) | Variable(V::BrakeTimeConstant | V::BrakeDelay))
                    || is_brake
            }
            Unknown::State(DRIVE) => is_drive,
            Unknown::State(_) => is_brake,
            Unknown::Variable(_) => false,
        };
        if depends { Some(DependencyKind::Dependent) } else { None }
    }

    /// By states; by inputs and parameters the layer takes differences.
    fn partial_derivative(&mut self, unknown: Unknown<V>, known: Known<V>) -> Option<f64> {
        let Known::State(state) = known else { return None };
        let plant = self.plant();
        Some(match unknown {
            Unknown::Variable(V::Acceleration) => plant.partial(SPEED, state),
            Unknown::Variable(V::Speed) => f64::from(u8::from(state == SPEED)),
            Unknown::Variable(V::Distance) => f64::from(u8::from(state == DISTANCE)),
            Unknown::Derivative(rate) => plant.partial(rate, state),
            Unknown::Variable(_) | Unknown::State(_) => 0.0,
        })
    }

    fn save(&self) -> Vec<u8> {
        encode(&(self.flags, self.plant.save()))
    }

    fn load(&mut self, bytes: &[u8]) -> Result<(), String> {
        let (flags, saved): (LongitudinalFlags, SavedLongitudinalPlant) = decode(bytes)?;
        let plant = self.plant.restored(saved).map_err(|e| refuse(&e))?;
        let mut loaded = Self { plant, flags };
        check_settable(&mut loaded)?;
        *self = loaded;
        Ok(())
    }
}
