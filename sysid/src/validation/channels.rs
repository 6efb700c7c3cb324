//! Faults of single channels, found on their own clocks before anything is resampled.
//!
//! A *spike* (or dropout) is a run of one to three samples that jumps away and back. Both jumps are
//! large against what the channel usually does from sample to sample (second differences, by their
//! median and upper percentile, as in Hampel's identifier: F. R. Hampel, *The influence curve and its
//! role in robust estimation*, JASA 69, 1974). A held command that steps does not jump back; where it
//! steps often, the upper percentile is the size of its steps.
//!
//! A channel is *frozen* where it repeats one value for longer than it ever should while the vehicle
//! moves and is steered.

use crate::log::{Series, median_period};
use std::ops::Range;

/// A second difference beyond that many standard deviations (from the median) is no noise: in a
/// million samples of normal noise none is.
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
/// Second differences this near a spike are much smaller; those about a sharp peak of a smooth signal
/// are not.
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
    pub(crate) fn of(time: &[f64], x: &[f64]) -> Option<Self> {
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

/// Whether the `w` samples from `i` on jump away and back by more than `least`.
fn is_spike(x: &[f64], i: usize, w: usize, least: f64) -> bool {
    let Some(after) = x.get(i + w) else { return false };
    let (away, back) = (x[i] - x[i - 1], after - x[i + w - 1]);
    let height = away.abs().min(back.abs());
    if !(height > least && away * back < 0.0 && (after - x[i - 1]).abs() <= BACK * height) {
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

/// The step that (almost) all differences of successive values are multiples of, where there is one.
pub(crate) fn resolution(x: &[f64]) -> Option<f64> {
    /// Changes that are looked at, however long a vehicle rests before: more change nothing.
    const CHANGES: usize = 20_000;
    let size = x.iter().fold(0.0_f64, |m, x| m.max(x.abs()));
    let mut steps: Vec<f64> = x
        .windows(2)
        .map(|w| (w[1] - w[0]).abs())
        .filter(|d| d.is_finite() && *d > 1e-9 * size)
        .take(CHANGES)
        .collect();
    if steps.len() < 10 {
        return None;
    }
    // A few interpolated values in between do not hide it.
    let k = steps.len() / 200;
    let least = *steps.select_nth_unstable_by(k, f64::total_cmp).1;
    let multiples = steps.iter().filter(|d| {
        let turns = *d / least;
        (turns - turns.round()).abs() < (0.02 * turns.max(1.0).sqrt()).min(0.1)
    });
    // Of differences without a step, at most a fifth are so near to a multiple.
    (multiples.count() as f64 > 0.95 * steps.len() as f64).then_some(least)
}

/// A channel on its own clock.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Sampled<'a> {
    /// Instants, s.
    pub(crate) time: &'a [f64],
    /// Values, SI.
    pub(crate) value: &'a [f64],
}

impl<'a> Sampled<'a> {
    pub(crate) fn of(series: &'a Series) -> Self {
        Self { time: &series.time, value: &series.value }
    }

    /// Values from one instant to another.
    fn within(&self, from: f64, to: f64) -> &'a [f64] {
        let first = self.time.partition_point(|t| *t < from);
        let end = self.time.partition_point(|t| *t <= to);
        &self.value[first.min(end)..end]
    }
}

/// A gyro that repeats one value for that long while the vehicle is steered is frozen, s.
const LEAST_FROZEN_S: f64 = 0.5;
/// … and that many times longer than 95 % of its runs of equal values, which a slow sensor in fast rows
/// has.
const FROZEN_FACTOR: f64 = 5.0;
/// The steering within the run spans at least its standard deviation.
const STEERED: f64 = 1.0;
/// Slower on average, a vehicle stands, m/s: steered, it need not yaw.
pub(crate) const MOVING_MPS: f64 = 0.5;
/// The yaw rate's standard deviation over its smallest change, below which repeated values say nothing.
const FINE_ENOUGH: f64 = 3.0;

/// Runs of equal values whose lengths show what is usual: more change nothing.
const RUNS: usize = 100_000;

/// Finds where a yaw rate is frozen, in rows that may come in chunks.
#[derive(Debug, Default)]
pub(crate) struct Freezes {
    /// Lengths of its first runs of equal values, s.
    lengths: Vec<f64>,
    yaw_rate: Spread,
    steering: Spread,
    /// The value, bit for bit, and the start of a frozen run that may go on.
    goes_on: Option<(u64, f64)>,
}

/// The rows of a drive that a frozen run is looked for in.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Moving<'a> {
    pub(crate) yaw_rate: Sampled<'a>,
    pub(crate) steering: Sampled<'a>,
    pub(crate) speed: Option<Sampled<'a>>,
    /// The step of the yaw rate's values, where it has one.
    pub(crate) resolution: Option<f64>,
}

