//! The VARX model: one-step prediction from the p last samples, by least squares.

use crate::Error;
use crate::linalg::dense::{RANK_TOLERANCE, hcat, least_squares, r_factor};
use crate::subspace::closed_loop::windows::{Signals, Windows};
use crate::subspace::factor::Factor;
use faer::{Mat, MatRef};

/// `ŷ(t) = D u(t) + Σ_{j=1..p} Ξ_j z(t−j)` with z = [u; y] and Ξ_j = C Ã^{j−1} B̃.
#[derive(Debug, Clone, PartialEq)]
pub struct Predictor {
    /// Ξ_1 … Ξ_p, each ny by nu+ny.
    pub markov: Vec<Mat<f64>>,
    /// D, ny by nu; zero where no feedthrough was requested.
    pub feedthrough: Mat<f64>,
    /// Covariance of the one-step error, ny by ny.
    pub innovation: Mat<f64>,
}

impl Predictor {
    /// Fits the VARX model of order `past`.
    ///
    /// # Errors
    /// As [`decompose`](crate::subspace::closed_loop::decompose).
    pub fn new(factor: &Factor, past: usize, feedthrough: bool) -> Result<Self, Error> {
        let windows = Windows::new(factor)?;
        windows.holds(past + 1)?;
        let scaled = Self::in_units(&windows, past, feedthrough)?;
        let (u, y) = (&windows.input_scale, &windows.output_scale);
        let m = windows.inputs;
        let of = |j: usize| if j < m { u[j] } else { y[j - m] };
        let back =
            |x: &Mat<f64>| Mat::from_fn(x.nrows(), x.ncols(), |i, j| x[(i, j)] * y[i] / of(j));
        Ok(Self {
            markov: scaled.markov.iter().map(back).collect(),
            feedthrough: back(&scaled.feedthrough),
            innovation: Mat::from_fn(y.len(), y.len(), |i, j| {
                scaled.innovation[(i, j)] * y[i] * y[j]
            }),
        })
    }

    pub(crate) fn in_units(
        windows: &Windows,
        past: usize,
        feedthrough: bool,
    ) -> Result<Self, Error> {
        let (m, p, width) = (windows.inputs, windows.outputs, windows.channels());
        let mut regressors = windows.take(0..past, Signals::Z);
        if feedthrough {
            let now = windows.take(past..past + 1, Signals::U);
            regressors = hcat(&[regressors.as_ref(), now.as_ref()]);
        }
        let y = windows.take(past..past + 1, Signals::Y);
        let theta = least_squares(regressors.as_ref(), y.as_ref(), RANK_TOLERANCE)?;
        let error = y - regressors * &theta;
        // Lag j = 1 is the last block of the window's past.
        let block =
            |from: usize, columns: usize| Mat::from_fn(p, columns, |i, j| theta[(from + j, i)]);
        Ok(Self {
            markov: (1..=past).map(|j| block((past - j) * width, width)).collect(),
            feedthrough: if feedthrough { block(past * width, m) } else { Mat::zeros(p, m) },
            innovation: error.transpose() * &error,
        })
    }

    /// p.
    #[must_use]
    pub fn past(&self) -> usize {
        self.markov.len()
    }
}

/// The past horizon for a factor: the order of the VARX model of least AIC, `N ln det Σ_p +
/// 2·p·ny·(nu + ny)`, among 1 to `most`, all from one R factor on the same samples. Where the bias
/// is to vanish in the variance, take a multiple: D. Bauer (Automatica 41, 2005) uses 2p.
///
/// # Errors
/// As [`decompose`](crate::subspace::closed_loop::decompose), for `most + 1` lags.
pub fn past_horizon(factor: &Factor, most: usize, feedthrough: bool) -> Result<usize, Error> {
    if most == 0 {
        return Err(Error::option("past horizon", 0, "1 or more"));
    }
    let windows = Windows::new(factor)?;
    windows.holds(most + 1)?;
    order_in(&windows, most, feedthrough)
}

pub(crate) fn order_in(windows: &Windows, most: usize, feedthrough: bool) -> Result<usize, Error> {
    let (p, width) = (windows.outputs, windows.channels());
    let now = windows.take(most..most + 1, Signals::U);
    let blocks: Vec<Mat<f64>> =
        (0..most).rev().map(|lag| windows.take(lag..lag + 1, Signals::Z)).collect();
    let y = windows.take(most..most + 1, Signals::Y);
    let mut parts: Vec<MatRef<'_, f64>> = Vec::with_capacity(most + 2);
    if feedthrough {
        parts.push(now.as_ref());
    }
    let start = parts.iter().map(|x| x.ncols()).sum::<usize>();
    parts.extend(blocks.iter().map(|x| x.as_ref()));
    parts.push(y.as_ref());
    let r = r_factor(hcat(&parts).as_ref());
    let of_y = r.get(.., start + most * width..);
    let n = windows.count as f64;
    let mut best = (f64::INFINITY, 1);
    for order in 1..=most {
        let rest = of_y.get((start + order * width).min(of_y.nrows()).., ..);
        // Data without noise leave rounding, which must not decide.
        let covariance = Mat::from_fn(p, p, |i, j| {
            let floor = if i == j { 1e-20 } else { 0.0 };
            floor + (rest.col(i).transpose() * rest.col(j))
        });
        let parameters = (order * p * width) as f64;
        let value = n * covariance.determinant().max(f64::MIN_POSITIVE).ln() + 2.0 * parameters;
        if value < best.0 {
            best = (value, order);
        }
    }
    Ok(best.1)
}
