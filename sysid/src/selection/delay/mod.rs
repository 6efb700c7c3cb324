//! The pure delay between steering and yaw rate, in seconds (docs/methods/selection.md).
//!
//! A long ARX model whitens the noise; then models of order 1 to 5 in continuous time are fitted,
//! each without a delay and with one of its own, exactly for an input that is held over the
//! samples, all on lag sums. The models are those of a vehicle: two poles and a zero, and lags
//! without a zero on top, which cannot take the shape of a delay as a Padé approximant does. The
//! delay competes with the lags by BIC; and it must do better than models without a delay whose
//! zeros are free, since it is such a model that is identified after it. Where a lag and a delay
//! are both there and the noise hides which is which, a model of lower order has a longer delay in
//! place of the lag.

mod fit;
mod lags;
mod response;

use crate::Error;
use crate::data::DataSet;
use crate::data::held_input::ContinuousResponse;
use crate::selection::delay::fit::{Fit, Search, Zeros};
use crate::selection::delay::lags::Quadratic;
use crate::selection::delay::response::{MOST, polynomial};

/// Longest delay looked for, s.
const LONGEST_S: f64 = 0.5;
/// What impulse responses last, s: lateral dynamics settle in about a second.
const RESPONSE_S: f64 = 2.0;
/// Difference of the criterion that counts as strong evidence (Kass and Raftery 1995).
const STRONG: f64 = 6.0;
/// … and as positive evidence.
const POSITIVE: f64 = 2.0;
/// Delays shorter than that share of a sample are none.
const LEAST_SAMPLES: f64 = 0.25;
/// Largest standard error of a delay that is used, s: at 2 Hz, a fifth of a radian of phase.
const LARGEST_ERROR_S: f64 = 0.015;
/// Longest lag of a steering actuator that is thought of, s.
const LONGEST_LAG_S: f64 = 0.1;
const FINE: usize = 30;
/// Largest order of a vehicle: two poles and an actuator's lag.
const LARGEST_VEHICLE: usize = 3;
/// Standard errors by which a delay must differ from none.
const LEAST_ERRORS: f64 = 3.0;

/// The estimate of a pure delay.
#[derive(Debug, Clone, PartialEq)]
pub struct Delay {
    /// The delay to use, s: that of `estimate_s` where the data require one, else 0.
    pub seconds: f64,
    /// Delay of the best model that has one, s.
    pub estimate_s: f64,
    /// Its standard error, s, from noise and the spread over orders, or from what an actuator's lag
    /// can replace; infinite where the data do not determine it to half a second.
    pub standard_error_s: f64,
    /// Order of the best model without a delay.
    pub order_without: usize,
    /// Fastest time constant of the best model without a delay, s: the lag that can replace the delay.
    pub lag_without_s: f64,
    /// By how much the information criterion prefers the delay to lags; negative where it does not.
    pub evidence: f64,
}

/// Estimates the delay from the input to the output of `data`, one of each.
///
/// # Errors
/// [`Error::Data`] for several inputs or outputs, [`Error::TooFewSamples`] where the segments are too
/// short for the models, and [`Error::Numerical`] where a decomposition fails.
pub fn estimate_delay(data: &DataSet) -> Result<Delay, Error> {
    estimate(data).map(|estimated| estimated.delay)
}

/// The estimate of the delay, and what else its models show.
pub(crate) struct Estimated {
    pub(crate) delay: Delay,
    /// A vehicle that the data determine: with the delay where it is to be used, else without one; `None` where no fit
    /// is one.
    pub(crate) vehicle: Option<ContinuousResponse>,
    /// The least information criterion of all models; less is likelier, of the same output.
    pub(crate) criterion: f64,
}

