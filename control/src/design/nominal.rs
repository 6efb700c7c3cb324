//! The design on the nominal plant alone, which a robust one begins from.

use crate::Error;
use crate::closed_loop::simulate::Simulator;
use crate::design::aim::{BARELY, HOPELESS_WEIGHT, QUICKEST, WITH_RESERVE};
use crate::design::objective::Objective;
use crate::design::optimise::{EVOLVED, SHORT};
use crate::design::search::{EXACT_DIGITS, READABLE_DIGITS, rounded, search, starts};
use crate::requirement::{Reached, Requirement};
use formats::Specification;
use vehicle_models::PidParameters;

/// Multiples of the plant's scale about which a loop is looked for, and starts about each: the settling
/// time jumps where a response just leaves its band again, and has many minima.
const SCALES: [f64; 6] = [1.0, 1.5, 2.25, 3.0, 4.0, 6.0];
const STARTS: u32 = 11;
/// What is asked for next of the quickest loop, as a share of its settling time, and how often.
const SHORTER: f64 = 0.94;
const SHORTER_AT_MOST: usize = 12;
/// A quickest loop slower than the time asked for by more is nowhere near it.
const FAR: f64 = 1.15;

/// A controller, its decision variables, and what it reaches on the nominal plant.
#[derive(Debug, Clone)]
pub(crate) struct Found {
    pub(crate) pid: PidParameters,
    pub(crate) variables: Vec<f64>,
    pub(crate) reached: Reached,
    pub(crate) met: bool,
    /// Other loops that were found on the way, to begin again from.
    pub(crate) others: Vec<Vec<f64>>,
}

impl Found {
    /// Rounded to what a person can read, unless that breaks what was just kept.
    pub(crate) fn of(objective: &Objective, mut points: Vec<Vec<f64>>) -> Self {
        // A search never comes back without a point.
        let variables = if points.is_empty() { Vec::new() } else { points.remove(0) };
        let mut simulator = Simulator::default();
        let mut finish = |digits| {
            let pid = rounded(&objective.controller(&variables).0, digits);
            let reached = objective.whole(&mut simulator, &pid);
            (pid, reached, reached.shortfalls(&objective.spec).len())
        };
        let mut best = finish(READABLE_DIGITS);
        if best.2 > 0 {
            let exact = finish(EXACT_DIGITS);
            if exact.2 < best.2 {
                best = exact;
            }
        }
        let (pid, reached, short) = best;
        Self { pid, variables, reached, met: short == 0, others: points }
    }

    /// What a requirement is missed by, summed over those asked for, the settling time apart.
    pub(super) fn missed(&self, objective: &Objective) -> f64 {
        // What is out of reach must not take the rest with it.
        let capped = |v: f64| v.min(1.0) + HOPELESS_WEIGHT * v.max(1.0).ln();
        let missed =
            |(r, required): (Requirement, f64)| capped(r.missed(required, self.reached.value(r)));
        objective
            .required()
            .into_iter()
            .filter(|(r, _)| *r != Requirement::Settling)
            .map(missed)
            .sum()
    }
}

/// Whether the quickest loop is too slow for another search to change that.
pub(crate) fn is_far(objective: &Objective, quickest: &Found) -> bool {
    let reached = quickest.reached.value(Requirement::Settling);
    objective.spec.settling_time_s.is_some_and(|asked| reached > FAR * asked)
}

/// With some reserve; or else the quickest loop that keeps everything but the settling time.
/// `doubtful` says that others have not been found to keep it.
pub(crate) fn find(objective: &Objective, seed: u64, doubtful: bool) -> Result<Found, Error> {
    let begin = SCALES.map(|multiple| starts(objective, multiple, STARTS, seed)).concat();
    let quickest = || -> Result<Found, Error> {
        let found = Found::of(objective, search(objective, &QUICKEST, &begin, EVOLVED)?);
        shortened(objective, found, &begin)
    };
    let quickest_first = doubtful.then(quickest).transpose()?;
    if let Some(quickest) = quickest_first.as_ref().filter(|q| is_far(objective, q)) {
        return Ok(quickest.clone());
    }
    // And about the time asked for, where that is longer.
    let asked = objective.spec.settling_time_s.map_or(0.0, |t| t / objective.scale);
    let slow = SCALES.iter().all(|multiple| asked > *multiple);
    let slower = if slow { starts(objective, asked, STARTS, seed) } else { Vec::new() };
    let own = [begin.clone(), slower].concat();
    let found = Found::of(objective, search(objective, &WITH_RESERVE, &own, EVOLVED)?);
    if found.met {
        return Ok(found);
    }
    // The second search forgets the first one: what is too soon is missed by the same loop, however
    // much too soon it was asked for.
    let quickest = match quickest_first {
        Some(quickest) => quickest,
        None => quickest()?,
    };
    if quickest.met || is_far(objective, &quickest) {
        return Ok(better(objective, quickest, found));
    }
    // Many minima lie near the requirements: one that just keeps them may be none of the quickest.
    let near = [own, vec![found.variables.clone(), quickest.variables.clone()]].concat();
    let barely = Found::of(objective, search(objective, &BARELY, &near, EVOLVED)?);
    if barely.met {
        return Ok(barely);
    }
    Ok(better(objective, quickest, found))
}

/// The quickest loop that asking for less and less time finds: a search for a settling time that can be kept
/// finds what one for the shortest misses, since its cost does not jump with the least of overshoots. The
/// times asked for depend on the loops found and not on the specification's, so whatever is too soon ends
/// at the same loop.
fn shortened(objective: &Objective, mut best: Found, begin: &[Vec<f64>]) -> Result<Found, Error> {
    for _ in 0..SHORTER_AT_MOST {
        if best.met || best.missed(objective) > 0.0 {
            break;
        }
        let settling_time_s = SHORTER * best.reached.value(Requirement::Settling);
        let asked = objective
            .with(Specification { settling_time_s: Some(settling_time_s), ..objective.spec });
        let from = [std::slice::from_ref(&best.variables), begin].concat();
        let found = Found::of(&asked, search(&asked, &BARELY, &from, SHORT)?);
        if !found.met {
            break;
        }
        best = Found::of(objective, vec![found.variables]);
    }
    Ok(best)
}

/// The quickest loop, unless it gives up clearly more than the settling time.
fn better(objective: &Objective, quickest: Found, found: Found) -> Found {
    const HARDLY: f64 = 0.02;
    let gives_up = quickest.missed(objective) > found.missed(objective) + HARDLY;
    if gives_up && !quickest.met { found } else { quickest }
}
