//! The autoregressive noise model `v(t) = Σ_{k=1..p} a_k v(t−k) + e(t)` of simulation errors v = y
//! − G u, and the data filtered by it (docs/methods/selection.md).
//!
//! Given a, the prediction error of plant and noise together is the simulation error of the same
//! plant for [whitened](AutoregressiveNoise::whitened) data, since scalar filters commute. One
//! autoregression serves all outputs, each in the unit of its errors. It is found by Durbin and
//! Levinson's recursion from the autocovariance, which makes it stable.

use crate::Error;
use crate::data::{DataSet, Segment, Signals};
use crate::linalg::dense::dot;
use crate::selection::order::Errors;

/// Largest order that is tried, and the samples for each coefficient.
const MOST: usize = 30;
const SAMPLES: usize = 50;
/// Errors of a smaller share of the output are rounding, without a noise model.
const ROUNDING: f64 = 1e-8;

/// An autoregression of simulation errors.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct AutoregressiveNoise {
    /// a_1 … a_p.
    coefficients: Vec<f64>,
    pub(crate) remaining: f64,
}

impl AutoregressiveNoise {
    pub(crate) fn fitted(errors: &Errors, order: usize) -> Self {
        let all = autoregressions(errors, order);
        all.into_iter().last().unwrap_or(Self { coefficients: Vec::new(), remaining: 1.0 })
    }

    /// The order by Akaike's criterion, which grows with the data as no true noise is of an order.
    pub(crate) fn order(errors: &Errors, data: &DataSet) -> usize {
        let shortest = data.segments().iter().map(Segment::len).min().unwrap_or(0);
        let most = MOST.min(data.samples() / SAMPLES).min(shortest / 4);
        let outputs = data.segments().iter().map(|s| power(&s.y)).sum::<f64>();
        let of_errors = errors.iter().map(power).sum::<f64>();
        if !(of_errors.is_finite() && of_errors.sqrt() > ROUNDING * outputs.sqrt()) {
            return 0;
        }
        let values = (data.samples() * data.outputs()) as f64;
        let criterion = |c: &Self| values * c.remaining.ln() + 2.0 * c.coefficients.len() as f64;
        autoregressions(errors, most)
            .iter()
            .min_by(|a, b| criterion(a).total_cmp(&criterion(b)))
            .map_or(0, |c| c.coefficients.len())
    }

    /// How often its standard error a mean of so many errors is off 0, squared: their spectral density at
    /// the frequency 0 is that of e over (1 − Σ a)², and the mean's variance that over the count.
    pub(crate) fn square_of_mean(&self, mean: f64, variance: f64, count: usize) -> f64 {
        let past: f64 = self.coefficients.iter().sum();
        let scatter = variance * self.remaining / count as f64;
        (mean * (1.0 - past)).powi(2) / scatter.max(f64::MIN_POSITIVE)
    }

    /// Input and output less their predictions, from the sample on where the past is known.
    pub(crate) fn whitened(&self, data: &DataSet) -> Result<DataSet, Error> {
        let order = self.coefficients.len();
        let apply = |m: &Signals| {
            Signals::from_fn(m.nrows(), m.ncols() - order, |i, t| {
                let past = self.coefficients.iter().enumerate();
                let predicted: f64 = past.map(|(k, a)| a * m[(i, t + order - 1 - k)]).sum();
                m[(i, t + order)] - predicted
            })
        };
        let long = data.segments().iter().filter(|s| s.len() > order);
        let segments = long.map(|s| Segment { u: apply(&s.u), y: apply(&s.y) }).collect();
        DataSet::new(data.sample_time_s(), segments)
    }
}

fn power(signals: &Signals) -> f64 {
    dot(signals.values(), signals.values())
}

