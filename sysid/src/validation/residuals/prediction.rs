//! Prediction of the validation data, k steps ahead. With the one-step residuals e, the error of
//! the prediction from outputs up to t − k is `e(t) + C z(t) − C A^{k−1} z(t−k+1)` with `z(t+1) = A
//! z(t) + K e(t)`, which costs two products with A a sample, however large k is. The first k − 1
//! samples of a segment are predicted from its estimated initial state.

use crate::data::statistics::{fit_percent, variance_accounted_for};
use crate::linalg::dense::{rows, short_dot};
use crate::model::StateSpace;
use crate::validation::residuals::fit::fit_with_error;
use crate::validation::response::modelled::rounded;
use steerwright_formats::{HeldOut, PredictionFit};

/// How far ahead predictions are tried, s.
const AHEAD: [f64; 5] = [0.1, 0.2, 0.5, 1.0, 2.0];

/// Validation data with the model's predictions of them, in any units common to all.
pub(crate) struct Prediction<'a> {
    pub(crate) model: &'a StateSpace,
    pub(crate) gain: &'a [f64],
    pub(crate) output: &'a [&'a [f64]],
    pub(crate) simulated: &'a [&'a [f64]],
    pub(crate) residuals: &'a [&'a [f64]],
    pub(crate) sample_time_s: f64,
    pub(crate) selection: &'static str,
    pub(crate) segments_s: Vec<[f64; 2]>,
    /// Standard deviation of the one-step errors on the estimation data, the least noise.
    pub(crate) noise: f64,
}

pub(crate) fn on_validation_data(p: &Prediction<'_>) -> HeldOut {
    let y = p.output.concat();
    let simulated = p.simulated.concat();
    let pairs: Vec<(&[f64], &[f64])> =
        p.output.iter().copied().zip(p.simulated.iter().copied()).collect();
    let with_error = fit_with_error(&pairs, p.sample_time_s);
    let row = |steps: Option<usize>, y_hat: &[f64]| PredictionFit {
        steps,
        ahead_s: steps.map(|k| rounded(k as f64 * p.sample_time_s)),
        fit: bounded(fit_percent(&y, y_hat)),
        variance_accounted_for: bounded(variance_accounted_for(&y, y_hat)),
    };
    let longest = p.output.iter().map(|s| s.len()).max().unwrap_or(0);
    let mut steps: Vec<usize> =
        AHEAD.iter().map(|s| ((s / p.sample_time_s).round() as usize).max(1)).collect();
    steps.insert(0, 1);
    steps.dedup();
    steps.retain(|k| *k < longest);
    let mut predictions: Vec<PredictionFit> = steps
        .into_iter()
        .map(|k| {
            let errors = p.residuals.iter().flat_map(|e| ahead(p.model, p.gain, e, k));
            let y_hat: Vec<f64> = y.iter().zip(errors).map(|(y, e)| y - e).collect();
            row(Some(k), &y_hat)
        })
        .collect();
    predictions.push(row(None, &simulated));
    let spread = steerwright_drivelog::signal::standard_deviation(&y);
    HeldOut {
        fit_standard_error: with_error.standard_error,
        blocks: with_error.blocks,
        selection: p.selection.into(),
        segments_s: p.segments_s.clone(),
        fit_bound: if spread > 0.0 {
            Some(rounded(bounded(100.0 * (1.0 - p.noise / spread))))
        } else {
            None
        },
        variance_accounted_for: bounded(variance_accounted_for(&y, &simulated)),
        predictions,
    }
}

/// A file holds finite numbers only.
fn bounded(percent: f64) -> f64 {
    percent.max(-1e9)
}

fn ahead(model: &StateSpace, gain: &[f64], residuals: &[f64], k: usize) -> Vec<f64> {
    let n = model.order();
    let a = rows(model.a.as_ref());
    let times_a =
        |x: &[f64]| -> Vec<f64> { a.chunks_exact(n).map(|row| short_dot(row, x)).collect() };
    let c = rows(model.c.as_ref());
    // C A^{k−1}: rows times A is Aᵀ times columns.
    let at = rows(model.a.transpose());
    let mut far = c.clone();
    for _ in 1..k {
        far = at.chunks_exact(n).map(|row| short_dot(row, &far)).collect();
    }
    let mut z = vec![0.0; n];
    let mut before: std::collections::VecDeque<Vec<f64>> = std::collections::VecDeque::new();
    let mut errors = Vec::with_capacity(residuals.len());
    for e in residuals {
        before.push_back(z.clone());
        if before.len() > k {
            before.pop_front();
        }
        let old = if before.len() == k { short_dot(&far, &before[0]) } else { 0.0 };
        errors.push(e + short_dot(&c, &z) - old);
        z = times_a(&z);
        for (z, k) in z.iter_mut().zip(gain) {
            *z += k * e;
        }
    }
    errors
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::data::Signals;
    use crate::model::simulate;
    use faer::{Mat, mat};

    /// Against the definition: the filtered state of k samples ago, run open-loop from there.
    #[test]
    fn k_step_errors_are_those_of_the_definition() {
        let model = StateSpace {
            a: Mat::from_fn(2, 2, |i, j| [[0.8, 0.3], [-0.2, 0.7]][i][j]),
            b: Mat::from_fn(2, 1, |i, _| [0.5, 1.0][i]),
            c: mat![[1.0, -0.4]],
            d: mat![[0.2]],
        };
        let gain = [0.3, 0.1];
        let n = 60;
        let u: Vec<f64> = (0..n).map(|k| f64::from(k * k % 7) - 3.0).collect();
        let y: Vec<f64> = (0..n).map(|k| f64::from(k * k * k % 11) - 5.0).collect();
        // One step: x(t+1|t), and the residuals.
        let step = |x: [f64; 2], u: f64, e: f64| -> [f64; 2] {
            std::array::from_fn(|i| {
                model.a[(i, 0)] * x[0] + model.a[(i, 1)] * x[1] + model.b[(i, 0)] * u + gain[i] * e
            })
        };
        let out = |x: [f64; 2], u: f64| x[0] - 0.4 * x[1] + 0.2 * u;
        let mut states = vec![[0.4, -0.3]];
        let mut residuals = Vec::new();
        for t in 0..u.len() {
            let e = y[t] - out(states[t], u[t]);
            residuals.push(e);
            states.push(step(states[t], u[t], e));
        }
        for k in [1, 2, 5, 20] {
            let got = ahead(&model, &gain, &residuals, k);
            for t in k..u.len() {
                // From x(t−k+1|t−k), k − 1 steps without measurements.
                let mut x = states[t + 1 - k];
                for u in &u[t + 1 - k..t] {
                    x = step(x, *u, 0.0);
                }
                let expected = y[t] - out(x, u[t]);
                assert!((got[t] - expected).abs() < 1e-10, "{k} {t}: {} {expected}", got[t]);
            }
        }
        // Longer than the data it is the simulation from the initial state.
        let simulated = simulate(&model, Signals::from(u.clone()).as_ref(), &states[0]);
        for (t, error) in ahead(&model, &gain, &residuals, 1000).iter().enumerate() {
            assert!((error - (y[t] - simulated[(0, t)])).abs() < 1e-10);
        }
    }
}
