//! Spikes of a channel, found in rows that may come in chunks: every row is seen with its neighbours.

use crate::series::Series;
use crate::signal::median_period;
use std::ops::Range;
use std::rc::Rc;

/// A second difference beyond that many standard deviations (from the median) is no noise …
const SIGMAS: f64 = 8.0;
/// … and beyond that many times the 95th percentile, so that a command of short pulses has none; a spike
/// has three large second differences, so that they may be one row in sixty.
const PERCENTILE_FACTOR: f64 = 2.0;
/// Rows further apart than that many median periods have a gap between them.
const GAP: f64 = 1.5;
/// Longest spike in samples, and in s where it has several: longer ones may be real.
const LONGEST: usize = 3;
const LONGEST_S: f64 = 0.035;
/// The samples on both sides of a spike agree to that share of its height.
const BACK: f64 = 0.3;
/// Second differences this near a spike are smaller by that factor; about a sharp peak they are not.
const NEAR: usize = 3;
const PEAK: f64 = 4.0;

/// Rows on either side of the first row of a spike that decide upon it.
pub(crate) const NEIGHBOURS: usize = LONGEST + NEAR + 2;
/// Fewest second differences that show what is usual.
const ENOUGH: usize = 50;

/// How far a channel usually jumps.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Jumps {
    period: f64,
    least: f64,
    /// Second differences that this was read from.
    pub(crate) count: usize,
}

impl Jumps {
    /// `None` of too few rows.
    pub(crate) fn from_samples(time: &[f64], x: &[f64]) -> Option<Self> {
        let period = median_period(time);
        let mut sizes: Vec<f64> = (1..x.len().saturating_sub(1))
            .filter(|&i| joined(time, i - 1, i + 1, period))
            .map(|i| (x[i] - 0.5 * (x[i - 1] + x[i + 1])).abs())
            .collect();
        if sizes.len() < ENOUGH {
            return None;
        }
        let mut quantile = |share: f64| {
            let k = (share * (sizes.len() - 1) as f64) as usize;
            *sizes.select_nth_unstable_by(k, f64::total_cmp).1
        };
        let (median, high) = (quantile(0.5), quantile(0.95));
        let size = x.iter().fold(0.0_f64, |m, x| m.max(x.abs()));
        let least = (SIGMAS * 1.4826 * median).max(PERCENTILE_FACTOR * high).max(1e-6 * size);
        Some(Self { period, least, count: sizes.len() })
    }

    /// The samples of each spike or dropout.
    pub(crate) fn spikes(&self, time: &[f64], x: &[f64]) -> Vec<Range<usize>> {
        let Self { period, least, .. } = *self;
        let mut found = Vec::new();
        let mut i = 1;
        while i + 1 < x.len() {
            let wide = |w: usize| w == 1 || w as f64 * period <= LONGEST_S;
            let width = (1..=LONGEST).find(|&w| {
                wide(w)
                    && i + w < x.len()
                    && joined(time, i - 1, i + w, period)
                    && is_spike(x, i, w, least)
            });
            match width {
                Some(w) => {
                    found.push(i..i + w);
                    i += w + 1;
                }
                None => i += 1,
            }
        }
        found
    }
}

/// Samples on both sides of a gap are no neighbours: the signal moves on meanwhile.
fn joined(time: &[f64], from: usize, to: usize, period: f64) -> bool {
    (from..to).all(|k| time[k + 1] - time[k] <= GAP * period)
}

/// Whether the `w` samples from `i` on jump away and back by more than `least`, and are as far off the lines through
/// the two samples on either side: a corner is on one of them.
fn is_spike(x: &[f64], i: usize, w: usize, least: f64) -> bool {
    let Some(after) = x.get(i + w) else { return false };
    let (away, back) = (x[i] - x[i - 1], after - x[i + w - 1]);
    let height = away.abs().min(back.abs());
    let before = if i >= 2 { x[i - 1] - x[i - 2] } else { 0.0 };
    let later = x.get(i + w + 1).map_or(0.0, |next| next - after);
    let is_off = |jump: f64, step: f64| (jump - step) * jump.signum() > least;
    let is_pulse =
        height > least && away * back < 0.0 && is_off(away, before) && is_off(back, later);
    if !(is_pulse && (after - x[i - 1]).abs() <= BACK * height) {
        return false;
    }
    let around = (i.saturating_sub(NEAR)..i - 1).chain(i + w + 1..i + w + NEAR);
    let near = around
        .filter(|&k| k >= 1 && k + 1 < x.len())
        .map(|k| (x[k] - 0.5 * (x[k - 1] + x[k + 1])).abs())
        .filter(|b| b.is_finite())
        .fold(0.0, f64::max);
    height > PEAK * near
}

#[derive(Default)]
pub(crate) struct SpikeFilter {
    /// The last rows seen: those already passed on, then those that wait for their neighbours.
    held: Vec<(f64, f64, u64)>,
    /// How many of them have been passed on.
    passed: usize,
    /// Those that are samples of spikes.
    left_out: Vec<usize>,
    /// What the channel usually does.
    jumps: Option<Jumps>,
}

impl SpikeFilter {
    /// Replaces the rows that follow by those that are decided upon, and adds the spikes' instants. The
    /// last rows wait for those after them, unless these `are_last`.
    pub(crate) fn take(&mut self, series: &mut Series, are_last: bool) {
        if !self.held.is_empty() {
            let held = std::mem::take(&mut self.held);
            Rc::make_mut(&mut series.time).splice(0..0, held.iter().map(|row| row.0));
            series.value.splice(0..0, held.iter().map(|row| row.1));
            Rc::make_mut(&mut series.line).splice(0..0, held.iter().map(|row| row.2));
        }
        let (rows, passed) = (series.value.len(), self.passed);
        let end = if are_last { rows } else { rows.saturating_sub(NEIGHBOURS).max(passed) };
        // The last rows of a file may be too few to determine what is usual.
        if let Some(jumps) = Jumps::from_samples(&series.time, &series.value)
            && self.jumps.is_none_or(|earlier| 2 * jumps.count >= earlier.count)
        {
            self.jumps = Some(jumps);
        }
        let mut left_out = std::mem::take(&mut self.left_out);
        if let Some(jumps) = self.jumps {
            let found = jumps.spikes(&series.time, &series.value).into_iter();
            for spike in found.filter(|spike| (passed..end).contains(&spike.start)) {
                series.spikes.extend(spike.clone().map(|i| series.time[i]));
                left_out.extend(spike);
            }
        }
        let from = end.saturating_sub(NEIGHBOURS);
        if !are_last {
            self.held =
                (from..rows).map(|i| (series.time[i], series.value[i], series.line[i])).collect();
            self.passed = end - from;
            self.left_out = left_out.iter().filter_map(|i| i.checked_sub(from)).collect();
        }
        let left_out: std::collections::HashSet<usize> = left_out.into_iter().collect();
        series.retain(|i| (passed..end).contains(&i) && !left_out.contains(&i));
    }
}