/// The same with what else the models show.
pub(crate) fn estimate(data: &DataSet) -> Result<Estimated, Error> {
    if (data.inputs(), data.outputs()) != (1, 1) {
        return Err(Error::data(format!(
            "a delay is estimated from one input to one output, there are {} and {}",
            data.inputs(),
            data.outputs()
        )));
    }
    let sample = data.sample_time_s();
    let longest = data.segments().iter().map(crate::data::Segment::len).max().unwrap_or(0);
    let lags = ((RESPONSE_S / sample).round().clamp(24.0, 160.0) as usize).min(longest / 12);
    if lags < 12 {
        return Err(Error::too_few(longest, 12 * 12, sample));
    }
    let most = (LONGEST_S / sample).min(lags as f64 / 3.0);
    let q = Quadratic::new(data, lags)?;
    let search = Search { q: &q, most, zeros: Zeros::Vehicle, lag: 0.0 };
    let models = models(&search);
    let free = Search { zeros: Zeros::Free, ..search };
    let others = models.iter().map(|(none, _)| Fit::new(&free, &none.parameters, 0.0, false, FINE));
    let others: Vec<Fit> = others.collect();
    let n = q.count as f64;
    let deviance = |fit: &Fit| n * ((q.least + fit.excess) / n).ln();
    let count = |s: &Search<'_>, fit: &Fit| (fit.order() + s.numerators(fit.order())) as f64;
    let bayes = |fit: &Fit, more: f64| deviance(fit) + (count(&search, fit) + more) * n.ln();
    let akaike = |fit: &Fit| deviance(fit) + 2.0 * (count(&search, fit) + 1.0);
    let plain = models.iter().map(|(none, _)| none);
    let plain = plain.min_by(|a, b| bayes(a, 0.0).total_cmp(&bayes(b, 0.0)));
    // A servo's lag in addition is plausible, so the order is by the more generous criterion
    // (Akaike 1974).
    let chosen = models.iter().min_by(|a, b| akaike(&a.1).total_cmp(&akaike(&b.1)));
    let (Some(plain), Some((_, best))) = (plain, chosen) else {
        return Err(Error::Numerical { what: "models with a delay" });
    };
    let j0 = bayes(plain, 0.0);
    let j1 = models.iter().map(|(_, free)| bayes(free, 1.0)).fold(f64::INFINITY, f64::min);
    let other = others.iter().map(|fit| deviance(fit) + count(&free, fit) * n.ln());
    let other = other.fold(f64::INFINITY, f64::min) - j1;
    let error = spread(&search, &models, best, |fit| bayes(fit, 1.0) - j1);
    let split = if error.is_finite() { split(&search, best, sample, &deviance) } else { 0.0 };
    let evidence = j0 - j1;
    let (estimate_s, standard_error_s) = (best.delay * sample, error.max(split) * sample);
    let is_taken = taken([evidence, other], best.delay, error, sample);
    // Wider than what was searched, it is no statement about the delay.
    let is_known = standard_error_s < LONGEST_S;
    let fits = models.iter().map(|(none, free)| if is_taken { free } else { none });
    let vehicle = vehicle(&search, sample, fits, |fit| bayes(fit, 0.0))?;
    let delay = Delay {
        seconds: if is_taken { estimate_s } else { 0.0 },
        estimate_s,
        standard_error_s: if is_known { standard_error_s } else { f64::INFINITY },
        order_without: plain.order(),
        lag_without_s: sample * fastest(&plain.parameters),
        evidence,
    };
    Ok(Estimated { delay, vehicle, criterion: j0.min(j1) })
}

/// Whether the evidence against lags and free zeros, and delay and error in samples, are enough.
fn taken(evidence: [f64; 2], delay: f64, error: f64, sample: f64) -> bool {
    evidence[0] > STRONG
        && evidence[1] > POSITIVE
        && delay >= LEAST_SAMPLES
        && delay > LEAST_ERRORS * error
        && error * sample <= LARGEST_ERROR_S
}

