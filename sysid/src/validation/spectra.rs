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

use drivelog::signal::mean;
use std::f64::consts::PI;

/// A window lasts about so long, s: a resolution of about 0.1 Hz.
const WINDOW_S: f64 = 7.0;
/// … but is shortened until there are that many windows.
const LEAST_WINDOWS: usize = 7;
/// Correlation of the spectra of two neighbouring windows: (Σ w(i) w(i + L/2) / Σ w(i)²)².
const OVERLAP: f64 = 1.0 / 36.0;

/// One-sided spectral densities at frequencies above 0, averaged over windows.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Spectra {
    /// Frequencies, Hz, without 0, up to half the sample rate.
    pub(crate) frequency_hz: Vec<f64>,
    /// Power density of the input, its unit squared per Hz.
    pub(crate) input: Vec<f64>,
    /// Power density of the output.
    pub(crate) output: Vec<f64>,
    /// Cross density from input to output as (real, imaginary).
    pub(crate) cross: Vec<(f64, f64)>,
    /// Windows averaged.
    pub(crate) windows: usize,
    /// Independent averages n_d.
    pub(crate) averages: f64,
}

impl Spectra {
    /// Spectra of stretches of (input, output) at one sample time.
    pub(crate) fn welch(stretches: &[(&[f64], &[f64])], sample_time_s: f64) -> Self {
        let samples = |(u, y): &(&[f64], &[f64])| u.len().min(y.len());
        let windows =
            |length: usize| -> usize { stretches.iter().map(|s| count(samples(s), length)).sum() };
        let mut length = 16;
        while (length as f64) * sample_time_s < WINDOW_S && windows(2 * length) >= LEAST_WINDOWS {
            length *= 2;
        }
        while length > 2 && windows(length) == 0 {
            length /= 2;
        }
        let mut sums = Sums::new(length);
        for (u, y) in stretches {
            sums.push(u, y);
            sums.end_stretch();
        }
        sums.spectra(sample_time_s)
    }

    /// Number of frequencies.
    pub(crate) fn len(&self) -> usize {
        self.frequency_hz.len()
    }

    /// Distance of two frequencies, Hz.
    pub(crate) fn resolution_hz(&self) -> f64 {
        self.frequency_hz.first().copied().unwrap_or(0.0)
    }

    /// Magnitude-squared coherence γ² at a frequency, 0 to 1.
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

/// Windows of a length with half overlap in so many samples.
fn count(samples: usize, length: usize) -> usize {
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
    /// Samples of the stretch that no later window can do without.
    rest: [Vec<f64>; 2],
    /// Windows of the stretch so far.
    of_stretch: usize,
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
            of_stretch: 0,
        }
    }

    /// For recordings of unknown length.
    pub(crate) fn of_sample_time(sample_time_s: f64) -> Self {
        let samples = (WINDOW_S / sample_time_s).ceil().clamp(16.0, 65_536.0) as usize;
        Self::new(samples.next_power_of_two())
    }

    /// Samples of a window.
    pub(crate) fn length(&self) -> usize {
        2 * self.sum.len()
    }

    /// Adds samples that follow those before.
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
        self.of_stretch += count;
        self.rest.iter_mut().for_each(|x| drop(x.drain(..count * half)));
    }

    /// No window straddles what was added and what is added next.
    pub(crate) fn end_stretch(&mut self) {
        self.rest.iter_mut().for_each(Vec::clear);
        let k = std::mem::take(&mut self.of_stretch);
        self.windows += k;
        self.variance += k as f64 + 2.0 * (k.saturating_sub(1)) as f64 * OVERLAP;
    }

    /// Adds what another has of windows of the same length, both of whole stretches.
    pub(crate) fn merge(&mut self, other: &Self) {
        for (a, b) in self.sum.iter_mut().zip(&other.sum) {
            a.iter_mut().zip(b).for_each(|(a, b)| *a += b);
        }
        self.windows += other.windows;
        self.variance += other.variance;
    }

    /// Averages over the windows of all stretches that were ended.
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

    /// What [`Self::to_numbers`] gave; `None` for numbers that no recording gives.
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
        (count && sound).then(|| Self {
            sum: sum.to_vec(),
            windows: *windows as usize,
            variance: *variance,
            ..Self::new(2 * sum.len())
        })
    }
}

