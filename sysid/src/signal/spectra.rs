//! Auto and cross spectra of an input and an output by Welch's method, and what follows from them:
//! coherence, the frequency response H1, and their confidence.
//!
//! Windows are von Hann's with half overlap, each with its mean removed; none of them straddles two
//! stretches of a recording. With K windows of one stretch their averages scatter as those of
//!
//! `n_d = K² / (K + 2(K − 1)ρ²)`, ρ = 1/6 for this window and overlap (Welch 1967),
//!
//! independent ones do, and n_d is what enters the confidence bounds of Bendat and Piersol (2010,
//! chapter 9).

use super::mean;
use std::f64::consts::PI;

/// A window lasts about so long, s: a resolution of about 0.1 Hz.
const WINDOW_S: f64 = 7.0;
/// … but is shortened until there are that many windows.
const LEAST_WINDOWS: usize = 7;
/// Correlation of the spectra of two neighbouring windows: (Σ w(i) w(i + L/2) / Σ w(i)²)².
const OVERLAP: f64 = 1.0 / 36.0;

/// One-sided spectral densities at frequencies above 0, averaged over windows.
#[derive(Debug, Clone, PartialEq)]
pub struct Spectra {
    /// Frequencies, Hz, without 0, up to half the sample rate.
    pub frequency_hz: Vec<f64>,
    /// Power density of the input, its unit squared per Hz.
    pub input: Vec<f64>,
    /// Power density of the output.
    pub output: Vec<f64>,
    /// Cross density from input to output as (real, imaginary).
    pub cross: Vec<(f64, f64)>,
    /// Windows averaged.
    pub windows: usize,
    /// Independent averages n_d.
    pub averages: f64,
}

impl Spectra {
    /// Spectra of stretches of (input, output) at one sample time.
    #[must_use]
    pub fn welch(stretches: &[(&[f64], &[f64])], sample_time_s: f64) -> Self {
        let samples = |(u, y): &(&[f64], &[f64])| u.len().min(y.len());
        let windows = |length: usize| -> usize {
            stretches.iter().map(|s| count(samples(s), length)).sum()
        };
        let mut length = 16;
        while (length as f64) * sample_time_s < WINDOW_S && windows(2 * length) >= LEAST_WINDOWS {
            length *= 2;
        }
        while length > 2 && windows(length) == 0 {
            length /= 2;
        }
        let transform = Transform::new(length);
        let bins = length / 2;
        let mut sum = vec![[0.0; 4]; bins];
        let (mut all, mut variance) = (0, 0.0);
        for stretch in stretches {
            let k = count(samples(stretch), length);
            for i in 0..k {
                let at = i * bins..i * bins + length;
                transform.add(&stretch.0[at.clone()], &stretch.1[at], &mut sum);
            }
            all += k;
            variance += k as f64 + 2.0 * (k.saturating_sub(1)) as f64 * OVERLAP;
        }
        let power: f64 = transform.window.iter().map(|w| w * w).sum();
        let scale = |k: usize| {
            // The density at half the sample rate has no mirror image.
            let sides = if k + 1 == bins { 1.0 } else { 2.0 };
            sides * sample_time_s / (power * all.max(1) as f64)
        };
        let density = |part: usize| (0..bins).map(|k| scale(k) * sum[k][part]).collect();
        Self {
            frequency_hz: (1..=bins).map(|k| k as f64 / (length as f64 * sample_time_s)).collect(),
            input: density(0),
            output: density(1),
            cross: (0..bins).map(|k| (scale(k) * sum[k][2], scale(k) * sum[k][3])).collect(),
            windows: all,
            averages: if all > 0 { (all * all) as f64 / variance } else { 0.0 },
        }
    }

    /// Number of frequencies.
    #[must_use]
    pub fn len(&self) -> usize {
        self.frequency_hz.len()
    }

