//! Auto- and cross-correlation of residuals with their confidence bands, and the tests over all
//! lags. Covariances are the biased ones, R(k) = Σ e(t) e(t+k)/N. The cross-covariance of unrelated
//! residuals and input at two lags i, j scatters with covariance P(i − j)/N, `P(m) = Σ_k w(k)
//! R_e(k) R_u(k + m)` (Bartlett; Ljung 1999, eq 16.74), w Parzen's lag window, which keeps P
//! positive.

use crate::data::statistics::{Z99, Z995, chi_squared_quantile};
use crate::linalg::dense::{column, dot, solve};
use crate::validation::residuals::prewhitening::{centred, prewhitened};
use faer::Mat;
use steerwright_formats::ResidualTest;

/// Correlation at consecutive lags.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Correlation {
    pub(crate) first_lag: i64,
    pub(crate) values: Vec<f64>,
    /// Each alone stays within ± this with a probability of 99 % where there is no correlation.
    pub(crate) bound: f64,
}

/// Σ a(t) b(t + k) within the segments, over N; `a` and `b` have zero mean.
fn covariance(a: &[Vec<f64>], b: &[Vec<f64>], k: i64) -> f64 {
    let shift = k.unsigned_abs() as usize;
    let mut sum = 0.0;
    let mut count = 0;
    for (a, b) in a.iter().zip(b) {
        let n = a.len().min(b.len());
        count += n;
        if shift < n {
            let (early, late) =
                if k >= 0 { (&a[..n], &b[shift..n]) } else { (&b[..n], &a[shift..n]) };
            sum += dot(&early[..late.len()], late);
        }
    }
    if count > 0 { sum / count as f64 } else { 0.0 }
}

fn test(lags: usize, statistic: f64) -> ResidualTest {
    let bound = chi_squared_quantile(lags, Z99);
    ResidualTest { lags, statistic, bound, pass: statistic <= bound }
}

fn samples(x: &[&[f64]]) -> usize {
    x.iter().map(|s| s.len()).sum()
}

/// Autocorrelation of residuals at lags 1 to `lags`; the band is that of white noise, ±2.576/√N.
pub(crate) fn autocorrelation(residuals: &[&[f64]], lags: usize) -> Correlation {
    let e = centred(residuals);
    let zero = covariance(&e, &e, 0);
    let value = |k: usize| if zero > 0.0 { covariance(&e, &e, k as i64) / zero } else { 0.0 };
    Correlation {
        first_lag: 1,
        values: (1..=lags).map(value).collect(),
        bound: Z995 / (samples(residuals).max(1) as f64).sqrt(),
    }
}

/// Whether residuals are white: Q = N(N+2) Σ r_k²/(N−k) (Ljung and Box 1978).
pub(crate) fn whiteness(residuals: &[&[f64]], lags: usize) -> ResidualTest {
    let n = samples(residuals);
    let r = autocorrelation(residuals, lags.min(n.saturating_sub(1)));
    let sum: f64 = r.values.iter().enumerate().map(|(k, r)| r * r / (n - k - 1) as f64).sum();
    test(lags, n as f64 * (n as f64 + 2.0) * sum)
}

/// Residuals and input without their means, with P(m) for m below `count`.
struct Pair {
    e: Vec<Vec<f64>>,
    u: Vec<Vec<f64>>,
    samples: f64,
    p: Vec<f64>,
}

impl Pair {
    fn new(residuals: &[&[f64]], input: &[&[f64]], count: usize) -> Self {
        let (e, u) = (centred(residuals), centred(input));
        // Long enough for what one-step residuals and a driver's hands remember.
        let reach = 2 * count as i64;
        let re: Vec<f64> = (0..=reach).map(|k| covariance(&e, &e, k)).collect();
        let ru: Vec<f64> = (0..=reach + count as i64).map(|k| covariance(&u, &u, k)).collect();
        let at = |k: i64| ru[k.unsigned_abs() as usize];
        let p = (0..count as i64)
            .map(|m| {
                let term = |k: i64| parzen(k as f64 / (reach + 1) as f64) * re[k as usize];
                let both = |k: i64| term(k) * (at(m + k) + at(m - k));
                term(0) * at(m) + (1..=reach).map(both).sum::<f64>()
            })
            .collect();
        let samples = e.iter().zip(&u).map(|(e, u)| e.len().min(u.len())).sum::<usize>() as f64;
        Self { e, u, samples, p }
    }

