//! What the comparison needs of each structure of a model.

use crate::Error;
use crate::vehicle::validate_vehicle;
use steerwright_drivelog::DriveLog;
use steerwright_formats::Model;
use steerwright_sysid::bicycle::validate_bicycle;
use steerwright_sysid::{IdentifyOptions, Validated, validate_plant};

/// The simulation of a log by a model.
pub(crate) fn validate_model(
    model: &Model,
    log: &DriveLog,
    options: &IdentifyOptions,
) -> Result<Validated, Error> {
    Ok(match model {
        Model::StateSpace(plant) => validate_plant(log, options, plant)?,
        Model::Bicycle(bicycle) => validate_bicycle(log, options, bicycle)?,
        Model::SingleTrack(vehicle) => validate_vehicle(log, options.validation.fraction, vehicle)?,
        // Which `models` makes none of.
        other => return Err(steerwright_control::no_steering(other).into()),
    })
}
