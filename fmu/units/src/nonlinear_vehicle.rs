//! `NonlinearVehicle`: the glue from [`steerwright_models::NonlinearVehicle`] to the export trait.
//!
//! States, from 0: v_y, r, δ, a_φ, which can be set at the start, then ψ, X, Y.

use self::Variable as V;
use crate::fmu::{Definition, Role};
use crate::plant::{Flags, HeldInput, pose, settable};
use crate::resources::{optional, with_start_values};
use crate::saved::{check_settable, decode, encode, outputs_are_finite, refuse};
use crate::scenario::{SCENARIO_ANGLE, Scenario, steered};
use fmi2_export::{
    Capabilities, CoSimulationUnit, Known, Log, Resources, StateSpec, Unknown, VariableId,
    variables,
};
use model_description::DependsOn::{Nothing, On};
use model_description::{DependencyKind, Table, Value};
use serde::{Deserialize, Serialize};
use steerwright_formats::Vehicle;
use steerwright_models::NonlinearParameters;
use steerwright_models::nonlinear::SavedVehicle;

/// Dependencies of the lateral acceleration at the start, besides the states.
#[rustfmt::skip]
const FORCES: &[&str] = &[
    "speed", "crosswind", "side_force_area", "mass", "distance_front", "distance_rear", "cornering_stiffness_front", "cornering_stiffness_rear",
    "friction_coefficient", "friction_balance_rear", "tyre_shape_factor", "tyre_curvature_factor", "friction_load_sensitivity",
    "stiffness_load_sensitivity", "centre_of_gravity_height", "track_width", "roll_stiffness_front",
];