    /// N rᵀ P⁻¹ r of the covariances of u(t) and e(t + k) at `lags` consecutive lags.
    fn test(&self, first_lag: i64, lags: usize) -> ResidualTest {
        if self.p.first().is_none_or(|p| p.is_nan() || *p <= 0.0) {
            return test(lags, 0.0);
        }
        let r: Vec<f64> =
            (0..lags as i64).map(|k| covariance(&self.u, &self.e, first_lag + k)).collect();
        // A ridge far below the noise keeps a band-limited input's covariance invertible.
        let covariance = Mat::from_fn(lags, lags, |i, j| {
            self.p[i.abs_diff(j)] + if i == j { 1e-6 * self.p[0] } else { 0.0 }
        });
        let x = solve(covariance.as_ref(), column(&r).as_ref());
        let form: f64 = r.iter().enumerate().map(|(i, r)| r * x[(i, 0)]).sum();
        test(lags, (self.samples * form).max(0.0))
    }
}

/// Parzen's lag window on −1…1 (Technometrics 3, 1961).
pub(crate) fn parzen(x: f64) -> f64 {
    let x = x.abs();
    if x <= 0.5 { 1.0 - 6.0 * x * x * (1.0 - x) } else { 2.0 * (1.0 - x).powi(3) }
}

/// Correlation of u(t) and e(t + k) at lags −`lags` to `lags`; negative ones are feedback.
pub(crate) fn cross_correlation(
    residuals: &[&[f64]],
    input: &[&[f64]],
    lags: usize,
) -> Correlation {
    let pair = Pair::new(residuals, input, lags.max(1));
    let power = covariance(&pair.e, &pair.e, 0) * covariance(&pair.u, &pair.u, 0);
    let scale = if power > 0.0 { 1.0 / power.sqrt() } else { 0.0 };
    let reach = lags as i64;
    Correlation {
        first_lag: -reach,
        values: (-reach..=reach).map(|k| scale * covariance(&pair.u, &pair.e, k)).collect(),
        bound: Z995 * scale * (pair.p[0].max(0.0) / pair.samples.max(1.0)).sqrt(),
    }
}

/// Whether residuals depend on past input: N rᵀ P⁻¹ r (Ljung 1999, section 16.6).
pub(crate) fn independence(residuals: &[&[f64]], input: &[&[f64]], lags: usize) -> ResidualTest {
    Pair::new(residuals, input, lags.max(1)).test(1, lags)
}

