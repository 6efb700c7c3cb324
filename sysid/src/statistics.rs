//! Fit, and tests of residuals.

use crate::dense::{column, solve};
use crate::signal::mean;
use faer::Mat;
use formats::ResidualTest;

/// `100·(1 − ‖y − ŷ‖/‖y − mean(y)‖)` in percent; −∞ where ŷ is not finite.
#[must_use]
pub fn fit_percent(y: &[f64], y_hat: &[f64]) -> f64 {
    let m = mean(y);
    let error: f64 = y.iter().zip(y_hat).map(|(a, b)| (a - b) * (a - b)).sum();
    let spread: f64 = y.iter().map(|a| (a - m) * (a - m)).sum();
    if !error.is_finite() || spread <= 0.0 {
        return f64::NEG_INFINITY;
    }
    100.0 * (1.0 - (error / spread).sqrt())
}

/// Quantile of the χ² distribution with `degrees` degrees of freedom at the standard normal
/// quantile `z`: Wilson and Hilferty's cube, off by less than 0.3 % at 99 % from 5 degrees on.
#[must_use]
pub fn chi_squared_quantile(degrees: usize, z: f64) -> f64 {
    let k = degrees.max(1) as f64;
    let v = 2.0 / (9.0 * k);
    k * (1.0 - v + z * v.sqrt()).powi(3)
}

/// Standard normal quantile of 99 %.
const Z99: f64 = 2.326_347_874_040_841;

/// Autocorrelation of the residuals at lags 1 to `lags` (Ljung and Box 1978):
/// Q = N(N+2) Σ r_k²/(N−k), χ² with `lags` degrees of freedom where they are white.
#[must_use]
pub fn whiteness(residuals: &[f64], lags: usize) -> ResidualTest {
    let n = residuals.len();
    let m = mean(residuals);
    let e: Vec<f64> = residuals.iter().map(|x| x - m).collect();
    let r0: f64 = e.iter().map(|x| x * x).sum();
    let mut statistic = 0.0;
    for k in 1..=lags.min(n.saturating_sub(1)) {
        let r: f64 = e.iter().zip(&e[k..]).map(|(a, b)| a * b).sum();
        if r0 > 0.0 {
            statistic += (r / r0).powi(2) / (n - k) as f64;
        }
    }
    statistic *= n as f64 * (n as f64 + 2.0);
    test(lags, statistic)
}

/// Cross-correlation of the residuals with the input at lags 1 to `lags` (Ljung 1999, eq 16.79):
/// N·rᵀ R_u⁻¹ r / σ_e², R_u being the input's covariance matrix; χ² with `lags` degrees of freedom
/// where past inputs say nothing of the residuals.
#[must_use]
pub fn independence(residuals: &[f64], input: &[f64], lags: usize) -> ResidualTest {
    let n = residuals.len().min(input.len());
    let (me, mu) = (mean(&residuals[..n]), mean(&input[..n]));
    let e: Vec<f64> = residuals[..n].iter().map(|x| x - me).collect();
    let u: Vec<f64> = input[..n].iter().map(|x| x - mu).collect();
    let correlate = |a: &[f64], b: &[f64], k: usize| -> f64 {
        a[k.min(n)..].iter().zip(b).map(|(x, y)| x * y).sum::<f64>() / n as f64
    };
    let variance = correlate(&e, &e, 0);
    let ru: Vec<f64> = (0..lags).map(|k| correlate(&u, &u, k)).collect();
    if variance <= 0.0 || ru.first().is_none_or(|r| *r <= 0.0) {
        return test(lags, 0.0);
    }
    let r: Vec<f64> = (1..=lags).map(|k| correlate(&e, &u, k)).collect();
    // A ridge far below the noise keeps a band-limited input's covariance invertible.
    let covariance = Mat::from_fn(lags, lags, |i, j| {
        ru[i.abs_diff(j)] + if i == j { 1e-6 * ru[0] } else { 0.0 }
    });
    let x = solve(covariance.as_ref(), column(&r).as_ref());
    let form: f64 = r.iter().enumerate().map(|(i, r)| r * x[(i, 0)]).sum();
    test(lags, (n as f64 * form / variance).max(0.0))
}

fn test(lags: usize, statistic: f64) -> ResidualTest {
    let bound = chi_squared_quantile(lags, Z99);
    ResidualTest { lags, statistic, bound, pass: statistic <= bound }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantiles_of_the_table() {
        for (k, expected) in [(5, 15.086), (10, 23.209), (25, 44.314), (50, 76.154)] {
            let got = chi_squared_quantile(k, Z99);
            assert!((got / expected - 1.0).abs() < 3e-3, "{k}: {got}");
        }
    }

    #[test]
    fn fit_of_perfect_mean_and_broken() {
        let y = [1.0, 2.0, 3.0, 4.0];
        assert_eq!(fit_percent(&y, &y), 100.0);
        assert!(fit_percent(&y, &[2.5; 4]).abs() < 1e-12);
        assert_eq!(fit_percent(&y, &[f64::NAN; 4]), f64::NEG_INFINITY);
    }

    #[test]
    fn tests_pass_on_white_and_fail_on_coloured_residuals() {
        let mut state = 7_u64;
        let mut noise = || {
            (0..12)
                .map(|_| {
                    state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
                    (state >> 33) as f64 / f64::from(1_u32 << 31)
                })
                .sum::<f64>()
                - 6.0
        };
        let e: Vec<f64> = (0..5000).map(|_| noise()).collect();
        let u: Vec<f64> = (0..5000).map(|_| noise()).collect();
        assert!(whiteness(&e, 25).pass);
        assert!(independence(&e, &u, 25).pass);
        let coloured: Vec<f64> = e.windows(2).map(|w| w[1] + 0.3 * w[0]).collect();
        assert!(!whiteness(&coloured, 25).pass);
        let driven: Vec<f64> =
            (0..5000).map(|t| e[t] + if t >= 3 { 0.2 * u[t - 3] } else { 0.0 }).collect();
        assert!(!independence(&driven, &u, 25).pass);
    }
}
