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

/// Whether no free simulation of the drives spins with a reduction.
fn follows(drives: &[&Problem<'_>], point: &Point, run: &SimulationRun, reduction: f64) -> bool {
    let mut point = *point;
    point[Parameter::FrictionBalance.index()] += (1.0 - reduction).ln();
    drives.iter().all(|drive| drive.errors(&point, run).is_some())
}

/// The number of reductions from the first on with which nothing spins, where it is more than `least`; `None` otherwise,
/// which one simulation shows.
fn followed(follows: impl Fn(f64) -> bool, least: Option<usize>) -> Option<usize> {
    // With less friction a model that has spun does not follow again.
    let count = |reductions: &[f64]| reductions.partition_point(|&reduction| follows(reduction));
    let Some(least) = least else { return Some(count(&REDUCTIONS)) };
    let (next, rest) = REDUCTIONS.get(least..)?.split_first()?;
    if follows(*next) { Some(least + 1 + count(rest)) } else { None }
}

/// The largest of so many reductions.
fn margin(followed: usize) -> f64 {
    followed.checked_sub(1).map_or(0.0, |place| REDUCTIONS[place])
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
    let mut most = followed(|by| follows(drives, least, run, by), None).unwrap_or_default();
    let mut found = Moved { point: *least, margin: margin(most) };
    if most == REDUCTIONS.len() {
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
        // A smaller margin than that of an estimate that fits well enough is of no use.
        let least = if is_enough { Some(most) } else { None };
        if let Some(count) = followed(|by| follows(drives, &point, run, by), least) {
            most = count;
            found = Moved { point, margin: margin(most) };
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

#[cfg(test)]
mod tests {
    use super::*;
    use std::cell::Cell;

    #[test]
    fn a_margin_that_is_no_larger_takes_one_simulation() {
        for spins_at in 0..=REDUCTIONS.len() {
            let tried = Cell::new(0);
            let follows = |by: f64| {
                tried.set(tried.get() + 1);
                REDUCTIONS[..spins_at].contains(&by)
            };
            assert_eq!(followed(follows, None), Some(spins_at));
            for least in 0..=REDUCTIONS.len() {
                tried.set(0);
                let expected = if spins_at > least { Some(spins_at) } else { None };
                assert_eq!(followed(follows, Some(least)), expected, "{spins_at} {least}");
                assert!(expected.is_some() || tried.get() <= 1, "{spins_at} {least}");
            }
        }
    }
}
