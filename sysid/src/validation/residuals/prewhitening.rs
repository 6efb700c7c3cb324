//! Prewhitening: a signal less its prediction from its own past.

use crate::linalg::dense::solve;
use faer::Mat;

pub(crate) fn centred(x: &[&[f64]]) -> Vec<Vec<f64>> {
    let count: usize = x.iter().map(|s| s.len()).sum();
    let sum: f64 = x.iter().map(|s| s.iter().sum::<f64>()).sum();
    let mean = if count > 0 { sum / count as f64 } else { 0.0 };
    x.iter().map(|s| s.iter().map(|v| v - mean).collect()).collect()
}

/// A signal less its prediction from its past `order` samples by least squares, from sample `order` of
/// each segment on. The Gram matrix of the lags is updated along its diagonals.
pub(crate) fn prewhitened(x: &[&[f64]], order: usize) -> Vec<Vec<f64>> {
    let x = centred(x);
    let count = order + 1;
    let mut gram = Mat::<f64>::zeros(count, count);
    for x in x.iter().filter(|x| x.len() > order) {
        // Row i is the signal i samples ago: G(i, j) = Σ x(t−i) x(t−j), t from `order` on.
        let n = x.len();
        for lag in 0..count {
            let mut g: f64 = x[order..].iter().zip(&x[order - lag..]).map(|(a, b)| a * b).sum();
            for i in 0..count - lag {
                gram[(i, i + lag)] += g;
                if lag > 0 {
                    gram[(i + lag, i)] += g;
                }
                let (first, last) = (order - i, n - 1 - i);
                if i + lag + 1 < count {
                    g += x[first - 1] * x[first - 1 - lag] - x[last] * x[last - lag];
                }
            }
        }
    }
    // A band-limited signal is determined by its past to rounding: the ridge bounds the weights.
    let ridge = 1e-9 * gram[(0, 0)];
    let past = Mat::from_fn(order, order, |i, j| {
        gram[(i + 1, j + 1)] + if i == j { ridge.max(f64::MIN_POSITIVE) } else { 0.0 }
    });
    let now = Mat::from_fn(order, 1, |i, _| gram[(i + 1, 0)]);
    let weights = solve(past.as_ref(), now.as_ref());
    x.iter()
        .map(|x| {
            let predicted =
                |t: usize| (0..order).map(|i| weights[(i, 0)] * x[t - 1 - i]).sum::<f64>();
            (order..x.len()).map(|t| x[t] - predicted(t)).collect()
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Against least squares written out, in two segments.
    #[test]
    fn prewhitening_is_what_least_squares_leaves() {
        // A slow signal that no few lags determine.
        let x: Vec<f64> = (0..300)
            .map(f64::from)
            .map(|t| (0.0009 * t * t).sin() + 0.3 * (0.7 * t * t).sin() + 0.2)
            .collect();
        let segments = [&x[..120], &x[120..]];
        let order = 3;
        let mean = x.iter().sum::<f64>() / 300.0;
        let at = |s: &[f64], t: usize| s[t] - mean;
        let rows: Vec<(Vec<f64>, f64)> = segments
            .iter()
            .flat_map(|s| {
                (order..s.len()).map(|t| ((1..=order).map(|i| at(s, t - i)).collect(), at(s, t)))
            })
            .collect();
        let past = Mat::from_fn(rows.len(), order, |i, j| rows[i].0[j]);
        let now = Mat::from_fn(rows.len(), 1, |i, _| rows[i].1);
        let weights =
            crate::linalg::dense::least_squares(past.as_ref(), now.as_ref(), 1e-14).unwrap();
        let left = &now - &past * &weights;
        let got = prewhitened(&segments, order).concat();
        assert_eq!(got.len(), rows.len());
        for (i, g) in got.iter().enumerate() {
            assert!((g - left[(i, 0)]).abs() < 1e-6, "{i}: {g} {}", left[(i, 0)]);
        }
    }
}
