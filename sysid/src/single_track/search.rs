//! The search: from several initial estimates, over runs that become harder to follow.
//!
//! At the limit of grip a wrong model spins, and a free simulation of minutes has no useful derivatives
//! then. The first runs therefore start again every few seconds, with the measured yaw rate fed back and
//! the sideslip guarded, on yaw rate alone; then the whole drive is simulated with feedback, and at last
//! without. A model that spins in the free simulation where the vehicle did not has no cost.

use crate::Error;
use crate::single_track::noise::{Densities, observed, supposed};
use crate::single_track::parameters::Parameter;
use crate::single_track::problem::{Point, Problem};
use crate::single_track::simulate::Run;
use crate::single_track::step::{Refined, refine};

/// Initial estimates that are refined to the end, of those that are tried.
const KEPT: usize = 3;
/// Steps on windows, with feedback and in free simulation.
const STEPS: [usize; 3] = [10, 15, 30];
/// Seconds between two initial states of the first run.
const WINDOW_S: f64 = 5.0;
/// Feedback of yaw rate, 1/s, while the free simulation spins.
const GAINS: [f64; 4] = [1.0, 0.3, 0.1, 0.03];
/// The guard of sideslip with feedback, 1/s.
const GUARD: f64 = 5.0;
/// Steps of the search and of the result, s.
const COARSE_S: f64 = 0.02;
const FINE_S: f64 = 0.01;
/// Costs that differ by less are of one minimum.
const SAME_COST: f64 = 0.5;

/// What was found.
#[derive(Debug, Clone)]
pub(super) struct Found {
    pub(super) point: Point,
    pub(super) densities: Densities,
    /// Initial estimates that were refined to the end, those that followed the drive without a spin, and
    /// those that reached the minimum of the result.
    pub(super) initial_estimates: [usize; 3],
}

/// The free simulation in steps of about `step_s`.
pub(super) fn free_run(sample_time_s: f64, step_s: f64) -> Run {
    let stride = (step_s / sample_time_s).round().max(1.0) as usize;
    Run { stride, longest_step_s: step_s, gain: 0.0, guard: 0.0, restart: 0 }
}

/// The run of the result.
pub(super) fn result_run(sample_time_s: f64) -> Run {
    free_run(sample_time_s, FINE_S)
}

/// The estimate of least cost.
pub(super) fn solve(problem: &Problem<'_>) -> Result<Found, Error> {
    let free = free_run(problem.sample_time, COARSE_S);
    let restart = (WINDOW_S / problem.sample_time).round() as usize;
    let windows = Run { gain: 2.0, guard: GUARD, restart, ..free };
    let yaw_rate = Problem { fitted: [true, false, false], ..problem.clone() };
    let at_first = supposed(problem);
    let mut tried =
        each(&initial_estimates(problem), |p| refine(&yaw_rate, p, &at_first, &windows, STEPS[0]));
    tried.sort_by(|a, b| a.cost.total_cmp(&b.cost));
    tried.truncate(KEPT);
    let followed = each(&tried, |r| follow(problem, &r.point, &at_first, &free));
    // One weighting for all, that of the best so far.
    let cheapest = followed.iter().min_by(|a, b| a.cost.total_cmp(&b.cost)).ok_or_else(spins)?;
    let densities = observed(problem, &cheapest.point, &free).ok_or_else(spins)?;
    let mut refined = each(&followed, |r| refine(problem, &r.point, &densities, &free, STEPS[2]));
    refined.sort_by(|a, b| a.cost.total_cmp(&b.cost));
    let best = refined.first().ok_or_else(spins)?;
    let same = refined.iter().filter(|r| r.cost < best.cost + SAME_COST).count();

    let fine = result_run(problem.sample_time);
    let mut point = best.point;
    let mut densities = densities;
    for _ in 0..2 {
        densities = observed(problem, &point, &fine).ok_or_else(spins)?;
        point = refine(problem, &point, &densities, &fine, STEPS[2]).ok_or_else(spins)?.point;
    }
    let initial_estimates = [tried.len(), refined.len(), same];
    Ok(Found { point, densities, initial_estimates })
}

/// From feedback to the free simulation; `None` where that spins.
fn follow(
    problem: &Problem<'_>,
    from: &Point,
    densities: &Densities,
    free: &Run,
) -> Option<Refined> {
    let mut point = *from;
    for gain in GAINS {
        let run = Run { gain, guard: GUARD, ..*free };
        point = refine(problem, &point, densities, &run, STEPS[1])?.point;
        if problem.cost(&point, free, densities).is_some() {
            break;
        }
    }
    refine(problem, &point, densities, free, STEPS[1])
}

fn spins() -> Error {
    Error::no_model("every single-track model spins on this drive")
}

/// `work` on each at the same time, without those that have no result; in their order.
fn each<A: Sync, B: Send>(all: &[A], work: impl Fn(&A) -> Option<B> + Sync) -> Vec<B> {
    std::thread::scope(|scope| {
        let work = &work;
        let handles: Vec<_> = all.iter().map(|a| scope.spawn(move || work(a))).collect();
        handles.into_iter().filter_map(|h| h.join().ok().flatten()).collect()
    })
}

/// The priors' means, and from there stiff and soft tyres with little and much grip, in priors'
/// deviations.
fn initial_estimates(problem: &Problem<'_>) -> Vec<Point> {
    let mean: Point = std::array::from_fn(|i| problem.priors[i].mean);
    let mut all = vec![mean];
    for stiffness in [-1.0, 1.0] {
        for friction in [-1.0, 1.0] {
            let mut p = mean;
            for (parameter, by) in [
                (Parameter::StiffnessFront, stiffness),
                (Parameter::StiffnessRear, stiffness),
                (Parameter::FrictionFront, friction),
            ] {
                let i = parameter.index();
                let [low, high] = problem.priors[i].bounds;
                p[i] = (p[i] + by * problem.priors[i].deviation).clamp(low, high);
            }
            all.push(p);
        }
    }
    all
}