/// Windowed discrete Fourier transform of one length, a power of two.
#[derive(Debug, Clone)]
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
        // One after the other: in one complex transform, the rounding of a large signal would be
        // taken for a small or constant one.
        let (u, y) = (self.of(u), self.of(y));
        for (sum, (u, y)) in sum.iter_mut().zip(u[1..].iter().zip(&y[1..])) {
            sum[0] += u.0 * u.0 + u.1 * u.1;
            sum[1] += y.0 * y.0 + y.1 * y.1;
            sum[2] += u.0 * y.0 + u.1 * y.1;
            sum[3] += u.0 * y.1 - u.1 * y.0;
        }
    }

    /// The transform of one signal without its mean.
    fn of(&self, x: &[f64]) -> Vec<(f64, f64)> {
        let m = mean(x);
        let mut z: Vec<(f64, f64)> =
            x.iter().zip(&self.window).map(|(x, w)| ((x - m) * w, 0.0)).collect();
        self.transform(&mut z);
        z
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

#[cfg(test)]
mod tests {
    use super::*;

    fn near(got: f64, expected: f64) {
        assert!((got - expected).abs() <= 1e-9 * expected.abs() + 1e-13, "{got:e} {expected:e}");
    }

    /// Printed by SciPy 1.17.1:
    /// ```python
    /// import numpy as np; from scipy import signal
    /// k = np.arange(1200); f = lambda k: np.sin(.001*k*k) + .5*np.cos(.3*k)
    /// u = f(k); y = u + .5*f(k-2) + .2*np.cos(.0037*k*k) + 3
    /// o = dict(fs=25, window='hann', nperseg=256, noverlap=128, detrend='constant')
    /// for a in (signal.welch(u, **o), signal.welch(y, **o), signal.csd(u, y, **o),
    ///           signal.coherence(u, y, **o)): print(repr(a[0][[1,12,40,128]]), repr(a[1][[1,12,40,128]]))
    /// ```
    #[test]
    fn spectra_are_those_of_scipy() {
        let f = |k: f64| (0.001 * k * k).sin() + 0.5 * (0.3 * k).cos();
        let k: Vec<f64> = (0..1200).map(f64::from).collect();
        let u: Vec<f64> = k.iter().map(|k| f(*k)).collect();
        let y: Vec<f64> = k
            .iter()
            .map(|k| f(*k) + 0.5 * f(k - 2.0) + 0.2 * (0.0037 * k * k).cos() + 3.0)
            .collect();
        let s = Spectra::welch(&[(&u, &y)], 0.04);
        assert_eq!((s.len(), s.windows), (128, 8));
        let frequency = [0.097_656_25, 1.171_875, 3.906_25];
        let input = [6.646_628_456_158_351e-3, 8.136_788_713_824_805e-1, 7.195_445_206_938_066e-2];
        let output = [1.799_382_159_613_037e-2, 1.735_516_459_418_689, 6.443_647_133_913_034e-2];
        let cross = [
            (1.030_784_085_905_662e-2, -5.312_577_148_399_713e-5),
            (1.164_960_508_434_825, -2.328_697_960_386_887e-1),
            (5.805_949_577_322_397e-2, -3.358_174_335_518_337e-2),
        ];
        let coherence =
            [8.884_277_863_116_303e-1, 9.994_393_342_617_816e-1, 9.702_679_348_198_384e-1];
        for (i, k) in [0, 11, 39].into_iter().enumerate() {
            near(s.frequency_hz[k], frequency[i]);
            near(s.input[k], input[i]);
            near(s.output[k], output[i]);
            near(s.cross[k].0, cross[i].0);
            near(s.cross[k].1, cross[i].1);
            near(s.coherence(k), coherence[i]);
        }
        near(s.frequency_hz[127], 12.5);
        near(s.output[127], 1.140_712_587_795_038e-3);
    }

    /// A small repeatable normal noise: the sum of twelve uniform numbers.
    fn noise(state: &mut u64) -> f64 {
        let mut uniform = || {
            *state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
            (*state >> 33) as f64 / f64::from(1_u32 << 31)
        };
        (0..12).map(|_| uniform()).sum::<f64>() - 6.0
    }

    /// Bounds hold as often as they say, over many seeds and frequencies: the response of
    /// y(t) = u(t) + u(t−1) + e(t), its coherence, and that of unrelated signals.
    #[test]
    fn bands_hold_as_often_as_they_say() {
        let mut state = 1;
        let [mut all, mut inside, mut covered, mut alarms] = [0.0; 4];
        for _ in 0..60 {
            let u: Vec<f64> = (0..2001).map(|_| noise(&mut state)).collect();
            let v: Vec<f64> = (0..2000).map(|_| noise(&mut state)).collect();
            let y: Vec<f64> = (0..2000).map(|t| u[t + 1] + u[t] + v[t]).collect();
            let s = Spectra::welch(&[(&u[1..], &y)], 0.04);
            let unrelated = Spectra::welch(&[(&u[1..], &v)], 0.04);
            for k in 0..100 {
                let omega = PI * (k + 1) as f64 / s.len() as f64;
                let truth = (1.0 + omega.cos(), -omega.sin());
                let power = truth.0 * truth.0 + truth.1 * truth.1;
                let got = s.response(k);
                let apart = (got.0 - truth.0).hypot(got.1 - truth.1);
                let (low, high) = s.coherence_bounds(k, 1.96);
                all += 1.0;
                inside += f64::from(u8::from(apart <= s.radius(k, 0.05)));
                covered += f64::from(u8::from((low..=high).contains(&(power / (power + 1.0)))));
                alarms +=
                    f64::from(u8::from(unrelated.coherence(k) > unrelated.significance(0.01)));
            }
        }
        let [inside, covered, alarms] = [inside / all, covered / all, alarms / all];
        println!("response {inside:.4}, coherence {covered:.4}, false alarms {alarms:.4}");
        assert!((inside - 0.95).abs() < 0.015, "{inside}");
        assert!((covered - 0.95).abs() < 0.015, "{covered}");
        assert!((0.005..0.016).contains(&alarms), "{alarms}");
    }

    /// The gain's scatter over seeds is its standard error, with several stretches as with one.
    #[test]
    fn standard_errors_are_the_scatter() {
        for parts in [1, 5] {
            let mut state = 5;
            let (mut squares, mut predicted, mut count) = (0.0, 0.0, 0.0);
            for _ in 0..40 {
                let u: Vec<f64> = (0..3000).map(|_| noise(&mut state)).collect();
                let y: Vec<f64> = u.iter().map(|u| u + 0.5 * noise(&mut state)).collect();
                let length = u.len() / parts;
                let stretches: Vec<_> = u.chunks(length).zip(y.chunks(length)).collect();
                let s = Spectra::welch(&stretches, 0.04);
                for k in 2..100 {
                    let (re, im) = s.response(k);
                    squares += (re.hypot(im) - 1.0).powi(2);
                    predicted += s.noise_to_input(k) / (2.0 * s.averages.max(1.0));
                    count += 1.0;
                }
            }
            let ratio = (squares / predicted).sqrt();
            println!(
                "{parts} stretches: scatter {:.4}, ratio {ratio:.3}",
                f64::sqrt(squares / count)
            );
            assert!((0.92..1.08).contains(&ratio), "{ratio}");
        }
    }

    /// In pieces of any length, merged and through numbers, as in one.
    #[test]
    fn pieces_give_what_the_whole_gives() {
        let mut state = 9;
        let u: Vec<f64> = (0..3000).map(|_| noise(&mut state)).collect();
        let y: Vec<f64> = (0..3000).map(|_| noise(&mut state)).collect();
        let whole = Spectra::welch(&[(&u[..2000], &y[..2000]), (&u[2000..], &y[2000..])], 0.04);
        let mut parts = [2000, 1000].map(|_| Sums::of_sample_time(0.04));
        for (part, range) in parts.iter_mut().zip([0..2000, 2000..3000]) {
            for (u, y) in u[range.clone()].chunks(37).zip(y[range].chunks(37)) {
                part.push(u, y);
            }
            part.end_stretch();
        }
        let [mut first, second] = parts;
        first.merge(&Sums::from_numbers(&second.to_numbers()).unwrap_or_else(|| Sums::new(2)));
        assert_eq!(first.length(), 256);
        let got = first.spectra(0.04);
        assert_eq!((got.windows, got.averages), (whole.windows, whole.averages));
        for k in 0..got.len() {
            near(got.output[k], whole.output[k]);
            near(got.cross[k].1, whole.cross[k].1);
        }
        let mut wrong = second.to_numbers();
        wrong[2] = -1.0;
        assert!(Sums::from_numbers(&wrong).is_none() && Sums::from_numbers(&[1.0]).is_none());
    }

    #[test]
    fn no_window_straddles_two_stretches() {
        let mut state = 3;
        let u: Vec<f64> = (0..1200).map(|_| noise(&mut state)).collect();
        let y: Vec<f64> = u.iter().map(|u| 2.0 * u).collect();
        // A jump between the two would be seen at every frequency.
        let high: Vec<f64> = y[600..].iter().map(|y| y + 1e3).collect();
        let s = Spectra::welch(&[(&u[..600], &y[..600]), (&u[600..], &high)], 0.04);
        for k in 0..s.len() {
            assert!((s.response(k).0 - 2.0).abs() < 1e-9 && s.response(k).1.abs() < 1e-9);
            assert!(s.coherence(k) > 1.0 - 1e-9);
        }
    }

    #[test]
    fn little_or_no_data_gives_no_nonsense() {
        for n in [0, 1, 2, 3, 10, 40] {
            let u: Vec<f64> = (0..n).map(|k| f64::from(k % 3)).collect();
            let s = Spectra::welch(&[(&u, &vec![1.0; u.len()])], 0.04);
            for k in 0..s.len() {
                assert_eq!(s.coherence(k), 0.0);
                assert!(s.response(k).0.is_finite() && !s.significance(0.01).is_nan());
            }
        }
    }
}
