//! How many independent samples are in so many of a drive.
//!
//! Schwarz's criterion counts independent samples, which those of a drive are not: its errors are
//! correlated over time, and so is the steering. How much of the errors a superfluous parameter takes up
//! by chance is governed by the correlation of the errors e and of the sensitivities together, so that N
//! samples count for
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
//! White errors leave N_e = N. A factor has no signals of which a model of the noise could be made, as it
//! is where orders are compared on a log.

use crate::identify::order::Errors;
use crate::signal::{dot, mean};
use crate::{DataSet, Signals};

/// The number N_e of independent samples in simulation errors of `data`.
pub(super) fn effective_samples(data: &DataSet, errors: &Errors) -> f64 {
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
