//! A segment made ready for simulation: road-wheel angle and speed as functions of time.

use crate::structures::single_track::drive::{Drive, DriveSegment};
use crate::structures::single_track::dynamics::{DriveMotion, ROLL_TIME_CONSTANT_S};

/// Half the width of the average of yaw rate that an initial state is made of, s.
const YAW_AVERAGE_S: f64 = 0.05;

/// A segment with what the simulation needs.
#[derive(Debug, Clone)]
pub(super) struct PreparedSegment<'a> {
    pub(super) sample_time: f64,
    steering_delay: f64,
    /// The same of a steering that is held over each sample.
    held: Option<Vec<f64>>,
    /// From before the first sample on, by so many.
    steering: Vec<f64>,
    before: usize,
    /// Its slope at the samples, rad per sample.
    steering_slope: Vec<f64>,
    pub(super) speed: &'a [f64],
    /// Longitudinal acceleration that the load has followed, m/s².
    acceleration: Vec<f64>,
    pub(super) yaw_rate: &'a [f64],
    pub(super) smooth_yaw_rate: Vec<f64>,
    pub(super) lateral_acceleration: Option<&'a [f64]>,
    pub(super) lateral_velocity: Option<&'a [f64]>,
}

/// All segments of a drive, prepared.
pub(super) fn prepare(drive: &Drive) -> Vec<PreparedSegment<'_>> {
    drive.segments.iter().map(|s| PreparedSegment::new(drive, s)).collect()
}

impl<'a> PreparedSegment<'a> {
    fn new(drive: &Drive, segment: &'a DriveSegment) -> Self {
        let t = drive.sample_time_s;
        let steering = segment.steering_before_rad.iter().chain(&segment.steering_rad);
        let steering: Vec<f64> = steering.map(|s| s / drive.steering_ratio).collect();
        let held = match &segment.steering_held_rad {
            Some(held) => Some(held.iter().map(|s| s / drive.steering_ratio).collect()),
            None if (drive.steering_delay_s - 0.5 * t).abs() < 1e-9 => Some(steering.clone()),
            None => None,
        };
        Self {
            sample_time: t,
            steering_delay: drive.steering_delay_s,
            held,
            steering_slope: differences(&steering),
            steering,
            before: segment.steering_before_rad.len(),
            speed: &segment.speed_mps,
            acceleration: followed_acceleration(&segment.speed_mps, t),
            yaw_rate: &segment.yaw_rate_radps,
            smooth_yaw_rate: average(&segment.yaw_rate_radps, (YAW_AVERAGE_S / t).round() as usize),
            lateral_acceleration: segment.lateral_acceleration_mps2.as_deref(),
            lateral_velocity: segment.lateral_velocity_mps.as_deref(),
        }
    }

    pub(super) fn len(&self) -> usize {
        self.yaw_rate.len()
    }

    /// Road-wheel angle by the stated ratio at the samples, rad.
    pub(super) fn steering_samples(&self) -> &[f64] {
        &self.steering[self.before..]
    }

    /// Time before the first sample from which the steering is known, s.
    pub(super) fn known_before(&self) -> f64 {
        self.before as f64 * self.sample_time
    }

    /// The sample before a time, of so many, and the share of the next one.
    #[inline]
    fn place(&self, time: f64, count: usize) -> (usize, f64) {
        let at = (time / self.sample_time).clamp(0.0, (count - 1) as f64);
        let index = (at as usize).min(count.saturating_sub(2));
        (index, at - index as f64)
    }

    /// Road-wheel angle by the stated ratio, rad, and its rate, rad/s, by cubic Hermite polynomials: the
    /// rate, which is the derivative by the delay, has no steps.
    #[inline]
    pub(super) fn steering(&self, time: f64) -> (f64, f64) {
        let since = time - self.steering_delay + self.known_before();
        let (i, x) = self.place(since, self.steering.len());
        let (from, to) = (self.steering[i], self.steering[i + 1]);
        let (a, b) = (self.steering_slope[i], self.steering_slope[i + 1]);
        let (c, d) = (3.0 * (to - from) - 2.0 * a - b, 2.0 * (from - to) + a + b);
        let angle = from + x * (a + x * (c + x * d));
        (angle, (a + x * (2.0 * c + x * 3.0 * d)) / self.sample_time)
    }

    /// Road-wheel angle by the stated ratio, rad, in all samples of a steering that is held over them, and how many of them are
    /// before the first of the segment.
    pub(super) fn held_steering(&self) -> Option<(&[f64], usize)> {
        Some((self.held.as_deref()?, self.before))
    }

    /// Measured yaw rate, rad/s.
    #[inline]
    pub(super) fn yaw_rate(&self, time: f64) -> f64 {
        let (i, share) = self.place(time, self.len());
        self.yaw_rate[i] + share * (self.yaw_rate[i + 1] - self.yaw_rate[i])
    }

    /// Measured speed, and the acceleration that follows from it.
    #[inline]
    pub(super) fn known(&self, time: f64) -> DriveMotion {
        let (i, share) = self.place(time, self.len());
        let between = |x: &[f64]| x[i] + share * (x[i + 1] - x[i]);
        DriveMotion { speed: between(self.speed), acceleration: between(&self.acceleration) }
    }
}

/// What the load has followed of the acceleration v̇: `(v − v_f)/T` with `T·v̇_f = v − v_f`, for a speed that is linear
/// between samples and was constant before.
fn followed_acceleration(speed: &[f64], sample_time: f64) -> Vec<f64> {
    let keep = (-sample_time / ROLL_TIME_CONSTANT_S).exp();
    let mut acceleration = 0.0;
    let mut before = speed.first().copied().unwrap_or_default();
    let followed = speed.iter().map(|&v| {
        let slope = (v - before) / sample_time;
        acceleration = slope + keep * (acceleration - slope);
        before = v;
        acceleration
    });
    followed.collect()
}

/// The mean over `half` samples to either side, fewer at the ends.
fn average(x: &[f64], half: usize) -> Vec<f64> {
    let mut sums = vec![0.0];
    let mut sum = 0.0;
    for value in x {
        sum += value;
        sums.push(sum);
    }
    (0..x.len())
        .map(|i| {
            let half = half.min(i).min(x.len() - 1 - i);
            (sums[i + half + 1] - sums[i - half]) / (2 * half + 1) as f64
        })
        .collect()
}

/// Central differences per sample, one-sided at the ends.
fn differences(x: &[f64]) -> Vec<f64> {
    (0..x.len())
        .map(|i| {
            let (from, to) = (i.saturating_sub(1), (i + 1).min(x.len() - 1));
            (x[to] - x[from]) / (to - from).max(1) as f64
        })
        .collect()
}
