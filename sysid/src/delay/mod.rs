//! The pure delay between steering and yaw rate, in seconds.
//!
//! A long ARX model whitens the noise; then models of order 1 to 5 in continuous time are fitted, each
//! with the delays of a grid and then with a delay of its own, exactly for an input that is held over
//! the samples (so fractions of a sample count as they are). All of it works on lag sums, so the
//! cost beyond one pass over the data does not depend on their number.
//!
//! *Delay or lag.* An actuator's lag, a further pole and a delay look alike where the log says little
//! about high frequencies. The delay competes with further poles by the Bayesian information
//! criterion (Schwarz 1978): it is taken only where no model of up to order 5 without one does as well
//! for its number of parameters. What it replaces is reported: the fastest time constant of the best
//! model without a delay.

mod fit;
mod lags;
mod response;

use crate::{DataSet, Error};
use fit::Fit;
use lags::Quadratic;
use response::{MOST, polynomial};

/// Longest delay looked for, s.
const LONGEST_S: f64 = 0.5;
/// What impulse responses last, s: lateral dynamics settle in about a second.
const RESPONSE_S: f64 = 2.0;
/// Difference of the criterion that counts as strong evidence (Kass and Raftery 1995).
const STRONG: f64 = 10.0;
/// Delays shorter than that share of a sample are none.
const LEAST_SAMPLES: f64 = 0.25;
/// Standard errors by which a delay must differ from none.
const LEAST_ERRORS: f64 = 3.0;

/// What the data say about a pure delay.
#[derive(Debug, Clone, PartialEq)]
pub struct Delay {
    /// The delay to use, s: that of `estimate_s` where the data ask for one, else 0.
    pub seconds: f64,
    /// Delay of the best model that has one, s.
    pub estimate_s: f64,
    /// Its standard error, s, from the curvature of the squared error and what the model leaves
    /// unexplained; infinite where the data do not determine it.
    pub standard_error_s: f64,
    /// Order of that model.
    pub order: usize,
    /// Order of the best model without a delay.
    pub order_without: usize,
    /// Fastest time constant of the best model without a delay, s: the lag that can stand in place
    /// of the delay.
    pub lag_without_s: f64,
    /// By how much the information criterion prefers the delay; negative where it does not.
    pub evidence: f64,
    /// By how much the whitened squared error falls by the delay at its order, percent.
    pub gain_percent: f64,
}

/// Estimates the delay from the input to the output of `data`, one of each.
///
/// # Errors
/// [`Error::Data`] for several inputs or outputs, [`Error::TooFewSamples`] where the segments are too
/// short for the models, and [`Error::Numerical`] where a decomposition fails.
pub fn estimate_delay(data: &DataSet) -> Result<Delay, Error> {
    if (data.inputs(), data.outputs()) != (1, 1) {
        let problem = format!(
            "a delay is estimated from one input to one output, there are {} and {}",
            data.inputs(),
            data.outputs()
        );
        return Err(Error::Data { problem });
    }
    let sample = data.sample_time_s();
    let longest = data.segments().iter().map(crate::Segment::len).max().unwrap_or(0);
    let lags = ((RESPONSE_S / sample).round().clamp(24.0, 160.0) as usize).min(longest / 12);
    let need = 12 * 12;
    if lags < 12 {
        return Err(Error::TooFewSamples { got: longest, need, sample_time_s: sample });
    }
    let most = (LONGEST_S / sample).min(lags as f64 / 3.0);
    let q = Quadratic::new(data, lags)?;
    let models = models(&q, most);
    let criterion = |fit: &Fit, parameters: usize| {
        let n = q.count as f64;
        n * ((q.least + fit.excess) / n).ln() + parameters as f64 * n.ln()
    };
    let mut with: Option<(f64, &Fit, &Fit)> = None;
    let mut without: Option<(f64, &Fit)> = None;
    for (none, free) in &models {
        let n = none.order();
        let (j0, j1) = (criterion(none, 2 * n), criterion(free, 2 * n + 1));
        if without.is_none_or(|(j, _)| j0 < j) {
            without = Some((j0, none));
        }
        if with.is_none_or(|(j, ..)| j1 < j) {
            with = Some((j1, free, none));
        }
    }
    let (Some((j1, best, same)), Some((j0, plain))) = (with, without) else {
        return Err(Error::Numerical { what: "models with a delay" });
    };
    // What the model leaves beyond the noise is no less uncertain than noise is.
    let noise =
        (q.least / q.count as f64).max(best.excess / (lags - 2 * best.order()).max(1) as f64);
    let error =
        best.delay_variance(&q, most).map_or(f64::INFINITY, |variance| (variance * noise).sqrt());
    let evidence = j0 - j1;
    let taken =
        evidence > STRONG && best.delay >= LEAST_SAMPLES && best.delay > LEAST_ERRORS * error;
    Ok(Delay {
        seconds: if taken { best.delay * sample } else { 0.0 },
        estimate_s: best.delay * sample,
        standard_error_s: error * sample,
        order: best.order(),
        order_without: plain.order(),
        lag_without_s: sample * fastest(&plain.parameters),
        evidence,
        gain_percent: 100.0 * (same.excess - best.excess) / (q.least + same.excess),
    })
}

