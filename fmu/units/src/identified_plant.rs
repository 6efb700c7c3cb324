//! `IdentifiedPlant`: the glue from [`steerwright_models::IdentifiedPlant`] to the export trait.

use self::Variable as V;
use crate::fmu::{Definition, Role};
use crate::plant::{Flags, kind, pose, settable};
use crate::resources::{required, with_start_values};
use crate::saved::{check_settable, decode, encode, outputs_are_finite, refuse};
use crate::scenario::{SCENARIO_ANGLE, Scenario, steered};
use fmi2_export::{
    Capabilities, CoSimulationUnit, Known, Log, Resources, StateSpec, Unknown, variables,
};
use model_description::DependsOn::{Nothing, On};
use model_description::{DependencyKind, Table, Value};
use std::sync::Arc;
use steerwright_formats::{InputKind, Plant};
use steerwright_models::SavedIdentifiedPlant;
use steerwright_models::sensitivity::{self, Factor};

variables! {
    /// Variables of the identified plant. Without feedthrough no output depends on an input at a
    /// communication point; where a model has one, `CoSimulationUnit::dependency` returns it. The states are
    /// listed by the layer.
    Variable of IdentifiedPlant, "IdentifiedPlant", "lateral dynamics identified from a drive: steering angle in, yaw rate and pose out";
    SteeringAngle = 0, real "steering_angle", Input, Continuous, at plant.steering_angle,
        .unit("rad").display_unit("deg").nominal(0.1).description("steering angle, positive to the left, in the log's coordinates");
    Speed = 1, real "speed", Input, Continuous, at plant.speed,
        .unit("m/s").display_unit("km/h").min(0.0).nominal(10.0).description("speed of the vehicle");
    YawRate = 10, real "yaw_rate", Output, Continuous,
        .unit("rad/s").display_unit("deg/s").nominal(0.1).depends_on(Nothing)
        .initial_depends_on(On(&["noise_scale", "noise_seed"])).description("yaw rate, positive to the left");
    Yaw = 11, real "yaw", Output, Continuous,
        .unit("rad").display_unit("deg").depends_on(Nothing).initial_depends_on(On(&["initial_yaw"]))
        .description("yaw, the integral of the yaw rate, not wrapped");
    X = 12, real "x", Output, Continuous,
        .unit("m").nominal(100.0).depends_on(Nothing).initial_depends_on(On(&["initial_x"])).description("position");
    Y = 13, real "y", Output, Continuous,
        .unit("m").nominal(100.0).depends_on(Nothing).initial_depends_on(On(&["initial_y"])).description("position");
    InitialX = 20, real "initial_x", Parameter, Fixed, at plant.initial_x,
        .unit("m").nominal(100.0).description("position at the start");
    InitialY = 21, real "initial_y", Parameter, Fixed, at plant.initial_y,
        .unit("m").nominal(100.0).description("position at the start");
    InitialYaw = 22, real "initial_yaw", Parameter, Fixed, at plant.initial_yaw,
        .unit("rad").display_unit("deg").description("yaw at the start");
    NoiseScale = 23, real "noise_scale", Parameter, Fixed, at plant.noise_scale,
        .unit("1").min(0.0).description("noise relative to the identified: 0 deterministic, 1 as identified");
    NoiseSeed = 24, integer "noise_seed", Parameter, Fixed,
        .description("names the noise sequence");
}

/// The lateral dynamics identified from a drive (eq 6–7), with yaw and position.
#[derive(Debug, Clone)]
pub struct IdentifiedPlant {
    plant: steerwright_models::IdentifiedPlant,
    flags: Flags,
    /// Whether a speed far from the identified one was reported.
    warned_of_speed: bool,
}

impl IdentifiedPlant {
    /// The plant; until the start as a start from the present settings would leave it.
    #[inline]
    fn plant(&mut self) -> &mut steerwright_models::IdentifiedPlant {
        if !self.flags.started {
            self.plant.start();
        }
        &mut self.plant
    }

    /// The partial derivative, `None` where it is zero whatever the values.
    fn factor(&self, unknown: Unknown<V>, known: Known<V>) -> Option<Factor> {
        let n = self.plant.model_states();
        let unknown = match unknown {
            Unknown::Variable(V::YawRate) => sensitivity::Unknown::YawRate,
            Unknown::Variable(V::Yaw) => sensitivity::Unknown::State(n),
            Unknown::Variable(V::X) => sensitivity::Unknown::State(n + 1),
            Unknown::Variable(V::Y) => sensitivity::Unknown::State(n + 2),
            Unknown::Variable(_) => return None,
            Unknown::State(i) => sensitivity::Unknown::State(i),
            Unknown::Derivative(i) => sensitivity::Unknown::Rate(i),
        };
        let known = match known {
            Known::Variable(V::SteeringAngle) => sensitivity::Known::SteeringAngle,
            Known::Variable(V::Speed) => sensitivity::Known::Speed,
            Known::Variable(V::InitialYaw) => sensitivity::Known::State(n),
            Known::Variable(V::InitialX) => sensitivity::Known::State(n + 1),
            Known::Variable(V::InitialY) => sensitivity::Known::State(n + 2),
            // The seed acts where the scale does.
            Known::Variable(V::NoiseScale | V::NoiseSeed) => sensitivity::Known::NoiseScale,
            Known::Variable(_) => return None,
            Known::State(i) => sensitivity::Known::State(i),
        };
        self.plant.partial(unknown, known)
    }
}

