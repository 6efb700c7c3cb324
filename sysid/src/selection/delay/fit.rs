//! The best model of one order, with a given delay or with its own.
//!
//! Variable projection (Golub and Pereyra 1973): for given poles and delay the numerator is a linear
//! least-squares problem, and Levenberg–Marquardt steps move poles and delay on what it leaves.

use crate::Error;
use crate::data::held_input::ContinuousResponse;
use crate::linalg::dense::{RANK_TOLERANCE, column, least_squares, short_dot};
use crate::linalg::levenberg_marquardt::{Damping, lower};
use crate::selection::delay::lags::Quadratic;
use crate::selection::delay::response::{basis, polynomial, with_pole};
use faer::Mat;
use pulp::{Arch, Simd, WithSimd};
use std::convert::Infallible;

/// A model with its cost; times in samples.
#[derive(Debug, Clone)]
pub(super) struct Fit {
    /// Poles, as [`polynomial`] takes them.
    pub(super) parameters: Vec<f64>,
    pub(super) delay: f64,
    /// Squared whitened error beyond the least.
    pub(super) excess: f64,
}

/// Bounds of ln of the coefficients: 1/20 to 1000 samples.
const BOUNDS: (f64, f64) = (-14.0, 6.0);

/// Which numerators a model may have.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Zeros {
    /// Two poles with a zero, and lags without one, which cannot take the shape of a delay.
    Vehicle,
    /// As many as a held input allows.
    Free,
}

/// The target of the fit and the candidates.
#[derive(Clone, Copy)]
pub(super) struct Search<'a> {
    pub(super) q: &'a Quadratic,
    /// Longest delay, samples.
    pub(super) most: f64,
    pub(super) zeros: Zeros,
    /// Time constant of a lag that every model has in addition to its poles, samples; 0 for none.
    pub(super) lag: f64,
}

impl Search<'_> {
    pub(super) fn numerators(&self, order: usize) -> usize {
        if self.zeros == Zeros::Free || order < 3 { order } else { order - 1 }
    }
}

impl Fit {
    pub(super) fn order(&self) -> usize {
        self.parameters.len()
    }

    /// From these poles and this delay, which stays unless it is `free`.
    pub(super) fn new(
        search: &Search<'_>,
        parameters: &[f64],
        delay: f64,
        free: bool,
        steps: usize,
    ) -> Self {
        let q = search.q;
        let n = parameters.len();
        let mut x: Vec<f64> = parameters.to_vec();
        x.push(delay);
        let unknowns = if free { n + 1 } else { n };
        let residual = left(search, &x);
        let cost = squares(&residual);
        let Ok(reached) = lower::<_, _, Infallible>(
            ((x, residual), cost),
            steps,
            Damping { first: 1e-3, fall: 0.1, least: 1e-10, rise: 10.0, tries: 6 },
            // What is left to gain is negligible compared with the noise.
            |before, now| before - now > 1e-3 * (q.least / q.count.max(1) as f64) + 1e-6 * now,
            |(x, residual), _| Ok(Some(jacobian(search, x, residual, unknowns))),
            |(x, residual), jacobian, damping| {
                let mut trial = x.clone();
                for (t, s) in trial.iter_mut().zip(&damped(jacobian, residual, damping)) {
                    *t += s.clamp(-1.5, 1.5);
                }
                bound(&mut trial, search.most);
                let residual = left(search, &trial);
                let cost = squares(&residual);
                Ok(Some(((trial, residual), cost)))
            },
        );
        let ((mut x, _), cost) = (reached.point, reached.cost);
        let delay = x.pop().unwrap_or(0.0);
        Self { parameters: x, delay, excess: cost }
    }

    /// The model without its delay; `sample` is a sample in s.
    pub(super) fn response(
        &self,
        search: &Search<'_>,
        sample: f64,
    ) -> Result<ContinuousResponse, Error> {
        let q = search.q;
        let a = polynomial(&self.parameters);
        let n = a.len();
        let first = n - search.numerators(n);
        let columns: Vec<Vec<f64>> = basis(&a, self.delay, q.target.len())
            .iter()
            .skip(first)
            .map(|column| q.times(column))
            .collect();
        let columns = Mat::from_fn(q.target.len(), columns.len(), |i, j| columns[j][i]);
        let numerator =
            least_squares(columns.as_ref(), column(&q.target).as_ref(), RANK_TOLERANCE)?;
        Ok(ContinuousResponse {
            f: Mat::from_fn(n, n, |i, j| match j {
                0 => -a[i] / sample,
                _ if j == i + 1 => 1.0 / sample,
                _ => 0.0,
            }),
            g: Mat::from_fn(
                n,
                1,
                |i, _| {
                    if i < first { 0.0 } else { numerator[(i - first, 0)] / sample }
                },
            ),
            h: Mat::from_fn(1, n, |_, j| if j == 0 { 1.0 } else { 0.0 }),
            d: 0.0,
        })
    }

