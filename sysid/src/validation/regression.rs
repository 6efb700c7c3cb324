//! Yaw rate regressed on the steering by a bank of Laguerre filters (B. Wahlberg, IEEE Transactions
//! on Automatic Control 36, 1991), block by block: no structure, order or delay is chosen, and a
//! change of the steering (play taken out, or moved in time) is compared by what a least-squares
//! fit leaves. Sums are kept for each of [`BLOCKS`] blocks of time, so that leaving one out for the
//! jackknife costs nothing.

use crate::linalg::dense::solve;
use faer::Mat;
use steerwright_drivelog::DriveLog;

/// Functions of the bank.
const FUNCTIONS: usize = 8;
/// Regressors: the steering itself, the bank, a constant, and the yaw rate to be explained.
const COLUMNS: usize = FUNCTIONS + 3;
/// Blocks of time.
pub(crate) const BLOCKS: usize = 10;
/// The transient of the bank at the start of a segment, in its time constants.
const SETTLING: f64 = 12.0;

/// One segment of steering and yaw rate, of equal lengths.
#[derive(Debug, Clone)]
pub(crate) struct Pair<'a> {
    pub(crate) steering: &'a [f64],
    pub(crate) yaw_rate: &'a [f64],
    /// Speed, if the log has it: the yaw rate is taken for that of steering times speed.
    pub(crate) speed: Option<&'a [f64]>,
}

/// Samples in which play and clocks are looked for: more change nothing.
const MOST_FOR_FAULTS: usize = 60_000;

/// Steering, yaw rate and speed of the log's segments, as many as are needed to find faults.
pub(crate) fn pairs(log: &DriveLog) -> Vec<Pair<'_>> {
    let mut left = MOST_FOR_FAULTS;
    let ranges = log.segments.iter().map(|s| {
        let range = s.range.start..s.range.end.min(s.range.start + left);
        left -= range.len();
        range
    });
    let pair = |r: std::ops::Range<usize>| Pair {
        steering: &log.input[r.clone()],
        yaw_rate: &log.output[r.clone()],
        speed: log.speed.as_ref().map(|v| &v[r]),
    };
    ranges.filter(|r| !r.is_empty()).map(pair).collect()
}

pub(crate) struct Sums {
    blocks: Vec<Mat<f64>>,
}

impl Sums {
    /// With the steering changed by `change` and the last `spare` samples left out.
    pub(crate) fn new(
        segments: &[Pair<'_>],
        sample_time_s: f64,
        pole_radps: f64,
        spare: usize,
        change: &dyn Fn(&[f64]) -> Vec<f64>,
    ) -> Self {
        let pole = (-pole_radps * sample_time_s).exp();
        let skip = (SETTLING / (pole_radps * sample_time_s)).ceil() as usize;
        let counted = |n: usize| n.saturating_sub(skip + spare);
        let total: usize = segments.iter().map(|s| counted(s.steering.len())).sum();
        let mut blocks = vec![Mat::<f64>::zeros(COLUMNS, COLUMNS); BLOCKS];
        let mut taken = 0;
        for segment in segments {
            let mut u = change(segment.steering);
            if let Some(speed) = segment.speed {
                u.iter_mut().zip(speed).for_each(|(u, v)| *u *= v);
            }
            let mut bank = Bank::new(pole, u.first().copied().unwrap_or(0.0));
            for (k, (u, y)) in u.iter().zip(segment.yaw_rate).enumerate() {
                let row = bank.row(*u, *y);
                if k < skip || k + spare >= segment.yaw_rate.len() {
                    continue;
                }
                let block = &mut blocks[(taken * BLOCKS / total.max(1)).min(BLOCKS - 1)];
                for i in 0..COLUMNS {
                    for j in i..COLUMNS {
                        block[(i, j)] += row[i] * row[j];
                    }
                }
                taken += 1;
            }
        }
        Self { blocks }
    }

    pub(crate) fn variation(&self) -> f64 {
        let of = |i: usize, j: usize| self.blocks.iter().map(|b| b[(i, j)]).sum::<f64>();
        let (one, y) = (COLUMNS - 2, COLUMNS - 1);
        of(y, y) - of(one, y).powi(2) / of(one, one).max(1.0)
    }

    /// Sum of squares that is left of all blocks but one; `None` where nothing can be regressed.
    pub(crate) fn left(&self, without: Option<usize>) -> Option<f64> {
        let mut sum = Mat::<f64>::zeros(COLUMNS, COLUMNS);
        for (_, block) in self.blocks.iter().enumerate().filter(|(b, _)| Some(*b) != without) {
            sum += block;
        }
        let y = COLUMNS - 1;
        // Columns of unit length: the rank does not hang on units.
        let scale: Vec<f64> = (0..COLUMNS).map(|i| sum[(i, i)].sqrt()).collect();
        if scale.iter().any(|s| !(*s > 0.0 && s.is_finite())) {
            return None;
        }
        let at = |i: usize, j: usize| sum[(i.min(j), i.max(j))] / (scale[i] * scale[j]);
        // A little ridge in place of a rank decision.
        let normal = Mat::from_fn(y, y, |i, j| at(i, j) + if i == j { 1e-9 } else { 0.0 });
        let right = Mat::from_fn(y, 1, |i, _| at(i, y));
        let solution = solve(normal.as_ref(), right.as_ref());
        let explained: f64 = (0..y).map(|i| solution[(i, 0)] * right[(i, 0)]).sum();
        let left = (1.0 - explained) * scale[y] * scale[y];
        left.is_finite().then_some(left.max(0.0))
    }
}

struct Bank {
    pole: f64,
    gain: f64,
    /// The mean at the start, about which the steering is taken.
    mean: f64,
    before: [f64; FUNCTIONS + 1],
}

impl Bank {
    fn new(pole: f64, mean: f64) -> Self {
        Self { pole, gain: (1.0 - pole * pole).sqrt(), mean, before: [0.0; FUNCTIONS + 1] }
    }

    fn row(&mut self, u: f64, y: f64) -> [f64; COLUMNS] {
        let mut now = [0.0; FUNCTIONS + 1];
        now[0] = u - self.mean;
        now[1] = self.pole * self.before[1] + self.gain * self.before[0];
        for i in 2..=FUNCTIONS {
            now[i] = self.pole * self.before[i] + self.before[i - 1] - self.pole * now[i - 1];
        }
        self.before = now;
        let mut row = [0.0; COLUMNS];
        row[..=FUNCTIONS].copy_from_slice(&now);
        row[0] = u;
        row[FUNCTIONS + 1] = 1.0;
        row[FUNCTIONS + 2] = y;
        row
    }
}

/// Standard error of what was found without each block in turn.
pub(crate) fn jackknife(without: &[f64]) -> f64 {
    let n = without.len() as f64;
    let mean = steerwright_drivelog::signal::mean(without);
    ((n - 1.0) / n * without.iter().map(|x| (x - mean).powi(2)).sum::<f64>()).sqrt()
}