    /// Whether there is none.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.frequency_hz.is_empty()
    }

    /// Distance of two frequencies, Hz.
    #[must_use]
    pub fn resolution_hz(&self) -> f64 {
        self.frequency_hz.first().copied().unwrap_or(0.0)
    }

    /// Magnitude-squared coherence γ² at a frequency, 0 to 1.
    #[must_use]
    pub fn coherence(&self, k: usize) -> f64 {
        let power = self.input[k] * self.output[k];
        let cross = self.cross[k].0 * self.cross[k].0 + self.cross[k].1 * self.cross[k].1;
        if power > 0.0 { (cross / power).min(1.0) } else { 0.0 }
    }

    /// Bounds of the coherence at standard normal quantile `z`: artanh γ is nearly normal with
    /// variance 1/(2 n_d − 2) and bias half that ratio (Bendat and Piersol 2010, eq 9.78–9.81).
    #[must_use]
    pub fn coherence_bounds(&self, k: usize, z: f64) -> (f64, f64) {
        if self.averages <= 1.5 {
            return (0.0, 1.0);
        }
        let degrees = 2.0 * self.averages - 2.0;
        let middle = self.coherence(k).min(1.0 - 1e-12).sqrt().atanh() - 1.0 / degrees;
        let bound = |x: f64| x.max(0.0).tanh().powi(2);
        (bound(middle - z / degrees.sqrt()), bound(middle + z / degrees.sqrt()))
    }

    /// What the coherence of unrelated signals stays below with probability 1 − `risk`:
    /// 1 − risk^{1/(n_d − 1)} (Carter 1987).
    #[must_use]
    pub fn significance(&self, risk: f64) -> f64 {
        1.0 - risk.powf(1.0 / (self.averages - 1.0).max(0.1))
    }

    /// H1 = cross density over that of the input, (real, imaginary).
    #[must_use]
    pub fn response(&self, k: usize) -> (f64, f64) {
        let u = self.input[k];
        if u > 0.0 { (self.cross[k].0 / u, self.cross[k].1 / u) } else { (0.0, 0.0) }
    }

    /// Radius of the disk about H1 that holds the response with probability 1 − `risk`:
    /// r² = (2/(n − 2)) F_{2, n−2} (1 − γ²) G_yy/G_uu with n = 2 n_d (Bendat and Piersol 2010,
    /// eq 9.94); the quantile of F with 2 and m degrees of freedom is (m/2)(risk^{−2/m} − 1).
    #[must_use]
    pub fn radius(&self, k: usize, risk: f64) -> f64 {
        let quantile = risk.powf(-1.0 / (self.averages - 1.0).max(0.1)) - 1.0;
        (quantile * self.noise_to_input(k)).sqrt()
    }

    /// Standard error of |H1|, √((1 − γ²) G_yy/(2 n_d G_uu)) (Bendat and Piersol 2010, eq 9.90).
    #[must_use]
    pub fn standard_error(&self, k: usize) -> f64 {
        (self.noise_to_input(k) / (2.0 * self.averages.max(1.0))).sqrt()
    }

    /// Power of what the input does not explain in the output, over that of the input.
    fn noise_to_input(&self, k: usize) -> f64 {
        let u = self.input[k];
        let noise = self.noise(k);
        if u > 0.0 { noise / u } else { f64::INFINITY }
    }

    /// Power density of what the input does not explain in the output, (1 − γ²) G_yy.
    #[must_use]
    pub fn noise(&self, k: usize) -> f64 {
        (1.0 - self.coherence(k)) * self.output[k]
    }
}

/// Windows of a length with half overlap in so many samples.
fn count(samples: usize, length: usize) -> usize {
    if samples < length { 0 } else { (samples - length) / (length / 2) + 1 }
}

/// Windowed discrete Fourier transform of one length, a power of two.
struct Transform {
    window: Vec<f64>,
    /// e^{−2πjk/L} for k below L/2.
    twiddles: Vec<(f64, f64)>,
}

impl Transform {
    fn new(length: usize) -> Self {
        let angle = |k: usize| 2.0 * PI * k as f64 / length as f64;
        Self {
            window: (0..length).map(|i| 0.5 - 0.5 * angle(i).cos()).collect(),
            twiddles: (0..length / 2).map(|k| (angle(k).cos(), -angle(k).sin())).collect(),
        }
    }

    /// Adds |U|², |Y|² and U*Y at the frequencies 1 to L/2 of one window.
    fn add(&self, u: &[f64], y: &[f64], sum: &mut [[f64; 4]]) {
        // Two real signals in one complex transform.
        let (mu, my) = (mean(u), mean(y));
        let mut z: Vec<(f64, f64)> = u
            .iter()
            .zip(y)
            .zip(&self.window)
            .map(|((u, y), w)| ((u - mu) * w, (y - my) * w))
            .collect();
        self.transform(&mut z);
        for (k, sum) in sum.iter_mut().enumerate() {
            let (a, b) = (z[k + 1], z[z.len() - k - 1]);
            let (ur, ui) = (0.5 * (a.0 + b.0), 0.5 * (a.1 - b.1));
            let (yr, yi) = (0.5 * (a.1 + b.1), 0.5 * (b.0 - a.0));
            sum[0] += ur * ur + ui * ui;
            sum[1] += yr * yr + yi * yi;
            sum[2] += ur * yr + ui * yi;
            sum[3] += ur * yi - ui * yr;
        }
    }

    /// Radix-2 transform in place.
    fn transform(&self, z: &mut [(f64, f64)]) {
        let n = z.len();
        let mut j = 0;
        for i in 1..n {
            let mut bit = n >> 1;
            while j & bit != 0 {
                j ^= bit;
                bit >>= 1;
            }
            j |= bit;
            if i < j {
                z.swap(i, j);
            }
        }
        let mut length = 2;
        while length <= n {
            let (half, stride) = (length / 2, n / length);
            for block in z.chunks_exact_mut(length) {
                let (low, high) = block.split_at_mut(half);
                for ((a, b), (c, s)) in
                    low.iter_mut().zip(high).zip(self.twiddles.iter().step_by(stride))
                {
                    let t = (b.0 * c - b.1 * s, b.0 * s + b.1 * c);
                    *b = (a.0 - t.0, a.1 - t.1);
                    *a = (a.0 + t.0, a.1 + t.1);
                }
            }
            length *= 2;
        }
    }
}
