//! Levenberg–Marquardt steps within the bounds.

use crate::Error;
use crate::linalg::bounded_step::bounded_step;
use crate::linalg::levenberg_marquardt::{Damping, USUAL, lower};
use crate::structures::single_track::problem::{Densities, Point, Problem};
use crate::structures::single_track::simulate::SimulationRun;

/// When to stop.
#[derive(Debug, Clone, Copy)]
pub(super) struct Stop {
    pub(super) steps: usize,
    /// A step that lowers the cost, half a sum of squares in deviations, by less is the last …
    pub(super) least_gain: f64,
    /// … or by less than this share of it.
    pub(super) least_share: f64,
}

/// A point with its cost.
#[derive(Debug, Clone, Copy)]
pub(super) struct Refined {
    pub(super) point: Point,
    pub(super) cost: f64,
}

/// Lowers the cost of a run from a point until `stop`; `None` where the point has no cost.
pub(super) fn refine(
    problem: &Problem<'_>,
    point: &Point,
    densities: &Densities,
    run: &SimulationRun,
    stop: Stop,
) -> Option<Refined> {
    let cost = problem.cost(point, run, densities)?;
    let reached = lower::<_, _, Error>(
        (*point, cost),
        stop.steps,
        Damping { first: 1e-2, ..USUAL },
        |before, now| before - now > stop.least_gain.max(stop.least_share * before),
        |at, _| Ok(problem.normals(at, run, densities)),
        |at, normals, damping| {
            let (free, priors) = (&problem.free, &problem.priors);
            let Some(next) =
                bounded_step(free, priors, &normals.gradient, &normals.hessian, at, damping)
            else {
                return Ok(None);
            };
            Ok(problem.cost(&next, run, densities).map(|cost| (next, cost)))
        },
    )
    .ok()?;
    Some(Refined { point: reached.point, cost: reached.cost })
}
