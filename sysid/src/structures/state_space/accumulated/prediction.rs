//! One-step prediction errors of plant and noise together, from the R factor of the windows alone:
//! the model α(q) (y − G u) = e of docs/methods/accumulate.md, by which orders are compared on a
//! [log in memory](crate::selection::in_memory) too.
//!
//! e is the simulation error of G for the signals filtered by α. Of a window of L samples these are
//! known from t = p on. The state x(p) follows from the errors at p … L−2, and what is evaluated is
//! the error at the window's last sample:
//!
//! ```text
//! ε = ỹ(L−1) − (H ũ)(L−1) − φ (ΦᵀΦ + σ²Π⁻¹)⁻¹ Φᵀ [ỹ − H ũ](p … L−2)
//! ```
//!
//! with Φ the rows C Aᵗ, φ the one after them, σ² the variance of e, and Π that of the state which
//! follows from the input before the window, `Π = AΠAᵀ + A z Bᵀ + B zᵀAᵀ + r(0) B Bᵀ` with `z = Σ
//! Aʲ B r(j+1)` and r the autocovariance of ũ: a mode that the input does not drive cannot take up
//! what the noise model leaves. Under feedback ε is no more biased than any direct prediction
//! error. It is a linear combination cᵀh of the window's samples h, of variance ‖R c‖².

use crate::Error;
use crate::linalg::dense::{
    identity, is_finite, least_squares, positive_part, r_factor, solve, spectral_radius,
};
use crate::linalg::levenberg_marquardt::{USUAL, by_more_than, lower};
use crate::model::{StateSpace, free_response};
use crate::pem::{Coordinates, Stop, damped_step};
use crate::structures::state_space::accumulated::windows::Windows;
use faer::{Mat, MatRef, Scale};

/// Samples of a window for each coefficient of the noise, and samples of the drives.
const SHARE: usize = 2;
const SAMPLES: usize = 50;
/// Errors of a smaller share of the output are rounding, without a noise model.
const ROUNDING: f64 = 1e-8;
/// Relative, of the squares that determine a state: a mode that the window does not show stays finite.
const RIDGE: f64 = 1e-10;
/// Step of the derivatives along coordinates whose scale is 1.
const DIFFERENCE: f64 = 1e-6;

/// Plant and noise.
#[derive(Debug, Clone)]
pub(crate) struct PlantAndNoise {
    pub(crate) model: StateSpace,
    /// a_1 … a_p.
    autoregression: Vec<f64>,
    /// σ², where it was estimated; 0 for a state without any information before.
    noise_variance: f64,
}

impl PlantAndNoise {
    /// A plant with a noise model of so many coefficients, found for the plant as it is.
    pub(crate) fn new(windows: &Windows, model: StateSpace, order: usize) -> Result<Self, Error> {
        let v = simulation_errors(windows, &model, order + 1);
        let (past, now) = (v.get(.., 1..), v.get(.., ..1));
        let a = least_squares(past, now, 1e-12)?;
        let noise_variance = (now - past * &a).squared_norm_l2();
        Ok(Self { model, autoregression: (0..order).map(|k| a[(k, 0)]).collect(), noise_variance })
    }

    /// How many coefficients the noise that a model leaves has by Akaike's criterion.
    pub(crate) fn noise_order(windows: &Windows, model: &StateSpace) -> usize {
        let samples = windows.count as f64;
        let most = (windows.length / SHARE).min(windows.count / SAMPLES);
        let v = simulation_errors(windows, model, most + 1);
        let size = v.col(0).norm_l2();
        if !(size.is_finite() && size > ROUNDING * windows.covariance(1, 1, 0).sqrt()) {
            return 0;
        }
        // Regressors first: the rows below the first p hold what p of them leave of the last column.
        let ordered = Mat::from_fn(v.nrows(), most + 1, |i, j| v[(i, (j + 1) % (most + 1))]);
        let r = r_factor(ordered.as_ref());
        let left = |p: usize| (p..=most).map(|i| r[(i, most)].powi(2)).sum::<f64>();
        let criterion = |p: usize| samples * left(p).max(f64::MIN_POSITIVE).ln() + 2.0 * p as f64;
        (0..=most).min_by(|a, b| criterion(*a).total_cmp(&criterion(*b))).unwrap_or(0)
    }