variables! {
    /// Variables of the nonlinear vehicle.
    Variable of NonlinearVehicle, "NonlinearVehicle", "vehicle with saturating tyres, load transfer and a steering actuator: steering angle and speed in, yaw rate and pose out";
    SteeringAngle = 0, real "steering_angle", Input, Continuous, at vehicle.steering_angle,
        .unit("rad").display_unit("deg").description("steering angle, positive to the left");
    Speed = 1, real "speed", Input, Continuous, at vehicle.speed,
        .unit("m/s").display_unit("km/h").min(0.0).description("longitudinal velocity");
    Crosswind = 2, real "crosswind", Input, Continuous, at vehicle.crosswind,
        .unit("m/s").display_unit("km/h").description("velocity of the air to the left of the vehicle, held within a step");
    YawRate = 10, real "yaw_rate", Output, Continuous,
        .unit("rad/s").display_unit("deg/s").depends_on(Nothing).initial_depends_on(Nothing)
        .description("yaw rate, positive to the left");
    Yaw = 11, real "yaw", Output, Continuous,
        .unit("rad").display_unit("deg").depends_on(Nothing).initial_depends_on(On(&["initial_yaw"]))
        .description("yaw, not wrapped");
    X = 12, real "x", Output, Continuous,
        .unit("m").depends_on(Nothing).initial_depends_on(On(&["initial_x"])).description("position of the centre of gravity");
    Y = 13, real "y", Output, Continuous,
        .unit("m").depends_on(Nothing).initial_depends_on(On(&["initial_y"])).description("position of the centre of gravity");
    LateralVelocity = 14, real "lateral_velocity", Output, Continuous,
        .unit("m/s").depends_on(Nothing).initial_depends_on(Nothing)
        .description("velocity to the left of the centre of gravity");
    LateralAcceleration = 15, real "lateral_acceleration", Output, Continuous,
        .unit("m/s2").depends_on(On(&["speed", "crosswind"])).initial_depends_on(On(FORCES))
        .description("acceleration to the left of the centre of gravity");
    Mass = 20, real "mass", Parameter, Fixed, at vehicle.parameters.body.mass_kg,
        .unit("kg").min(1.0).description("mass m");
    YawInertia = 21, real "yaw_inertia", Parameter, Fixed, at vehicle.parameters.body.yaw_inertia_kgm2,
        .unit("kg.m2").min(0.1).description("yaw inertia J");
    DistanceFront = 22, real "distance_front", Parameter, Fixed, at vehicle.parameters.body.distance_front_m,
        .unit("m").min(0.01).description("centre of gravity to front axle L_f");
    DistanceRear = 23, real "distance_rear", Parameter, Fixed, at vehicle.parameters.body.distance_rear_m,
        .unit("m").min(0.01).description("centre of gravity to rear axle L_r");
    CorneringStiffnessFront = 24, real "cornering_stiffness_front", Parameter, Fixed, at vehicle.parameters.tyres.cornering_stiffness_front_npr,
        .unit("N/rad").min(1.0).description("cornering stiffness of the front axle C_f at the static load");
    CorneringStiffnessRear = 25, real "cornering_stiffness_rear", Parameter, Fixed, at vehicle.parameters.tyres.cornering_stiffness_rear_npr,
        .unit("N/rad").min(1.0).description("cornering stiffness of the rear axle C_r at the static load");
    ActuatorTimeConstant = 26, real "actuator_time_constant", Parameter, Fixed, at vehicle.parameters.actuator.time_constant_s,
        .unit("s").min(1e-4).max(100.0).description("time constant of the steering actuator T_n");
    SteeringRatio = 27, real "steering_ratio", Parameter, Fixed, at vehicle.parameters.actuator.steering_ratio,
        .unit("1").min(1e-3).description("steering angle over road-wheel angle, 1/n");
    InitialX = 30, real "initial_x", Parameter, Fixed, at vehicle.initial_x,
        .unit("m").description("position at the start");
    InitialY = 31, real "initial_y", Parameter, Fixed, at vehicle.initial_y,
        .unit("m").description("position at the start");
    InitialYaw = 32, real "initial_yaw", Parameter, Fixed, at vehicle.initial_yaw,
        .unit("rad").display_unit("deg").description("yaw at the start");
    ActuatorDelay = 40, real "actuator_delay", Parameter, Fixed, at vehicle.parameters.actuator.delay_s,
        .unit("s").display_unit("ms").min(0.0).max(10.0).description("delay before the steering actuator");
    RoadWheelRateMax = 41, real "road_wheel_rate_max", Parameter, Fixed, at vehicle.parameters.actuator.road_wheel_rate_max_radps,
        .unit("rad/s").display_unit("deg/s").min(1e-6).max(1e6).description("largest rate of the road-wheel angle");
    RoadWheelAngleMax = 42, real "road_wheel_angle_max", Parameter, Fixed, at vehicle.parameters.actuator.road_wheel_angle_max_rad,
        .unit("rad").display_unit("deg").min(1e-6).max(1.5).description("largest road-wheel angle to either side");
    FrictionCoefficient = 43, real "friction_coefficient", Parameter, Fixed, at vehicle.parameters.tyres.friction_coefficient,
        .unit("1").min(0.01).max(10.0).description("peak lateral force over load of the front axle at the static wheel load mu");
    TyreShapeFactor = 44, real "tyre_shape_factor", Parameter, Fixed, at vehicle.parameters.tyres.shape_factor,
        .unit("1").min(1.0).max(1.99).description("shape factor C of the magic formula");
    TyreCurvatureFactor = 45, real "tyre_curvature_factor", Parameter, Fixed, at vehicle.parameters.tyres.curvature_factor,
        .unit("1").min(-1.5).max(1.0).description("curvature factor E of the magic formula");
    FrictionLoadSensitivity = 46, real "friction_load_sensitivity", Parameter, Fixed, at vehicle.parameters.tyres.friction_load_sensitivity,
        .unit("1").min(0.0).max(0.9).description("relative loss of friction at twice the static wheel load k_mu");
    StiffnessLoadSensitivity = 47, real "stiffness_load_sensitivity", Parameter, Fixed, at vehicle.parameters.tyres.stiffness_load_sensitivity,
        .unit("1").min(0.0).max(0.9).description("relative loss of stiffness over load at twice the static wheel load k_C");
    CentreOfGravityHeight = 48, real "centre_of_gravity_height", Parameter, Fixed, at vehicle.parameters.body.centre_of_gravity_height_m,
        .unit("m").min(0.0).max(10.0).description("height of the centre of gravity h");
    TrackWidth = 49, real "track_width", Parameter, Fixed, at vehicle.parameters.body.track_width_m,
        .unit("m").min(0.01).max(100.0).description("left to right wheel");
    RollStiffnessFront = 50, real "roll_stiffness_front", Parameter, Fixed, at vehicle.parameters.body.roll_stiffness_front,
        .unit("1").display_unit("%").min(0.0).max(1.0).description("share of the front axle in the roll stiffness");
    RollTimeConstant = 51, real "roll_time_constant", Parameter, Fixed, at vehicle.parameters.body.roll_time_constant_s,
        .unit("s").min(1e-3).max(100.0).description("time constant of the load transfer T_phi");
    FrictionBalanceRear = 52, real "friction_balance_rear", Parameter, Fixed, at vehicle.parameters.tyres.friction_balance_rear,
        .unit("1").min(0.01).max(100.0).description("friction of the rear axle over that of the front axle");
    DriveShareFront = 53, real "drive_share_front", Parameter, Fixed, at vehicle.parameters.body.drive_share_front,
        .unit("1").display_unit("%").min(0.0).max(1.0).description("share of the front axle in the driving force");
    BrakeShareFront = 54, real "brake_share_front", Parameter, Fixed, at vehicle.parameters.body.brake_share_front,
        .unit("1").display_unit("%").min(0.0).max(1.0).description("share of the front axle in the braking force");
    CombinedSlip = 55, real "combined_slip", Parameter, Fixed, at vehicle.parameters.tyres.combined_slip,
        .unit("1").display_unit("%").min(0.0).max(1.0).description("share of the driving and braking force that the friction bears beside the lateral force");
    SideForceArea = 56, real "side_force_area", Parameter, Fixed, at vehicle.parameters.body.side_force_area_m2,
        .unit("m2").min(0.0).max(1e4).description("force to the side over dynamic pressure and angle of the air in a crosswind");
    SideForceArm = 57, real "side_force_arm", Parameter, Fixed, at vehicle.parameters.body.side_force_arm_m,
        .unit("m").min(-100.0).max(100.0).description("centre of gravity to where the crosswind acts, positive ahead");
    SteeringPlay = 58, real "steering_play", Parameter, Fixed, at vehicle.parameters.actuator.play_rad,
        .unit("rad").display_unit("deg").min(0.0).max(0.5).description("play between actuator and road wheels from stop to stop");
}