    /// Variance of the delay over the noise's; `None` where the data do not determine it.
    pub(super) fn delay_variance(&self, search: &Search<'_>) -> Option<f64> {
        let mut x = self.parameters.clone();
        x.push(self.delay);
        let n = x.len();
        let jacobian = jacobian(search, &x, &left(search, &x), n);
        // The delay's column, what the poles explain of it taken away.
        let mut delay = jacobian.last().cloned().unwrap_or_default();
        let full = squares(&delay);
        let mut orthogonal: Vec<Vec<f64>> = Vec::new();
        for mut column in jacobian.into_iter().take(n - 1) {
            let size = squares(&column);
            without(&mut column, &orthogonal);
            // A pole far beyond the samples moves nothing: no direction to take away.
            let left = squares(&column);
            if left > 1e-8 * size && left > 1e-10 * full {
                column.iter_mut().for_each(|x| *x /= left.sqrt());
                orthogonal.push(column);
            }
        }
        without(&mut delay, &orthogonal);
        let information = squares(&delay);
        if information > 1e-12 * full { Some(1.0 / information) } else { None }
    }
}

fn bound(x: &mut [f64], most: f64) {
    let n = x.len() - 1;
    for p in &mut x[..n] {
        *p = p.clamp(BOUNDS.0, BOUNDS.1);
    }
    x[n] = x[n].clamp(0.0, most);
}

fn left(search: &Search<'_>, x: &[f64]) -> Vec<f64> {
    Arch::new().dispatch(Left { search, x })
}

struct Left<'a> {
    search: &'a Search<'a>,
    x: &'a [f64],
}

impl WithSimd for Left<'_> {
    type Output = Vec<f64>;

    /// The same sums whatever the vectors are.
    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> Vec<f64> {
        let Self { search, x } = self;
        let q = search.q;
        let n = x.len() - 1;
        let mut a = polynomial(&x[..n]);
        if search.lag > 0.0 {
            a = with_pole(&a, 1.0 / search.lag);
        }
        let columns = basis(&a, x[n], q.target.len());
        let mut residual = q.target.clone();
        let mut orthogonal: Vec<Vec<f64>> = Vec::with_capacity(n);
        for column in columns.into_iter().skip(a.len() - search.numerators(n)) {
            let mut c = q.times(&column);
            let full = squares(&c);
            without(&mut c, &orthogonal);
            let size = squares(&c);
            if size > 1e-20 * full {
                let norm = size.sqrt();
                c.iter_mut().for_each(|x| *x /= norm);
                let along = short_dot(&c, &residual);
                residual.iter_mut().zip(&c).for_each(|(r, c)| *r -= along * c);
                orthogonal.push(c);
            }
        }
        residual
    }
}

/// Takes what lies along orthonormal columns out of `x`; twice is enough (Kahan and Parlett).
#[inline(always)]
fn without(x: &mut [f64], orthonormal: &[Vec<f64>]) {
    for _ in 0..2 {
        for o in orthonormal {
            let along = short_dot(o, x);
            x.iter_mut().zip(o).for_each(|(x, o)| *x -= along * o);
        }
    }
}

/// Columns of derivatives of [`left`] by the first unknowns.
fn jacobian(search: &Search<'_>, x: &[f64], residual: &[f64], unknowns: usize) -> Vec<Vec<f64>> {
    const STEP: f64 = 1e-4;
    // The delay is last, and is differenced towards the inside.
    (0..x.len())
        .map(|i| {
            if i >= unknowns {
                return vec![0.0; residual.len()];
            }
            let h = if i + 1 == x.len() && x[i] + STEP > search.most { -STEP } else { STEP };
            let mut moved = x.to_vec();
            moved[i] += h;
            left(search, &moved).iter().zip(residual).map(|(a, b)| (a - b) / h).collect()
        })
        .collect()
}

/// −(JᵀJ + λ·diag)⁻¹ Jᵀ r by Cholesky; zero for a column of zeros.
fn damped(columns: &[Vec<f64>], residual: &[f64], damping: f64) -> Vec<f64> {
    let n = columns.len();
    let mut m = vec![vec![0.0; n]; n];
    for i in 0..n {
        for j in 0..=i {
            m[i][j] = short_dot(&columns[i], &columns[j]);
        }
        m[i][i] = m[i][i] * (1.0 + damping) + f64::MIN_POSITIVE;
    }
    let mut x: Vec<f64> = columns.iter().map(|c| -short_dot(c, residual)).collect();
    for i in 0..n {
        for j in 0..=i {
            let known: f64 = (0..j).map(|k| m[i][k] * m[j][k]).sum();
            let value = m[i][j] - known;
            m[i][j] = if i == j { value.max(1e-14 * m[i][i]).sqrt() } else { value / m[j][j] };
        }
        let known: f64 = (0..i).map(|k| m[i][k] * x[k]).sum();
        x[i] = (x[i] - known) / m[i][i];
    }
    for i in (0..n).rev() {
        let known: f64 = (i + 1..n).map(|k| m[k][i] * x[k]).sum();
        x[i] = (x[i] - known) / m[i][i];
    }
    x
}

