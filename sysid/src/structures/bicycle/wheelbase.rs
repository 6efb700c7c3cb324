//! The wheelbase that a drive determines, for structures that have none: that of a bicycle of the same drive.

use crate::Error;
use crate::data::moving::{least_speed, moving};
use crate::data::recording::{Recording, samples_in};
use crate::data::split::Split;
use crate::linalg::dual::Scalar;
use crate::structures::bicycle::estimate::Problem;
use crate::structures::bicycle::options::BicycleOptions;
use crate::structures::bicycle::parameters::{Combination, Geometry, combinations};
use crate::structures::bicycle::simulate::within;
use crate::structures::bicycle::simulation::segments;
use crate::structures::bicycle::uncertainty::{LARGEST_ERROR, covariance, deviation};
use crate::validation::plausible::opposite;
use crate::validation::residuals::pairs::pairs;
use steerwright_drivelog::DriveLog;
use steerwright_drivelog::signal::standard_deviation;

/// A step that lowers the sum of squares by a smaller share is the last: the wheelbase then stays to a thousandth.
const LEAST_GAIN: f64 = 1e-5;
/// Share of the yaw rate's variance that the bicycle may leave: a drive that it does not follow has no wheelbase.
const MOST_LEFT: f64 = 0.5;

/// The wheelbase with its standard error, m. At one speed, where the understeer gradient takes the place of the wheelbase,
/// the tyres' priors limit that gradient, and the standard error covers what they leave open. `None` where the drive has
/// no speed, no steering angle or no bicycle, or where its gain is not determined.
pub(crate) fn wheelbase(log: &DriveLog) -> Option<[f64; 2]> {
    estimated(log).ok().flatten()
}

fn estimated(log: &DriveLog) -> Result<Option<[f64; 2]>, Error> {
    let log = &*moving(log, least_speed(log, None, None))?;
    if !log.has_steering_angle() || opposite(&pairs(log), log.sample_time_s).is_some() {
        return Ok(None);
    }
    let options = BicycleOptions::default();
    let recording = Recording::new(log, &|turned| {
        Split::new(log, turned, options.validation).thinned(options.max_samples, log.sample_time_s)
    })?;
    let all = segments(&recording, log);
    let estimation = within(&all, &recording.split.estimation);
    let geometry = Geometry { wheelbase: None, is_angle: true };
    let mut problem = Problem::new(estimation, options.front_share(), geometry, false);
    problem.least_gain = LEAST_GAIN;
    let found = problem.solve()?;
    let Some(errors) = problem.errors(&found.parameters, &found.initial_states) else {
        return Ok(None);
    };
    let left = errors.iter().flatten().map(|e| e * e).sum::<f64>() / problem.samples() as f64;
    let yaw_rate = standard_deviation(&samples_in(&log.output, &recording.split.estimation));
    let covariance = covariance(&problem, &found)?;
    let speed_mps = recording.speed_summary().mean_mps;
    let with_error = |c: Combination| [c.2.value(), deviation(&c.2.by(), &covariance)];
    let all = combinations(&found.parameters, options.front_share(), speed_mps);
    let quantity = |name: &str| all.iter().find(|c| c.0 == name).copied().map(with_error);
    let is_determined =
        quantity("yaw_rate_gain").is_some_and(|[gain, error]| error <= LARGEST_ERROR * gain.abs());
    let is_followed = left <= MOST_LEFT * yaw_rate * yaw_rate;
    Ok(quantity("effective_wheelbase").filter(|_| is_determined && is_followed))
}
