//! The margin before a spin, and the estimate with the largest one of those that the data hardly tell apart.
//!
//! An error of some percent in the friction of the rear axle is invisible on the drive and a spin on the next one. The
//! estimate of least cost is moved towards more grip there, on the line on which the cost rises least, up to the end of the
//! 95 % band.

use crate::structures::single_track::parameters::Parameter;
use crate::structures::single_track::problem::{Point, Problem};
use crate::structures::single_track::simulate::SimulationRun;
use crate::structures::single_track::uncertainty::Covariance;
use steerwright_formats::SimulationFit;

/// Reductions of the rear axle's friction that the margin is one of: fine where models are compared.
const REDUCTIONS: [f64; 12] =
    [0.005, 0.01, 0.015, 0.02, 0.025, 0.03, 0.04, 0.05, 0.075, 0.1, 0.15, 0.2];
/// Standard deviations of the rear axle's friction that the estimate is moved by: the last is the end of the 95 % band.
const MOVES: [f64; 5] = [0.0, 0.5, 1.0, 1.5, 1.959];

/// The largest of the reductions with which no free simulation of the drives spins.
fn spin_margin(drives: &[&Problem<'_>], point: &Point, run: &SimulationRun) -> f64 {
    let follows = |reduction: f64| {
        let mut point = *point;
        point[Parameter::FrictionBalance.index()] += (1.0 - reduction).ln();
        drives.iter().all(|drive| drive.errors(&point, run).is_some())
    };
    // With less friction a model that has spun does not follow again.
    let place = REDUCTIONS.partition_point(|&reduction| follows(reduction));
    place.checked_sub(1).map_or(0.0, |place| REDUCTIONS[place])
}

/// An estimate with its margin.
#[derive(Debug, Clone, Copy)]
pub(super) struct Moved {
    pub(super) point: Point,
    pub(super) margin: f64,
}

/// The estimate of least cost or one near it: the one with the largest margin on the drives of those whose fit, as
/// `validate` returns it, is less than a standard error below the best.
///
/// # Errors
/// Those of `validate`.
pub(super) fn with_margin<E>(
    drives: &[&Problem<'_>],
    least: &Point,
    covariance: &Covariance,
    run: &SimulationRun,
    validate: impl Fn(&Point) -> Result<SimulationFit, E>,
) -> Result<Moved, E> {
    let mut found = Moved { point: *least, margin: spin_margin(drives, least, run) };
    if Some(&found.margin) == REDUCTIONS.last() {
        return Ok(found);
    }
    let points = MOVES.map(|deviations| moved(drives[0], least, covariance, deviations));
    let fits = points.iter().map(validate).collect::<Result<Vec<_>, E>>()?;
    let Some(best) = fits.iter().max_by(|a, b| a.yaw_rate.total_cmp(&b.yaw_rate)) else {
        return Ok(found);
    };
    let enough = best.yaw_rate - best.yaw_rate_standard_error.unwrap_or(0.0);
    let mut is_enough = fits[0].yaw_rate >= enough;
    for (point, fit) in points.into_iter().zip(&fits).skip(1) {
        if fit.yaw_rate < enough {
            continue;
        }
        let margin = spin_margin(drives, &point, run);
        if !is_enough || margin > found.margin {
            found = Moved { point, margin };
            is_enough = true;
        }
    }
    Ok(found)
}

/// The most likely parameters where the grip of the rear axle is by some standard deviations more.
fn moved(drive: &Problem<'_>, least: &Point, covariance: &Covariance, deviations: f64) -> Point {
    let grip = [Parameter::FrictionFront, Parameter::FrictionBalance].map(Parameter::index);
    let with_grip: Point = std::array::from_fn(|i| grip.iter().map(|&j| covariance[i][j]).sum());
    let deviation = grip.iter().map(|&i| with_grip[i]).sum::<f64>().max(0.0).sqrt();
    let mut point = *least;
    for &i in drive.free.iter().filter(|_| deviation > 0.0) {
        let [low, high] = drive.priors[i].bounds;
        point[i] = (point[i] + deviations / deviation * with_grip[i]).clamp(low, high);
    }
    point
}
