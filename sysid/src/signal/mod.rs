//! Integration, unwrapping, means and spectra of uniformly sampled signals.

mod spectra;

use std::f64::consts::PI;

pub use spectra::{Spectra, Sums};

/// Trapezoidal integral from 0 (yaw rate to yaw), one value for each sample.
#[must_use]
pub fn integrate(rate: &[f64], sample_time_s: f64) -> Vec<f64> {
    let mut sum = 0.0;
    let mut before: Option<f64> = None;
    rate.iter()
        .map(|&x| {
            if let Some(b) = before {
                sum += 0.5 * sample_time_s * (b + x);
            }
            before = Some(x);
            sum
        })
        .collect()
}

/// Σ a(t)·b(t) of long signals: eight sums side by side, which a compiler makes vectors of.
pub(crate) fn dot(a: &[f64], b: &[f64]) -> f64 {
    let mut sums = [0.0; 8];
    let (a8, b8) = (a.chunks_exact(8), b.chunks_exact(8));
    let rest: f64 = a8.remainder().iter().zip(b8.remainder()).map(|(x, y)| x * y).sum();
    for (x, y) in a8.zip(b8) {
        for (s, (x, y)) in sums.iter_mut().zip(x.iter().zip(y)) {
            *s += x * y;
        }
    }
    sums.iter().sum::<f64>() + rest
}

/// Removes jumps by multiples of 2π.
#[must_use]
pub fn unwrap(angle: &[f64]) -> Vec<f64> {
    let mut turns = 0.0;
    let mut before: Option<f64> = None;
    angle
        .iter()
        .map(|&x| {
            if let Some(b) = before {
                turns -= ((x - b) / (2.0 * PI)).round();
            }
            before = Some(x);
            x + 2.0 * PI * turns
        })
        .collect()
}

/// Mean; 0 of nothing.
#[must_use]
pub fn mean(x: &[f64]) -> f64 {
    if x.is_empty() { 0.0 } else { x.iter().sum::<f64>() / x.len() as f64 }
}

/// Standard deviation (of the whole, not of a sample).
#[must_use]
pub fn standard_deviation(x: &[f64]) -> f64 {
    let m = mean(x);
    if x.is_empty() {
        return 0.0;
    }
    (x.iter().map(|v| (v - m) * (v - m)).sum::<f64>() / x.len() as f64).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn integral_of_a_sine_and_unwrapping() {
        let ts = 0.01;
        let time: Vec<f64> = (0..1000).map(|i| i as f64 * ts).collect();
        let rate: Vec<f64> = time.iter().map(|t| (2.0 * t).cos()).collect();
        for (yaw, t) in integrate(&rate, ts).iter().zip(&time) {
            assert!((yaw - 0.5 * (2.0 * t).sin()).abs() < 1e-4);
        }
        // A yaw that turns many times, wrapped as a log would have it.
        let wrapped: Vec<f64> =
            time.iter().map(|t| (7.0 * t + PI).rem_euclid(2.0 * PI) - PI).collect();
        let unwrapped = unwrap(&wrapped);
        assert!(unwrapped.iter().zip(&time).all(|(yaw, t)| (yaw - 7.0 * t).abs() < 1e-9));
    }
}
