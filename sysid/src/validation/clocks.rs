//! Clocks of channels that are apart: a yaw rate that comes before the steering that causes it, or later than a
//! vehicle's.
//!
//! A bicycle whose delay is negative then explains much more than one without; a driver who answers to gusts
//! explains a percent at most. The other way round a delay is that of the clocks, or of a vehicle, where a little more of it explains
//! much less. A vehicle's own lag is the bicycle's and its actuator's, which share with the delay what the
//! steering does not separate: a lead is stated as the least, a lag as the most of what explains the yaw rate.

use crate::bicycle::reference::{BLOCKS, Delay, Fitted, Reference};

/// The residual with the lead over that without: a driver's answers explain less.
const LEFT: f64 = 0.93;
/// … and its share of the yaw rate: a part in a thousand may be what a bicycle lacks.
const EXPLAINED: f64 = 0.003;
/// The lead holds in that many of the blocks of time.
const IN_BLOCKS: usize = BLOCKS - 2;
/// The lead is the smallest that gets so near to the best.
const NEAR: f64 = 0.05;
/// Delays are resolved to, s.
const RESOLVED_S: f64 = 0.002;

fn delayed(reference: &Reference<'_>, seconds: f64, from: &Fitted) -> Option<Fitted> {
    reference.changed(&<[f64]>::to_vec, Delay::Fixed(seconds), from)
}

/// By how much the yaw rate leads at least, s; `None` where it does not. `open_s` of a lead may come from what the
/// steering does between its samples.
pub(crate) fn yaw_rate_lead(
    reference: &Reference<'_>,
    recorded: &Fitted,
    open_s: f64,
) -> Option<f64> {
    let best = recorded.delay_s();
    if best >= -open_s {
        return None;
    }
    let without = delayed(reference, -open_s, recorded)?;
    let explained = without.left() - recorded.left();
    if !(recorded.left() < LEFT * without.left() && explained > EXPLAINED * reference.variation()) {
        return None;
    }
    let in_block = |b: usize| {
        let of = |f: &Fitted| f.left() - f.left_without(b);
        of(recorded) < of(&without)
    };
    if (0..BLOCKS).filter(|b| in_block(*b)).count() < IN_BLOCKS {
        return None;
    }
    let enough = recorded.left() + NEAR * explained;
    let (mut low, mut high) = (open_s, -best);
    while high - low > RESOLVED_S {
        let middle = 0.5 * (low + high);
        if delayed(reference, -middle, recorded)?.left() <= enough {
            high = middle
        } else {
            low = middle
        }
    }
    Some(high)
}

/// Longest lag that is looked for, s.
const LONGEST_LAG_S: f64 = 0.3;
const STEP_S: f64 = 0.01;
/// With the steering delayed by no more than the lag, what is left stays within that factor of the least …
const FLAT: f64 = 1.05;
/// … and that much later it is beyond this one, else the steering is too slow for a lag to show.
const BEYOND_S: f64 = 0.08;
const STEEP: f64 = 1.3;
/// Share of the yaw rate that may be left: with more noise, a wrong lag is lost in it.
const NOISY: f64 = 0.002;

/// By how much the steering can be delayed before it no longer explains the yaw rate, s; `None` where that is less
/// than `noticed_s`, or not certain.
pub(crate) fn yaw_rate_lag(
    reference: &Reference<'_>,
    recorded: &Fitted,
    noticed_s: f64,
) -> Option<f64> {
    let least = recorded.left();
    if least >= NOISY * reference.variation() {
        return None;
    }
    let flat = |fit: &Fitted| fit.left() <= FLAT * least;
    let mut lag = recorded.delay_s();
    let mut last = None;
    if lag < noticed_s {
        last = Some(delayed(reference, noticed_s, recorded).filter(flat)?);
        lag = noticed_s;
    }
    while lag < LONGEST_LAG_S {
        let next = delayed(reference, lag + STEP_S, last.as_ref().unwrap_or(recorded))?;
        if !flat(&next) {
            break;
        }
        (last, lag) = (Some(next), lag + STEP_S);
    }
    let beyond = delayed(reference, lag + BEYOND_S, last.as_ref().unwrap_or(recorded))?;
    (beyond.left() > STEEP * least).then_some(lag)
}