/// For each order the best model without a delay and the best with one.
fn models(q: &Quadratic, most: f64) -> Vec<(Fit, Fit)> {
    let steps = most.ceil().clamp(2.0, 14.0) as usize;
    let mut all: Vec<(Fit, Fit)> = Vec::new();
    for order in 1..=MOST {
        let starts = |fit: Option<&Fit>| -> Vec<Vec<f64>> {
            match fit {
                None => vec![vec![0.2_f64.ln()]],
                Some(f) => grown(&f.parameters),
            }
        };
        let last = all.last();
        let best = |fits: Vec<Fit>| fits.into_iter().min_by(|a, b| a.excess.total_cmp(&b.excess));
        let none = best(
            starts(last.map(|l| &l.0)).iter().map(|p| Fit::new(q, p, 0.0, false, most)).collect(),
        );
        let mut candidates: Vec<Fit> = Vec::new();
        if order <= 2 {
            // All delays are tried where models are simple; the higher orders grow from these.
            for k in 0..=steps {
                let delay = most * k as f64 / steps as f64;
                for p in starts(last.map(|l| &l.1)) {
                    candidates.push(Fit::new(q, &p, delay, false, most));
                }
            }
            candidates.sort_by(|a, b| a.excess.total_cmp(&b.excess));
            candidates.truncate(2);
            candidates = candidates
                .iter()
                .map(|f| Fit::new(q, &f.parameters, f.delay, true, most))
                .collect();
        } else if let Some((_, free)) = last {
            for p in grown(&free.parameters) {
                candidates.push(Fit::new(q, &p, free.delay, true, most));
            }
        }
        if let Some(none) = &none {
            // A model without a delay is one with a delay of nought.
            candidates.push(Fit::new(q, &none.parameters, 0.1, true, most));
            candidates.push(none.clone());
        }
        if let (Some(none), Some(free)) = (none, best(candidates)) {
            all.push((none, free));
        }
    }
    all
}

/// Starts for one order more: a further pole, fast and slow.
fn grown(parameters: &[f64]) -> Vec<Vec<f64>> {
    let n = parameters.len();
    [1.5, 0.1_f64]
        .iter()
        .map(|pole| {
            let mut p = parameters.to_vec();
            if n % 2 == 1 {
                // s + a becomes (s + a)(s + pole) = s² + (a + pole) s + a·pole.
                let a = p[n - 1].exp();
                p[n - 1] = (a + pole).ln();
                p.push((a * pole).ln());
            } else {
                p.push(pole.ln());
            }
            p
        })
        .collect()
}

/// Time constant of the fastest pole, samples.
fn fastest(parameters: &[f64]) -> f64 {
    let a = polynomial(parameters);
    let n = a.len();
    let companion = faer::Mat::from_fn(n, n, |i, j| {
        if j == 0 {
            -a[i]
        } else if j == i + 1 {
            1.0
        } else {
            0.0
        }
    });
    let poles = crate::dense::eigenvalues(companion.as_ref()).unwrap_or_default();
    let most = poles.iter().map(|(re, im)| re.hypot(*im)).fold(0.0, f64::max);
    if most > 0.0 { 1.0 / most } else { f64::INFINITY }
}
