//! Clocks of channels that are apart: a yaw rate that comes before the steering that causes it, or later than a
//! vehicle's.
//!
//! A bicycle whose delay is negative then explains much more than one without; a driver who answers to gusts
//! explains a percent at most. The other way round its delay is larger than that of sensors and buses, which
//! explains less. A vehicle's own lag is that of the bicycle's tyres and of its actuator; since a lag hides some of a
//! lead, the least lead is stated that explains the yaw rate.

use crate::structures::bicycle::reference::{BLOCKS, Delay, Fitted, Reference};

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

/// The yaw rate of a vehicle follows its steering angle without delay; sensors and buses add 10 to 40 ms.
const SENSORS_S: f64 = 0.04;
/// A delay from which clocks are said to be apart, s.
pub(crate) const LARGEST_DELAY_S: f64 = 0.07;

/// By how much the yaw rate is late, s; `None` where that is no more than a vehicle's, or explains no more than the
/// delay of sensors does. `open_s` of it may come from what the steering does between its samples.
pub(crate) fn yaw_rate_lag(
    reference: &Reference<'_>,
    recorded: &Fitted,
    open_s: f64,
) -> Option<f64> {
    let delay = recorded.delay_s();
    if delay <= LARGEST_DELAY_S.max(SENSORS_S + open_s) {
        return None;
    }
    let with_sensors = delayed(reference, SENSORS_S, recorded)?;
    if recorded.left() < LEFT * with_sensors.left() { Some(delay) } else { None }
}