/// The simplest of the fits, by rising order, that a vehicle can have, unless one of higher order is strongly preferred by
/// the criterion: a response that is to be trusted up to half the sample rate.
fn vehicle<'a>(
    search: &Search<'_>,
    sample: f64,
    fits: impl Iterator<Item = &'a Fit>,
    criterion: impl Fn(&Fit) -> f64,
) -> Result<Option<ContinuousResponse>, Error> {
    let mut best: Option<(f64, ContinuousResponse)> = None;
    for fit in fits.take(LARGEST_VEHICLE) {
        let response = fit.response(search, sample)?;
        let worth = criterion(fit);
        if response.is_of_a_vehicle(sample)
            && best.as_ref().is_none_or(|(least, _)| worth < least - STRONG)
        {
            best = Some((worth, response));
        }
    }
    Ok(best.map(|(_, response)| response))
}

/// Standard error of the delay with the orders' variances about it, by BIC's `excess`.
fn spread(
    search: &Search<'_>,
    models: &[(Fit, Fit)],
    best: &Fit,
    excess: impl Fn(&Fit) -> f64,
) -> f64 {
    let q = search.q;
    let (mut sum, mut weights) = (0.0, 0.0);
    for (_, fit) in models {
        let weight = (-0.5 * excess(fit)).exp();
        // Occam's window (Madigan and Raftery 1994).
        if weight < 0.05 {
            continue;
        }
        // What the model leaves beyond the noise is no less uncertain than noise is.
        let freedom = q.target.len().saturating_sub(2 * fit.order()).max(1) as f64;
        let noise = (q.least / q.count as f64).max(fit.excess / freedom);
        let Some(variance) = fit.delay_variance(search) else { return f64::INFINITY };
        sum += weight * (variance * noise + (fit.delay - best.delay).powi(2));
        weights += weight;
    }
    (sum / weights).sqrt()
}

/// Standard deviation of the delay where an actuator's lag of up to [`LONGEST_LAG_S`] may replace
/// part of it: with each lag, the delay is fitted again, and weighted by its likelihood.
fn split(search: &Search<'_>, best: &Fit, sample: f64, deviance: &impl Fn(&Fit) -> f64) -> f64 {
    const TRIED: usize = 5;
    const STEPS: usize = 12;
    let (mut sum, mut weights) = (0.0, 0.5);
    let nominal = deviance(best);
    for k in 1..=TRIED {
        let lag = LONGEST_LAG_S / sample * k as f64 / TRIED as f64;
        let with_lag = Search { lag, ..*search };
        let from = (best.delay - lag).max(0.0);
        let fit = Fit::new(&with_lag, &best.parameters, from, true, STEPS);
        // A better fit counts no more than the best: it is the split that is in doubt.
        let weight = (-0.5 * (deviance(&fit) - nominal).max(0.0)).exp();
        let weight = if k == TRIED { 0.5 * weight } else { weight };
        sum += weight * (fit.delay - best.delay).powi(2);
        weights += weight;
    }
    (sum / weights).sqrt()
}

/// For each order the best model without a delay and the best with one.
fn models(search: &Search<'_>) -> Vec<(Fit, Fit)> {
    /// Delays tried where models are simple; the higher orders grow from these.
    const GRID: usize = 12;
    const ROUGH: usize = 5;
    let best = |fits: Vec<Fit>| fits.into_iter().min_by(|a, b| a.excess.total_cmp(&b.excess));
    let mut all: Vec<(Fit, Fit)> = Vec::new();
    for order in 1..=MOST {
        let last = all.last();
        let starts = |fit: Option<&Fit>| match fit {
            None => vec![vec![0.2_f64.ln()]],
            Some(fit) => grown(&fit.parameters),
        };
        let without = starts(last.map(|l| &l.0));
        let without = without.iter().map(|p| Fit::new(search, p, 0.0, false, FINE)).collect();
        let Some(none) = best(without) else { break };
        let from = starts(last.map(|l| &l.1));
        let mut tried: Vec<(Vec<f64>, f64)> = Vec::new();
        if order <= 2 {
            let mut rough: Vec<Fit> = (0..=GRID)
                .map(|k| search.most * k as f64 / GRID as f64)
                .map(|delay| Fit::new(search, &from[0], delay, false, ROUGH))
                .collect();
            rough.sort_by(|a, b| a.excess.total_cmp(&b.excess));
            tried.extend(rough.into_iter().take(2).map(|f| (f.parameters, f.delay)));
        }
        if let Some((_, free)) = last {
            tried.extend(from.into_iter().map(|p| (p, free.delay)));
        }
        tried.push((none.parameters.clone(), 0.3));
        let mut fits: Vec<Fit> =
            tried.iter().map(|(p, delay)| Fit::new(search, p, *delay, true, FINE)).collect();
        // A model without a delay is one with a delay of nought.
        fits.push(none.clone());
        let Some(free) = best(fits) else { break };
        all.push((none, free));
    }
    all
}

