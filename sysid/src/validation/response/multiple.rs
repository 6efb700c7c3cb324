//! Spectra of several inputs and one or more outputs by Welch's method: the frequency responses of all inputs together,
//! `H = S_yu S_uu⁻¹`, the multiple coherence `S_yu S_uu⁻¹ S_uy / S_yy`, and their confidence (Bendat and Piersol, *Random
//! Data*, 4th ed. 2010, sections 7.3 and 9.3). With one input they are H1 and the coherence of
//! [`spectra`](crate::validation::response::spectra).

use crate::data::{DataSet, Segment};
use crate::validation::response::spectra::{OVERLAP, Transform, count};
use faer::linalg::solvers::Solve;
use faer::{Mat, c64};

/// Windows at least, and independent averages for each input.
const LEAST_WINDOWS: usize = 7;
const AVERAGES: f64 = 4.0;
/// Samples of the longest window.
const LONGEST: usize = 1024;
const SHORTEST: usize = 16;

/// Responses at frequencies above 0.
pub(crate) struct MultipleSpectra {
    /// Frequencies, Hz, up to half the sample rate.
    pub(crate) frequency_hz: Vec<f64>,
    /// Independent averages n_d.
    averages: f64,
    inputs: usize,
    points: Vec<Point>,
}

struct Point {
    /// ny by nu.
    response: Mat<c64>,
    /// Multiple coherence of each output.
    coherence: Vec<f64>,
    /// Of each output and input: power of what the inputs do not explain times the entry of S_uu⁻¹.
    noise_to_input: Mat<f64>,
}

impl MultipleSpectra {
    /// Of all segments; no frequencies where there are too few windows for so many inputs.
    pub(crate) fn welch(data: &DataSet) -> Self {
        let (m, p) = (data.inputs(), data.outputs());
        let windows = |length: usize| -> usize {
            data.segments().iter().map(|s| count(s.len(), length)).sum()
        };
        let averages = |length: usize| {
            let variance = |s: &Segment| {
                let k = count(s.len(), length);
                k as f64 + 2.0 * k.saturating_sub(1) as f64 * OVERLAP
            };
            let variance: f64 = data.segments().iter().map(variance).sum();
            if variance > 0.0 { (windows(length) as f64).powi(2) / variance } else { 0.0 }
        };
        let is_enough = |length: usize| {
            windows(length) >= LEAST_WINDOWS && averages(length) >= AVERAGES * m as f64
        };
        let mut length = SHORTEST;
        while 2 * length <= LONGEST && is_enough(2 * length) {
            length *= 2;
        }
        let none = Self { frequency_hz: vec![], averages: 0.0, inputs: m, points: vec![] };
        if !is_enough(length) {
            return none;
        }
        let bins = length / 2;
        let width = m + p;
        let mut sums = vec![Mat::<c64>::zeros(width, width); bins];
        let transform = Transform::new(length);
        for s in data.segments() {
            for window in 0..count(s.len(), length) {
                let at = window * bins..window * bins + length;
                let row = |k: usize| if k < m { s.u.row(k) } else { s.y.row(k - m) };
                let spectra: Vec<Vec<(f64, f64)>> =
                    (0..width).map(|k| transform.spectrum(&row(k)[at.clone()])).collect();
                for (bin, sum) in sums.iter_mut().enumerate() {
                    let z = |k: usize| c64::new(spectra[k][bin + 1].0, spectra[k][bin + 1].1);
                    for i in 0..width {
                        for j in 0..width {
                            sum[(i, j)] += z(i) * z(j).conj();
                        }
                    }
                }
            }
        }
        let step = data.sample_time_s();
        let mut found = Self { averages: averages(length), ..none };
        for (bin, sum) in sums.iter().enumerate() {
            if let Some(point) = Point::new(sum, m) {
                found.frequency_hz.push((bin + 1) as f64 / (length as f64 * step));
                found.points.push(point);
            }
        }
        found
    }

    /// Gain and phase (rad) of a pair at the k-th frequency.
    pub(crate) fn response(&self, output: usize, input: usize, k: usize) -> (f64, f64) {
        let h = self.points[k].response[(output, input)];
        (h.re.hypot(h.im), h.im.atan2(h.re))
    }

    /// Multiple coherence of an output at the k-th frequency, 0 to 1.
    pub(crate) fn coherence(&self, output: usize, k: usize) -> f64 {
        self.points[k].coherence[output]
    }

    /// Radius of the disk about the response that holds it with probability 1 − `risk`: `r² = (2/ν) F_{2,ν} (1 − γ²) G_yy
    /// [G_uu⁻¹]_jj` with ν = 2(n_d − nu) (Bendat and Piersol 2010, eq 9.106).
    pub(crate) fn radius(&self, output: usize, input: usize, k: usize, risk: f64) -> f64 {
        let free = (self.averages - self.inputs as f64).max(0.1);
        let quantile = risk.powf(-1.0 / free) - 1.0;
        (quantile * self.points[k].noise_to_input[(output, input)]).max(0.0).sqrt()
    }

    /// What the multiple coherence of unrelated signals stays below with probability 1 − `risk`: it has a beta distribution
    /// with nu and n_d − nu.
    pub(crate) fn significance(&self, risk: f64) -> f64 {
        let (trials, inputs) = (self.averages.round().max(1.0) as usize - 1, self.inputs);
        if trials < inputs {
            return 1.0;
        }
        // P(γ² > x) of a beta distribution of whole numbers is that of fewer than nu successes.
        let beyond = |x: f64| {
            let mut term = (1.0 - x).powi(trials as i32);
            let mut sum = 0.0;
            for k in 0..inputs {
                sum += term;
                term *= (trials - k) as f64 / (k + 1) as f64 * x / (1.0 - x);
            }
            sum
        };
        let (mut low, mut high) = (0.0, 1.0 - 1e-12);
        for _ in 0..60 {
            let middle = 0.5 * (low + high);
            if beyond(middle) > risk { low = middle } else { high = middle }
        }
        high
    }
}