/// As [`independence`] at the lags −`lags` to −1, of the input less its prediction from its own
/// past: a memory of the input and a model with an error would else look like feedback.
pub(crate) fn feedback(residuals: &[&[f64]], input: &[&[f64]], lags: usize) -> ResidualTest {
    let order = 2 * lags;
    let prewhitened = prewhitened(input, order);
    let late: Vec<&[f64]> = residuals
        .iter()
        .zip(input)
        .map(|(e, u)| e.get(order..e.len().min(u.len())).unwrap_or_default())
        .collect();
    let prewhitened: Vec<&[f64]> = prewhitened.iter().map(Vec::as_slice).collect();
    Pair::new(&late, &prewhitened, lags.max(1)).test(-(lags as i64), lags)
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;

    /// A small repeatable normal noise: the sum of twelve uniform numbers.
    pub(crate) fn noise(state: &mut u64) -> f64 {
        let mut uniform = || {
            *state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
            (*state >> 33) as f64 / f64::from(1_u32 << 31)
        };
        (0..12).map(|_| uniform()).sum::<f64>() - 6.0
    }

    fn white(n: usize, state: &mut u64) -> Vec<f64> {
        (0..n).map(|_| noise(state)).collect()
    }

    /// First-order low pass: neighbouring samples correlate by `a`.
    fn coloured(n: usize, a: f64, state: &mut u64) -> Vec<f64> {
        let mut x = 0.0;
        (0..n)
            .map(|_| {
                x = a * x + noise(state);
                x
            })
            .collect()
    }

    /// Printed by SciPy 1.17.1 and NumPy:
    /// ```python
    /// import numpy as np; from scipy import signal, stats
    /// t = np.arange(300); e = np.sin(.7*t*t) ; u = np.cos(.11*t*t)
    /// e = e - e.mean(); u = u - u.mean()
    /// R = lambda a, b: signal.correlate(b, a) / 300  # index 299 + k: sum of a(t) b(t+k)
    /// r = R(e, e)[300:305] / R(e, e)[299]; c = R(u, e)[297:302] / (e.std() * u.std())
    /// k = np.arange(1, 6); print(repr(r), repr(c), 300*302*np.sum(r**2/(300-k)), stats.chi2.ppf(.99, 5))
    /// ```
    #[test]
    fn correlations_are_those_of_scipy() {
        let t: Vec<f64> = (0..300).map(f64::from).collect();
        let e: Vec<f64> = t.iter().map(|t| (0.7 * t * t).sin()).collect();
        let u: Vec<f64> = t.iter().map(|t| (0.11 * t * t).cos()).collect();
        let r = autocorrelation(&[&e], 5);
        let c = cross_correlation(&[&e], &[&u], 2);
        let q = whiteness(&[&e], 5);
        let near = |got: &[f64], expected: &[f64]| {
            for (g, e) in got.iter().zip(expected) {
                assert!((g - e).abs() < 1e-10, "{got:?}");
            }
        };
        near(
            &r.values,
            &[
                0.03431180961228107,
                0.008101247678590481,
                -0.01676668232528026,
                -0.02533306972802706,
                0.029970856467945874,
            ],
        );
        near(
            &c.values,
            &[
                0.056057226704186204,
                -0.034326261916054895,
                -0.026892786331085855,
                -0.13767517705674223,
                0.009151379941887685,
            ],
        );
        assert_eq!((r.first_lag, c.first_lag), (1, -2));
        assert!((q.statistic - 0.9347453981286835).abs() < 1e-8, "{}", q.statistic);
        assert!((q.bound / 15.08627246938899 - 1.0).abs() < 3e-3);
        assert!((r.bound * 300_f64.sqrt() - 2.575_829_3).abs() < 1e-6, "{}", r.bound);
    }

    /// Printed by NumPy and SciPy 1.17.1, for signals slow enough for the window to count:
    /// ```python
    /// import numpy as np; from scipy import signal, linalg
    /// n = 400; t = np.arange(n); f = lambda t: np.sin(.0009*t*t)
    /// e = f(t) + .3*np.sin(.7*t*t); u = np.cos(.0013*t*t) + .4*f(t-5)
    /// e = e - e.mean(); u = u - u.mean(); lags = 4; reach = 2*lags
    /// R = lambda a, b: signal.correlate(b, a)/n  # index n-1+k: sum of a(t) b(t+k)
    /// k = np.arange(-reach, reach+1); x = abs(k)/(reach+1)
    /// w = np.where(x <= .5, 1 - 6*x**2*(1-x), 2*(1-x)**3)
    /// P = [sum(w*R(e, e)[n-1+k]*R(u, u)[n-1+k+m]) for m in range(lags)]
    /// r = R(u, e)[n:n+lags]; C = linalg.toeplitz(P) + 1e-6*P[0]*np.eye(lags)
    /// print(n*r @ linalg.solve(C, r), 2.5758293035489*np.sqrt(P[0]/n)/(e.std()*u.std()))
    /// ```
    #[test]
    fn the_scatter_of_the_cross_correlation_is_bartletts_with_parzens_window() {
        let f = |t: f64| (0.0009 * t * t).sin();
        let t: Vec<f64> = (0..400).map(f64::from).collect();
        let e: Vec<f64> = t.iter().map(|t| f(*t) + 0.3 * (0.7 * t * t).sin()).collect();
        let u: Vec<f64> = t.iter().map(|t| (0.0013 * t * t).cos() + 0.4 * f(t - 5.0)).collect();
        let q = independence(&[&e], &[&u], 4);
        assert!((q.statistic / 1.8618632524061065 - 1.0).abs() < 1e-6, "{}", q.statistic);
        let bound = cross_correlation(&[&e], &[&u], 4).bound;
        assert!((bound / 0.21419506588710016 - 1.0).abs() < 1e-9, "{bound}");
    }

    /// An answer after one sample is found at that lag, by a test of that lag alone.
    #[test]
    fn feedback_is_looked_for_at_its_lag() {
        let state = &mut 21;
        let (e, u) = (white(3000, state), white(3000, state));
        let answer = |after: usize| -> Vec<f64> {
            (0..3000).map(|t| u[t] + if t >= after { 0.3 * e[t - after] } else { 0.0 }).collect()
        };
        assert!(!feedback(&[&e], &[&answer(1)], 1).pass);
        assert!(feedback(&[&e], &[&answer(2)], 1).pass && feedback(&[&e], &[&answer(0)], 1).pass);
    }

    #[test]
    fn the_lag_window_is_parzens() {
        for (x, w) in [(0.0, 1.0), (0.25, 0.71875), (0.5, 0.25), (-0.75, 0.03125), (1.0, 0.0)] {
            assert!((parzen(x) - w).abs() < 1e-15, "{x}");
        }
    }

    /// Tests at 99 % fail on 1 % of seeds where there is nothing to find, with white residuals as
    /// with coloured ones, white input as with a driver's slow one.
    #[test]
    fn tests_raise_a_false_alarm_as_often_as_stated() {
        const SEEDS: u64 = 400;
        for (pole_e, pole_u) in [(0.0, 0.0), (0.0, 0.95), (0.8, 0.9)] {
            let [mut not_white, mut dependent, mut fed_back, mut outside] = [0.0; 4];
            for seed in 0..SEEDS {
                let state = &mut (seed + 1);
                let e = coloured(1500, pole_e, state);
                let u = coloured(1500, pole_u, state);
                let (e, u): (Vec<&[f64]>, Vec<&[f64]>) =
                    (e.chunks(700).collect(), u.chunks(700).collect());
                let one = 1.0 / SEEDS as f64;
                not_white += one * f64::from(u8::from(!whiteness(&e, 25).pass));
                dependent += one * f64::from(u8::from(!independence(&e, &u, 25).pass));
                fed_back += one * f64::from(u8::from(!feedback(&e, &u, 25).pass));
                let c = cross_correlation(&e, &u, 10);
                let beyond = c.values.iter().filter(|v| v.abs() > c.bound).count();
                outside += one * beyond as f64 / c.values.len() as f64;
            }
            println!(
                "{pole_e} {pole_u}: white {not_white:.4} independent {dependent:.4} feedback {fed_back:.4} lags {outside:.4}"
            );
            assert!(pole_e > 0.0 || not_white < 0.03, "{not_white}");
            assert!(dependent < 0.04 && fed_back < 0.04, "{dependent} {fed_back}");
            assert!((0.002..0.03).contains(&outside), "{outside}");
        }
    }

    #[test]
    fn coloured_noise_missing_dynamics_and_feedback_are_found() {
        let state = &mut 7;
        let e = white(5000, state);
        let u = white(5000, state);
        let late = |x: &[f64], t: usize, k: usize| if t >= k { x[t - k] } else { 0.0 };
        let with = |x: &[f64], of: &[f64], share: f64, k: usize| -> Vec<f64> {
            (0..5000).map(|t| x[t] + share * late(of, t, k)).collect()
        };
        assert!(whiteness(&[&e], 25).pass && independence(&[&e], &[&u], 25).pass);
        assert!(!whiteness(&[&with(&e, &e, 0.1, 1)], 25).pass);
        let driven = with(&e, &u, 0.1, 3);
        assert!(!independence(&[&driven], &[&u], 25).pass);
        assert!(feedback(&[&driven], &[&u], 25).pass);
        let c = cross_correlation(&[&driven], &[&u], 25);
        assert!((c.values[25 + 3] - 0.1).abs() < 0.04 && c.values[25 + 3] > c.bound);
        // An input with a memory does not make feedback of missing dynamics.
        let state = &mut 8;
        for seed in 0..20 {
            *state = 100 + seed;
            let slow = coloured(3000, 0.97, state);
            let e: Vec<f64> = (0..3000).map(|t| noise(state) + 0.5 * late(&slow, t, 2)).collect();
            assert!(!independence(&[&e], &[&slow], 25).pass);
            let got = feedback(&[&e[..1700], &e[1700..]], &[&slow[..1700], &slow[1700..]], 25);
            assert!(got.statistic < 55.0, "{got:?}");
        }
        let steered = with(&u, &e, 0.1, 3);
        assert!(!feedback(&[&e], &[&steered], 25).pass);
        assert!(independence(&[&e], &[&steered], 25).pass);
        assert!(cross_correlation(&[&e], &[&steered], 25).values[25 - 3] > c.bound);
    }

    #[test]
    fn no_lag_reaches_over_a_gap() {
        // Correlated by the jump between the segments alone.
        let a = [1.0, -1.0, 1.0, -1.0];
        let joined = autocorrelation(&[&[a, a].concat()], 1).values[0];
        let apart = autocorrelation(&[&a, &a], 1).values[0];
        assert!((joined + 7.0 / 8.0).abs() < 1e-12 && (apart + 6.0 / 8.0).abs() < 1e-12);
        for empty in [&[][..], &[&[][..]], &[&[1.0][..]], &[&[2.0; 30][..]]] {
            assert_eq!(whiteness(empty, 25).statistic, 0.0);
            assert_eq!(independence(empty, empty, 25).statistic, 0.0);
            assert!(cross_correlation(empty, empty, 25).values.iter().all(|v| *v == 0.0));
        }
    }
}
