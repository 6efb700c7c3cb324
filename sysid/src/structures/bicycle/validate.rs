//! A bicycle on a drive that need not be its own, over the recorded speed. The offsets of steering
//! and yaw rate are the drive's and follow from the estimation data; the simulated yaw rate is
//! linear in them and in each segment's initial states.

use crate::Error;
use crate::data::recording::Recording;
use crate::data::split::Split;
use crate::linalg::dense::least_squares;
use crate::selection::options::IdentifyOptions;
use crate::structures::bicycle::estimate::Problem;
use crate::structures::bicycle::parameters::{self, PARAMETERS, STEERING_OFFSET, YAW_RATE_OFFSET};
use crate::structures::bicycle::simulate::{sensitivities, within};
use crate::structures::bicycle::simulation::{Simulation, segments};
use crate::validation::validate::{Validated, held_as};
use faer::Mat;
use std::borrow::Cow;
use steerwright_drivelog::DriveLog;
use steerwright_formats::Bicycle;

/// Offsets whose effect is a smaller share are left: at one speed they cannot be separated.
const SEPARABLE: f64 = 1e-3;

/// Validates a bicycle on a drive, with the recorded speed, or its own where none was recorded.
///
/// # Errors
/// As [`identify_bicycle`](crate::structures::bicycle::identify_bicycle) for a drive that is too short or does not move.
pub fn validate_bicycle(
    log: &DriveLog,
    options: &IdentifyOptions,
    bicycle: &Bicycle,
) -> Result<Validated, Error> {
    options.check()?;
    let vehicle = &bicycle.vehicle;
    let log = &*match &bicycle.evidence {
        Some(e) => held_as(log, &e.channels, e.open_hold_s.is_some(), e.held_for.as_ref())?,
        None => Cow::Borrowed(log),
    };
    let with_speed = DriveLog {
        speed: Some(log.speed.clone().unwrap_or_else(|| vec![vehicle.speed_mps; log.len()])),
        ..log.clone()
    };
    let recording = Recording::new(&with_speed, &|turned| {
        Split::end(log, turned.len(), options.validation.fraction)
    })?;
    let segments = segments(&recording, &with_speed);
    let stated = parameters::Geometry { wheelbase: None, is_angle: true };
    let share = vehicle.distance_rear_m / (vehicle.distance_front_m + vehicle.distance_rear_m);
    let [estimation, validation] = [&recording.split.estimation, &recording.split.validation]
        .map(|ranges| Problem::new(within(&segments, ranges), share, stated, false));

    let mut p = parameters::of_vehicle(vehicle, log.steering_ratio);
    if let Some(evidence) = &bicycle.evidence {
        p[STEERING_OFFSET] = evidence.steering_offset_rad / log.steering_ratio;
        p[YAW_RATE_OFFSET] = evidence.yaw_rate_offset_radps;
    }
    offsets(&estimation, &mut p)?;
    let errors = |part: &Problem<'_>| -> Result<Option<Vec<Vec<f64>>>, Error> {
        Ok(part.initial_states(&p)?.and_then(|initial_states| part.errors(&p, &initial_states)))
    };
    let simulation = Simulation::new(log, &recording, errors(&estimation)?, errors(&validation)?);
    Ok(Validated {
        estimation_fit: simulation.estimation_fit,
        validation_fit: simulation.validation_fit.fit,
        simulated_yaw_rate_radps: simulation.simulated,
        first_validation_sample: recording.split.validation.first().map_or(log.len(), |r| r.start),
    })
}

/// Moves both offsets to where the model follows best, whatever the initial states explain; not
/// where it leaves all bounds.
fn offsets(problem: &Problem<'_>, p: &mut [f64; PARAMETERS]) -> Result<(), Error> {
    let mut rows: Vec<[f64; 3]> = Vec::with_capacity(problem.samples());
    for segment in &problem.segments {
        let from = segment.measured();
        let Some(found) = sensitivities(p, problem.share, segment, &from, false) else {
            return Ok(());
        };
        let by_start = Mat::from_fn(segment.len(), 2, |t, j| found.by[t][PARAMETERS + j]);
        let moved = Mat::from_fn(segment.len(), 3, |t, j| match j {
            0 => found.by[t][STEERING_OFFSET],
            1 => found.by[t][YAW_RATE_OFFSET],
            _ => segment.yaw_rate[t] - found.yaw_rate[t],
        });
        let explained = &by_start * least_squares(by_start.as_ref(), moved.as_ref(), 1e-9)?;
        rows.extend(
            (0..segment.len()).map(|t| [0, 1, 2].map(|j| moved[(t, j)] - explained[(t, j)])),
        );
    }
    let by_offset = Mat::from_fn(rows.len(), 2, |t, j| rows[t][j]);
    let rest = Mat::from_fn(rows.len(), 1, |t, _| rows[t][2]);
    let step = least_squares(by_offset.as_ref(), rest.as_ref(), SEPARABLE)?;
    p[STEERING_OFFSET] += step[(0, 0)];
    p[YAW_RATE_OFFSET] += step[(1, 0)];
    Ok(())
}