    /// Variance of the prediction errors; ∞ where they are not finite.
    pub(crate) fn variance(&self, windows: &Windows) -> f64 {
        let error = self.errors(windows);
        let squares = error.iter().map(|e| e * e).sum::<f64>();
        if squares.is_finite() { squares } else { f64::INFINITY }
    }

    /// Makes the prediction errors small; models of a spectral radius of `radius` or more are refused.
    pub(crate) fn refined(
        self,
        windows: &Windows,
        feedthrough: bool,
        stop: Stop,
        radius: f64,
    ) -> Result<Self, Error> {
        let reached = lower::<_, _, Error>(
            (self, 1.0),
            stop.steps,
            USUAL,
            by_more_than(stop.least_gain),
            // With σ² of the step before.
            |at: &Self, cost| {
                *cost = at.variance(windows);
                if cost.is_finite() && *cost > 0.0 {
                    at.linearised(windows, feedthrough).map(Some)
                } else {
                    Ok(None)
                }
            },
            |at, (coordinates, r), damping| {
                let count = r.ncols() - 1;
                let rows = r.nrows().min(count);
                let (left, right) = (r.get(..rows, ..count), r.get(..rows, count..));
                let trial = at.moved(coordinates, &damped_step(left, right, damping, 0)?);
                if spectral_radius(trial.model.a.as_ref()) < radius {
                    let noise_variance = trial.variance(windows);
                    return Ok(Some((Self { noise_variance, ..trial }, noise_variance)));
                }
                Ok(None)
            },
        )?;
        Ok(reached.point)
    }

    /// The model moved along local coordinates of the plant and coefficients of the noise.
    fn moved(&self, at: &Coordinates, step: &[f64]) -> Self {
        let (plant, noise) = step.split_at(at.count());
        let autoregression = self.autoregression.iter().zip(noise).map(|(a, d)| a + d).collect();
        Self { model: at.moved(plant), autoregression, noise_variance: self.noise_variance }
    }

    /// R of the derivatives along these, and last the errors' column.
    fn linearised(
        &self,
        windows: &Windows,
        feedthrough: bool,
    ) -> Result<(Coordinates, Mat<f64>), Error> {
        let at = Coordinates::new(&self.model, &identity(1), &[feedthrough])?;
        let mut step = vec![0.0; at.count() + self.autoregression.len()];
        let here = self.moved(&at, &step).errors(windows);
        let mut derivatives = Mat::zeros(here.len(), step.len() + 1);
        for k in 0..step.len() {
            step[k] = DIFFERENCE;
            let there = self.moved(&at, &step).errors(windows);
            step[k] = 0.0;
            for (i, (there, here)) in there.iter().zip(&here).enumerate() {
                derivatives[(i, k)] = (here - there) / DIFFERENCE;
            }
        }
        for (i, e) in here.iter().enumerate() {
            derivatives[(i, step.len())] = *e;
        }
        Ok((at, r_factor(derivatives.as_ref())))
    }

    /// ε of each row of R.
    fn errors(&self, windows: &Windows) -> Vec<f64> {
        let weights = self.error_weights(windows);
        let c = self.of_samples(&weights, windows.length);
        windows.times(&c)
    }

    /// Weights β of the errors at p … L−1 of the signals through α, simulated from rest, in ε.
    fn error_weights(&self, windows: &Windows) -> Vec<f64> {
        let free = free_response(&self.model, windows.length - self.autoregression.len());
        let last = free.nrows() - 1;
        let state = self.state_weights(windows, &free);
        let phi = free.get(last..last + 1, ..);
        let explained = phi * state;
        (0..last).map(|t| -explained[(0, t)]).chain([1.0]).collect()
    }

    /// (ΦᵀΦ + σ²Π⁻¹)⁻¹Φᵀ of all rows but the last.
    fn state_weights(&self, windows: &Windows, free: &Mat<f64>) -> Mat<f64> {
        let seen = free.get(..free.nrows() - 1, ..);
        let squares = seen.transpose() * seen;
        let n = squares.nrows();
        let spread = if self.noise_variance > 0.0 { self.state_covariance(windows) } else { None };
        // Π (ΦᵀΦ Π + σ²)⁻¹ Φᵀ, which needs no inverse of Π.
        let mut left = match spread.as_ref() {
            Some(spread) => &squares * spread,
            None => squares.clone(),
        };
        let ridge = RIDGE * (0..n).map(|i| left[(i, i)].abs()).sum::<f64>();
        let noise_variance = if spread.is_some() { self.noise_variance } else { 0.0 };
        (0..n).for_each(|i| left[(i, i)] += noise_variance + ridge);
        let weights = solve(left.as_ref(), seen.transpose());
        match spread {
            Some(spread) => spread * weights,
            None => weights,
        }
    }