/// A vehicle with saturating tyres, load transfer and a steering actuator.
#[derive(Debug, Clone)]
pub struct NonlinearVehicle {
    vehicle: steerwright_models::NonlinearVehicle,
    flags: Flags,
    wind: Wind,
}

/// What is logged of the wind.
#[derive(Debug, Clone, Copy, Default, Serialize, Deserialize)]
struct Wind {
    rate: HeldInput,
    /// Whether it was logged that it has no area to act on.
    without_area: bool,
}

/// A gust of the reference run, m/s.
const SCENARIO_GUST: f64 = 8.0;

/// Places of the states that follow from the pose at the start.
const YAW: usize = 4;
const X: usize = 5;
const Y: usize = 6;

impl NonlinearVehicle {
    /// Until the start, everything is as after a start from the present settings; a vehicle
    /// that cannot start is refused when initialization mode is left.
    fn settled(&mut self) -> &steerwright_models::NonlinearVehicle {
        if !self.flags.started {
            let _ = self.vehicle.start();
        }
        &self.vehicle
    }
}

impl Definition for NonlinearVehicle {
    type File = Vehicle;
    const RESOURCE: &'static str = "vehicle.json";
    const ROLE: Role = Role::Vehicle;

    fn scenario(file: Vehicle) -> Scenario {
        // Steered so much that its tyres saturate.
        let angle = 3.0 * SCENARIO_ANGLE * file.actuator.steering_ratio;
        let road = steered(0.0, angle, file.speed_mps);
        // Without an area the wind has no effect, which is a warning.
        let gust = if file.body.side_force_area_m2 > 0.0 { SCENARIO_GUST } else { 0.0 };
        Scenario::new(move |input, moment| match input {
            "crosswind" => Some(if (4.0..6.0).contains(&moment.course) { gust } else { 0.0 }),
            _ => road.value(input, moment),
        })
    }
}

