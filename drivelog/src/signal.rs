//! Integration, unwrapping, means, clocks and resolution of sampled signals.

use std::f64::consts::PI;

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

/// Median step of a clock. Of a clock whose numbers are too large for its steps, such as seconds since 1970, the
/// mean of the steps near the median, in which their rounding cancels.
pub(crate) fn median_period(time: &[f64]) -> f64 {
    let mut steps: Vec<f64> = time.windows(2).map(|w| w[1] - w[0]).collect();
    if steps.is_empty() {
        return 0.0;
    }
    let middle = steps.len() / 2;
    let median = *steps.select_nth_unstable_by(middle, f64::total_cmp).1;
    let rounding = f64::EPSILON * time.iter().fold(0.0_f64, |most, t| most.max(t.abs()));
    if rounding <= 1e-9 * median.abs() || rounding > 0.01 * median.abs() {
        return median;
    }
    steps.retain(|step| (step - median).abs() < 2.0 * rounding);
    if steps.is_empty() { median } else { mean(&steps) }
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
    if multiples.count() as f64 > 0.95 * steps.len() as f64 { Some(least) } else { None }
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;

    #[test]
    fn the_period_of_an_epoch_clock_is_not_rounded() {
        let epoch: Vec<f64> = (0..5000).map(|k| 1.7e9 + 0.01 * f64::from(k)).collect();
        assert!((median_period(&epoch) - 0.01).abs() < 1e-9);
        let own: Vec<f64> = (0..5000).map(|k| 0.01 * f64::from(k)).collect();
        assert!((median_period(&own) - 0.01).abs() < 1e-12);
        assert_eq!(median_period(&[0.0]), 0.0);
    }

    /// Normal noise, nearly.
    pub(crate) fn noise(seed: &mut u64) -> f64 {
        let mut uniform = || {
            *seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
            (*seed >> 33) as f64 / f64::from(1_u32 << 31)
        };
        (0..12).map(|_| uniform()).sum::<f64>() - 6.0
    }

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
}
