//! A yaw rate that comes before the steering that causes it: clocks of channels that are apart.
//! Where a later steering explains much more, the clocks are wrong; a driver who answers to gusts
//! explains a percent at most. The other way round, an earlier steering explains as much as long as
//! the yaw rate is late by more.

use crate::validation::regression::{BLOCKS, Pair, Sums};

/// Leads tried, s.
const LONGEST_S: f64 = 0.3;
const STEP_S: f64 = 0.02;
/// Pole of the functions, rad/s, as in [`crate::validation::play`].
const POLE_RADPS: f64 = 8.0;
/// The residual with the lead over that without: a driver's answers explain less.
const LEFT: f64 = 0.93;
/// … and its share of the yaw rate: a part in a thousand may be what the functions lack.
const EXPLAINED: f64 = 0.003;
/// The lead holds in that many of the blocks of time.
const IN_BLOCKS: usize = BLOCKS - 2;
/// The lead is the smallest that gets so near to the best.
const NEAR: f64 = 0.05;

/// By how much the yaw rate leads, s; `None` where it does not.
pub(crate) fn yaw_rate_lead(segments: &[Pair<'_>], sample_time_s: f64) -> Option<f64> {
    let stride = (STEP_S / sample_time_s).round().max(1.0) as usize;
    let most = (LONGEST_S / sample_time_s).floor() as usize;
    let leads: Vec<usize> = (0..=most).step_by(stride).collect();
    let all: Vec<Sums> = leads
        .iter()
        .map(|&lead| {
            let ahead = |u: &[f64]| -> Vec<f64> {
                let last = u.last().copied().unwrap_or(0.0);
                u.iter()
                    .skip(lead)
                    .copied()
                    .chain(std::iter::repeat_n(last, lead.min(u.len())))
                    .collect()
            };
            Sums::new(segments, sample_time_s, POLE_RADPS, most, &ahead)
        })
        .collect();
    let left: Option<Vec<f64>> = all.iter().map(|s| s.left(None)).collect();
    let left = left?;
    let best = (0..left.len()).min_by(|a, b| left[*a].total_cmp(&left[*b]))?;
    let explained = left[0] - left[best];
    if !(left[best] < LEFT * left[0] && explained > EXPLAINED * all[0].variation()) {
        return None;
    }
    let holds = |b: &usize| {
        let of = |i: usize| all[i].left(Some(*b)).zip(all[i].left(None)).map(|(w, a)| a - w);
        of(best).zip(of(0)).is_some_and(|(with, without)| with < without)
    };
    if (0..BLOCKS).filter(holds).count() < IN_BLOCKS {
        return None;
    }
    let near = left[best] + NEAR * (left[0] - left[best]);
    let first = (0..=best).find(|&i| left[i] <= near)?;
    Some(leads[first] as f64 * sample_time_s)
}

/// Lags tried, s.
const LONGEST_LAG_S: f64 = 0.36;
/// With the steering delayed by no more than the lag, what is left stays within that factor of the least …
const FLAT: f64 = 1.05;
/// … and that much later it is beyond this one, else the steering is too slow for a lead to show.
const BEYOND_S: f64 = 0.08;
const STEEP: f64 = 1.3;
/// Share of the yaw rate that may be left: with more noise, a wrong lag is lost in it.
const NOISY: f64 = 0.002;

/// By how much the steering can be delayed before it no longer explains the yaw rate, s.
pub(crate) fn yaw_rate_lag(segments: &[Pair<'_>], sample_time_s: f64) -> Option<f64> {
    let stride = (STEP_S / sample_time_s).round().max(1.0) as usize;
    let most = (LONGEST_LAG_S / sample_time_s).floor() as usize;
    let lags: Vec<usize> = (0..=most).step_by(stride).collect();
    let mut left = Vec::new();
    let mut variation = 0.0;
    for &lag in &lags {
        let behind = |u: &[f64]| -> Vec<f64> {
            let first = u.first().copied().unwrap_or(0.0);
            std::iter::repeat_n(first, lag).chain(u.iter().copied()).take(u.len()).collect()
        };
        let sums = Sums::new(segments, sample_time_s, POLE_RADPS, 0, &behind);
        variation = sums.variation();
        left.push(sums.left(None)?);
    }
    let least = left.iter().copied().fold(f64::INFINITY, f64::min);
    let last = (0..left.len()).rev().find(|&i| left[i] <= FLAT * least)?;
    let beyond = last + (BEYOND_S / (stride as f64 * sample_time_s)).ceil() as usize;
    let steep = left.get(beyond).is_some_and(|l| *l > STEEP * least);
    (steep && least < NOISY * variation).then(|| lags[last] as f64 * sample_time_s)
}
