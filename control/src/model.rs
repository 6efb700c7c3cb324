//! What control needs of each structure of a model.

use crate::Error;
use crate::bicycle::bicycle_of_vehicle;
use crate::plants::behind_actuator::{bicycle_behind, plant_behind};
use crate::plants::design_plant::DesignPlant;
use steerwright_formats::{
    Bicycle, Grade, Model, Plant, Quality, Reason, ReasonCode, StatedActuator, Structure, Vehicle,
};
use steerwright_models::Sideslip;

impl DesignPlant {
    /// The plant of a model as controllers are designed on it: a vehicle as it is in gentle driving.
    ///
    /// # Errors
    /// Those of [`DesignPlant::from_plant`] and [`DesignPlant::from_bicycle`]; [`Error::SteeredByTorque`], [`Error::NoSteering`],
    /// [`Error::NamedChannels`].
    pub fn from_model(model: &Model) -> Result<Self, Error> {
        match model {
            Model::StateSpace(plant) => Self::from_plant(plant),
            Model::Bicycle(bicycle) => Self::from_bicycle(bicycle),
            Model::SingleTrack(vehicle) => {
                let mut gentle = Self::from_bicycle(&bicycle_of_vehicle(vehicle)?)?;
                gentle.quality = with_play(gentle.quality, vehicle.actuator.play_rad);
                gentle.vehicle = Some(vehicle.clone());
                Ok(gentle)
            }
            other => Err(no_steering(other)),
        }
    }
}

/// The quality with a reason where the vehicle's file states play, rad at the road wheel, which no design includes.
fn with_play(quality: Quality, play_rad: f64) -> Quality {
    if play_rad == 0.0 {
        return quality;
    }
    let degrees = play_rad.to_degrees();
    let message = format!(
        "the vehicle has {degrees:.2}° of play between actuator and road wheels, which the design does not include"
    );
    let advice = "simulate the loop of the packed units to see the limit cycle: steerwright simulate NonlinearVehicle.fmu ReferencePath.fmu LateralPid.fmu";
    let reason = Reason::new(ReasonCode::SteeringPlay, Grade::Warn, message);
    quality.with_reason(reason.compared(degrees, 0.0, "deg"), advice.into())
}

/// Why no controller of the steering is designed on a model of any other structure than those of the lateral dynamics.
#[must_use]
pub fn no_steering(model: &Model) -> Error {
    match model {
        Model::Torque(_) => Error::SteeredByTorque,
        Model::Multivariable(_) => Error::NamedChannels,
        other => {
            let structure = other.structure();
            let elsewhere = match structure {
                Structure::Longitudinal => {
                    "; the speed of this one is controlled by: steerwright design longitudinal.json"
                }
                _ => "",
            };
            Error::NoSteering { structure: structure.name(), elsewhere }
        }
    }
}

/// The model behind an actuator, whose FMU takes the command; `None` is the model itself. A bicycle or a vehicle with a lag
/// of its own gets one lag, the sum of both.
#[must_use]
pub fn model_behind(model: &Model, actuator: Option<StatedActuator>) -> Model {
    let Some(actuator) = actuator else { return model.clone() };
    match model {
        Model::StateSpace(plant) => Model::StateSpace(plant_behind(plant, actuator).into()),
        Model::Bicycle(bicycle) => Model::Bicycle(bicycle_behind(bicycle, actuator).into()),
        Model::SingleTrack(vehicle) => {
            let mut behind = vehicle.clone();
            behind.actuator.time_constant_s += actuator.time_constant_s;
            behind.actuator.delay_s += actuator.delay_s;
            Model::SingleTrack(behind)
        }
        other => other.clone(),
    }
}

/// The vehicle up to its limits that a model is; `None` of another structure.
#[must_use]
pub fn model_vehicle(model: &Model) -> Option<&Vehicle> {
    match model {
        Model::SingleTrack(vehicle) => Some(vehicle),
        _ => None,
    }
}

/// The bicycle that a model is in gentle driving; `None` of a structure that is none.
///
/// # Errors
/// A vehicle that is no bicycle in gentle driving.
pub fn model_bicycle(model: &Model) -> Result<Option<Bicycle>, Error> {
    Ok(match model {
        Model::Bicycle(bicycle) => Some(bicycle.as_ref().clone()),
        Model::SingleTrack(vehicle) => Some(bicycle_of_vehicle(vehicle)?),
        _ => None,
    })
}

/// The sideslip of a vehicle: the one that its model's drive determined, at the speed that is stated with it, otherwise that
/// of the model at `speed` in m/s, by default its own. `None` where there is neither.
///
/// # Errors
/// A vehicle that is no bicycle in gentle driving.
pub fn model_sideslip(model: &Model, speed: Option<f64>) -> Result<Option<Sideslip>, Error> {
    Ok(match model {
        Model::StateSpace(plant) => plant_sideslip(plant),
        Model::Bicycle(bicycle) => bicycle_sideslip(bicycle, speed),
        Model::SingleTrack(vehicle) => bicycle_sideslip(&bicycle_of_vehicle(vehicle)?, speed),
        _ => None,
    })
}

/// The largest lateral acceleration that the evidence of a model covers, m/s²; `None` where it states none.
#[must_use]
pub fn evidence_acceleration(model: &Model) -> Option<f64> {
    match model {
        Model::SingleTrack(vehicle) => {
            let stated =
                vehicle.evidence.as_ref().map(|evidence| evidence.lateral_acceleration_mps2);
            stated.filter(|largest| *largest > 0.0)
        }
        _ => None,
    }
}

fn bicycle_sideslip(bicycle: &Bicycle, speed: Option<f64>) -> Option<Sideslip> {
    let vehicle = &bicycle.vehicle;
    if let Some(stated) = &bicycle.sideslip {
        return Some(steerwright_models::files::sideslip(stated, vehicle.speed_mps));
    }
    let speed = speed.unwrap_or(vehicle.speed_mps);
    let parameters = steerwright_models::files::bicycle_parameters(vehicle);
    if speed > 0.0 { Some(parameters.sideslip(speed)) } else { None }
}

/// The sideslip of an identified plant, where it was measured.
#[must_use]
pub fn plant_sideslip(plant: &Plant) -> Option<Sideslip> {
    let speed = plant.operating_point.speed_mps;
    plant.sideslip.as_ref().map(|stated| steerwright_models::files::sideslip(stated, speed))
}
