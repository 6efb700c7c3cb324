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

/// Indices of the samples of spikes and dropouts.
pub(crate) fn spikes(time: &[f64], x: &[f64]) -> Vec<usize> {
    let n = x.len();
    if n < 50 {
        return Vec::new();
    }
    let period = median_step(time);
    // Samples on both sides of a gap are no neighbours: the signal moves on meanwhile.
    let joined = |from: usize, to: usize| (from..to).all(|k| time[k + 1] - time[k] <= GAP * period);
    let bend = |i: usize| x[i] - 0.5 * (x[i - 1] + x[i + 1]);
    let mut sizes: Vec<f64> = (1..n - 1)
        .filter(|&i| joined(i - 1, i + 1))
        .map(|i| bend(i).abs())
        .filter(|b| b.is_finite())
        .collect();
    if sizes.len() < 50 {
        return Vec::new();
    }
    let mut quantile = |share: f64| {
        let k = (share * (sizes.len() - 1) as f64) as usize;
        *sizes.select_nth_unstable_by(k, f64::total_cmp).1
    };
    let (median, high) = (quantile(0.5), quantile(0.95));
    let size = x.iter().filter(|x| x.is_finite()).fold(0.0_f64, |m, x| m.max(x.abs()));
    let least = (SIGMAS * 1.4826 * median).max(PERCENTILE_FACTOR * high).max(1e-6 * size);
    let mut found = Vec::new();
    let mut i = 1;
    while i + 1 < n {
        let wide = |w: usize| w == 1 || w as f64 * period <= LONGEST_S;
        let width = (1..=LONGEST)
            .find(|&w| wide(w) && i + w < n && joined(i - 1, i + w) && is_spike(x, i, w, least));
        match width {
            Some(w) => {
                found.extend(i..i + w);
                i += w + 1;
            }
            None => i += 1,
        }
    }
    found
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

fn median_step(time: &[f64]) -> f64 {
    let mut steps: Vec<f64> =
        time.windows(2).map(|w| w[1] - w[0]).filter(|s| s.is_finite()).collect();
    let middle = steps.len() / 2;
    if steps.is_empty() { 0.0 } else { *steps.select_nth_unstable_by(middle, f64::total_cmp).1 }
}

/// The step that (almost) all differences of successive values are multiples of, where there is one.
pub(crate) fn resolution(x: &[f64]) -> Option<f64> {
    /// Rows that are looked at: more change nothing.
    const ROWS: usize = 20_000;
    let rows = &x[..x.len().min(ROWS)];
    let size = rows.iter().fold(0.0_f64, |m, x| m.max(x.abs()));
    let mut steps: Vec<f64> = rows
        .windows(2)
        .map(|w| (w[1] - w[0]).abs())
        .filter(|d| d.is_finite() && *d > 1e-9 * size)
        .collect();
    if steps.len() < 10 {
        return None;
    }
    // A few interpolated values in between do not hide it.
    let k = steps.len() / 200;
    let least = *steps.select_nth_unstable_by(k, f64::total_cmp).1;
    let multiples = steps.iter().filter(|d| {
        let turns = *d / least;
        (turns - turns.round()).abs() < 0.02 * turns.max(1.0).sqrt()
    });
    // Of differences without a step, at most some ten percent are so near to a multiple.
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
/// Slower, a steered vehicle need not yaw, m/s.
const MOVING_MPS: f64 = 0.5;
/// The yaw rate's standard deviation over its smallest change, below which repeated values say nothing.
const FINE_ENOUGH: f64 = 3.0;

/// Runs, from the first to the last instant, in which the yaw rate is frozen.
pub(crate) fn frozen(
    yaw_rate: Sampled<'_>,
    steering: Sampled<'_>,
    speed: Option<Sampled<'_>>,
) -> Vec<[f64; 2]> {
    let Sampled { time, value: x } = yaw_rate;
    let mut runs: Vec<(usize, usize)> = Vec::new();
    for i in 0..x.len() {
        match runs.last_mut() {
            // Bit for bit: a sensor that lives has noise.
            Some((_, last)) if x[*last].to_bits() == x[i].to_bits() => *last = i,
            _ => runs.push((i, i)),
        }
    }
    let lasting = |&(a, b): &(usize, usize)| time[b] - time[a];
    let mut lengths: Vec<f64> = runs.iter().map(lasting).collect();
    if lengths.is_empty() {
        return Vec::new();
    }
    let k = (0.95 * (lengths.len() - 1) as f64) as usize;
    let usual = *lengths.select_nth_unstable_by(k, f64::total_cmp).1;
    let least = LEAST_FROZEN_S.max(FROZEN_FACTOR * usual);
    let spread = crate::signal::standard_deviation(x);
    if resolution(x).is_some_and(|step| spread < FINE_ENOUGH * step) {
        return Vec::new();
    }
    let usual_steering = crate::signal::standard_deviation(steering.value);
    let span = |x: &[f64]| {
        let (low, high) =
            x.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), v| (a.min(*v), b.max(*v)));
        high - low
    };
    runs.into_iter()
        .filter(|run| lasting(run) > least)
        .map(|(a, b)| [time[a], time[b]])
        .filter(|[from, to]| span(steering.within(*from, *to)) > STEERED * usual_steering)
        .filter(|[from, to]| {
            speed.is_none_or(|v| crate::signal::mean(v.within(*from, *to)) > MOVING_MPS)
        })
        .collect()
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
