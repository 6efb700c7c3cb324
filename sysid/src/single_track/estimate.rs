//! The search: Levenberg–Marquardt steps within the bounds, from several initial estimates, over runs
//! that become longer: windows with the measured yaw rate fed back, the whole with it fed back, and the
//! free simulation.

use crate::Error;
use crate::data::statistics::long_run_variance;
use crate::linalg::dense::is_finite;
use crate::linalg::levenberg_marquardt::{Damping, USUAL, by_more_than, lower};
use crate::single_track::parameters::Parameter;
use crate::single_track::problem::{Densities, Normals, OUTPUTS, Point, Problem};
use crate::single_track::simulate::Run;
use faer::linalg::solvers::Solve;
use faer::{Mat, Side};
use steerwright_drivelog::signal::standard_deviation;

/// Largest step in priors' deviations.
const LARGEST_STEP: f64 = 2.0;
/// A step that lowers the cost by a smaller share is the last.
const LEAST_GAIN: f64 = 1e-6;
/// Share of an output's deviation that errors are supposed to have before there are any.
const SUPPOSED_ERROR: f64 = 0.1;
/// How long errors are supposed to last, s.
const SUPPOSED_DURATION_S: f64 = 0.5;
/// Initial estimates that are refined to the end.
const KEPT: usize = 2;

/// What was found.
#[derive(Debug, Clone)]
pub(super) struct Estimate {
    pub(super) point: Point,
    pub(super) densities: Densities,
    pub(super) cost: f64,
}

/// The run of the result: every sample, free.
pub(super) fn free_run(problem: &Problem<'_>) -> Run {
    let _ = problem;
    Run { stride: 1, longest_step_s: 0.01, gain: 0.0, restart: 0 }
}

fn coarse(problem: &Problem<'_>) -> Run {
    let t = problem.segments.first().map_or(0.01, |s| s.sample_time);
    Run {
        stride: (0.02 / t).round().max(1.0) as usize,
        longest_step_s: 0.02,
        gain: 0.0,
        restart: 0,
    }
}

/// Estimates from several initial estimates.
pub(super) fn solve(problem: &Problem<'_>) -> Result<Estimate, Error> {
    let t = problem.segments.first().map_or(0.01, |s| s.sample_time);
    let free = coarse(problem);
    let windows = Run { gain: 2.0, restart: (5.0 / t).round() as usize, ..free };
    let fed_back = Run { gain: 1.0, ..free };
    let densities = supposed(problem);
    let starts = starts(problem);
    let mut tried: Vec<Estimate> =
        each(&starts, |start| refine(problem, *start, densities, &windows, 8));
    tried.sort_by(|a, b| a.cost.total_cmp(&b.cost));
    tried.truncate(KEPT);
    let points: Vec<Point> = tried.iter().map(|e| e.point).collect();
    let mut found: Vec<Estimate> = each(&points, |point| {
        let at = refine(problem, *point, densities, &fed_back, 15)?;
        // Less feedback where the free simulation spins.
        let mut at = at;
        for gain in [0.3, 0.1, 0.03] {
            if problem.cost(&at.point, &free, &densities).is_some() {
                break;
            }
            at = refine(problem, at.point, densities, &Run { gain, ..free }, 15)?;
        }
        let at = refine(problem, at.point, densities, &free, 20)?;
        let densities = observed(problem, &at.point, &free)?;
        refine(problem, at.point, densities, &free, 20)
    });
    // Densities differ: the costs are compared with those of the first.
    let common = found.first().map(|e| e.densities).ok_or_else(none)?;
    found.sort_by(|a, b| {
        let cost = |e: &Estimate| problem.cost(&e.point, &free, &common).unwrap_or(f64::INFINITY);
        cost(a).total_cmp(&cost(b))
    });
    let best = found.into_iter().next().ok_or_else(none)?;
    let full = free_run(problem);
    let densities = observed(problem, &best.point, &full).ok_or_else(none)?;
    let best = refine(problem, best.point, densities, &full, 20).ok_or_else(none)?;
    Ok(best)
}

fn none() -> Error {
    Error::no_model("no single-track model follows this drive without spinning")
}

/// `work` on each, on two threads or more.
fn each<A: Sync, B: Send>(all: &[A], work: impl Fn(&A) -> Option<B> + Sync) -> Vec<B> {
    std::thread::scope(|scope| {
        let work = &work;
        let handles: Vec<_> = all.iter().map(|a| scope.spawn(move || work(a))).collect();
        handles.into_iter().filter_map(|h| h.join().ok().flatten()).collect()
    })
}

