//! The search: from several initial estimates, over runs that become harder to follow.
//!
//! At the limit of grip a wrong model spins, and a free simulation of minutes has no useful derivatives
//! then. The first runs therefore start again every few seconds, with the measured yaw rate fed back and
//! the sideslip guarded, on yaw rate alone; then the whole drive is simulated with feedback, and at last
//! without. A model that spins in the free simulation where the vehicle did not has no cost.

use crate::Error;
use crate::structures::single_track::noise::{observed, supposed};
use crate::structures::single_track::parameters::Parameter;
use crate::structures::single_track::problem::{Densities, Point, Problem};
use crate::structures::single_track::simulate::SimulationRun;
use crate::structures::single_track::step::{Refined, Stop, refine};
use steerwright_formats::interruption::Interruption;

/// Initial estimates that are refined to the end, of those that are tried.
const KEPT: usize = 3;
/// On windows, on the way to the free simulation, and of the result.
const WINDOWS: Stop = Stop { steps: 10, least_gain: 1e-3, least_share: 1e-3 };
pub(super) const ON_THE_WAY: Stop = Stop { steps: 15, least_gain: 1e-3, least_share: 1e-3 };
const RESULT: Stop = Stop { steps: 40, least_gain: 1e-3, least_share: 0.0 };
/// Seconds between two initial states of the first run.
const WINDOW_S: f64 = 5.0;
/// Time between samples on windows, s.
const WINDOW_STEP_S: f64 = 0.04;
/// Feedback of yaw rate, 1/s, while the free simulation spins.
const GAINS: [f64; 4] = [1.0, 0.3, 0.1, 0.03];
/// The guard of sideslip with feedback, 1/s.
const GUARD: f64 = 5.0;
/// Feedback of yaw rate in the run whose errors are weighed at last, 1/s. What disturbs the vehicle for a
/// moment would last in the errors of a free simulation near the limit of grip, and the model would be made
/// stiffer than the vehicle to follow it.
const RESULT_GAIN: f64 = 1.0;
/// Additions to the logarithm of the friction balance, in turn, until the free simulation does not spin.
const BALANCES: [f64; 4] = [0.03, 0.06, 0.12, 0.24];
/// Time between samples of the search and of the result, s.
const COARSE_S: f64 = 0.02;
const FINE_S: f64 = 0.01;
/// Step of integration of the result, s: with twice that, the delay is wrong by half a millisecond.
const FINE_STEP_S: f64 = 0.005;
/// Costs that differ by less are of one minimum, and points by less of the priors' deviations.
const SAME_COST: f64 = 0.5;
const SAME_POINT: f64 = 0.25;

/// What was found.
#[derive(Debug, Clone)]
pub(super) struct FittedPoint {
    pub(super) point: Point,
    pub(super) densities: Densities,
    /// The run whose errors it is made of.
    pub(super) run: SimulationRun,
    /// Initial estimates that were refined to the end, those that followed the drive without a spin, and
    /// those that reached the minimum of the result.
    pub(super) initial_estimates: [usize; 3],
}

/// The free simulation in steps of about `step_s`.
pub(super) fn free_run(sample_time_s: f64, step_s: f64) -> SimulationRun {
    let stride = (step_s / sample_time_s).round().max(1.0) as usize;
    SimulationRun { stride, longest_step_s: step_s, gain: 0.0, guard: 0.0, restart: 0 }
}

/// That of the search.
pub(super) fn search_run(sample_time_s: f64) -> SimulationRun {
    free_run(sample_time_s, COARSE_S)
}

/// The run of the result.
pub(super) fn result_run(sample_time_s: f64) -> SimulationRun {
    SimulationRun { longest_step_s: FINE_STEP_S, ..free_run(sample_time_s, FINE_S) }
}

/// The estimate of least cost, from a point of another fit of the same drive where that leads to one.
pub(super) fn solve(problem: &Problem<'_>, near: Option<&Point>) -> Result<FittedPoint, Error> {
    let free = search_run(problem.sample_time);
    let at_first = supposed(problem);
    let nearby = near.filter(|point| problem.errors(point, &free).is_some());
    if let Some(refined) = nearby.and_then(|p| refine(problem, p, &at_first, &free, ON_THE_WAY))
        && let Ok(found) = to_the_end(problem, 1, &[refined])
    {
        return Ok(found);
    }
    let (tried, followed) = from_all(problem, &at_first, &free);
    to_the_end(problem, tried, &followed)
}

