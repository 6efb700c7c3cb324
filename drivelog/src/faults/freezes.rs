//! Where a channel is frozen: it repeats one value while the vehicle moves and is steered.

use crate::series::{MOVING_MPS, Series};
use crate::signal::mean;

#[derive(Debug, Clone, Copy)]
pub(crate) struct Sampled<'a> {
    /// Instants, s.
    pub(crate) time: &'a [f64],
    /// Values, SI.
    pub(crate) value: &'a [f64],
}

impl<'a> Sampled<'a> {
    pub(crate) fn from_series(series: &'a Series) -> Self {
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
/// … and that many times longer than 95 % of its runs of equal values, which a slow sensor in fast rows has.
const FROZEN_FACTOR: f64 = 5.0;
/// The steering within the run spans at least its standard deviation.
const STEERED: f64 = 1.0;
/// The yaw rate's standard deviation over its smallest change, below which repeated values are no evidence.
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

    /// How many of the rows are decided upon, and the frozen runs among them, from the first to the last instant;
    /// one that goes on has the start that it had.
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
                && speed.is_none_or(|v| mean(v.within(from, to)) > MOVING_MPS)
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
        if lengths.len() < 2 {
            return 0.0;
        }
        let k = (0.95 * (lengths.len() - 1) as f64) as usize;
        *lengths.select_nth_unstable_by(k, f64::total_cmp).1
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