/// Densities before there are errors.
fn supposed(problem: &Problem<'_>) -> Densities {
    let of = |signal: &dyn Fn(usize) -> Option<Vec<f64>>| {
        let all: Vec<f64> = (0..problem.segments.len()).filter_map(signal).flatten().collect();
        let error = SUPPOSED_ERROR * standard_deviation(&all);
        (error * error * SUPPOSED_DURATION_S).max(1e-12)
    };
    let s = &problem.segments;
    [
        of(&|k| Some(s[k].yaw_rate.to_vec())),
        of(&|k| s[k].lateral_acceleration.map(<[f64]>::to_vec)),
        of(&|k| s[k].lateral_velocity.map(<[f64]>::to_vec)),
    ]
}

/// Densities of the errors of a run.
pub(super) fn observed(problem: &Problem<'_>, p: &Point, run: &Run) -> Option<Densities> {
    let errors = problem.errors(p, run)?;
    let period = problem.period(run);
    Some(std::array::from_fn(|i| {
        if problem.fitted[i] { (long_run_variance(&errors[i]) * period).max(1e-14) } else { 1.0 }
    }))
}

/// Initial estimates: stiff and soft tyres, little and much grip.
fn starts(problem: &Problem<'_>) -> Vec<Point> {
    let mean: Point = std::array::from_fn(|i| problem.priors[i].mean);
    let mut all = vec![mean];
    for stiffness in [-0.8, 0.8] {
        for friction in [-0.7, 1.0] {
            let mut p = mean;
            for (parameter, by) in [
                (Parameter::StiffnessFront, stiffness),
                (Parameter::StiffnessRear, stiffness),
                (Parameter::FrictionFront, friction),
            ] {
                let i = parameter.index();
                p[i] += by * problem.priors[i].deviation;
                p[i] = p[i].clamp(problem.priors[i].bounds[0], problem.priors[i].bounds[1]);
            }
            all.push(p);
        }
    }
    all
}

/// Lowers the cost of a run from a point; `None` where there is no cost.
pub(super) fn refine(
    problem: &Problem<'_>,
    point: Point,
    densities: Densities,
    run: &Run,
    steps: usize,
) -> Option<Estimate> {
    let cost = problem.cost(&point, run, &densities)?;
    let reached = lower::<_, _, Error>(
        (point, cost),
        steps,
        Damping { first: 1e-2, fall: 0.2, tries: 8, ..USUAL },
        by_more_than(LEAST_GAIN),
        |at, _| Ok(problem.normals(at, run, &densities)),
        |at, normals, damping| {
            let Some(next) = step(problem, at, normals, damping) else { return Ok(None) };
            Ok(problem.cost(&next, run, &densities).map(|cost| (next, cost)))
        },
    )
    .ok()?;
    Some(Estimate { point: reached.point, densities, cost: reached.cost })
}

/// A damped step within the bounds. Parameters at a bound that the step would leave stay there.
fn step(problem: &Problem<'_>, at: &Point, normals: &Normals, damping: f64) -> Option<Point> {
    let mut moving = problem.free.clone();
    loop {
        let n = moving.len();
        if n == 0 {
            return None;
        }
        let hessian = Mat::from_fn(n, n, |i, j| {
            let h = normals.hessian[moving[i]][moving[j]];
            if i == j { h * (1.0 + damping) } else { h }
        });
        let gradient = Mat::from_fn(n, 1, |i, _| -normals.gradient[moving[i]]);
        let solution = hessian.llt(Side::Lower).ok()?.solve(&gradient);
        if !is_finite(solution.as_ref()) {
            return None;
        }
        let stays = |(j, &i): (usize, &usize)| {
            let [low, high] = problem.priors[i].bounds;
            let step = solution[(j, 0)];
            (at[i] <= low && step < 0.0) || (at[i] >= high && step > 0.0)
        };
        let held: Vec<usize> =
            moving.iter().enumerate().filter(|&x| stays(x)).map(|(_, &i)| i).collect();
        if !held.is_empty() {
            moving.retain(|i| !held.contains(i));
            continue;
        }
        let largest = moving
            .iter()
            .enumerate()
            .map(|(j, &i)| (solution[(j, 0)] / problem.priors[i].deviation).abs())
            .fold(0.0, f64::max);
        let scale = if largest > LARGEST_STEP { LARGEST_STEP / largest } else { 1.0 };
        let mut next = *at;
        for (j, &i) in moving.iter().enumerate() {
            let [low, high] = problem.priors[i].bounds;
            next[i] = (at[i] + scale * solution[(j, 0)]).clamp(low, high);
        }
        return Some(next);
    }
}

const _: () = assert!(OUTPUTS == 3);