impl Point {
    /// Of the sums of z zᴴ of inputs and outputs; `None` where an input has no power of its own.
    fn new(sum: &Mat<c64>, inputs: usize) -> Option<Self> {
        let outputs = sum.nrows() - inputs;
        let power = |k: usize| sum[(k, k)].re;
        if (0..inputs).any(|k| power(k).is_nan() || power(k) <= 0.0) {
            return None;
        }
        let own = sum.get(..inputs, ..inputs);
        let inverse = own.partial_piv_lu().solve(Mat::<c64>::identity(inputs, inputs));
        let cross = sum.get(inputs.., ..inputs);
        let response = cross * &inverse;
        let mut coherence = Vec::new();
        let mut noise_to_input = Mat::zeros(outputs, inputs);
        for i in 0..outputs {
            let mut explained = c64::new(0.0, 0.0);
            for j in 0..inputs {
                explained += response[(i, j)] * sum[(j, inputs + i)];
            }
            let all = power(inputs + i);
            let share = if all > 0.0 { (explained.re / all).clamp(0.0, 1.0) } else { 0.0 };
            coherence.push(share);
            for j in 0..inputs {
                noise_to_input[(i, j)] = (1.0 - share) * all * inverse[(j, j)].re;
            }
        }
        let is_finite =
            response.col_iter().flat_map(|c| c.iter()).all(|h| (h.re + h.im).is_finite());
        if is_finite { Some(Self { response, coherence, noise_to_input }) } else { None }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::data::Signals;
    use crate::validation::residuals::correlation::tests::noise;
    use crate::validation::response::spectra::Spectra;

    fn white(count: usize, state: &mut u64) -> Vec<f64> {
        (0..count).map(|_| noise(state)).collect()
    }

    /// With one input it is the method of one input; its own windows are of the length of these data.
    #[test]
    fn of_one_input_it_is_h1() {
        let state = &mut 5;
        let u = white(1500, state);
        let y: Vec<f64> = (0..1500)
            .map(|t| if t > 1 { u[t - 1] - 0.4 * u[t - 2] } else { 0.0 } + 0.5 * noise(state))
            .collect();
        let one = Spectra::welch(&[(&u, &y)], 7.0 / 256.0);
        let data = DataSet::single(7.0 / 256.0, u, y).unwrap();
        let several = MultipleSpectra::welch(&data);
        let same: Vec<(usize, usize)> = (0..one.len())
            .filter_map(|k| {
                let near = |f: &f64| (f / one.frequency_hz[k] - 1.0).abs() < 1e-9;
                Some((k, several.frequency_hz.iter().position(near)?))
            })
            .collect();
        assert!(same.len() > 20);
        if one.len() == several.frequency_hz.len() {
            for (a, b) in same {
                let (re, im) = one.response(a);
                let (gain, phase) = several.response(0, 0, b);
                assert!((gain - re.hypot(im)).abs() < 1e-9 && (phase - im.atan2(re)).abs() < 1e-9);
                assert!((one.coherence(a) - several.coherence(0, b)).abs() < 1e-9);
                assert!((one.radius(a, 0.05) / several.radius(0, 0, b, 0.05) - 1.0).abs() < 1e-9);
            }
        }
        assert!((one.significance(0.05) - several.significance(0.05)).abs() < 0.02);
    }

    /// Two inputs that correlate: each response is its own, and the truth is in 95 of 100 disks; unrelated signals exceed
    /// the coherence of chance at one frequency in twenty.
    #[test]
    fn correlated_inputs_have_responses_of_their_own() {
        let (mut inside, mut all, mut beyond) = (0.0, 0.0, 0.0);
        for seed in 1..40 {
            let state = &mut (100 + seed);
            let (a, b) = (white(4000, state), white(4000, state));
            let u = [a.clone(), a.iter().zip(&b).map(|(a, b)| 0.7 * a + b).collect::<Vec<f64>>()];
            let y = |t: usize| if t > 0 { 2.0 * u[0][t - 1] - 0.5 * u[1][t] } else { 0.0 };
            let data =
                DataSet::single(
                    1.0,
                    Signals::from_fn(2, 4000, |i, t| u[i][t]),
                    Signals::from_fn(2, 4000, |i, t| {
                        if i == 0 { y(t) + noise(state) } else { noise(state) }
                    }),
                )
                .unwrap();
            let found = MultipleSpectra::welch(&data);
            for (k, hz) in found.frequency_hz.iter().enumerate().filter(|(k, _)| k % 7 == 3) {
                let w = std::f64::consts::TAU * hz;
                for (input, truth) in [(0, (2.0 * w.cos(), -2.0 * w.sin())), (1, (-0.5, 0.0))] {
                    let (gain, phase) = found.response(0, input, k);
                    let apart = (gain * phase.cos() - truth.0).hypot(gain * phase.sin() - truth.1);
                    inside += f64::from(u8::from(apart < found.radius(0, input, k, 0.05)));
                    all += 1.0;
                }
                beyond += f64::from(u8::from(found.coherence(1, k) > found.significance(0.05)));
            }
        }
        let (inside, beyond) = (inside / all, 2.0 * beyond / all);
        println!("inside {inside:.3}, beyond chance {beyond:.3}");
        assert!((0.92..0.98).contains(&inside), "{inside}");
        assert!((0.02..0.09).contains(&beyond), "{beyond}");
    }
}