fn autoregressions(errors: &Errors, most: usize) -> Vec<AutoregressiveNoise> {
    let r = autocovariance(errors, most);
    let mut now = AutoregressiveNoise { coefficients: Vec::new(), remaining: 1.0 };
    let mut all = vec![now.clone()];
    for k in 1..=most {
        let a = &now.coefficients;
        let reflection = (r[k] - (0..k - 1).map(|j| a[j] * r[k - 1 - j]).sum::<f64>())
            / now.remaining.max(f64::MIN_POSITIVE);
        if reflection.is_nan() || reflection.abs() >= 1.0 {
            break;
        }
        let mut coefficients: Vec<f64> =
            (0..k - 1).map(|j| a[j] - reflection * a[k - 2 - j]).collect();
        coefficients.push(reflection);
        let remaining = now.remaining * (1.0 - reflection * reflection);
        now = AutoregressiveNoise { coefficients, remaining };
        all.push(now.clone());
    }
    all
}

/// Autocovariance at the lags 0 to `most` over that at 0, the mean of all outputs.
fn autocovariance(errors: &Errors, most: usize) -> Vec<f64> {
    let outputs = errors.first().map_or(0, Signals::nrows);
    let mut mean = vec![0.0; most + 1];
    for i in 0..outputs {
        let mut sums = vec![0.0; most + 1];
        for e in errors {
            let x = e.row(i);
            for (lag, sum) in sums.iter_mut().enumerate() {
                let later = x.get(lag..).unwrap_or_default();
                *sum += dot(&x[..later.len()], later);
            }
        }
        for (mean, sum) in mean.iter_mut().zip(&sums) {
            *mean += sum / sums[0].max(f64::MIN_POSITIVE) / outputs as f64;
        }
    }
    mean
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A reproducible white sequence of unit variance.
    fn white(count: usize) -> Vec<f64> {
        let mut state = 1_u64;
        (0..count)
            .map(|_| {
                state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
                ((state >> 11) as f64 / (1_u64 << 53) as f64 - 0.5) * 12_f64.sqrt()
            })
            .collect()
    }

    /// The means of records of coloured noise have the stated scatter.
    #[test]
    fn means_of_coloured_errors_scatter_as_stated() {
        const COUNT: usize = 500;
        let e = white(200 * COUNT);
        let mut v = 0.0;
        let all: Vec<f64> = e
            .iter()
            .map(|e| {
                v = 0.8 * v + e;
                v
            })
            .collect();
        let mut sum = 0.0;
        for record in all.chunks(COUNT) {
            let mean = record.iter().sum::<f64>() / COUNT as f64;
            let variance = record.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / COUNT as f64;
            let errors = vec![Signals::from(record.to_vec())];
            sum += AutoregressiveNoise::fitted(&errors, 1).square_of_mean(mean, variance, COUNT)
                / 200.0;
        }
        assert!((0.75..1.3).contains(&sum), "{sum}");
    }

    #[test]
    fn an_autoregression_is_found_and_taken_out() {
        let e = white(20_000);
        let mut v = vec![0.0; e.len()];
        for t in 2..e.len() {
            v[t] = 1.5 * v[t - 1] - 0.7 * v[t - 2] + e[t];
        }
        let y = Signals::from(v);
        let data = DataSet::single(1.0, e.clone(), y.clone()).unwrap();
        let order = AutoregressiveNoise::order(&vec![y.clone()], &data);
        assert!((2..=4).contains(&order), "{order}");
        let noise = AutoregressiveNoise::fitted(&vec![y], 2);
        let near = |x: f64, want: f64| (x - want).abs() < 0.02;
        assert!(near(noise.coefficients[0], 1.5) && near(noise.coefficients[1], -0.7));
        let white = noise.whitened(&data).unwrap();
        let left = (0..1000).map(|t| (white.segments()[0].y[(0, t)] - e[t + 2]).abs());
        assert!(left.fold(0.0, f64::max) < 0.1);
        // White errors: whatever order chance takes, it takes out next to nothing.
        let white = vec![Signals::from(e)];
        let noise = AutoregressiveNoise::fitted(&white, AutoregressiveNoise::order(&white, &data));
        assert!(noise.remaining > 0.998, "{noise:?}");
    }
}
