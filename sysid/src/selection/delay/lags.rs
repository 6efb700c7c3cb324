//! Least squares on lagged signals from lag sums: cost N·L, not N·L². With G_(i,a)(j,b) = Σ
//! z_a(t−i) z_b(t−j), `G_(i,a)(j,b) = G_(i−1,a)(j−1,b) + z_a(L−i) z_b(L−j) − z_a(N−i) z_b(N−j)`
//! follows from the first block row (covariance method).

use crate::Error;
use crate::data::DataSet;
use crate::linalg::dense;
use crate::linalg::dense::dot;
use faer::{Mat, Side};
use steerwright_drivelog::signal::mean;

/// Yaw rate and steering of one segment, or what takes their place.
pub(super) struct Pair {
    pub(super) y: Vec<f64>,
    pub(super) u: Vec<f64>,
}

/// Sums over all segments; index `2·lag + (0 for y, 1 for u)`.
struct Gram {
    sums: Mat<f64>,
    count: usize,
}

impl Gram {
    fn new(pairs: &[Pair], lags: usize) -> Self {
        let size = 2 * (lags + 1);
        let mut sums = Mat::zeros(size, size);
        let mut count = 0;
        for pair in pairs.iter().filter(|p| p.y.len() > lags) {
            let z = [pair.y.as_slice(), pair.u.as_slice()];
            let n = z[0].len();
            count += n - lags;
            // Column by column, so that each entry finds the one before it on its diagonal.
            let mut own = Mat::<f64>::zeros(size, size);
            for j in 0..=lags {
                for (a, b) in [(0, 0), (0, 1), (1, 0), (1, 1)] {
                    own[(a, 2 * j + b)] = dot(&z[a][lags..], &z[b][lags - j..n - j]);
                    for i in 1..=j {
                        own[(2 * i + a, 2 * j + b)] = own[(2 * i - 2 + a, 2 * j - 2 + b)]
                            + z[a][lags - i] * z[b][lags - j]
                            - z[a][n - i] * z[b][n - j];
                    }
                }
            }
            sums += &own;
        }
        // Below the diagonal blocks by symmetry.
        for j in 0..size {
            for i in j + 1..size {
                sums[(i, j)] = sums[(j, i)];
            }
        }
        Self { sums, count }
    }
}

/// The squared error of whitened signals, `y_f(t) − Σ g_k u_f(t−k)`, is `least + ‖target −
/// factor·g‖²` for impulse responses g.
pub(super) struct Quadratic {
    /// Upper triangular, lags by lags.
    pub(super) factor: Mat<f64>,
    pub(super) target: Vec<f64>,
    /// What no impulse response explains.
    pub(super) least: f64,
    pub(super) count: usize,
}

impl Quadratic {
    /// From the first input and output of the data, each segment's means removed.
    pub(super) fn new(data: &DataSet, lags: usize) -> Result<Self, Error> {
        let pairs: Vec<Pair> = data
            .segments()
            .iter()
            .map(|s| {
                let signal = |x: &[f64]| -> Vec<f64> {
                    let middle = mean(x);
                    x.iter().map(|x| x - middle).collect()
                };
                Pair { y: signal(s.y.row(0)), u: signal(s.u.row(0)) }
            })
            .collect();
        let denominator = denominator(&pairs, lags)?;
        let white: Vec<Pair> = pairs
            .iter()
            .filter(|p| p.y.len() > 2 * lags)
            .map(|p| Pair { y: whitened(&p.y, &denominator), u: whitened(&p.u, &denominator) })
            .collect();
        let gram = Gram::new(&white, lags);
        let past_u = |i: usize| 2 * (i + 1) + 1;
        let r = Mat::from_fn(lags, lags, |i, j| gram.sums[(past_u(i), past_u(j))]);
        let lower = cholesky(r)?;
        let target = forward(&lower, (0..lags).map(|i| gram.sums[(0, past_u(i))]).collect());
        let explained: f64 = target.iter().map(|x| x * x).sum();
        let power = gram.sums[(0, 0)];
        // Rounding leaves a noise-free record's remainder uncertain by this.
        let least = (power - explained).max(1e-13 * power);
        Ok(Self { factor: lower.transpose().to_owned(), target, least, count: gram.count })
    }
}

