//! The autocovariance of errors as a filter: an autoregression of ny channels, its order that of
//! least AIC.
//!
//! `Σ_t Σ_s ψ(t)ᵀ R(t−s) ψ(s)` for errors v of autocovariance R(τ) is, with the autoregression
//! `v(−t) = Σ A_k v(−t+k) + e'`, `E e'e'ᵀ = Λ'`, of the time-reversed errors, `Σ_t ψ̄(t)ᵀ Λ' ψ̄(t)`
//! for `ψ̄(t) = ψ(t) + Σ A_kᵀ ψ̄(t−k)` (Ljung 1999, eq 9.42).

use crate::Error;
use crate::linalg::dense::{positive_part, solve};
use faer::{Mat, Side};

const ORDERS: [usize; 12] = [0, 1, 2, 3, 4, 6, 8, 12, 16, 24, 32, 48];

pub(super) struct Autocovariance {
    channels: usize,
    lags: usize,
    /// R(τ) times the count, τ from 0, each row by row.
    sums: Vec<f64>,
    /// The samples so far, all channels of the oldest first.
    past: Vec<f64>,
    count: usize,
}

impl Autocovariance {
    pub(super) fn new(channels: usize, samples: usize) -> Self {
        let lags = (samples / (10 * channels)).min(ORDERS[ORDERS.len() - 1]);
        Self {
            channels,
            lags,
            sums: vec![0.0; (lags + 1) * channels * channels],
            past: Vec::new(),
            count: 0,
        }
    }

    /// Forgets the past: what comes is no continuation.
    pub(super) fn break_off(&mut self) {
        self.past.clear();
    }

    pub(super) fn push(&mut self, v: &[f64]) {
        let p = self.channels;
        if self.past.len() > 8 * (self.lags + 1) * p {
            self.past.drain(..self.past.len() - self.lags * p);
        }
        self.past.extend_from_slice(v);
        let newest_first = self.past.rchunks_exact(p);
        for (sum, before) in self.sums.chunks_exact_mut(p * p).zip(newest_first) {
            for (row, v) in sum.chunks_exact_mut(p).zip(v) {
                for (sum, before) in row.iter_mut().zip(before) {
                    *sum += v * before;
                }
            }
        }
        self.count += 1;
    }

    pub(super) fn reversed(&self) -> Result<Autoregression, Error> {
        let p = self.channels;
        let scale = 1.0 / self.count.max(1) as f64;
        // R'(τ) = R(τ)ᵀ, R'(−τ) = R(τ).
        let r = |lag: isize, i: usize, j: usize| {
            let at = lag.unsigned_abs() * p * p;
            scale * self.sums[at + if lag >= 0 { j * p + i } else { i * p + j }]
        };
        let mut best: Option<(f64, Autoregression)> = None;
        for order in ORDERS.into_iter().filter(|order| *order <= self.lags) {
            let size = order * p;
            let toeplitz = Mat::from_fn(size, size, |row, column| {
                r((column / p) as isize - (row / p) as isize, row % p, column % p)
                    + if row == column { 1e-12 * r(0, row % p, row % p) } else { 0.0 }
            });
            let right =
                Mat::from_fn(p, size, |i, column| r((column / p + 1) as isize, i, column % p));
            let a = if size == 0 {
                Mat::zeros(p, 0)
            } else {
                solve(toeplitz.transpose(), right.transpose()).transpose().to_owned()
            };
            let remaining = Mat::from_fn(p, p, |i, j| r(0, i, j)) - &a * right.transpose();
            let innovation = positive_part(remaining.as_ref())?;
            let determinant = innovation.determinant();
            let aic = self.count as f64 * determinant.max(1e-300).ln() + 2.0 * (size * p) as f64;
            if determinant.is_finite() && best.as_ref().is_none_or(|(least, _)| aic < *least) {
                let a = (0..order).map(|k| a.get(.., k * p..(k + 1) * p).to_owned()).collect();
                best = Some((aic, Autoregression { a, innovation }));
            }
        }
        best.map(|(_, model)| model)
            .ok_or(Error::Numerical { what: "autocovariance of the simulation errors" })
    }
}

/// `v(t) = Σ A_k v(t−k) + e`.
pub(super) struct Autoregression {
    a: Vec<Mat<f64>>,
    innovation: Mat<f64>,
}

impl Autoregression {
    /// A filter of rows ψ (ny rows of `width`) to chol(Λ)ᵀψ̄.
    pub(super) fn filter(&self, width: usize) -> Result<RowFilter<'_>, Error> {
        let p = self.innovation.nrows();
        let size = (0..p).map(|i| self.innovation[(i, i)]).sum::<f64>();
        let near = Mat::from_fn(p, p, |i, j| {
            self.innovation[(i, j)] + if i == j { 1e-14 * size } else { 0.0 }
        });
        let factor = match near.llt(Side::Lower) {
            Ok(cholesky) => cholesky.L().transpose().to_owned(),
            Err(_) if size == 0.0 => Mat::zeros(p, p),
            Err(_) => return Err(Error::Numerical { what: "covariance of the simulation errors" }),
        };
        let past = std::collections::VecDeque::from(vec![vec![0.0; p * width]; self.a.len()]);
        Ok(RowFilter { model: self, factor, past, width })
    }
}