impl Freezes {
    /// Notes how far the signals move in rows that follow.
    pub(crate) fn note(&mut self, yaw_rate: &[f64], steering: &[f64]) {
        yaw_rate.iter().for_each(|x| self.yaw_rate.note(*x));
        steering.iter().for_each(|x| self.steering.note(*x));
    }

    /// How many of the rows are decided upon, and the runs among them, from the first to the last instant,
    /// in which the yaw rate is frozen; one that goes on has the start that it had.
    ///
    /// A run may go on in the rows that follow, so that it waits for them, but no more than `most` rows do.
    /// Of a run that is cut there the rest is one of its own, unless it is frozen.
    pub(crate) fn find(&mut self, rows: Moving<'_>, most: Option<usize>) -> (usize, Vec<[f64; 2]>) {
        let Moving { yaw_rate: Sampled { time, value: x }, steering, speed, resolution } = rows;
        let mut found = Vec::new();
        let mut from = 0;
        if let Some((bits, start)) = self.goes_on {
            from = x.iter().take_while(|x| x.to_bits() == bits).count();
            found.extend(from.checked_sub(1).map(|last| [start, time[last]]));
            self.goes_on = self.goes_on.filter(|_| from == x.len());
        }
        let mut runs: Vec<(usize, usize)> = Vec::new();
        for i in from..x.len() {
            match runs.last_mut() {
                // Bit for bit: a sensor that lives has noise.
                Some((_, last)) if x[*last].to_bits() == x[i].to_bits() => *last = i,
                _ => runs.push((i, i)),
            }
        }
        let lasting = |&(a, b): &(usize, usize)| time[b] - time[a];
        let closed = match most {
            None => runs.len(),
            Some(_) => {
                let ends = std::iter::once(steering).chain(speed).map(|c| c.time.last().copied());
                let known =
                    ends.map(|t| t.unwrap_or(f64::NEG_INFINITY)).fold(f64::INFINITY, f64::min);
                let open = runs.len().saturating_sub(1);
                runs[..open].partition_point(|(_, last)| time[*last] <= known)
            }
        };
        let room = RUNS - self.lengths.len();
        self.lengths.extend(runs[..closed].iter().map(lasting).take(room));
        let waiting = runs.get(closed).map_or(0, |(first, _)| x.len() - first);
        let is_cut = most.is_some_and(|most| waiting >= most);
        let decided = if is_cut { runs.len() } else { closed };
        let next = runs.get(decided).map_or(x.len(), |(first, _)| *first);
        let least = LEAST_FROZEN_S.max(FROZEN_FACTOR * self.usual_length());
        if resolution.is_some_and(|step| self.yaw_rate.deviation() < FINE_ENOUGH * step) {
            return (next, found);
        }
        let usual_steering = self.steering.deviation();
        let span = |x: &[f64]| {
            let (low, high) = x
                .iter()
                .fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), v| (a.min(*v), b.max(*v)));
            high - low
        };
        let is_frozen = |run: &(usize, usize)| {
            let (from, to) = (time[run.0], time[run.1]);
            lasting(run) > least
                && span(steering.within(from, to)) > STEERED * usual_steering
                && speed.is_none_or(|v| crate::signal::mean(v.within(from, to)) > MOVING_MPS)
        };
        for run in runs[..decided].iter().filter(|run| is_frozen(run)) {
            found.push([time[run.0], time[run.1]]);
            if is_cut && run.1 + 1 == x.len() {
                self.goes_on = Some((x[run.1].to_bits(), time[run.0]));
            }
        }
        (next, found)
    }

    /// Whether a frozen run may go on in the rows that follow.
    pub(crate) fn goes_on(&self) -> bool {
        self.goes_on.is_some()
    }

    /// What 95 % of the runs do not exceed, s. A lone run shows nothing.
    fn usual_length(&self) -> f64 {
        let mut lengths = self.lengths.clone();
        match lengths.len() {
            0 | 1 => 0.0,
            n => {
                let k = (0.95 * (n - 1) as f64) as usize;
                *lengths.select_nth_unstable_by(k, f64::total_cmp).1
            }
        }
    }
}

/// Mean and sum of squared deviations from it, value after value (B. P. Welford, Technometrics 4, 1962).
#[derive(Debug, Default)]
struct Spread {
    count: f64,
    mean: f64,
    squares: f64,
}

impl Spread {
    fn note(&mut self, x: f64) {
        self.count += 1.0;
        let off = x - self.mean;
        self.mean += off / self.count;
        self.squares += off * (x - self.mean);
    }

