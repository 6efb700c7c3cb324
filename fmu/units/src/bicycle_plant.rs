//! `BicyclePlant`: the glue from [`steerwright_models::BicyclePlant`] to the export trait.

use self::Variable as V;
use crate::fmu::{Definition, Role};
use crate::plant::{Flags, kind, pose, settable};
use crate::resources::{optional, with_start_values};
use crate::saved::{check_settable, decode, encode, outputs_are_finite, refuse};
use crate::scenario::{SCENARIO_ANGLE, Scenario, steered};
use fmi2_export::{
    Capabilities, CoSimulationUnit, Known, Log, Resources, StateSpec, Unknown, variables,
};
use model_description::DependsOn::{Nothing, On};
use model_description::{DependencyKind, Table, Value};
use steerwright_formats::Bicycle;
use steerwright_models::sensitivity::{self, Factor};
use steerwright_models::{BicycleParameters, SavedBicyclePlant};

variables! {
    /// Variables of the bicycle plant. The states, which start where they are set to, are listed by
    /// the layer, and so are the dependencies on them.
    Variable of BicyclePlant, "BicyclePlant", "two-wheel bicycle model: steering angle and speed in, yaw rate and pose out";
    SteeringAngle = 0, real "steering_angle", Input, Continuous, at plant.steering_angle,
        .unit("rad").display_unit("deg").nominal(0.1).description("steering angle, positive to the left");
    Speed = 1, real "speed", Input, Continuous, at plant.speed,
        .unit("m/s").display_unit("km/h").min(0.0).nominal(10.0).description("longitudinal velocity");
    YawRate = 10, real "yaw_rate", Output, Continuous,
        .unit("rad/s").display_unit("deg/s").nominal(0.1).depends_on(Nothing).initial_depends_on(Nothing)
        .description("yaw rate, positive to the left");
    Yaw = 11, real "yaw", Output, Continuous,
        .unit("rad").display_unit("deg").depends_on(Nothing).initial_depends_on(On(&["initial_yaw"]))
        .description("yaw, not wrapped");
    X = 12, real "x", Output, Continuous,
        .unit("m").nominal(100.0).depends_on(Nothing).initial_depends_on(On(&["initial_x"])).description("position of the centre of gravity");
    Y = 13, real "y", Output, Continuous,
        .unit("m").nominal(100.0).depends_on(Nothing).initial_depends_on(On(&["initial_y"])).description("position of the centre of gravity");
    LateralVelocity = 14, real "lateral_velocity", Output, Continuous,
        .unit("m/s").nominal(0.1).depends_on(Nothing).initial_depends_on(Nothing)
        .description("velocity to the left of the centre of gravity");
    LateralAcceleration = 15, real "lateral_acceleration", Output, Continuous,
        .unit("m/s2").depends_on(On(&["speed"]))
        .initial_depends_on(On(&["speed", "mass", "distance_front", "distance_rear",
            "cornering_stiffness_front", "cornering_stiffness_rear"]))
        .description("acceleration to the left of the centre of gravity");
    Mass = 20, real "mass", Parameter, Fixed, at plant.parameters.mass,
        .unit("kg").min(1.0).nominal(1000.0).description("mass m");
    YawInertia = 21, real "yaw_inertia", Parameter, Fixed, at plant.parameters.yaw_inertia,
        .unit("kg.m2").min(0.1).nominal(1000.0).description("yaw inertia J");
    DistanceFront = 22, real "distance_front", Parameter, Fixed, at plant.parameters.distance_front,
        .unit("m").min(0.01).description("centre of gravity to front axle L_f");
    DistanceRear = 23, real "distance_rear", Parameter, Fixed, at plant.parameters.distance_rear,
        .unit("m").min(0.01).description("centre of gravity to rear axle L_r");
    CorneringStiffnessFront = 24, real "cornering_stiffness_front", Parameter, Fixed, at plant.parameters.cornering_stiffness_front,
        .unit("N/rad").display_unit("N/deg").min(1.0).nominal(1e5).description("cornering stiffness of the front axle C_f");
    CorneringStiffnessRear = 25, real "cornering_stiffness_rear", Parameter, Fixed, at plant.parameters.cornering_stiffness_rear,
        .unit("N/rad").display_unit("N/deg").min(1.0).nominal(1e5).description("cornering stiffness of the rear axle C_r");
    ActuatorTimeConstant = 26, real "actuator_time_constant", Parameter, Fixed, at plant.parameters.actuator_time_constant,
        .unit("s").min(1e-4).nominal(0.1).description("time constant of the steering actuator T_n");
    SteeringRatio = 27, real "steering_ratio", Parameter, Fixed, at plant.parameters.steering_ratio,
        .unit("1").min(1e-3).nominal(10.0).description("steering angle over road-wheel angle, 1/n");
    ActuatorDelay = 28, real "actuator_delay", Parameter, Fixed, at plant.parameters.actuator_delay,
        .unit("s").display_unit("ms").min(0.0).max(10.0).description("delay before the steering actuator");
    ActuatorRateMax = 29, real "actuator_rate_max", Parameter, Fixed, at plant.parameters.actuator_rate_max,
        .unit("rad/s").display_unit("deg/s").min(1e-6).max(1e6).description("largest rate of the road wheels; 1e6 rad/s limits nothing");
    InitialX = 30, real "initial_x", Parameter, Fixed, at plant.initial_x,
        .unit("m").nominal(100.0).description("position at the start");
    InitialY = 31, real "initial_y", Parameter, Fixed, at plant.initial_y,
        .unit("m").nominal(100.0).description("position at the start");
    InitialYaw = 32, real "initial_yaw", Parameter, Fixed, at plant.initial_yaw,
        .unit("rad").display_unit("deg").description("yaw at the start");
}

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
            matches!(
                parameter,
                V::ActuatorTimeConstant | V::ActuatorDelay | V::ActuatorRateMax | V::SteeringRatio
            )
        }
        _ => false,
    }
}

impl Definition for BicyclePlant {
    type File = Bicycle;
    const RESOURCE: &'static str = "bicycle.json";
    const ROLE: Role = Role::Vehicle;

    fn scenario(file: Bicycle) -> Scenario {
        let vehicle = file.vehicle;
        steered(0.0, SCENARIO_ANGLE * vehicle.steering_ratio, vehicle.speed_mps)
    }
}

impl CoSimulationUnit for BicyclePlant {
    type Variable = V;
    const TABLE: &'static Table = V::TABLE;
    const CAPABILITIES: Capabilities = Capabilities::ALL;

    fn open(resources: &Resources) -> Result<Self, String> {
        let bicycle = optional::<Bicycle>(resources, Self::RESOURCE)?;
        let vehicle = bicycle.map(|b| b.vehicle);
        let parameters = match &vehicle {
            Some(vehicle) => steerwright_models::files::bicycle_parameters(vehicle),
            None => BicycleParameters::default(),
        };
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
            other => other.place(self).map_or(0.0, |value| *value),
        })
    }

    #[inline]
    fn set(&mut self, variable: V, value: &Value) {
        if let (Value::Real(value), Some(place)) = (value, variable.place(self)) {
            *place = *value;
        }
    }

    fn exit_initialization(&mut self, _start_time: f64, _log: &mut Log) -> Result<(), String> {
        self.flags.started = true;
        self.plant.start().map_err(|e| refuse(&e))?;
        outputs_are_finite(self)
    }

    fn step(&mut self, _time: f64, step: f64, log: &mut Log) -> Result<(), String> {
        self.flags.speed_rate.warn("speed", log);
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
