//! `BicyclePlant`: the glue from [`steerwright_models::BicyclePlant`] to the export trait.

use crate::plant::{Flags, kind, pose, settable};
use crate::resources::{optional, with_start_values};
use crate::saved::{check_settable, decode, encode, outputs_are_finite, refuse};
use crate::tables::bicycle_plant::Variable as V;
use fmi2_export::{Capabilities, Known, Log, Resources, Slave, StateSpec, Unknown};
use model_description::{DependencyKind, Table, Value};
use steerwright_models::sensitivity::{self, Factor};
use steerwright_models::{BicycleParameters, SavedBicyclePlant};

/// The two-wheel bicycle model (eq 13) in its body-frame form, with yaw and position.
#[derive(Debug, Clone)]
pub struct BicyclePlant {
    plant: steerwright_models::BicyclePlant,
    flags: Flags,
}

/// Indices of the states.
const LATERAL_VELOCITY: usize = 0;
const YAW_RATE: usize = 1;
const ROAD_WHEEL_ANGLE: usize = 2;
const YAW: usize = 3;
const X: usize = 4;
const Y: usize = 5;

impl BicyclePlant {
    /// A parameter or an input that is a Real; `None` for the others and for outputs.
    #[inline]
    fn number(&mut self, variable: V) -> Option<&mut f64> {
        let p = &mut self.plant;
        Some(match variable {
            V::SteeringAngle => &mut p.steering_angle,
            V::Speed => &mut p.speed,
            V::Mass => &mut p.parameters.mass,
            V::YawInertia => &mut p.parameters.yaw_inertia,
            V::DistanceFront => &mut p.parameters.distance_front,
            V::DistanceRear => &mut p.parameters.distance_rear,
            V::CorneringStiffnessFront => &mut p.parameters.cornering_stiffness_front,
            V::CorneringStiffnessRear => &mut p.parameters.cornering_stiffness_rear,
            V::ActuatorTimeConstant => &mut p.parameters.actuator_time_constant,
            V::ActuatorDelay => &mut p.parameters.actuator_delay,
            V::SteeringRatio => &mut p.parameters.steering_ratio,
            V::InitialX => &mut p.initial_x,
            V::InitialY => &mut p.initial_y,
            V::InitialYaw => &mut p.initial_yaw,
            V::YawRate | V::Yaw | V::X | V::Y | V::LateralVelocity | V::LateralAcceleration => {
                return None;
            }
        })
    }

    /// The plant; until the start as a start from the present settings would leave it. A vehicle
    /// that cannot start is refused when initialization mode is left.
    #[inline]
    fn plant(&mut self) -> &mut steerwright_models::BicyclePlant {
        if !self.flags.started {
            let _ = self.plant.start();
        }
        &mut self.plant
    }

    /// The partial derivative by an input or state, `None` where it is zero whatever the values.
    fn factor(&self, unknown: Unknown<V>, known: Known<V>) -> Option<Factor> {
        let unknown = match unknown {
            Unknown::Variable(V::YawRate) => sensitivity::Unknown::YawRate,
            Unknown::Variable(V::LateralAcceleration) => sensitivity::Unknown::LateralAcceleration,
            Unknown::Variable(V::LateralVelocity) => sensitivity::Unknown::State(LATERAL_VELOCITY),
            Unknown::Variable(V::Yaw) => sensitivity::Unknown::State(YAW),
            Unknown::Variable(V::X) => sensitivity::Unknown::State(X),
            Unknown::Variable(V::Y) => sensitivity::Unknown::State(Y),
            Unknown::Variable(_) => return None,
            Unknown::State(i) => sensitivity::Unknown::State(i),
            Unknown::Derivative(i) => sensitivity::Unknown::Rate(i),
        };
        let known = match known {
            Known::Variable(V::SteeringAngle) => sensitivity::Known::SteeringAngle,
            Known::Variable(V::Speed) => sensitivity::Known::Speed,
            Known::Variable(V::InitialYaw) => sensitivity::Known::State(YAW),
            Known::Variable(V::InitialX) => sensitivity::Known::State(X),
            Known::Variable(V::InitialY) => sensitivity::Known::State(Y),
            Known::Variable(_) => return None,
            Known::State(i) => sensitivity::Known::State(i),
        };
        self.plant.partial(unknown, known)
    }
}

/// Whether an unknown depends on a parameter of the vehicle, which matters in initialization mode.
fn by_parameter(unknown: Unknown<V>, parameter: V) -> bool {
    // Forces, which v̇_y has over the mass, and ṙ over the inertia.
    let force = matches!(
        parameter,
        V::DistanceFront | V::DistanceRear | V::CorneringStiffnessFront | V::CorneringStiffnessRear
    );
    match unknown {
        Unknown::Variable(V::LateralAcceleration) | Unknown::Derivative(LATERAL_VELOCITY) => {
            force || parameter == V::Mass
        }
        Unknown::Derivative(YAW_RATE) => force || parameter == V::YawInertia,
        Unknown::Derivative(ROAD_WHEEL_ANGLE) => {
            matches!(parameter, V::ActuatorTimeConstant | V::ActuatorDelay | V::SteeringRatio)
        }
        _ => false,
    }
}

