//! How many states the data ask for.
//!
//! Adding a state always lowers the simulation error of the estimation data. Whether by more than
//! chance is told by Schwarz's criterion (G. Schwarz, *Estimating the dimension of a model*, Annals of
//! Statistics 6, 1978),
//!
//! ```text
//! N_e·Σ_i ln V_i + d·ln(N_e·ny)
//! ```
//!
//! with V_i the mean squared simulation error of output i and d the number of parameters. It counts
//! independent samples, which those of a drive are not: its simulation errors are correlated over
//! time, and so is the steering. How much of the errors a superfluous parameter takes up by chance is
//! governed by the correlation of the errors e and of the sensitivities together, so that N samples
//! count for
//!
//! ```text
//! N_e = N / Σ_τ ρ_e(τ)·ρ_ŷ(τ)
//! ```
//!
//! (M. S. Bartlett, *Some aspects of the time-correlation problem in regard to tests of significance*,
//! J. Royal Statistical Society 98, 1935; for criteria of likelihoods that take samples for independent
//! which are not: X. Gao, P. X.-K. Song, *Composite likelihood Bayesian information criteria for model
//! selection in high-dimensional data*, J. American Statistical Association 105, 2010). The simulated
//! output ŷ stands for the sensitivities, which are the input filtered by the model's poles as it is.
//! White errors leave N_e = N.
//!
//! Simulation errors rather than prediction errors: a disturbance's own dynamics would count as states
//! of the plant in these.

use crate::model::{StateSpace, simulate};
use crate::signal::{dot, mean};
use crate::{DataSet, Signals};

/// Errors of the simulation, ny by N of each segment.
pub(crate) type Errors = Vec<Signals>;

/// `y − ŷ` of each segment from its initial state.
pub(crate) fn errors(model: &StateSpace, x0: &[Vec<f64>], data: &DataSet) -> Errors {
    let segments = data.segments().iter().zip(x0);
    segments.map(|(s, x0)| &s.y - simulate(model, s.u.as_ref(), x0)).collect()
}

/// Sum of squares over samples and outputs.
pub(crate) fn sum_of_squares(errors: &Errors) -> f64 {
    errors.iter().map(|e| squares(e.values())).sum()
}

fn squares(x: &[f64]) -> f64 {
    dot(x, x)
}

/// Σ_i ln V_i over the outputs; ∞ where an error is not finite.
pub(crate) fn log_square(errors: &Errors) -> f64 {
    let outputs = errors.first().map_or(0, Signals::nrows);
    let samples: usize = errors.iter().map(Signals::ncols).sum();
    (0..outputs)
        .map(|i| {
            let sum: f64 = errors.iter().map(|e| squares(e.row(i))).sum();
            if sum.is_finite() {
                (sum / samples.max(1) as f64).max(1e-300).ln()
            } else {
                f64::INFINITY
            }
        })
        .sum()
}

/// Parameters of a model up to the basis of its state: n(nu + ny), and nu·ny of D.
pub(crate) fn parameters(order: usize, inputs: usize, outputs: usize, feedthrough: bool) -> usize {
    order * (inputs + outputs) + if feedthrough { inputs * outputs } else { 0 }
}

/// Schwarz's criterion for `log_square` = Σ_i ln V_i from `samples` independent ones.
pub(crate) fn schwarz(log_square: f64, outputs: usize, parameters: usize, samples: f64) -> f64 {
    samples * log_square + parameters as f64 * (samples * outputs as f64).max(2.0).ln()
}

/// The number N_e of independent samples in simulation errors of `data`.
pub(crate) fn effective_samples(data: &DataSet, errors: &Errors) -> f64 {
    let simulated: Errors = data.segments().iter().zip(errors).map(|(s, e)| &s.y - e).collect();
    let (a, b) = (autocorrelation(errors), autocorrelation(&simulated));
    let lags = a.len();
    // Bartlett's taper, since far lags are all chance.
    let sum: f64 = (1..lags).map(|k| (1.0 - k as f64 / lags as f64) * a[k] * b[k]).sum();
    data.samples() as f64 / (1.0 + 2.0 * sum).max(1.0)
}

/// Autocorrelation of all rows together at lags from 0 up to √N.
fn autocorrelation(signals: &Errors) -> Vec<f64> {
    let samples: usize = signals.iter().map(Signals::ncols).sum();
    let lags = (samples as f64).sqrt().ceil().max(1.0) as usize;
    let mut r = vec![0.0; lags];
    for signal in signals {
        for i in 0..signal.nrows() {
            let m = mean(signal.row(i));
            let x: Vec<f64> = signal.row(i).iter().map(|v| v - m).collect();
            for (k, r) in r.iter_mut().enumerate() {
                let later = x.get(k..).unwrap_or_default();
                *r += dot(&x[..later.len()], later);
            }
        }
    }
    let r0 = r[0];
    if r0 > 0.0 {
        r.iter_mut().for_each(|x| *x /= r0);
    }
    r
}

/// `100·(1 − ‖Y − Ŷ‖/‖Y − mean(Y)‖)` over all outputs, the mean of each taken out; −∞ where an error
/// is not finite.
pub(crate) fn fit(data: &DataSet, errors: &Errors) -> f64 {
    let n = data.samples() as f64;
    let spread: f64 = (0..data.outputs())
        .map(|i| {
            let rows = || data.segments().iter().flat_map(|s| s.y.row(i).iter());
            let m = rows().sum::<f64>() / n;
            rows().map(|y| (y - m) * (y - m)).sum::<f64>()
        })
        .sum();
    let error = sum_of_squares(errors);
    if !error.is_finite() || spread <= 0.0 {
        return f64::NEG_INFINITY;
    }
    100.0 * (1.0 - (error / spread).sqrt())
}