impl Definition for IdentifiedPlant {
    type File = Plant;
    const RESOURCE: &'static str = "plant.json";
    const ROLE: Role = Role::Vehicle;

    fn scenario(file: Plant) -> Scenario {
        let seen = file.evidence.excitation.road_wheel_std_rad;
        let angle = if seen > 0.0 { seen } else { SCENARIO_ANGLE };
        let point = file.operating_point;
        steered(point.steering_offset_rad, angle * file.steering_ratio, point.speed_mps)
    }
}

impl CoSimulationUnit for IdentifiedPlant {
    type Variable = V;
    const TABLE: &'static Table = V::TABLE;
    const CAPABILITIES: Capabilities = Capabilities::ALL;

    fn open(resources: &Resources) -> Result<Self, String> {
        let plant = required::<Plant>(resources, Self::RESOURCE)?;
        let model = steerwright_models::files::identified_model(&plant)
            .map_err(|e| format!("plant.json: {e}; hint: {}", e.hint()))?;
        let plant = steerwright_models::IdentifiedPlant::new(Arc::new(model));
        with_start_values(
            Self { plant, flags: Flags::default(), warned_of_speed: false },
            resources,
        )
    }

    #[inline]
    fn get(&mut self, variable: V) -> Value {
        let p = self.plant();
        Value::Real(match variable {
            V::NoiseSeed => return Value::Integer(p.noise_seed),
            V::YawRate => p.yaw_rate(),
            V::Yaw => p.yaw(),
            V::X => p.x(),
            V::Y => p.y(),
            other => other.place(self).map_or(0.0, |value| *value),
        })
    }

    #[inline]
    fn set(&mut self, variable: V, value: &Value) {
        if let (V::NoiseSeed, Value::Integer(seed)) = (variable, value) {
            self.plant.noise_seed = *seed;
        } else if let (Value::Real(value), Some(place)) = (value, variable.place(self)) {
            *place = *value;
        }
    }

    fn exit_initialization(&mut self, _start_time: f64, _log: &mut Log) -> Result<(), String> {
        self.flags.started = true;
        self.plant.start();
        outputs_are_finite(self)
    }

    fn step(&mut self, _time: f64, step: f64, log: &mut Log) -> Result<(), String> {
        if !self.warned_of_speed && self.plant.speed_far_from_identified() {
            self.warned_of_speed = true;
            let data = self.plant.model().data();
            let consequence = match data.input {
                InputKind::Steering => "x and y follow it, the dynamics do not",
                InputKind::SteeringTimesSpeed => "of the dynamics, only the gain follows it",
            };
            log.warning(format!(
                "the speed of {:.4} m/s is more than 20 % from the {:.4} m/s at which the plant was \
                 identified: {consequence}",
                self.plant.speed, data.speed
            ));
        }
        self.flags.speed_rate.warn("speed", log);
        self.plant.step(step).map_err(|e| refuse(&e))
    }

    fn states(&self) -> Vec<StateSpec> {
        let model = (1..=self.plant.model_states())
            .map(|i| settable(format!("state {i} of the identified model"), None, None));
        model.chain(pose()).collect()
    }

    fn state(&mut self, index: usize) -> f64 {
        self.plant().state(index)
    }

    fn state_derivative(&mut self, index: usize) -> f64 {
        self.plant().state_rate(index)
    }

    fn set_state(&mut self, index: usize, value: f64) {
        if let Some(state) = self.plant.initial_states_mut().get_mut(index) {
            *state = value;
        }
    }

    fn set_input_derivative(&mut self, variable: V, derivative: f64) {
        match variable {
            V::SteeringAngle => self.plant.steering_rate = derivative,
            V::Speed => self.flags.speed_rate.set(derivative),
            _ => {}
        }
    }

    fn output_derivative(&mut self, variable: V) -> f64 {
        let p = self.plant();
        let n = p.model_states();
        match variable {
            V::YawRate => p.yaw_acceleration(),
            V::Yaw => p.state_rate(n),
            V::X => p.state_rate(n + 1),
            V::Y => p.state_rate(n + 2),
            _ => 0.0,
        }
    }

    fn dependency(&self, unknown: Unknown<V>, known: Known<V>) -> Option<DependencyKind> {
        self.factor(unknown, known).map(kind)
    }

    fn partial_derivative(&mut self, unknown: Unknown<V>, known: Known<V>) -> Option<f64> {
        self.plant();
        Some(self.factor(unknown, known).map_or(0.0, Factor::value))
    }

    fn save(&self) -> Vec<u8> {
        encode(&(self.flags, self.warned_of_speed, self.plant.save()))
    }

    fn load(&mut self, bytes: &[u8]) -> Result<(), String> {
        let saved: SavedIdentifiedPlant;
        let mut loaded = self.clone();
        (loaded.flags, loaded.warned_of_speed, saved) = decode(bytes)?;
        loaded.plant.restore(saved).map_err(|e| refuse(&e))?;
        check_settable(&mut loaded)?;
        *self = loaded;
        Ok(())
    }
}