impl CoSimulationUnit for NonlinearVehicle {
    type Variable = V;
    const TABLE: &'static Table = V::TABLE;
    const CAPABILITIES: Capabilities = Capabilities::ALL;

    fn open(resources: &Resources) -> Result<Self, String> {
        let file = optional::<Vehicle>(resources, Self::RESOURCE)?;
        let parameters = match &file {
            Some(file) => steerwright_models::files::nonlinear_parameters(file),
            None => NonlinearParameters::default(),
        };
        let mut vehicle = steerwright_models::NonlinearVehicle::new(parameters)
            .map_err(|e| format!("vehicle.json: {e}; hint: {}", e.hint()))?;
        if let Some(file) = file {
            vehicle.speed = file.speed_mps;
        }
        with_start_values(
            Self { vehicle, flags: Flags::default(), wind: Wind::default() },
            resources,
        )
    }

    #[inline]
    fn get(&mut self, variable: V) -> Value {
        Value::Real(match variable {
            V::YawRate => self.settled().yaw_rate(),
            V::Yaw => self.settled().yaw(),
            V::X => self.settled().x(),
            V::Y => self.settled().y(),
            V::LateralVelocity => self.settled().lateral_velocity(),
            V::LateralAcceleration => self.settled().lateral_acceleration(),
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
        self.vehicle.start().map_err(|e| refuse(&e))?;
        outputs_are_finite(self)
    }

    fn step(&mut self, _time: f64, step: f64, log: &mut Log) -> Result<(), String> {
        self.flags.speed_rate.warn("speed", log);
        self.wind.rate.warn("crosswind", log);
        let acts = self.vehicle.parameters.body.side_force_area_m2 > 0.0;
        if self.vehicle.crosswind != 0.0 && !acts && !self.wind.without_area {
            self.wind.without_area = true;
            log.warning(
                "the crosswind has no effect: side_force_area is 0; about 4 m2 is that of a car",
            );
        }
        self.vehicle.step(step).map_err(|e| refuse(&e))
    }

    fn states(&self) -> Vec<StateSpec> {
        let model = [
            settable("lateral velocity v_y of the centre of gravity", Some("m/s"), Some("m/s2")),
            settable("yaw rate r", Some("rad/s"), Some("rad/s2")),
            settable("road-wheel angle behind the actuator", Some("rad"), Some("rad/s")),
            settable("lateral acceleration that the load has followed", Some("m/s2"), Some("m/s3")),
        ];
        model.into_iter().chain(pose()).collect()
    }

    fn state(&mut self, index: usize) -> f64 {
        let v = self.settled();
        let [vy, r, angle, roll] = v.states();
        [vy, r, angle, roll, v.yaw(), v.x(), v.y()].get(index).copied().unwrap_or_default()
    }

    fn state_derivative(&mut self, index: usize) -> f64 {
        let v = self.settled();
        let pose = v.pose_derivatives();
        v.derivatives().iter().chain(&pose).nth(index).copied().unwrap_or_default()
    }

    fn set_state(&mut self, index: usize, value: f64) {
        if self.flags.started {
            self.vehicle.set_state(index, value);
        } else if let Some(state) = self.vehicle.initial_states.get_mut(index) {
            *state = value;
        }
    }

    fn set_input_derivative(&mut self, variable: V, derivative: f64) {
        match variable {
            V::SteeringAngle => self.vehicle.steering_slope = derivative,
            V::Speed => self.flags.speed_rate.set(derivative),
            V::Crosswind => self.wind.rate.set(derivative),
            _ => {}
        }
    }

    fn output_derivative(&mut self, variable: V) -> f64 {
        let v = self.settled();
        let ([lateral_velocity, yaw_rate, ..], [yaw, x, y]) =
            (v.derivatives(), v.pose_derivatives());
        match variable {
            V::YawRate => yaw_rate,
            V::Yaw => yaw,
            V::X => x,
            V::Y => y,
            V::LateralVelocity => lateral_velocity,
            V::LateralAcceleration => v.lateral_acceleration_derivative(),
            _ => 0.0,
        }
    }

    fn dependency(&self, unknown: Unknown<V>, known: Known<V>) -> Option<DependencyKind> {
        // Dependencies of the tyre forces.
        let forces = match known {
            Known::State(state) => state <= 3,
            Known::Variable(variable) => FORCES.contains(&variable.spec().name),
        };
        let variable = |wanted: &[V]| matches!(known, Known::Variable(v) if wanted.contains(&v));
        let state = |wanted: &[usize]| matches!(known, Known::State(i) if wanted.contains(&i));
        let depends = match unknown {
            Unknown::Variable(V::YawRate) | Unknown::Derivative(YAW) => state(&[1]),
            Unknown::Variable(V::LateralVelocity) => state(&[0]),
            Unknown::Variable(V::LateralAcceleration) | Unknown::Derivative(0) => forces,
            Unknown::Variable(V::Yaw) | Unknown::State(YAW) => {
                state(&[YAW]) || variable(&[V::InitialYaw])
            }
            Unknown::Variable(V::X) | Unknown::State(X) => state(&[X]) || variable(&[V::InitialX]),
            Unknown::Variable(V::Y) | Unknown::State(Y) => state(&[Y]) || variable(&[V::InitialY]),
            Unknown::Derivative(1) => forces || variable(&[V::YawInertia, V::SideForceArm]),
            Unknown::Derivative(2) => {
                state(&[2])
                    || variable(&[
                        V::SteeringAngle,
                        V::SteeringRatio,
                        V::ActuatorTimeConstant,
                        V::ActuatorDelay,
                        V::RoadWheelRateMax,
                        V::RoadWheelAngleMax,
                    ])
            }
            Unknown::Derivative(3) => forces || variable(&[V::RollTimeConstant]),
            Unknown::Derivative(X | Y) => state(&[0, YAW]) || variable(&[V::Speed, V::InitialYaw]),
            // Set from outside, or none of this vehicle's.
            Unknown::Variable(_) | Unknown::State(_) | Unknown::Derivative(_) => false,
        };
        if depends { Some(DependencyKind::Dependent) } else { None }
    }

    /// By the states that cannot be set; for the rest the layer takes differences.
    fn partial_derivative(&mut self, unknown: Unknown<V>, known: Known<V>) -> Option<f64> {
        let Known::State(state @ (YAW | X | Y)) = known else { return None };
        let [_, x_rate, y_rate] = self.settled().pose_derivatives();
        Some(match (unknown, state) {
            (Unknown::Variable(V::Yaw) | Unknown::State(YAW), YAW)
            | (Unknown::Variable(V::X) | Unknown::State(X), X)
            | (Unknown::Variable(V::Y) | Unknown::State(Y), Y) => 1.0,
            (Unknown::Derivative(X), YAW) => -y_rate,
            (Unknown::Derivative(Y), YAW) => x_rate,
            _ => 0.0,
        })
    }

    fn save(&self) -> Vec<u8> {
        encode(&(self.flags, self.wind, self.vehicle.save()))
    }

    fn load(&mut self, bytes: &[u8]) -> Result<(), String> {
        let (flags, wind, saved): (Flags, Wind, SavedVehicle) = decode(bytes)?;
        let vehicle =
            steerwright_models::NonlinearVehicle::restore(saved).map_err(|e| refuse(&e))?;
        let mut loaded = Self { vehicle, flags, wind };
        check_settable(&mut loaded)?;
        *self = loaded;
        Ok(())
    }
}
