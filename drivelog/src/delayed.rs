//! A recording with its steering delayed.

use crate::log::DriveLog;
use crate::role::Role;
use steerwright_formats::{ChannelSummary, Intersample};

/// Taps on either side of the instant.
const HALF: i64 = 3;

impl DriveLog {
    /// The same drive with the steering angle delayed by `seconds` against all else.
    ///
    /// Fractions of a sample are, of a command at the log's own rate, the mean over the time that each of
    /// two samples is held; otherwise a polynomial through six samples (Lagrange; at a fifth of the sample
    /// rate its gain is above 0.98). Before the start of a segment its first value is used.
    #[must_use]
    pub fn with_input_delayed(&self, seconds: f64) -> Self {
        let delay = seconds / self.sample_time_s;
        let whole = delay.floor();
        let weights = if self.is_held() { held(delay - whole) } else { lagrange(delay - whole) };
        let mut log = self.clone();
        for segment in &self.segments {
            let samples = &self.input[segment.range.clone()];
            let last = samples.len() as i64 - 1;
            let base = (whole as i64).min(last + HALF);
            for (k, out) in log.input[segment.range.clone()].iter_mut().enumerate() {
                let at = |tap: i64| samples[(k as i64 - base + tap).clamp(0, last) as usize];
                *out = weights.iter().zip(-HALF..HALF).map(|(w, tap)| w * at(tap)).sum();
            }
        }
        log
    }

    /// Whether the steering is as it was recorded, one sample for each of its own.
    fn is_held(&self) -> bool {
        if !self.response.is_of_yaw_rate() {
            return false;
        }
        let mut steering = self.channels.iter().filter(|c| c.role == Role::Steering.key());
        let one = |c: &ChannelSummary| c.rate_hz * self.sample_time_s < 1.5;
        steering.all(|c| one(c) && matches!(c.intersample, None | Some(Intersample::Zoh)))
    }
}

/// Weights of the samples at −3 … 2 where each is held.
fn held(fraction: f64) -> [f64; 2 * HALF as usize] {
    let mut weights = [0.0; 2 * HALF as usize];
    weights[HALF as usize - 1] = fraction;
    weights[HALF as usize] = 1.0 - fraction;
    weights
}

/// Weights of the samples at −3 … 2 for the value at −`fraction`.
fn lagrange(fraction: f64) -> [f64; 2 * HALF as usize] {
    let mut weights = [1.0; 2 * HALF as usize];
    for (i, weight) in (-HALF..HALF).zip(&mut weights) {
        for j in (-HALF..HALF).filter(|j| *j != i) {
            *weight *= (-fraction - j as f64) / (i - j) as f64;
        }
    }
    weights
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn weights_pass_polynomials_and_whole_samples() {
        assert_eq!(lagrange(0.0), [0.0, 0.0, 0.0, 1.0, 0.0, 0.0]);
        for fraction in [0.1, 0.5, 0.9] {
            for power in 0..6 {
                let x = |t: f64| t.powi(power);
                let sum: f64 =
                    lagrange(fraction).iter().zip(-3..).map(|(w, t)| w * x(f64::from(t))).sum();
                assert!((sum - x(-fraction)).abs() < 1e-12, "{fraction} {power}");
            }
        }
    }
}
