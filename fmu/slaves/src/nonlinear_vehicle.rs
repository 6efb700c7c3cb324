//! `NonlinearVehicle`: the glue from [`steerwright_models::NonlinearVehicle`] to the export trait.
//!
//! States, from 0: v_y, r, δ, a_φ, which can be set at the start, then ψ, X, Y.

use crate::finite::outputs_are_finite;
use crate::plant::{Flags, pose, settable};
use crate::resources::optional;
use crate::saved::{check_settable, decode, encode, refuse};
use crate::start::with_start_values;
use crate::tables::nonlinear_vehicle::Variable;
use fmi2_export::{Capabilities, Known, Log, Resources, Slave, StateSpec, Unknown};
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

    fn parameter(&mut self, variable: Variable) -> Option<&mut f64> {
        let v = &mut self.vehicle;
        let NonlinearParameters {
            mass,
            yaw_inertia,
            distance_front,
            distance_rear,
            cornering_stiffness_front,
            cornering_stiffness_rear,
            friction_coefficient,
            tyre_shape_factor,
            tyre_curvature_factor,
            friction_load_sensitivity,
            stiffness_load_sensitivity,
            centre_of_gravity_height,
            track_width,
            roll_stiffness_front,
            roll_time_constant,
            steering_ratio,
            actuator_time_constant,
            actuator_delay,
            road_wheel_rate_max,
            road_wheel_angle_max,
        } = &mut v.parameters;
        Some(match variable {
            Variable::SteeringAngle => &mut v.steering_angle,
            Variable::Speed => &mut v.speed,
            Variable::InitialX => &mut v.initial_x,
            Variable::InitialY => &mut v.initial_y,
            Variable::InitialYaw => &mut v.initial_yaw,
            Variable::Mass => mass,
            Variable::YawInertia => yaw_inertia,
            Variable::DistanceFront => distance_front,
            Variable::DistanceRear => distance_rear,
            Variable::CorneringStiffnessFront => cornering_stiffness_front,
            Variable::CorneringStiffnessRear => cornering_stiffness_rear,
            Variable::ActuatorTimeConstant => actuator_time_constant,
            Variable::SteeringRatio => steering_ratio,
            Variable::ActuatorDelay => actuator_delay,
            Variable::RoadWheelRateMax => road_wheel_rate_max,
            Variable::RoadWheelAngleMax => road_wheel_angle_max,
            Variable::FrictionCoefficient => friction_coefficient,
            Variable::TyreShapeFactor => tyre_shape_factor,
            Variable::TyreCurvatureFactor => tyre_curvature_factor,
            Variable::FrictionLoadSensitivity => friction_load_sensitivity,
            Variable::StiffnessLoadSensitivity => stiffness_load_sensitivity,
            Variable::CentreOfGravityHeight => centre_of_gravity_height,
            Variable::TrackWidth => track_width,
            Variable::RollStiffnessFront => roll_stiffness_front,
            Variable::RollTimeConstant => roll_time_constant,
            Variable::YawRate
            | Variable::Yaw
            | Variable::X
            | Variable::Y
            | Variable::LateralVelocity
            | Variable::LateralAcceleration => return None,
        })
    }
}

impl Slave for NonlinearVehicle {
    type Variable = Variable;
    const TABLE: &'static Table = Variable::TABLE;
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
    fn get(&mut self, variable: Variable) -> Value {
        Value::Real(match variable {
            Variable::YawRate => self.settled().yaw_rate(),
            Variable::Yaw => self.settled().yaw(),
            Variable::X => self.settled().x(),
            Variable::Y => self.settled().y(),
            Variable::LateralVelocity => self.settled().lateral_velocity(),
            Variable::LateralAcceleration => self.settled().lateral_acceleration(),
            other => self.parameter(other).map_or(0.0, |value| *value),
        })
    }

