//! `BicyclePlant`: the glue from [`vehicle_models::BicyclePlant`] to the export trait.

use crate::resources::optional;
use crate::tables::bicycle_plant::Variable;
use fmi2_export::{Log, Resources, Slave};
use model_description::{Table, Value};
use vehicle_models::BicycleParameters;

/// The two-wheel bicycle model (eq 13) in its body-frame form, with yaw and position.
#[derive(Debug, Clone)]
pub struct BicyclePlant {
    plant: vehicle_models::BicyclePlant,
    started: bool,
}

impl Slave for BicyclePlant {
    type Variable = Variable;
    const TABLE: &'static Table = Variable::TABLE;

    fn open(resources: &Resources) -> Result<Self, String> {
        let bicycle = optional::<formats::Bicycle>(resources, "bicycle.json")?;
        let vehicle = bicycle.map(|b| b.vehicle);
        let parameters = vehicle
            .as_ref()
            .map_or_else(BicycleParameters::default, model_loading::bicycle_parameters);
        let mut plant = vehicle_models::BicyclePlant::new(parameters)
            .map_err(|e| format!("bicycle.json: {e}; hint: {}", e.hint()))?;
        if let Some(vehicle) = vehicle {
            plant.speed = vehicle.speed_mps;
        }
        Ok(Self { plant, started: false })
    }

    #[inline]
    fn get(&mut self, variable: Variable) -> Value {
        let p = &mut self.plant;
        // Until the start, outputs are those that a start from the present settings would give;
        // a vehicle that cannot start is refused when initialization mode is left.
        if !self.started {
            let _ = p.start();
        }
        Value::Real(match variable {
            Variable::SteeringAngle => p.steering_angle,
            Variable::Speed => p.speed,
            Variable::YawRate => p.yaw_rate(),
            Variable::Yaw => p.yaw(),
            Variable::X => p.x(),
            Variable::Y => p.y(),
            Variable::LateralVelocity => p.lateral_velocity(),
            Variable::LateralAcceleration => p.lateral_acceleration(),
            Variable::Mass => p.parameters.mass,
            Variable::YawInertia => p.parameters.yaw_inertia,
            Variable::DistanceFront => p.parameters.distance_front,
            Variable::DistanceRear => p.parameters.distance_rear,
            Variable::CorneringStiffnessFront => p.parameters.cornering_stiffness_front,
            Variable::CorneringStiffnessRear => p.parameters.cornering_stiffness_rear,
            Variable::ActuatorTimeConstant => p.parameters.actuator_time_constant,
            Variable::SteeringRatio => p.parameters.steering_ratio,
            Variable::InitialX => p.initial_x,
            Variable::InitialY => p.initial_y,
            Variable::InitialYaw => p.initial_yaw,
        })
    }

    #[inline]
    fn set(&mut self, variable: Variable, value: &Value) {
        let Value::Real(value) = *value else { return };
        let p = &mut self.plant;
        *match variable {
            Variable::SteeringAngle => &mut p.steering_angle,
            Variable::Speed => &mut p.speed,
            Variable::Mass => &mut p.parameters.mass,
            Variable::YawInertia => &mut p.parameters.yaw_inertia,
            Variable::DistanceFront => &mut p.parameters.distance_front,
            Variable::DistanceRear => &mut p.parameters.distance_rear,
            Variable::CorneringStiffnessFront => &mut p.parameters.cornering_stiffness_front,
            Variable::CorneringStiffnessRear => &mut p.parameters.cornering_stiffness_rear,
            Variable::ActuatorTimeConstant => &mut p.parameters.actuator_time_constant,
            Variable::SteeringRatio => &mut p.parameters.steering_ratio,
            Variable::InitialX => &mut p.initial_x,
            Variable::InitialY => &mut p.initial_y,
            Variable::InitialYaw => &mut p.initial_yaw,
            Variable::YawRate
            | Variable::Yaw
            | Variable::X
            | Variable::Y
            | Variable::LateralVelocity
            | Variable::LateralAcceleration => return,
        } = value;
    }

    fn exit_initialization(&mut self, _start_time: f64, _log: &mut Log) -> Result<(), String> {
        self.started = true;
        self.plant.start().map_err(|e| format!("{e}; hint: {}", e.hint()))
    }

    fn step(&mut self, _time: f64, step: f64, _log: &mut Log) -> Result<(), String> {
        self.plant.step(step).map_err(|e| format!("{e}; hint: {}", e.hint()))
    }
}
