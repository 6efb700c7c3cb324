//! What robustness costs: how soon the loop can settle at each modulus margin.

use crate::Error;
use crate::design::aim::QUICKEST;
use crate::design::nominal::Found;
use crate::design::objective::Objective;
use crate::design::optimise::TWICE;
use crate::design::search::{search, starts};
use formats::{Specification, TradeOff};

/// The modulus margins looked at.
const MARGINS: [f64; 5] = [0.4, 0.5, 0.6, 0.7, 0.8];

/// Starts beside the loops that are known, and the multiple of the plant's scale about which.
const STARTS: u32 = 13;
const SCALE: f64 = 1.5;

/// The quickest loop on the nominal plant at each modulus margin, the other requirements kept.
pub(crate) fn trade_off(
    objective: &Objective,
    found: &Found,
    seed: u64,
) -> Result<Vec<TradeOff>, Error> {
    let mut rows = Vec::new();
    let mut from = found.variables.clone();
    // From the most robust one down: what is kept at a margin is kept at a smaller one.
    for modulus_margin in MARGINS.into_iter().rev() {
        let spec = Specification {
            modulus_margin: Some(modulus_margin),
            settling_time_s: None,
            ..objective.spec
        };
        let easier = objective.with(spec);
        let mut begin = starts(&easier, SCALE, STARTS, seed);
        begin.extend([from.clone(), found.variables.clone()]);
        let quickest = Found::of(&easier, search(&easier, &QUICKEST, &begin, TWICE)?);
        if quickest.met {
            from.clone_from(&quickest.variables);
        }
        // The loop that was found is one of them.
        let known = found.reached.shortfalls(&spec).is_empty().then_some(&found.reached);
        let reached = quickest.met.then_some(&quickest.reached).into_iter().chain(known);
        let settling_time_s = reached.filter_map(|r| r.step.settling_time_s).min_by(f64::total_cmp);
        rows.push(TradeOff { modulus_margin, settling_time_s });
    }
    // A search may stop short: a loop that is more robust and quicker is a loop for less, too.
    let mut best = f64::INFINITY;
    for row in &mut rows {
        best = best.min(row.settling_time_s.unwrap_or(f64::INFINITY));
        row.settling_time_s = Some(best).filter(|t| t.is_finite());
    }
    rows.reverse();
    Ok(rows)
}
