//! `IdentifiedPlant`: the glue from [`vehicle_models::IdentifiedPlant`] to the export trait.

use crate::resources::required;
use crate::tables::identified_plant::Variable;
use fmi2_export::{Log, Resources, Slave};
use model_description::{Table, Value};
use std::sync::Arc;
use vehicle_models::InputKind;

/// The lateral dynamics identified from a drive (eq 6–7), with yaw and position.
#[derive(Debug, Clone)]
pub struct IdentifiedPlant {
    plant: vehicle_models::IdentifiedPlant,
    started: bool,
    warned_of_speed: bool,
}

impl IdentifiedPlant {
    /// Whether the yaw rate depends on the inputs of the same instant (D ≠ 0).
    pub(crate) fn has_feedthrough(resources: &Resources) -> Result<bool, String> {
        Ok(required::<formats::Plant>(resources, "plant.json")?.discrete.d.at(0, 0) != 0.0)
    }
}

impl Slave for IdentifiedPlant {
    type Variable = Variable;
    const TABLE: &'static Table = Variable::TABLE;

    fn open(resources: &Resources) -> Result<Self, String> {
        let plant = required::<formats::Plant>(resources, "plant.json")?;
        let model = model_loading::identified_model(&plant)
            .map_err(|e| format!("plant.json: {e}; hint: {}", e.hint()))?;
        let plant = vehicle_models::IdentifiedPlant::new(Arc::new(model));
        Ok(Self { plant, started: false, warned_of_speed: false })
    }

    #[inline]
    fn get(&mut self, variable: Variable) -> Value {
        let p = &mut self.plant;
        // Until the start, outputs are those that a start from the present settings would give.
        if !self.started {
            p.start();
        }
        Value::Real(match variable {
            Variable::NoiseSeed => return Value::Integer(p.noise_seed),
            Variable::SteeringAngle => p.steering_angle,
            Variable::Speed => p.speed,
            Variable::YawRate => p.yaw_rate(),
            Variable::Yaw => p.yaw(),
            Variable::X => p.x(),
            Variable::Y => p.y(),
            Variable::InitialX => p.initial_x,
            Variable::InitialY => p.initial_y,
            Variable::InitialYaw => p.initial_yaw,
            Variable::NoiseScale => p.noise_scale,
        })
    }

    #[inline]
    fn set(&mut self, variable: Variable, value: &Value) {
        let p = &mut self.plant;
        if let (Variable::NoiseSeed, Value::Integer(seed)) = (variable, value) {
            p.noise_seed = *seed;
        }
        let Value::Real(value) = *value else { return };
        *match variable {
            Variable::SteeringAngle => &mut p.steering_angle,
            Variable::Speed => &mut p.speed,
            Variable::InitialX => &mut p.initial_x,
            Variable::InitialY => &mut p.initial_y,
            Variable::InitialYaw => &mut p.initial_yaw,
            Variable::NoiseScale => &mut p.noise_scale,
            Variable::NoiseSeed | Variable::YawRate | Variable::Yaw | Variable::X | Variable::Y => {
                return;
            }
        } = value;
    }

    fn exit_initialization(&mut self, _start_time: f64, _log: &mut Log) -> Result<(), String> {
        self.plant.start();
        self.started = true;
        Ok(())
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
        self.plant.step(step).map_err(|e| format!("{e}; hint: {}", e.hint()))
    }
}
