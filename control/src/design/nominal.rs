//! The design on the nominal plant alone, and the trade-off between its robustness and its settling time.

use crate::Error;
use crate::design::objective::Objective;
use crate::design::optimiser::{EVOLVED, SHORT, TWICE};
use crate::design::search::{FoundDesign, starts};
use crate::design::target::{LEAST_RESERVE, SHORTEST_SETTLING, WITH_RESERVE};
use steerwright_formats::{Requirement, Specification, TradeOff};

/// Multiples of the plant's scale about which a search starts, and starting points about each: the settling
/// time jumps where a response just leaves its band again, and has many minima.
const SCALES: [f64; 6] = [1.0, 1.5, 2.25, 3.0, 4.0, 6.0];
const STARTS: u32 = 11;
/// The next shorter settling time that is tried, as a share of the last one, and the number of tries.
const SHORTER: f64 = 0.94;
const SHORTER_AT_MOST: usize = 12;
/// A shortest settling time beyond this multiple of the required one is out of reach of further searches.
const FAR: f64 = 1.15;

/// The modulus margins of the trade-off.
const MARGINS: [f64; 5] = [0.4, 0.5, 0.6, 0.7, 0.8];
/// Starting points of the trade-off next to the known loops, and the multiple of the scale about which.
const TRADE_OFF_STARTS: u32 = 13;
const TRADE_OFF_SCALE: f64 = 1.5;

/// Whether the fastest loop is too slow for another search to change that.
pub(crate) fn is_far(objective: &Objective, fastest: &FoundDesign) -> bool {
    let reached = fastest.reached.value(Requirement::Settling);
    objective.spec.settling_time_s.is_some_and(|required| reached > FAR * required)
}

/// The controller that keeps the requirements with some reserve; otherwise the fastest one that keeps all
/// but the settling time. `doubtful` states that a search on more plants did not find one that keeps it.
pub(crate) fn find(objective: &Objective, seed: u64, doubtful: bool) -> Result<FoundDesign, Error> {
    let begin = SCALES.map(|multiple| starts(objective, multiple, STARTS, seed)).concat();
    let fastest = || -> Result<FoundDesign, Error> {
        let found = FoundDesign::by_search(objective, &SHORTEST_SETTLING, &begin, EVOLVED)?;
        shortened(objective, found, &begin)
    };
    let fastest_first = doubtful.then(fastest).transpose()?;
    if let Some(fastest) = fastest_first.as_ref().filter(|f| is_far(objective, f)) {
        return Ok(fastest.clone());
    }
    // And about the required settling time, where that is longer.
    let required = objective.spec.settling_time_s.map_or(0.0, |t| t / objective.scale);
    let slow = SCALES.iter().all(|multiple| required > *multiple);
    let slower = if slow { starts(objective, required, STARTS, seed) } else { Vec::new() };
    let own = [begin.clone(), slower].concat();
    let found = FoundDesign::by_search(objective, &WITH_RESERVE, &own, EVOLVED)?;
    if found.met {
        return Ok(found);
    }
    // Not from the first one: the fastest loop must not depend on the required settling time.
    let fastest = match fastest_first {
        Some(fastest) => fastest,
        None => fastest()?,
    };
    if fastest.met || is_far(objective, &fastest) {
        return Ok(better(objective, fastest, found));
    }
    // Many minima lie near the requirements: one that just keeps them need not be among the fastest.
    let near = [own, vec![found.variables.clone(), fastest.variables.clone()]].concat();
    let barely = FoundDesign::by_search(objective, &LEAST_RESERVE, &near, EVOLVED)?;
    if barely.met {
        return Ok(barely);
    }
    Ok(better(objective, fastest, found))
}

/// The fastest loop that searches for shorter and shorter settling times find: a search for a settling time
/// that can be kept finds loops that one for the shortest misses, since its cost does not jump with a tiny
/// overshoot. The settling times depend on the loops found and not on the specification, so that every
/// specification that is out of reach ends at the same loop.
fn shortened(
    objective: &Objective,
    mut best: FoundDesign,
    begin: &[Vec<f64>],
) -> Result<FoundDesign, Error> {
    for _ in 0..SHORTER_AT_MOST {
        if best.met || best.missed(objective) > 0.0 {
            break;
        }
        let settling_time_s = SHORTER * best.reached.value(Requirement::Settling);
        let shorter = objective
            .with(Specification { settling_time_s: Some(settling_time_s), ..objective.spec });
        let from = [std::slice::from_ref(&best.variables), begin].concat();
        let found = FoundDesign::by_search(&shorter, &LEAST_RESERVE, &from, SHORT)?;
        if !found.met {
            break;
        }
        best = FoundDesign::new(objective, vec![found.variables]);
    }
    Ok(best)
}

/// The fastest loop, unless it misses clearly more than the settling time.
fn better(objective: &Objective, fastest: FoundDesign, found: FoundDesign) -> FoundDesign {
    const HARDLY: f64 = 0.02;
    let misses_more = fastest.missed(objective) > found.missed(objective) + HARDLY;
    if misses_more && !fastest.met { found } else { fastest }
}

/// The shortest settling time on the nominal plant at each modulus margin, with the other requirements kept.
pub(crate) fn trade_off(
    objective: &Objective,
    found: &FoundDesign,
    seed: u64,
) -> Result<Vec<TradeOff>, Error> {
    let mut rows = Vec::new();
    let mut from = found.variables.clone();
    // From the largest margin down: a loop that keeps a margin keeps a smaller one.
    for modulus_margin in MARGINS.into_iter().rev() {
        let spec = Specification {
            modulus_margin: Some(modulus_margin),
            settling_time_s: None,
            ..objective.spec
        };
        let easier = objective.with(spec);
        let mut begin = starts(&easier, TRADE_OFF_SCALE, TRADE_OFF_STARTS, seed);
        begin.extend([from.clone(), found.variables.clone()]);
        let fastest = FoundDesign::by_search(&easier, &SHORTEST_SETTLING, &begin, TWICE)?;
        if fastest.met {
            from.clone_from(&fastest.variables);
        }
        // The loop of the design is one of them.
        let known =
            if found.reached.shortfalls(&spec).is_empty() { Some(&found.reached) } else { None };
        let reached = fastest.met.then_some(&fastest.reached).into_iter().chain(known);
        let settling_time_s = reached.filter_map(|r| r.step.settling_time_s).min_by(f64::total_cmp);
        rows.push(TradeOff { modulus_margin, settling_time_s });
    }
    // A search may miss a minimum: a faster loop with a larger margin keeps the smaller one, too.
    let mut best = f64::INFINITY;
    for row in &mut rows {
        best = best.min(row.settling_time_s.unwrap_or(f64::INFINITY));
        row.settling_time_s = Some(best).filter(|t| t.is_finite());
    }
    rows.reverse();
    Ok(rows)
}
