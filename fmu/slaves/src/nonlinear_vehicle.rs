//! `NonlinearVehicle`: the glue from [`steerwright_models::NonlinearVehicle`] to the export trait.
//!
//! States, from 0: v_y, r, δ, a_φ, which can be set at the start, then ψ, X, Y.

use crate::plant::{Flags, pose, settable};
use crate::resources::{optional, with_start_values};
use crate::saved::{check_settable, decode, encode, outputs_are_finite, refuse};
use crate::tables::nonlinear_vehicle::{FORCES, Variable as V};
use fmi2_export::{Capabilities, Known, Log, Resources, Slave, StateSpec, Unknown, VariableId};
use model_description::{DependencyKind, Table, Value};
use steerwright_models::NonlinearParameters;
use steerwright_models::nonlinear::SavedVehicle;

/// A vehicle with saturating tyres, load transfer and a steering actuator.
#[derive(Debug, Clone)]
pub struct NonlinearVehicle {
    vehicle: steerwright_models::NonlinearVehicle,
    flags: Flags,
}

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

    /// A parameter or an input that is a Real; `None` for the others and for outputs.
    fn number(&mut self, variable: V) -> Option<&mut f64> {
        let v = &mut self.vehicle;
        let p = &mut v.parameters;
        Some(match variable {
            V::SteeringAngle => &mut v.steering_angle,
            V::Speed => &mut v.speed,
            V::InitialX => &mut v.initial_x,
            V::InitialY => &mut v.initial_y,
            V::InitialYaw => &mut v.initial_yaw,
            V::Mass => &mut p.mass,
            V::YawInertia => &mut p.yaw_inertia,
            V::DistanceFront => &mut p.distance_front,
            V::DistanceRear => &mut p.distance_rear,
            V::CorneringStiffnessFront => &mut p.cornering_stiffness_front,
            V::CorneringStiffnessRear => &mut p.cornering_stiffness_rear,
            V::ActuatorTimeConstant => &mut p.actuator_time_constant,
            V::SteeringRatio => &mut p.steering_ratio,
            V::ActuatorDelay => &mut p.actuator_delay,
            V::RoadWheelRateMax => &mut p.road_wheel_rate_max,
            V::RoadWheelAngleMax => &mut p.road_wheel_angle_max,
            V::FrictionCoefficient => &mut p.friction_coefficient,
            V::TyreShapeFactor => &mut p.tyre_shape_factor,
            V::TyreCurvatureFactor => &mut p.tyre_curvature_factor,
            V::FrictionLoadSensitivity => &mut p.friction_load_sensitivity,
            V::StiffnessLoadSensitivity => &mut p.stiffness_load_sensitivity,
            V::CentreOfGravityHeight => &mut p.centre_of_gravity_height,
            V::TrackWidth => &mut p.track_width,
            V::RollStiffnessFront => &mut p.roll_stiffness_front,
            V::RollTimeConstant => &mut p.roll_time_constant,
            V::YawRate | V::Yaw | V::X | V::Y | V::LateralVelocity | V::LateralAcceleration => {
                return None;
            }
        })
    }
}

impl Slave for NonlinearVehicle {
    type Variable = V;
    const TABLE: &'static Table = V::TABLE;
    const CAPABILITIES: Capabilities = Capabilities::ALL;

    fn open(resources: &Resources) -> Result<Self, String> {
        let file = optional::<steerwright_formats::Vehicle>(resources, "vehicle.json")?;
        let parameters = file
            .as_ref()
            .map_or_else(NonlinearParameters::default, steerwright_loading::nonlinear_parameters);
        let mut vehicle = steerwright_models::NonlinearVehicle::new(parameters)
            .map_err(|e| format!("vehicle.json: {e}; hint: {}", e.hint()))?;
        if let Some(file) = file {
            vehicle.speed = file.speed_mps;
        }
        with_start_values(Self { vehicle, flags: Flags::default() }, resources)
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
        self.vehicle.start().map_err(|e| refuse(&e))?;
        outputs_are_finite(self)
    }

    fn step(&mut self, _time: f64, step: f64, log: &mut Log) -> Result<(), String> {
        self.flags.speed_rate.warn(log);
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
            Unknown::Derivative(1) => forces || variable(&[V::YawInertia]),
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
        depends.then_some(DependencyKind::Dependent)
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
        encode(&(self.flags, self.vehicle.save()))
    }

    fn load(&mut self, bytes: &[u8]) -> Result<(), String> {
        let (flags, saved): (Flags, SavedVehicle) = decode(bytes)?;
        let vehicle =
            steerwright_models::NonlinearVehicle::restore(saved).map_err(|e| refuse(&e))?;
        let mut loaded = Self { vehicle, flags };
        check_settable(&mut loaded)?;
        *self = loaded;
        Ok(())
    }
}
