//! Auto and cross spectra of an input and an output by Welch's method, and what follows from them:
//! coherence, the frequency response H1, and their confidence (docs/methods/validation.md). Windows
//! average as `n_d = K² / (K + 2(K − 1)ρ²)`, ρ = 1/6, independent ones do (Welch 1967), and n_d
//! enters the bounds of Bendat and Piersol (2010, chapter 9).

use std::f64::consts::PI;
use steerwright_drivelog::signal::mean;

/// A window lasts about so long, s: a resolution of about 0.1 Hz.
const WINDOW_S: f64 = 7.0;
/// … but is shortened until there are that many windows.
const LEAST_WINDOWS: usize = 7;
/// Correlation of the spectra of two neighbouring windows: (Σ w(i) w(i + L/2) / Σ w(i)²)².
pub(crate) const OVERLAP: f64 = 1.0 / 36.0;

/// One-sided spectral densities at frequencies above 0, averaged over windows.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Spectra {
    /// Frequencies, Hz, without 0, up to half the sample rate.
    pub(crate) frequency_hz: Vec<f64>,
    /// Power density of the input, its unit squared per Hz.
    pub(crate) input: Vec<f64>,
    pub(crate) output: Vec<f64>,
    /// Cross density from input to output as (real, imaginary).
    pub(crate) cross: Vec<(f64, f64)>,
    pub(crate) windows: usize,
    /// Independent averages n_d.
    pub(crate) averages: f64,
}

impl Spectra {
    pub(crate) fn welch(segments: &[(&[f64], &[f64])], sample_time_s: f64) -> Self {
        let samples = |(u, y): &(&[f64], &[f64])| u.len().min(y.len());
        let windows =
            |length: usize| -> usize { segments.iter().map(|s| count(samples(s), length)).sum() };
        let mut length = 16;
        while (length as f64) * sample_time_s < WINDOW_S && windows(2 * length) >= LEAST_WINDOWS {
            length *= 2;
        }
        while length > 2 && windows(length) == 0 {
            length /= 2;
        }
        let mut sums = Sums::new(length);
        for (u, y) in segments {
            sums.push(u, y);
            sums.end_segment();
        }
        sums.spectra(sample_time_s)
    }

    pub(crate) fn len(&self) -> usize {
        self.frequency_hz.len()
    }

    pub(crate) fn resolution_hz(&self) -> f64 {
        self.frequency_hz.first().copied().unwrap_or(0.0)
    }

    pub(crate) fn coherence(&self, k: usize) -> f64 {
        let power = self.input[k] * self.output[k];
        let cross = self.cross[k].0 * self.cross[k].0 + self.cross[k].1 * self.cross[k].1;
        if power > 0.0 { (cross / power).min(1.0) } else { 0.0 }
    }

    /// Bounds of the coherence at standard normal quantile `z`: artanh γ is nearly normal with
    /// variance 1/(2 n_d − 2) and bias half that ratio (Bendat and Piersol 2010, eq 9.78–9.81).
    pub(crate) fn coherence_bounds(&self, k: usize, z: f64) -> (f64, f64) {
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
    pub(crate) fn significance(&self, risk: f64) -> f64 {
        1.0 - risk.powf(1.0 / (self.averages - 1.0).max(0.1))
    }

    /// H1 = cross density over that of the input, (real, imaginary).
    pub(crate) fn response(&self, k: usize) -> (f64, f64) {
        let u = self.input[k];
        if u > 0.0 { (self.cross[k].0 / u, self.cross[k].1 / u) } else { (0.0, 0.0) }
    }

    /// Radius of the disk about H1 that holds the response with probability 1 − `risk`:
    /// r² = (2/(n − 2)) F_{2, n−2} (1 − γ²) G_yy/G_uu with n = 2 n_d (Bendat and Piersol 2010,
    /// eq 9.94); the quantile of F with 2 and m degrees of freedom is (m/2)(risk^{−2/m} − 1).
    pub(crate) fn radius(&self, k: usize, risk: f64) -> f64 {
        let quantile = risk.powf(-1.0 / (self.averages - 1.0).max(0.1)) - 1.0;
        (quantile * self.noise_to_input(k)).sqrt()
    }

    /// Power of what the input does not explain in the output, over that of the input.
    fn noise_to_input(&self, k: usize) -> f64 {
        let u = self.input[k];
        let noise = self.noise(k);
        if u > 0.0 { noise / u } else { f64::INFINITY }
    }

    /// Power density of what the input does not explain in the output, (1 − γ²) G_yy.
    pub(crate) fn noise(&self, k: usize) -> f64 {
        (1.0 - self.coherence(k)) * self.output[k]
    }
}

/// Windows of one length, each half over the one before, in so many samples.
pub(crate) fn count(samples: usize, length: usize) -> usize {
    if samples < length { 0 } else { (samples - length) / (length / 2) + 1 }
}

/// Sums of windows' transforms, to which recordings are added piece by piece.
#[derive(Debug, Clone)]
pub(crate) struct Sums {
    transform: Transform,
    /// |U|², |Y|² and U*Y at each frequency.
    sum: Vec<[f64; 4]>,
    windows: usize,
    /// Variance of the averages, in windows squared.
    variance: f64,
    /// Samples of the segment that no later window can do without.
    rest: [Vec<f64>; 2],
    of_segment: usize,
}

impl Sums {
    /// For windows of so many samples, a power of two of at least 2.
    pub(crate) fn new(length: usize) -> Self {
        Self {
            transform: Transform::new(length),
            sum: vec![[0.0; 4]; length / 2],
            windows: 0,
            variance: 0.0,
            rest: [Vec::new(), Vec::new()],
            of_segment: 0,
        }
    }

