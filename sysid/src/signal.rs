//! Integration, unwrapping and spectra of uniformly sampled signals.

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

/// Magnitude-squared coherence by Welch's method.
#[derive(Debug, Clone, PartialEq)]
pub struct Coherence {
    /// Frequencies, Hz, without 0.
    pub frequency_hz: Vec<f64>,
    /// Magnitude-squared coherence at each.
    pub coherence: Vec<f64>,
    /// What unrelated signals stay below with a probability of 99 %: 1 − 0.01^{1/(n−1)} for n
    /// independent segments (Carter 1987), n being 2·N/L·9/11 for Hann windows with half overlap
    /// (Welch 1967).
    pub significance: f64,
}

/// Coherence of `u` and `y`: Hann windows with half overlap, each segment's mean removed. Segments
/// last about 10 s, shorter where that leaves fewer than 8 of them.
#[must_use]
pub fn coherence(u: &[f64], y: &[f64], sample_time_s: f64) -> Coherence {
    let n = u.len().min(y.len());
    let mut length = 16;
    while (length as f64) * sample_time_s < 7.0 && length * 2 * 4 <= n {
        length *= 2;
    }
    let length = length.min(n.max(2).next_power_of_two() / 2).max(2);
    let window: Vec<f64> =
        (0..length).map(|i| 0.5 - 0.5 * (2.0 * PI * i as f64 / length as f64).cos()).collect();
    let bins = length / 2;
    let (mut uu, mut yy) = (vec![0.0; bins], vec![0.0; bins]);
    let mut uy = vec![(0.0, 0.0); bins];
    let mut start = 0;
    while start + length <= n {
        // Two real signals in one complex transform.
        let (a, b) = (&u[start..start + length], &y[start..start + length]);
        let (ma, mb) = (mean(a), mean(b));
        let mut re: Vec<f64> = a.iter().zip(&window).map(|(x, w)| (x - ma) * w).collect();
        let mut im: Vec<f64> = b.iter().zip(&window).map(|(x, w)| (x - mb) * w).collect();
        fft(&mut re, &mut im);
        for k in 1..=bins {
            let m = length - k;
            let (ur, ui) = (0.5 * (re[k] + re[m]), 0.5 * (im[k] - im[m]));
            let (yr, yi) = (0.5 * (im[k] + im[m]), 0.5 * (re[m] - re[k]));
            uu[k - 1] += ur * ur + ui * ui;
            yy[k - 1] += yr * yr + yi * yi;
            uy[k - 1].0 += ur * yr + ui * yi;
            uy[k - 1].1 += ur * yi - ui * yr;
        }
        start += length / 2;
    }
    let independent = (2.0 * n as f64 / length as f64 * 9.0 / 11.0).max(2.0);
    Coherence {
        frequency_hz: (1..=bins).map(|k| k as f64 / (length as f64 * sample_time_s)).collect(),
        coherence: (0..bins)
            .map(|k| {
                let power = uu[k] * yy[k];
                let cross = uy[k].0 * uy[k].0 + uy[k].1 * uy[k].1;
                if power > 0.0 { (cross / power).min(1.0) } else { 0.0 }
            })
            .collect(),
        significance: 1.0 - 0.01_f64.powf(1.0 / (independent - 1.0)),
    }
}

/// Radix-2 transform in place; the length is a power of two.
fn fft(re: &mut [f64], im: &mut [f64]) {
    let n = re.len();
    let mut j = 0;
    for i in 1..n {
        let mut bit = n >> 1;
        while j & bit != 0 {
            j ^= bit;
            bit >>= 1;
        }
        j |= bit;
        if i < j {
            re.swap(i, j);
            im.swap(i, j);
        }
    }
    let mut length = 2;
    while length <= n {
        let half = length / 2;
        for k in 0..half {
            let (s, c) = (-2.0 * PI * k as f64 / length as f64).sin_cos();
            for a in (k..n).step_by(length) {
                let b = a + half;
                let (tr, ti) = (re[b] * c - im[b] * s, re[b] * s + im[b] * c);
                re[b] = re[a] - tr;
                im[b] = im[a] - ti;
                re[a] += tr;
                im[a] += ti;
            }
        }
        length *= 2;
    }
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

    #[test]
    fn coherence_tells_related_from_unrelated() {
        let mut state = 1_u64;
        let mut noise = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
            (state >> 33) as f64 / f64::from(1_u32 << 30) - 1.0
        };
        let u: Vec<f64> = (0..8000).map(|_| noise()).collect();
        let v: Vec<f64> = (0..8000).map(|_| noise()).collect();
        // y = u with equal power of v: coherence 1/2 everywhere.
        let y: Vec<f64> = u.iter().zip(&v).map(|(a, b)| a + b).collect();
        let half = coherence(&u, &y, 0.04);
        assert!((mean(&half.coherence) - 0.5).abs() < 0.04, "{}", mean(&half.coherence));
        let none = coherence(&u, &v, 0.04);
        let above = none.coherence.iter().filter(|c| **c > none.significance).count();
        assert!(above <= none.coherence.len() / 25, "{above} of {}", none.coherence.len());
    }
}
