//! Steering and yaw rate of a log's segments, and the jackknife over blocks of time.

use steerwright_drivelog::DriveLog;
use steerwright_drivelog::signal::mean;

/// One segment of steering and yaw rate, of equal lengths.
#[derive(Debug, Clone)]
pub(crate) struct Pair<'a> {
    pub(crate) steering: &'a [f64],
    pub(crate) yaw_rate: &'a [f64],
    /// Speed, if the log has it.
    pub(crate) speed: Option<&'a [f64]>,
}

/// Samples in which signs, play and clocks are looked for: more change nothing.
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

/// Standard error of what was found without each block in turn.
pub(crate) fn jackknife(without: &[f64]) -> f64 {
    let n = without.len() as f64;
    let level = mean(without);
    ((n - 1.0) / n * without.iter().map(|x| (x - level).powi(2)).sum::<f64>()).sqrt()
}