impl Slave for BicyclePlant {
    type Variable = V;
    const TABLE: &'static Table = V::TABLE;
    const CAPABILITIES: Capabilities = Capabilities::ALL;

    fn open(resources: &Resources) -> Result<Self, String> {
        let bicycle = optional::<steerwright_formats::Bicycle>(resources, "bicycle.json")?;
        let vehicle = bicycle.map(|b| b.vehicle);
        let parameters = vehicle
            .as_ref()
            .map_or_else(BicycleParameters::default, steerwright_loading::bicycle_parameters);
        let mut plant = steerwright_models::BicyclePlant::new(parameters)
            .map_err(|e| format!("bicycle.json: {e}; hint: {}", e.hint()))?;
        if let Some(vehicle) = vehicle {
            plant.speed = vehicle.speed_mps;
        }
        with_start_values(Self { plant, flags: Flags::default() }, resources)
    }

    #[inline]
    fn get(&mut self, variable: V) -> Value {
        let p = self.plant();
        Value::Real(match variable {
            V::YawRate => p.yaw_rate(),
            V::Yaw => p.yaw(),
            V::X => p.x(),
            V::Y => p.y(),
            V::LateralVelocity => p.lateral_velocity(),
            V::LateralAcceleration => p.lateral_acceleration(),
            other => self.number(other).map_or(0.0, |value| *value),
        })
    }

    #[inline]
    fn set(&mut self, variable: V, value: &Value) {
        if let (Value::Real(value), Some(place)) = (value, self.number(variable)) {
            *place = *value;
        }
    }

    fn exit_initialization(&mut self, _start_time: f64, _log: &mut Log) -> Result<(), String> {
        self.flags.started = true;
        self.plant.start().map_err(|e| refuse(&e))?;
        outputs_are_finite(self)
    }

    fn step(&mut self, _time: f64, step: f64, log: &mut Log) -> Result<(), String> {
        self.flags.speed_rate.warn(log);
        self.plant.step(step).map_err(|e| refuse(&e))
    }

    fn states(&self) -> Vec<StateSpec> {
        let model = [
            settable("lateral velocity v_y of the centre of gravity", Some("m/s"), Some("m/s2")),
            settable("yaw rate r", Some("rad/s"), Some("rad/s2")),
            settable("road-wheel angle behind the actuator", Some("rad"), Some("rad/s")),
        ];
        model.into_iter().chain(pose()).collect()
    }

    fn state(&mut self, index: usize) -> f64 {
        self.plant().state(index)
    }

    fn state_derivative(&mut self, index: usize) -> f64 {
        self.plant().state_rate(index)
    }

    fn set_state(&mut self, index: usize, value: f64) {
        if let Some(state) = self.plant.initial_states.get_mut(index) {
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
        match variable {
            V::LateralVelocity => p.state_rate(LATERAL_VELOCITY),
            V::YawRate => p.state_rate(YAW_RATE),
            V::Yaw => p.state_rate(YAW),
            V::X => p.state_rate(X),
            V::Y => p.state_rate(Y),
            V::LateralAcceleration => p.lateral_jerk(),
            _ => 0.0,
        }
    }

    fn dependency(&self, unknown: Unknown<V>, known: Known<V>) -> Option<DependencyKind> {
        if let Known::Variable(parameter) = known
            && by_parameter(unknown, parameter)
        {
            return Some(DependencyKind::Dependent);
        }
        self.factor(unknown, known).map(kind)
    }

    fn partial_derivative(&mut self, unknown: Unknown<V>, known: Known<V>) -> Option<f64> {
        // By parameters the layer takes differences: they matter before the start alone.
        if let Known::Variable(parameter) = known
            && by_parameter(unknown, parameter)
        {
            return None;
        }
        self.plant();
        Some(self.factor(unknown, known).map_or(0.0, Factor::value))
    }

    fn save(&self) -> Vec<u8> {
        encode(&(self.flags, self.plant.save()))
    }

    fn load(&mut self, bytes: &[u8]) -> Result<(), String> {
        let (flags, saved): (Flags, SavedBicyclePlant) = decode(bytes)?;
        let plant = steerwright_models::BicyclePlant::restore(&saved).map_err(|e| refuse(&e))?;
        let mut loaded = Self { plant, flags };
        check_settable(&mut loaded)?;
        *self = loaded;
        Ok(())
    }
}