    fn deviation(&self) -> f64 {
        (self.squares / self.count.max(1.0)).sqrt()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn noise(seed: &mut u64) -> f64 {
        let mut uniform = || {
            *seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
            (*seed >> 33) as f64 / f64::from(1_u32 << 31)
        };
        (0..12).map(|_| uniform()).sum::<f64>() - 6.0
    }

    fn spikes(time: &[f64], x: &[f64]) -> Vec<usize> {
        Jumps::of(time, x).unwrap().spikes(time, x).into_iter().flatten().collect()
    }

    fn frozen(
        yaw_rate: Sampled<'_>,
        steering: Sampled<'_>,
        speed: Option<Sampled<'_>>,
    ) -> Vec<[f64; 2]> {
        let mut freezes = Freezes::default();
        freezes.note(yaw_rate.value, steering.value);
        let resolution = resolution(yaw_rate.value);
        freezes.find(Moving { yaw_rate, steering, speed, resolution }, None).1
    }

    fn clock(n: usize, period: f64) -> Vec<f64> {
        (0..n).map(|k| k as f64 * period).collect()
    }

    #[test]
    fn spikes_and_dropouts_are_found_and_nothing_else() {
        let mut seed = 3;
        let time = clock(6000, 0.01);
        let smooth: Vec<f64> =
            time.iter().map(|t| 0.2 * (2.0 * t).sin() + 0.002 * noise(&mut seed)).collect();
        assert!(spikes(&time, &smooth).is_empty());
        let mut spoiled = smooth.clone();
        spoiled[700] += 0.15;
        spoiled[1234] = 0.0;
        spoiled[2500..2502].fill(-1.0);
        assert_eq!(spikes(&time, &spoiled), [700, 1234, 2500, 2501]);
    }

    #[test]
    fn steps_pulses_and_sharp_turns_stay() {
        let mut seed = 5;
        let time = clock(6000, 0.01);
        // A command with a new level every 0.15 s, a binary sequence, and a step every 10 s.
        let mut level = 0.0;
        let held: Vec<f64> = (0..6000)
            .map(|k| {
                if k % 15 == 0 {
                    level = noise(&mut seed);
                }
                level
            })
            .collect();
        let binary: Vec<f64> = held.iter().map(|x| x.signum()).collect();
        let rare: Vec<f64> = (0..6000).map(|k| f64::from(u8::from(k / 1000 % 2 == 1))).collect();
        // Each sample another binary level, and a swerve of a second in a straight minute at 10 Hz.
        let fast: Vec<f64> = (0..6000).map(|_| noise(&mut seed).signum()).collect();
        for x in [&held, &binary, &rare, &fast] {
            assert!(spikes(&time, x).is_empty(), "{:?}", spikes(&time, x));
        }
        let slow = clock(600, 0.1);
        let swerve: Vec<f64> = slow
            .iter()
            .map(|t| {
                let inside = (30.0..31.4).contains(t);
                let turn = 0.2 * (std::f64::consts::TAU * (t - 30.0) / 1.4).sin();
                if inside { turn } else { 0.0 }
            })
            .collect();
        assert!(spikes(&slow, &swerve).is_empty(), "{:?}", spikes(&slow, &swerve));
    }

    #[test]
    fn the_resolution_of_a_channel() {
        let mut seed = 9;
        let fine: Vec<f64> = (0..3000).map(|_| noise(&mut seed)).collect();
        assert_eq!(resolution(&fine), None);
        let coarse: Vec<f64> = fine.iter().map(|x| 0.25 * (x / 0.25).round()).collect();
        assert!((resolution(&coarse).unwrap() - 0.25).abs() < 1e-12);
        // Rests between manoeuvres: what is large against a small change is no multiple of it.
        let resting: Vec<f64> =
            fine.iter().enumerate().map(|(k, x)| if k % 50 < 2 { 1e-5 * x } else { *x }).collect();
        assert_eq!(resolution(&resting), None);
    }

    #[test]
    fn a_gyro_that_freezes_while_the_vehicle_is_steered() {
        let mut seed = 11;
        let time = clock(6000, 0.01);
        let of = |value| Sampled { time: &time, value };
        let steered: Vec<f64> = time.iter().map(|t| 0.02 * (2.0 * t).sin()).collect();
        let steering = of(&steered);
        let alive: Vec<f64> =
            time.iter().map(|t| 0.2 * (2.0 * t).sin() + 0.002 * noise(&mut seed)).collect();
        assert!(frozen(of(&alive), steering, None).is_empty());
        let mut stuck = alive.clone();
        stuck[1000..1200].fill(0.0);
        let held = stuck[3000];
        stuck[3000..3200].fill(held);
        let found = frozen(of(&stuck), steering, None);
        assert_eq!(found, [[time[1000], time[1199]], [time[3000], time[3199]]]);
        // At rest nothing is wrong with a yaw rate of zero.
        let at_rest = [0.0; 6000];
        assert!(frozen(of(&stuck), steering, Some(of(&at_rest))).is_empty());
    }
}
