//! Levenberg–Marquardt steps within the bounds.

use crate::Error;
use crate::linalg::dense::is_finite;
use crate::linalg::levenberg_marquardt::{Damping, USUAL, lower};
use crate::structures::single_track::problem::{Densities, Normals, Point, Problem};
use crate::structures::single_track::simulate::Run;
use faer::linalg::solvers::Solve;
use faer::{Mat, Side};

/// Largest step in priors' deviations.
const LARGEST_STEP: f64 = 2.0;
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
    run: &Run,
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
            let Some(next) = step(problem, at, normals, damping) else { return Ok(None) };
            Ok(problem.cost(&next, run, densities).map(|cost| (next, cost)))
        },
    )
    .ok()?;
    Some(Refined { point: reached.point, cost: reached.cost })
}

/// A damped step. Parameters at a bound that the step would leave stay there.
fn step(problem: &Problem<'_>, at: &Point, normals: &Normals, damping: f64) -> Option<Point> {
    let mut moving = problem.free.clone();
    while !moving.is_empty() {
        let n = moving.len();
        let hessian = Mat::from_fn(n, n, |i, j| {
            let h = normals.hessian[moving[i]][moving[j]];
            if i == j { h * (1.0 + damping) } else { h }
        });
        let gradient = Mat::from_fn(n, 1, |i, _| -normals.gradient[moving[i]]);
        let solution = hessian.llt(Side::Lower).ok()?.solve(&gradient);
        if !is_finite(solution.as_ref()) {
            return None;
        }
        let leaves = |(j, &i): (usize, &usize)| {
            let [low, high] = problem.priors[i].bounds;
            let step = solution[(j, 0)];
            ((at[i] <= low && step < 0.0) || (at[i] >= high && step > 0.0)).then_some(i)
        };
        let held: Vec<usize> = moving.iter().enumerate().filter_map(leaves).collect();
        if !held.is_empty() {
            moving.retain(|i| !held.contains(i));
            continue;
        }
        let relative =
            |(j, &i): (usize, &usize)| (solution[(j, 0)] / problem.priors[i].deviation).abs();
        let largest = moving.iter().enumerate().map(relative).fold(0.0, f64::max);
        let scale = if largest > LARGEST_STEP { LARGEST_STEP / largest } else { 1.0 };
        let mut next = *at;
        for (j, &i) in moving.iter().enumerate() {
            let [low, high] = problem.priors[i].bounds;
            next[i] = (at[i] + scale * solution[(j, 0)]).clamp(low, high);
        }
        return Some(next);
    }
    None
}
