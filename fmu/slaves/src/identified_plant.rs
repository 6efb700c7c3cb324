//! `IdentifiedPlant`: the glue from [`steerwright_models::IdentifiedPlant`] to the export trait.

use crate::plant::{Flags, kind, pose, settable};
use crate::resources::{required, with_start_values};
use crate::saved::{check_settable, decode, encode, outputs_are_finite, refuse};
use crate::tables::identified_plant::Variable as V;
use fmi2_export::{Capabilities, Known, Log, Resources, Slave, StateSpec, Unknown};
use model_description::{DependencyKind, Table, Value};
use std::sync::Arc;
use steerwright_models::sensitivity::{self, Factor};
use steerwright_models::{InputKind, SavedIdentifiedPlant};

/// The lateral dynamics identified from a drive (eq 6–7), with yaw and position.
#[derive(Debug, Clone)]
pub struct IdentifiedPlant {
    plant: steerwright_models::IdentifiedPlant,
    flags: Flags,
    /// Whether a speed far from the identified one was reported.
    warned_of_speed: bool,
}

impl IdentifiedPlant {
    /// A parameter or an input that is a Real; `None` for the others and for outputs.
    #[inline]
    fn number(&mut self, variable: V) -> Option<&mut f64> {
        let p = &mut self.plant;
        Some(match variable {
            V::SteeringAngle => &mut p.steering_angle,
            V::Speed => &mut p.speed,
            V::InitialX => &mut p.initial_x,
            V::InitialY => &mut p.initial_y,
            V::InitialYaw => &mut p.initial_yaw,
            V::NoiseScale => &mut p.noise_scale,
            V::NoiseSeed | V::YawRate | V::Yaw | V::X | V::Y => return None,
        })
    }

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

impl Slave for IdentifiedPlant {
    type Variable = V;
    const TABLE: &'static Table = V::TABLE;
    const CAPABILITIES: Capabilities = Capabilities::ALL;

    fn open(resources: &Resources) -> Result<Self, String> {
        let plant = required::<steerwright_formats::Plant>(resources, "plant.json")?;
        let model = steerwright_loading::identified_model(&plant)
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
            other => self.number(other).map_or(0.0, |value| *value),
        })
    }

    #[inline]
    fn set(&mut self, variable: V, value: &Value) {
        if let (V::NoiseSeed, Value::Integer(seed)) = (variable, value) {
            self.plant.noise_seed = *seed;
        } else if let (Value::Real(value), Some(place)) = (value, self.number(variable)) {
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
                "the speed of {} m/s is more than 20 % from the {} m/s at which the plant was \
                 identified: {consequence}",
                self.plant.speed, data.speed
            ));
        }
        self.flags.speed_rate.warn(log);
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
