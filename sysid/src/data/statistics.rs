//! Fits of simulated to measured signals, and quantiles of the tests.

use steerwright_drivelog::signal::{mean, standard_deviation};

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

/// Variance accounted for, `100·(1 − var(y − ŷ)/var(y))` in percent; −∞ where ŷ is not finite.
#[must_use]
pub fn variance_accounted_for(y: &[f64], y_hat: &[f64]) -> f64 {
    let error: Vec<f64> = y.iter().zip(y_hat).map(|(a, b)| a - b).collect();
    let (spread, left) = (standard_deviation(y), standard_deviation(&error));
    if !left.is_finite() || spread <= 0.0 {
        return f64::NEG_INFINITY;
    }
    100.0 * (1.0 - (left / spread).powi(2))
}

/// Quantile of χ² at the standard normal quantile `z` (Wilson and Hilferty), within 0.3 %.
#[must_use]
pub(crate) fn chi_squared_quantile(degrees: usize, z: f64) -> f64 {
    let k = degrees.max(1) as f64;
    let v = 2.0 / (9.0 * k);
    k * (1.0 - v + z * v.sqrt()).powi(3)
}

/// Standard normal quantile of 99 %, for one-sided tests.
pub(crate) const Z99: f64 = 2.326_347_874_040_841;
/// … and of 99.5 %, for bands of 99 %.
pub(crate) const Z995: f64 = 2.575_829_303_548_901;

/// Sum of the autocovariances over all lags, never below the variance: the initial positive
/// sequence of C. J. Geyer (*Practical Markov chain Monte Carlo*, Statistical Science 7, 1992).
pub(crate) fn long_run_variance(segments: &[Vec<f64>]) -> f64 {
    let count = segments.iter().map(Vec::len).sum::<usize>().max(1) as f64;
    let longest = segments.iter().map(Vec::len).max().unwrap_or(0);
    let covariance = |lag: usize| -> f64 {
        let of =
            |e: &Vec<f64>| -> f64 { e.iter().zip(e.iter().skip(lag)).map(|(a, b)| a * b).sum() };
        segments.iter().map(of).sum::<f64>() / count
    };
    let variance = covariance(0);
    let mut sum = -variance;
    // A tenth of the drive does not show correlations that last longer.
    for pair in 0..(longest / 20).max(1) {
        let two = covariance(2 * pair) + covariance(2 * pair + 1);
        if two <= 0.0 {
            break;
        }
        sum += 2.0 * two;
    }
    sum.max(variance)
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
}