impl Quadratic {
    /// `factor·g`.
    #[inline(always)]
    pub(super) fn times(&self, g: &[f64]) -> Vec<f64> {
        const GROUP: usize = 4;
        let mut out = vec![0.0; g.len()];
        let columns: Vec<&[f64]> = (0..g.len()).map(|j| self.factor.col_as_slice(j)).collect();
        let mut first = 0;
        // Several columns at once, since a sum is read and written for each.
        for (x, columns) in g.as_chunks::<GROUP>().0.iter().zip(columns.as_chunks::<GROUP>().0) {
            let above = first + 1;
            let [a, b, c, d] = columns.map(|column| &column[..above]);
            for (i, o) in out[..above].iter_mut().enumerate() {
                *o = (((*o + a[i] * x[0]) + b[i] * x[1]) + c[i] * x[2]) + d[i] * x[3];
            }
            for (k, (x, column)) in x.iter().zip(columns).enumerate().skip(1) {
                for i in above..=first + k {
                    out[i] += column[i] * x;
                }
            }
            first += GROUP;
        }
        for (j, x) in g.iter().enumerate().skip(first) {
            for (o, f) in out[..=j].iter_mut().zip(columns[j]) {
                *o += f * x;
            }
        }
        out
    }
}

/// Coefficients a_1 … a_L of the one-step predictor ŷ(t) = Σ a_i y(t−i) + Σ b_i u(t−i).
fn denominator(pairs: &[Pair], lags: usize) -> Result<Vec<f64>, Error> {
    let gram = Gram::new(pairs, lags);
    // The input's scale is brought to the output's: the ridge must not prefer one of them.
    let power = |i: usize| gram.sums[(i, i)].sqrt().max(f64::MIN_POSITIVE);
    let scale = [power(0), power(1)];
    let at = |i: usize, j: usize| gram.sums[(i, j)] / (scale[i % 2] * scale[j % 2]);
    let r = Mat::from_fn(2 * lags, 2 * lags, |i, j| at(i + 2, j + 2));
    let rhs = (0..2 * lags).map(|i| at(i + 2, 0)).collect();
    let lower = cholesky(r)?;
    let mut x = forward(&lower, rhs);
    for i in (0..x.len()).rev() {
        let known: f64 = (i + 1..x.len()).map(|j| lower[(j, i)] * x[j]).sum();
        x[i] = (x[i] - known) / lower[(i, i)];
    }
    Ok(x.into_iter().step_by(2).collect())
}

fn forward(lower: &Mat<f64>, mut x: Vec<f64>) -> Vec<f64> {
    for i in 0..x.len() {
        let known: f64 = (0..i).map(|j| lower[(i, j)] * x[j]).sum();
        x[i] = (x[i] - known) / lower[(i, i)];
    }
    x
}

/// Lower factor of a Gram matrix with a ridge of rounding's size, for smooth signals.
fn cholesky(mut gram: Mat<f64>) -> Result<Mat<f64>, Error> {
    let n = gram.nrows();
    let trace: f64 = (0..n).map(|i| gram[(i, i)]).sum();
    let mut ridge = 1e-12 * trace / n as f64;
    for _ in 0..4 {
        for i in 0..n {
            gram[(i, i)] += ridge;
        }
        if let Ok(llt) = gram.llt(Side::Lower) {
            let lower = llt.L().to_owned();
            if dense::is_finite(lower.as_ref()) {
                return Ok(lower);
            }
        }
        ridge *= 100.0;
    }
    Err(Error::Numerical { what: "Gram matrix of the lagged signals" })
}

/// x(t) − Σ a_i x(t−i) from the first instant that has all of its past.
fn whitened(x: &[f64], a: &[f64]) -> Vec<f64> {
    let reversed: Vec<f64> = a.iter().rev().copied().collect();
    (a.len()..x.len()).map(|t| x[t] - dot(&reversed, &x[t - a.len()..t])).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn whitening_takes_the_past_in_its_order() {
        // x(t) − 0.5 x(t−1) + 0.2 x(t−2).
        let got = whitened(&[1.0, 2.0, 4.0, -3.0], &[0.5, -0.2]);
        let expected = [4.0 - 1.0 + 0.2, -3.0 - 2.0 + 0.4];
        assert!(got.iter().zip(expected).all(|(g, e)| (g - e).abs() < 1e-15), "{got:?}");
        assert_eq!(got.len(), 2);
    }
}