/// Initial estimates for one order more: a further pole, fast and slow.
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

fn fastest(parameters: &[f64]) -> f64 {
    let a = polynomial(parameters);
    let n = a.len();
    let companion = faer::Mat::from_fn(n, n, |i, j| match j {
        0 => -a[i],
        _ if j == i + 1 => 1.0,
        _ => 0.0,
    });
    let poles = crate::linalg::dense::eigenvalues(companion.as_ref()).unwrap_or_default();
    let most = poles.iter().map(|(re, im)| re.hypot(*im)).fold(0.0, f64::max);
    if most > 0.0 { 1.0 / most } else { f64::INFINITY }
}

#[cfg(test)]
mod tests {
    use super::*;
    use faer::Mat;

    /// 0.12 ± 0.004 s at 25 Hz is used; each condition alone forbids it.
    #[test]
    fn each_condition_alone_forbids_a_delay() {
        assert!(taken([20.0, 5.0], 3.0, 0.1, 0.04));
        // As likely a lag, or a model with other zeros.
        assert!(!taken([5.0, 5.0], 3.0, 0.1, 0.04) && !taken([20.0, 1.0], 3.0, 0.1, 0.04));
        // 8 ms at 25 Hz, however well known.
        assert!(!taken([20.0, 5.0], 0.2, 0.01, 0.04));
        // 0.02 ± 0.01 s at 100 Hz may be none.
        assert!(!taken([20.0, 5.0], 2.0, 1.0, 0.01) && taken([20.0, 5.0], 4.0, 1.0, 0.01));
        // 0.2 ± 0.02 s leaves a fifth of a radian at 2 Hz open.
        assert!(!taken([20.0, 5.0], 5.0, 0.5, 0.04) && taken([20.0, 5.0], 5.0, 0.5, 0.02));
        // Nothing determines it.
        assert!(!taken([20.0, 5.0], 3.0, f64::INFINITY, 0.04));
    }

    /// What a model leaves beyond the noise makes its delay as uncertain as noise of that size would.
    #[test]
    fn what_the_model_leaves_counts_as_noise() {
        const COUNT: usize = 40;
        let parameters = vec![0.5_f64.ln(), 0.1_f64.ln()];
        let target = response::basis(&polynomial(&parameters), 2.4, COUNT)[0].clone();
        let factor = Mat::identity(COUNT, COUNT);
        let q = Quadratic { factor, target, least: 2.0, count: 1000 };
        let search = Search { q: &q, most: 12.0, zeros: Zeros::Vehicle, lag: 0.0 };
        let error = |excess: f64| {
            let fit = Fit { parameters: parameters.clone(), delay: 2.4, excess };
            spread(&search, &[(fit.clone(), fit.clone())], &fit, |_| 0.0).powi(2)
        };
        // 2/1000 is the noise's variance; 36 numbers are free of the four of the model.
        let ratio = error(0.72) / error(0.0);
        assert!((ratio - 10.0).abs() < 1e-6, "{ratio}");
        assert!((error(0.036) / error(0.0) - 1.0).abs() < 1e-6);
    }
}