    pub(crate) fn of_sample_time(sample_time_s: f64) -> Self {
        let samples = (WINDOW_S / sample_time_s).ceil().clamp(16.0, 65_536.0) as usize;
        Self::new(samples.next_power_of_two())
    }

    pub(crate) fn length(&self) -> usize {
        2 * self.sum.len()
    }

    pub(crate) fn push(&mut self, input: &[f64], output: &[f64]) {
        let n = input.len().min(output.len());
        self.rest[0].extend_from_slice(&input[..n]);
        self.rest[1].extend_from_slice(&output[..n]);
        let (length, half) = (self.length(), self.sum.len());
        let count = count(self.rest[0].len(), length);
        for i in 0..count {
            let at = i * half..i * half + length;
            self.transform.add(&self.rest[0][at.clone()], &self.rest[1][at], &mut self.sum);
        }
        self.of_segment += count;
        self.rest.iter_mut().for_each(|x| drop(x.drain(..count * half)));
    }

    /// No window straddles what was added and what is added next.
    pub(crate) fn end_segment(&mut self) {
        self.rest.iter_mut().for_each(Vec::clear);
        let k = std::mem::take(&mut self.of_segment);
        self.windows += k;
        self.variance += k as f64 + 2.0 * (k.saturating_sub(1)) as f64 * OVERLAP;
    }

    /// Adds what another has of windows of the same length, both of whole segments.
    pub(crate) fn merge(&mut self, other: &Self) {
        for (a, b) in self.sum.iter_mut().zip(&other.sum) {
            a.iter_mut().zip(b).for_each(|(a, b)| *a += b);
        }
        self.windows += other.windows;
        self.variance += other.variance;
    }

    pub(crate) fn spectra(&self, sample_time_s: f64) -> Spectra {
        let (bins, all) = (self.sum.len(), self.windows);
        let power: f64 = self.transform.window.iter().map(|w| w * w).sum();
        let scale = |k: usize| {
            // The density at half the sample rate has no mirror image.
            let sides = if k + 1 == bins { 1.0 } else { 2.0 };
            sides * sample_time_s / (power * all.max(1) as f64)
        };
        let density = |part: usize| (0..bins).map(|k| scale(k) * self.sum[k][part]).collect();
        let resolution_hz = 1.0 / (self.length() as f64 * sample_time_s);
        Spectra {
            frequency_hz: (1..=bins).map(|k| k as f64 * resolution_hz).collect(),
            input: density(0),
            output: density(1),
            cross: (0..bins)
                .map(|k| (scale(k) * self.sum[k][2], scale(k) * self.sum[k][3]))
                .collect(),
            windows: all,
            averages: if all > 0 { (all as f64).powi(2) / self.variance } else { 0.0 },
        }
    }

    /// The numbers, to be read by [`Self::from_numbers`].
    pub(crate) fn to_numbers(&self) -> Vec<f64> {
        let head = [self.windows as f64, self.variance];
        head.into_iter().chain(self.sum.iter().flatten().copied()).collect()
    }

    /// The spectra of [`Self::to_numbers`]; `None` for numbers that no recording has.
    pub(crate) fn from_numbers(numbers: &[f64]) -> Option<Self> {
        let [windows, variance, sum @ ..] = numbers else { return None };
        let (sum, rest) = sum.as_chunks::<4>();
        let is_power = |[u, y, ..]: &[f64; 4]| *u >= 0.0 && *y >= 0.0;
        let count = *windows >= 0.0 && *windows < 9e15 && windows.fract() == 0.0;
        let sound = numbers.iter().all(|x| x.is_finite())
            && rest.is_empty()
            && sum.len().is_power_of_two()
            && sum.len() <= 65_536
            && sum.iter().all(is_power)
            && *variance >= *windows;
        if count && sound {
            Some(Self {
                sum: sum.to_vec(),
                windows: *windows as usize,
                variance: *variance,
                ..Self::new(2 * sum.len())
            })
        } else {
            None
        }
    }
}

/// Windowed discrete Fourier transform of one length, a power of two.
#[derive(Debug, Clone)]
pub(crate) struct Transform {
    pub(crate) window: Vec<f64>,
    /// e^{−2πjk/L} for k below L/2.
    twiddles: Vec<(f64, f64)>,
}

impl Transform {
    /// Of a power of two.
    pub(crate) fn new(length: usize) -> Self {
        let angle = |k: usize| 2.0 * PI * k as f64 / length as f64;
        Self {
            window: (0..length).map(|i| 0.5 - 0.5 * angle(i).cos()).collect(),
            twiddles: (0..length / 2).map(|k| (angle(k).cos(), -angle(k).sin())).collect(),
        }
    }

    /// Adds |U|², |Y|² and U*Y at the frequencies 1 to L/2 of one window.
    fn add(&self, u: &[f64], y: &[f64], sum: &mut [[f64; 4]]) {
        // In one complex transform, a large signal's rounding would be taken for a small signal.
        let (u, y) = (self.spectrum(u), self.spectrum(y));
        for (sum, (u, y)) in sum.iter_mut().zip(u[1..].iter().zip(&y[1..])) {
            sum[0] += u.0 * u.0 + u.1 * u.1;
            sum[1] += y.0 * y.0 + y.1 * y.1;
            sum[2] += u.0 * y.0 + u.1 * y.1;
            sum[3] += u.0 * y.1 - u.1 * y.0;
        }
    }

    /// The transform of one window less its mean, windowed.
    pub(crate) fn spectrum(&self, x: &[f64]) -> Vec<(f64, f64)> {
        let m = mean(x);
        let mut z: Vec<(f64, f64)> =
            x.iter().zip(&self.window).map(|(x, w)| ((x - m) * w, 0.0)).collect();
        self.transform(&mut z);
        z
    }

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

#[cfg(test)]
mod tests;
