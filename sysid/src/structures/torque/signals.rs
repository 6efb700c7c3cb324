//! The signals of the equation, after the low-pass filter.

use super::options::TorqueOptions;
use steerwright_drivelog::{DriveLog, Role};

const GRAVITY: f64 = 9.806_65;
/// The low-pass filter: binomial, of zero phase, and about 0 from three quarters of the Nyquist frequency on.
const FILTER: [f64; 5] = [1.0 / 16.0, 4.0 / 16.0, 6.0 / 16.0, 4.0 / 16.0, 1.0 / 16.0];
/// Samples on either side that the filter and the derivative of the angle depend on.
const EDGE: usize = 4;
/// Time after the start of a segment before its first sample is used, s: the driver hands over, and the delayed
/// command is in the segment.
const SETTLED_S: f64 = 2.0;
/// Largest delay, s.
pub(super) const LARGEST_DELAY: f64 = 0.8;

/// Filtered samples of a log.
pub(super) struct Signals<'a> {
    pub(super) log: &'a DriveLog,
    /// The log with its command filtered.
    filtered: DriveLog,
    /// Lateral acceleration, m/s².
    pub(super) acceleration: Vec<f64>,
    /// tanh(ω/ω0).
    friction: Vec<f64>,
    /// g·sin(roll), m/s².
    gravity: Option<Vec<f64>>,
}

impl<'a> Signals<'a> {
    pub(super) fn from_log(log: &'a DriveLog, angle: &[f64], options: &TorqueOptions) -> Self {
        let filtered = |signal: &[f64]| filtered(log, signal);
        let rate = rate(log, angle);
        let friction: Vec<f64> =
            rate.iter().map(|rate| (rate / options.friction_rate_radps).tanh()).collect();
        let roll = log.others.get(&Role::Roll);
        let gravity =
            roll.map(|roll| roll.iter().map(|roll| GRAVITY * roll.sin()).collect::<Vec<_>>());
        Self {
            log,
            filtered: DriveLog { input: filtered(&log.input), ..log.clone() },
            acceleration: filtered(&log.output),
            friction: filtered(&friction),
            gravity: gravity.map(|gravity| filtered(&gravity)),
        }
    }

    pub(super) fn has_roll(&self) -> bool {
        self.gravity.is_some()
    }

    /// The samples that are used: at or above the lowest speed, once the segment has settled.
    pub(super) fn rows(&self, speed: &[f64], least_speed: f64) -> Vec<usize> {
        let settled = (SETTLED_S / self.log.sample_time_s).ceil() as usize + EDGE;
        let segments = self.log.segments.iter();
        let used = segments.flat_map(|s| s.range.start + settled..s.range.end.saturating_sub(EDGE));
        used.filter(|&k| speed[k] >= least_speed).collect()
    }

    /// The command of each sample, delayed.
    pub(super) fn command(&self, delay: f64) -> Vec<f64> {
        self.filtered.with_input_delayed(delay).input
    }

    /// The regressors of (K, K·f, ρ, b) at a sample; that of an absent roll is 0.
    pub(super) fn regressors(&self, command: f64, k: usize) -> [f64; 4] {
        let gravity = self.gravity.as_ref().map_or(0.0, |gravity| gravity[k]);
        [command, -self.friction[k], gravity, 1.0]
    }
}

/// A signal after the filter, segment by segment; the ends of a segment are held.
fn filtered(log: &DriveLog, signal: &[f64]) -> Vec<f64> {
    by_segment(log, signal, |at| (-2..=2).zip(FILTER).map(|(tap, weight)| weight * at(tap)).sum())
}

/// Rate of an angle, rad/s: the derivative of the polynomial through five samples.
fn rate(log: &DriveLog, angle: &[f64]) -> Vec<f64> {
    by_segment(log, angle, |at| {
        (8.0 * (at(1) - at(-1)) - (at(2) - at(-2))) / (12.0 * log.sample_time_s)
    })
}

fn by_segment(log: &DriveLog, signal: &[f64], of: impl Fn(&dyn Fn(i64) -> f64) -> f64) -> Vec<f64> {
    let mut all = Vec::with_capacity(signal.len());
    for segment in &log.segments {
        let own = &signal[segment.range.clone()];
        let last = own.len() as i64 - 1;
        all.extend((0..=last).map(|k| of(&|tap| own[(k + tap).clamp(0, last) as usize])));
    }
    all
}