    #[inline]
    fn set(&mut self, variable: Variable, value: &Value) {
        if let (Value::Real(value), Some(place)) = (value, self.parameter(variable)) {
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

    fn set_input_derivative(&mut self, variable: Variable, derivative: f64) {
        match variable {
            Variable::SteeringAngle => self.vehicle.steering_slope = derivative,
            Variable::Speed => self.flags.speed_rate.set(derivative),
            _ => {}
        }
    }

    fn output_derivative(&mut self, variable: Variable) -> f64 {
        let v = self.settled();
        let ([lateral_velocity, yaw_rate, ..], [yaw, x, y]) =
            (v.derivatives(), v.pose_derivatives());
        match variable {
            Variable::YawRate => yaw_rate,
            Variable::Yaw => yaw,
            Variable::X => x,
            Variable::Y => y,
            Variable::LateralVelocity => lateral_velocity,
            Variable::LateralAcceleration => v.lateral_acceleration_derivative(),
            _ => 0.0,
        }
    }

    fn dependency(
        &self,
        unknown: Unknown<Variable>,
        known: Known<Variable>,
    ) -> Option<DependencyKind> {
        // Dependencies of the tyre forces.
        let forces = match known {
            Known::State(state) => state <= 3,
            Known::Variable(variable) => matches!(
                variable,
                Variable::Speed
                    | Variable::Mass
                    | Variable::DistanceFront
                    | Variable::DistanceRear
                    | Variable::CorneringStiffnessFront
                    | Variable::CorneringStiffnessRear
                    | Variable::FrictionCoefficient
                    | Variable::TyreShapeFactor
                    | Variable::TyreCurvatureFactor
                    | Variable::FrictionLoadSensitivity
                    | Variable::StiffnessLoadSensitivity
                    | Variable::CentreOfGravityHeight
                    | Variable::TrackWidth
                    | Variable::RollStiffnessFront
            ),
        };
        let variable =
            |wanted: &[Variable]| matches!(known, Known::Variable(v) if wanted.contains(&v));
        let state = |wanted: &[usize]| matches!(known, Known::State(i) if wanted.contains(&i));
        let depends = match unknown {
            Unknown::Variable(Variable::YawRate) | Unknown::Derivative(YAW) => state(&[1]),
            Unknown::Variable(Variable::LateralVelocity) => state(&[0]),
            Unknown::Variable(Variable::LateralAcceleration) | Unknown::Derivative(0) => forces,
            Unknown::Variable(Variable::Yaw) | Unknown::State(YAW) => {
                state(&[YAW]) || variable(&[Variable::InitialYaw])
            }
            Unknown::Variable(Variable::X) | Unknown::State(X) => {
                state(&[X]) || variable(&[Variable::InitialX])
            }
            Unknown::Variable(Variable::Y) | Unknown::State(Y) => {
                state(&[Y]) || variable(&[Variable::InitialY])
            }
            Unknown::Derivative(1) => forces || variable(&[Variable::YawInertia]),
            Unknown::Derivative(2) => {
                state(&[2])
                    || variable(&[
                        Variable::SteeringAngle,
                        Variable::SteeringRatio,
                        Variable::ActuatorTimeConstant,
                        Variable::ActuatorDelay,
                        Variable::RoadWheelRateMax,
                        Variable::RoadWheelAngleMax,
                    ])
            }
            Unknown::Derivative(3) => forces || variable(&[Variable::RollTimeConstant]),
            Unknown::Derivative(X | Y) => {
                state(&[0, YAW]) || variable(&[Variable::Speed, Variable::InitialYaw])
            }
            // Set from outside, or none of this vehicle's.
            Unknown::Variable(_) | Unknown::State(_) | Unknown::Derivative(_) => false,
        };
        depends.then_some(DependencyKind::Dependent)
    }

    /// By the states that cannot be set; for the rest the layer takes differences.
    fn partial_derivative(
        &mut self,
        unknown: Unknown<Variable>,
        known: Known<Variable>,
    ) -> Option<f64> {
        let Known::State(state @ (YAW | X | Y)) = known else { return None };
        let [_, x_rate, y_rate] = self.settled().pose_derivatives();
        Some(match (unknown, state) {
            (Unknown::Variable(Variable::Yaw) | Unknown::State(YAW), YAW)
            | (Unknown::Variable(Variable::X) | Unknown::State(X), X)
            | (Unknown::Variable(Variable::Y) | Unknown::State(Y), Y) => 1.0,
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