pub(super) struct RowFilter<'a> {
    model: &'a Autoregression,
    factor: Mat<f64>,
    past: std::collections::VecDeque<Vec<f64>>,
    width: usize,
}

impl RowFilter<'_> {
    /// Adds ψ, stores ψ̄, and calls `visit` with each row of chol(Λ)ᵀψ̄.
    pub(super) fn push(&mut self, psi: &[f64], mut visit: impl FnMut(&[f64])) {
        let (p, width) = (self.factor.nrows(), self.width);
        let mut now = self.past.pop_back().unwrap_or_else(|| vec![0.0; p * width]);
        // The oldest is needed still: A_k of the last k is applied from a copy.
        let oldest = now.clone();
        now.copy_from_slice(psi);
        let before = self.past.iter().map(Vec::as_slice).chain(std::iter::once(oldest.as_slice()));
        for (a, before) in self.model.a.iter().zip(before) {
            for i in 0..p {
                for j in 0..p {
                    let factor = a[(j, i)];
                    let from = &before[j * width..(j + 1) * width];
                    for (o, v) in now[i * width..(i + 1) * width].iter_mut().zip(from) {
                        *o += factor * v;
                    }
                }
            }
        }
        let mut row = vec![0.0; width];
        for i in 0..p {
            row.fill(0.0);
            for j in i..p {
                let from = &now[j * width..(j + 1) * width];
                for (o, v) in row.iter_mut().zip(from) {
                    *o += self.factor[(i, j)] * v;
                }
            }
            visit(&row);
        }
        if !self.model.a.is_empty() {
            self.past.push_front(now);
        }
    }

    /// How many rows of zeros the filter is to be run on for its response to end.
    pub(super) fn tail(&self) -> usize {
        20 * self.model.a.len()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A reproducible white sequence of unit variance.
    fn white(state: &mut u64) -> f64 {
        *state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
        ((*state >> 11) as f64 / (1_u64 << 53) as f64 - 0.5) * 12_f64.sqrt()
    }

    /// Σ_t Σ_s ψ(t)ᵀ R(t−s) ψ(s) by the filter, for v(t) = A v(t−1) + e with an A that is far from
    /// symmetric, against the sum written out with R(τ) = A^τ R(0).
    #[test]
    fn the_filter_returns_the_double_sum_over_the_autocovariance() {
        const COUNT: usize = 6;
        let a = Mat::from_fn(2, 2, |i, j| [[0.7, 0.5], [-0.3, 0.6]][i][j]);
        let mut products = Autocovariance::new(2, 60_000);
        let (mut v, mut state) = ([0.0; 2], 1);
        for _ in 0..60_000 {
            let e = [white(&mut state), 0.5 * white(&mut state)];
            v = std::array::from_fn(|i| a[(i, 0)] * v[0] + a[(i, 1)] * v[1] + e[i]);
            products.push(&v);
        }
        // R(0) = A R(0) Aᵀ + E eeᵀ.
        let mut zero = Mat::<f64>::zeros(2, 2);
        for _ in 0..200 {
            let e = Mat::from_fn(2, 2, |i, j| if i == j { [1.0, 0.25][i] } else { 0.0 });
            zero = &a * &zero * a.transpose() + e;
        }
        let r = |lag: isize| {
            let mut r = zero.clone();
            for _ in 0..lag.unsigned_abs() {
                r = &a * r;
            }
            if lag >= 0 { r } else { r.transpose().to_owned() }
        };
        let psi: Vec<Mat<f64>> =
            (0..COUNT).map(|_| Mat::from_fn(2, 3, |_, _| white(&mut state))).collect();
        let mut expected = Mat::<f64>::zeros(3, 3);
        for (t, of_t) in psi.iter().enumerate() {
            for (s, of_s) in psi.iter().enumerate() {
                expected += of_t.transpose() * r(t as isize - s as isize) * of_s;
            }
        }
        let model = products.reversed().unwrap();
        let mut filter = model.filter(3).unwrap();
        let mut got = Mat::<f64>::zeros(3, 3);
        let mut add = |row: &[f64]| {
            for i in 0..3 {
                for j in 0..3 {
                    got[(i, j)] += row[i] * row[j];
                }
            }
        };
        for psi in &psi {
            filter.push(&crate::linalg::dense::rows(psi.as_ref()), &mut add);
        }
        for _ in 0..filter.tail() {
            filter.push(&[0.0; 6], &mut add);
        }
        let apart = (&got - &expected).norm_max() / expected.norm_max();
        assert!(apart < 0.03, "{apart}: {got:?} {expected:?}");
    }

    #[test]
    fn white_errors_have_no_autoregression() {
        let mut products = Autocovariance::new(1, 5000);
        let mut state = 3;
        for _ in 0..5000 {
            products.push(&[white(&mut state)]);
        }
        assert!(products.reversed().unwrap().a.len() <= 2);
    }
}