/// The estimate of least cost from those that follow the drive, of so many that were tried.
fn to_the_end(
    problem: &Problem<'_>,
    tried: usize,
    followed: &[Refined],
) -> Result<FittedPoint, Error> {
    let free = search_run(problem.sample_time);
    // One weighting for all, that of the best so far.
    let cheapest = followed.iter().min_by(|a, b| a.cost.total_cmp(&b.cost)).ok_or_else(spins)?;
    let densities = observed(problem, &cheapest.point, &free).ok_or_else(spins)?;
    let mut refined = each(followed, |r| refine(problem, &r.point, &densities, &free, RESULT));
    refined.sort_by(|a, b| a.cost.total_cmp(&b.cost));
    let best = refined.first().ok_or_else(spins)?;
    let same = refined.iter().filter(|r| r.cost < best.cost + SAME_COST).count();

    // With feedback, unless what is found then spins in the free simulation.
    let fine = result_run(problem.sample_time);
    let with_feedback = SimulationRun { gain: RESULT_GAIN, ..fine };
    let mut found = [with_feedback, fine].into_iter().filter_map(|run| {
        let mut found =
            FittedPoint { point: best.point, densities, run, initial_estimates: [0; 3] };
        for _ in 0..2 {
            found.densities = observed(problem, &found.point, &run)?;
            found.point = refine(problem, &found.point, &found.densities, &run, RESULT)?.point;
        }
        if problem.errors(&found.point, &fine).is_some() { Some(found) } else { None }
    });
    let initial_estimates = [tried, refined.len(), same];
    Ok(FittedPoint { initial_estimates, ..found.next().ok_or_else(spins)? })
}

/// From the priors: how many initial estimates were refined to the end, and those that followed the drive.
fn from_all(
    problem: &Problem<'_>,
    at_first: &Densities,
    free: &SimulationRun,
) -> (usize, Vec<Refined>) {
    let restart = (WINDOW_S / problem.sample_time).round() as usize;
    let step = free_run(problem.sample_time, WINDOW_STEP_S);
    let windows = SimulationRun { gain: 2.0, guard: GUARD, restart, ..step };
    let yaw_rate = Problem { fitted: [true, false, false], ..problem.clone() };
    let mut tried =
        each(&initial_estimates(problem), |p| refine(&yaw_rate, p, at_first, &windows, WINDOWS));
    tried.sort_by(|a, b| a.cost.total_cmp(&b.cost));
    // Of those in one minimum the first goes on.
    tried.dedup_by(|next, kept| is_same(problem, next, kept));
    tried.truncate(KEPT);
    let followed = each(&tried, |r| follow(problem, &r.point, at_first, free));
    (tried.len(), followed)
}

fn is_same(problem: &Problem<'_>, a: &Refined, b: &Refined) -> bool {
    let is_near =
        |&i: &usize| (a.point[i] - b.point[i]).abs() < SAME_POINT * problem.priors[i].deviation;
    let tolerance = SAME_COST.max(WINDOWS.least_share * a.cost);
    (a.cost - b.cost).abs() < tolerance && problem.free.iter().all(is_near)
}

/// From feedback to the free simulation; `None` where that spins.
fn follow(
    problem: &Problem<'_>,
    from: &Point,
    densities: &Densities,
    free: &SimulationRun,
) -> Option<Refined> {
    let mut point = *from;
    for gain in GAINS {
        let run = SimulationRun { gain, guard: GUARD, ..*free };
        point = refine(problem, &point, densities, &run, ON_THE_WAY)?.point;
        if problem.cost(&point, free, densities).is_some() {
            break;
        }
    }
    let grown = |by: f64| {
        let mut point = point;
        let balance = Parameter::FrictionBalance.index();
        point[balance] = (point[balance] + by).min(problem.priors[balance].bounds[1]);
        refine(problem, &point, densities, free, ON_THE_WAY)
    };
    std::iter::once(0.0).chain(BALANCES).find_map(grown)
}

fn spins() -> Error {
    Error::no_model("every single-track model spins on this drive")
}

/// `work` on each at the same time, without those that have no result; in their order.
fn each<A: Sync, B: Send>(all: &[A], work: impl Fn(&A) -> Option<B> + Sync) -> Vec<B> {
    let interruption = Interruption::current();
    std::thread::scope(|scope| {
        let (work, interruption) = (&work, &interruption);
        let handles: Vec<_> =
            all.iter().map(|a| scope.spawn(move || interruption.during(|| work(a)))).collect();
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