    /// Π of the signals through α; `None` of a model that is not stable.
    fn state_covariance(&self, windows: &Windows) -> Option<Mat<f64>> {
        let alpha: Vec<f64> =
            [1.0].into_iter().chain(self.autoregression.iter().map(|a| -a)).collect();
        let (lags, p) = (windows.length, self.autoregression.len());
        let taps: Vec<f64> =
            (0..=p).map(|k| (0..=p - k).map(|i| alpha[i] * alpha[i + k]).sum()).collect();
        let filtered = |lag: usize| -> f64 {
            let of = |k: usize| windows.input.get(k).copied().unwrap_or(0.0);
            let both = (1..=p).map(|k| taps[k] * (of(lag + k) + of(lag.abs_diff(k))));
            taps[0] * of(lag) + both.sum::<f64>()
        };
        let (a, b) = (&self.model.a, &self.model.b);
        let (mut z, mut driven) = (Mat::<f64>::zeros(a.nrows(), 1), b.clone());
        for lag in 1..lags + p {
            z = &z + &driven * Scale(filtered(lag));
            driven = a * driven;
        }
        let mixed = a * z * b.transpose();
        let own = b * b.transpose() * Scale(filtered(0));
        let spread = gramian(a.as_ref(), &mixed + mixed.transpose() + own).ok()?;
        positive_part(spread.as_ref()).ok()
    }

    /// The weights of the window's samples, in the order of its columns, in a sum of such errors.
    fn of_samples(&self, weights: &[f64], length: usize) -> Vec<f64> {
        let (p, count) = (self.autoregression.len(), weights.len());
        let markov = self.model.markov_parameters(count);
        let h: Vec<f64> = markov.iter().map(|h| h[(0, 0)]).collect();
        let of_input: Vec<f64> = (0..count)
            .map(|j| -weights[j..].iter().zip(&h).map(|(b, h)| b * h).sum::<f64>())
            .collect();
        let mut c = vec![0.0; 2 * length];
        for t in 0..count {
            for k in 0..=p {
                let alpha = if k == 0 { 1.0 } else { -self.autoregression[k - 1] };
                c[2 * (t + p - k)] += alpha * of_input[t];
                c[2 * (t + p - k) + 1] += alpha * weights[t];
            }
        }
        c
    }
}

/// `X = A X Aᵀ + W` for a stable A: X ← X + A X Aᵀ, A ← A², until nothing is added.
fn gramian(a: MatRef<'_, f64>, w: Mat<f64>) -> Result<Mat<f64>, Error> {
    const MOST_DOUBLINGS: usize = 50;
    let (mut a, mut x) = (a.to_owned(), w);
    for _ in 0..MOST_DOUBLINGS {
        let added = &a * &x * a.transpose();
        x = &x + &added;
        if !is_finite(x.as_ref()) {
            break;
        }
        if added.norm_l2() <= 1e-17 * x.norm_l2() {
            return Ok(x);
        }
        a = &a * &a;
    }
    Err(Error::Numerical { what: "the Gramian of a model that is not stable" })
}

/// The simulation errors v of the last `count` samples, the latest first, for each row of R.
fn simulation_errors(windows: &Windows, model: &StateSpace, count: usize) -> Mat<f64> {
    let length = windows.length;
    let free = free_response(model, length);
    let mut plain =
        PlantAndNoise { model: model.clone(), autoregression: Vec::new(), noise_variance: 0.0 };
    // The first pass determines σ² for the second.
    plain.noise_variance = plain.variance(windows);
    if !plain.noise_variance.is_finite() {
        plain.noise_variance = 0.0;
    }
    let explained = &free * plain.state_weights(windows, &free);
    let mut v = Mat::zeros(2 * length, count);
    for k in 0..count {
        let t = length - 1 - k;
        let of_state = (0..length).map(|j| if j + 1 < length { -explained[(t, j)] } else { 0.0 });
        let mut weights: Vec<f64> = of_state.collect();
        weights[t] += 1.0;
        for (i, e) in windows.times(&plain.of_samples(&weights, length)).into_iter().enumerate() {
            v[(i, k)] = e;
        }
    }
    v
}
