//! The plants that move in the plane, as they run in the FMUs.

use crate::Error;
use crate::plants::design_plant::{DesignPlant, Family};
use std::sync::Arc;
use steerwright_formats::{Bicycle, Plant, StatedActuator, Vehicle};
use steerwright_models::{BicyclePlant, IdentifiedPlant, NonlinearParameters, NonlinearVehicle};

/// Shortest lag of the actuator of a vehicle up to its limits, s. A model of a measured angle has hardly any; the integration
/// takes panels of a quarter of the lag, and steering that is later by less than half a tick makes a return no easier.
const LEAST_LAG_S: f64 = 0.004;

/// A plant that is driven along a path.
#[derive(Debug, Clone)]
pub enum PlantModel {
    /// Identified from a log.
    Identified(Box<IdentifiedPlant>),
    /// Eq 13.
    Bicycle(Box<BicyclePlant>),
    /// A single-track vehicle with saturating tyres, load transfer and an actuator of limited rate.
    Nonlinear(Box<NonlinearVehicle>),
}

/// The same expression for the plant of each kind.
macro_rules! of_each {
    ($model:expr, $plant:ident => $value:expr) => {
        match $model {
            PlantModel::Identified($plant) => $value,
            PlantModel::Bicycle($plant) => $value,
            PlantModel::Nonlinear($plant) => $value,
        }
    };
}

impl PlantModel {
    /// The plant of `plant.json`, at the speed of its identification.
    ///
    /// # Errors
    /// [`Error::Model`] where the model is inconsistent.
    pub fn from_plant(plant: &Plant) -> Result<Self, Error> {
        let model =
            steerwright_models::files::identified_model(plant).map_err(model_error(&plant.name))?;
        Ok(Self::Identified(Box::new(IdentifiedPlant::new(Arc::new(model)))))
    }

    /// The plant of `bicycle.json`, at its speed.
    ///
    /// # Errors
    /// [`Error::Model`] where the values are not those of a vehicle.
    pub fn from_bicycle(bicycle: &Bicycle) -> Result<Self, Error> {
        let vehicle = &bicycle.vehicle;
        let parameters = steerwright_models::files::bicycle_parameters(vehicle);
        let mut plant = BicyclePlant::new(parameters).map_err(model_error(&vehicle.name))?;
        plant.speed = vehicle.speed_mps;
        Ok(Self::Bicycle(Box::new(plant)))
    }

    /// The vehicle of `bicycle.json` up to its limits: its file has no tyre curve and no roll, which are those of
    /// [`NonlinearParameters::default`], with the lower of its own largest rate of the road wheel and `road_wheel_rate_max`,
    /// rad/s.
    pub(crate) fn saturating(bicycle: &Bicycle, road_wheel_rate_max: f64) -> Result<Self, Error> {
        let vehicle = &bicycle.vehicle;
        let mut parameters = NonlinearParameters::default();
        let NonlinearParameters { body, tyres, actuator } = &mut parameters;
        // The default's own rate is of no vehicle in particular.
        actuator.road_wheel_rate_max_radps = f64::INFINITY;
        vehicle.give_to(body, tyres, actuator);
        let rate = &mut actuator.road_wheel_rate_max_radps;
        *rate = rate.min(road_wheel_rate_max);
        Self::nonlinear(parameters, &vehicle.name)
    }

    /// The vehicle of `vehicle.json` behind an actuator, with the lower of its own largest rate of the road wheel and
    /// `road_wheel_rate_max`, rad/s.
    pub(crate) fn from_vehicle(
        vehicle: &Vehicle,
        behind: StatedActuator,
        road_wheel_rate_max: f64,
    ) -> Result<Self, Error> {
        let mut parameters = steerwright_models::files::nonlinear_parameters(vehicle);
        let actuator = &mut parameters.actuator;
        actuator.time_constant_s += behind.time_constant_s;
        actuator.delay_s += behind.delay_s;
        actuator.road_wheel_rate_max_radps =
            actuator.road_wheel_rate_max_radps.min(road_wheel_rate_max);
        Self::nonlinear(parameters, &vehicle.name)
    }

    fn nonlinear(mut parameters: NonlinearParameters, name: &str) -> Result<Self, Error> {
        let lag = &mut parameters.actuator.time_constant_s;
        *lag = lag.max(LEAST_LAG_S);
        let plant = NonlinearVehicle::new(parameters).map_err(model_error(name))?;
        Ok(Self::Nonlinear(Box::new(plant)))
    }

    /// The plant that moves, of the plant that a controller is designed on; `None` without a document.
    pub(crate) fn of_design(plant: &DesignPlant) -> Result<Option<Self>, Error> {
        match &plant.family {
            Family::Alone => Ok(None),
            Family::Identified(plant) => Self::from_plant(plant).map(Some),
            Family::Bicycle(bicycle) => Self::from_bicycle(bicycle).map(Some),
        }
    }

    /// Changes the speed, m/s.
    pub(crate) fn set_speed(&mut self, speed: f64) {
        of_each!(self, p => p.speed = speed);
    }

    /// Starts at a pose (x and y in m, yaw in rad) and a speed, m/s.
    pub(crate) fn start(
        &mut self,
        [x, y, yaw]: [f64; 3],
        speed: f64,
    ) -> Result<(), steerwright_models::Error> {
        of_each!(self, p => {
            (p.initial_x, p.initial_y, p.initial_yaw, p.speed) = (x, y, yaw, speed);
        });
        match self {
            Self::Identified(p) => {
                p.start();
                Ok(())
            }
            Self::Bicycle(p) => p.start(),
            Self::Nonlinear(p) => p.start(),
        }
    }

    /// Advances by `h`, s, with the steering angle held, rad.
    pub(crate) fn step(&mut self, steering: f64, h: f64) -> Result<(), steerwright_models::Error> {
        of_each!(self, p => {
            p.steering_angle = steering;
            p.step(h)
        })
    }

    /// x and y, m, yaw, rad, and yaw rate, rad/s.
    pub(crate) fn outputs(&self) -> [f64; 4] {
        of_each!(self, p => [p.x(), p.y(), p.yaw(), p.yaw_rate()])
    }
}

/// [`Error::Model`] of a model with this name.
pub(crate) fn model_error(model: &str) -> impl Fn(steerwright_models::Error) -> Error + '_ {
    move |e| Error::Model { model: model.into(), problem: e.to_string() }
}