#[inline(always)]
fn squares(x: &[f64]) -> f64 {
    short_dot(x, x)
}

#[cfg(test)]
mod tests {
    use super::*;

    const COUNT: usize = 60;

    /// Evaluates impulse responses by their distance to that of the model with these poles, numerator
    /// (highest power first) and delay.
    fn like(poles: &[f64], numerator: &[f64], delay: f64) -> Quadratic {
        let columns = basis(&polynomial(poles), delay, COUNT);
        let sum = |k: usize| columns.iter().zip(numerator).map(|(c, b)| b * c[k]).sum();
        Quadratic {
            factor: Mat::identity(COUNT, COUNT),
            target: (0..COUNT).map(sum).collect(),
            least: 1e-12,
            count: 1000,
        }
    }

    fn share_left(q: &Quadratic, zeros: Zeros, poles: &[f64]) -> f64 {
        let search = Search { q, most: 12.0, zeros, lag: 0.0 };
        squares(&left(&search, &[poles, &[0.0]].concat())) / squares(&q.target)
    }

    /// Two poles and a zero, and with a third pole no second zero: what has one is out of reach of a
    /// vehicle's numerators, and within that of free ones.
    #[test]
    fn numerators_of_a_vehicle_have_two_powers_less_than_its_poles_and_a_lags() {
        let poles = [0.5_f64.ln(), 0.1_f64.ln(), 0.8_f64.ln()];
        for (count, vehicle) in [(1, true), (2, true), (3, false)] {
            let mut numerator = vec![0.0; 3 - count];
            numerator.extend([1.0, -0.4, 0.3].iter().take(count));
            let q = like(&poles, &numerator, 0.0);
            assert!(share_left(&q, Zeros::Free, &poles) < 1e-20);
            let left = share_left(&q, Zeros::Vehicle, &poles);
            assert!(if vehicle { left < 1e-20 } else { left > 1e-3 }, "{count}: {left:e}");
        }
        for count in [1, 2] {
            let mut numerator = vec![0.0; 2 - count];
            numerator.extend([1.0, -0.4].iter().take(count));
            let q = like(&poles[..2], &numerator, 0.0);
            assert!(share_left(&q, Zeros::Vehicle, &poles[..2]) < 1e-20, "{count}");
        }
        let search = |q| Search { q, most: 12.0, zeros: Zeros::Vehicle, lag: 0.0 };
        let q = like(&poles, &[0.0, 1.0, 0.4], 0.0);
        assert_eq!([1, 2, 3, 4, 5].map(|n| search(&q).numerators(n)), [1, 2, 2, 3, 4]);
    }

    /// The delay's variance is that of least squares with all unknowns together, numerators included:
    /// the inverse of the information of poles, numerators and delay.
    #[test]
    fn the_delays_variance_is_that_of_all_unknowns_together() {
        let poles = [0.5_f64.ln(), 0.1_f64.ln()];
        let (numerator, delay) = ([1.0, 0.4], 2.4);
        let q = like(&poles, &numerator, delay);
        let response = |x: &[f64]| -> Vec<f64> {
            let columns = basis(&polynomial(&x[..2]), x[4], COUNT);
            (0..COUNT).map(|k| x[2] * columns[0][k] + x[3] * columns[1][k]).collect()
        };
        let x = [poles[0], poles[1], numerator[0], numerator[1], delay];
        let slopes = Mat::from_fn(COUNT, 5, |k, j| {
            let moved = |by: f64| {
                let mut x = x;
                x[j] += by;
                response(&x)[k]
            };
            (moved(1e-5) - moved(-1e-5)) / 2e-5
        });
        let information = slopes.transpose() * &slopes;
        let inverse = crate::linalg::dense::solve(
            information.as_ref(),
            crate::linalg::dense::identity(5).as_ref(),
        );
        let fit = Fit { parameters: poles.to_vec(), delay, excess: 0.0 };
        let search = Search { q: &q, most: 12.0, zeros: Zeros::Vehicle, lag: 0.0 };
        let got = fit.delay_variance(&search).unwrap();
        assert!((got / inverse[(4, 4)] - 1.0).abs() < 0.02, "{got} {}", inverse[(4, 4)]);
    }
}
