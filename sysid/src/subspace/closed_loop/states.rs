//! From states to A, B, C, D, K by least squares, for any order.
//!
//! With x = T z_p at two consecutive samples, C, D and the innovations follow from `y = C x + D u + e`,
//! and the rest from `x⁺ = A x + B u + K e`. The states of order n are the n first rows of T.

use crate::Error;
use crate::linalg::dense::{
    RANK_TOLERANCE, Svd, hcat, is_finite, least_squares, r_factor, spectral_radius, svd,
};
use crate::model::riccati::kalman_filter;
use crate::model::stability::stable_fit;
use crate::model::{Innovation, StateSpace};
use crate::subspace::closed_loop::predictor::Predictor;
use crate::subspace::closed_loop::windows::{Signals, Windows};
use faer::{Mat, MatRef};

/// The states of all orders and what is regressed on them.
#[derive(Debug, Clone)]
pub struct Decomposition {
    /// All singular values, descending: of ΓK Z_p with PBSID-opt (channels in units of their root
    /// mean square), canonical correlations with SSARX.
    pub singular_values: Vec<f64>,
    now: Mat<f64>,
    next: Mat<f64>,
    u: Mat<f64>,
    y: Mat<f64>,
    feedthrough: bool,
    input_scale: Vec<f64>,
    output_scale: Vec<f64>,
}

impl Decomposition {
    pub(crate) fn new(
        windows: &Windows,
        past: usize,
        map: MatRef<'_, f64>,
        mut singular_values: Vec<f64>,
        feedthrough: bool,
    ) -> Result<Self, Error> {
        if !is_finite(map) {
            return Err(Error::Numerical { what: "states of the predictor" });
        }
        let n = map.nrows();
        singular_values.truncate(n);
        let now = windows.take(0..past, Signals::Z) * map.transpose();
        let next = windows.take(1..past + 1, Signals::Z) * map.transpose();
        let u = windows.take(past..past + 1, Signals::U);
        let y = windows.take(past..past + 1, Signals::Y);
        // An R factor of these holds all that the regressions need.
        let (m, p) = (windows.inputs, windows.outputs);
        let r = r_factor(hcat(&[now.as_ref(), u.as_ref(), y.as_ref(), next.as_ref()]).as_ref());
        let part = |from: usize, count: usize| r.get(.., from..from + count).to_owned();
        Ok(Self {
            singular_values,
            now: part(0, n),
            u: part(n, m),
            y: part(n + m, p),
            next: part(n + m + p, n),
            feedthrough,
            input_scale: windows.input_scale.clone(),
            output_scale: windows.output_scale.clone(),
        })
    }

    /// The largest order that can be requested.
    #[must_use]
    pub fn largest_order(&self) -> usize {
        self.singular_values.len()
    }

    /// The model of an order, A − K C stable; A is as the data have it.
    ///
    /// # Errors
    /// [`Error::OrderAboveHorizon`] above [`Decomposition::largest_order`], [`Error::NoModel`] where
    /// no filter of the model is stable, [`Error::Numerical`] where a decomposition fails.
    pub fn model(&self, order: usize) -> Result<Innovation, Error> {
        let fit = Regression::new(self, order)?;
        let a = fit.free_a()?;
        self.finish(&fit, a)
    }

    /// The model of an order whose A has at most the spectral radius `radius` (below 1), by a penalty
    /// on A in its regression where it would be larger (see [`stability`](crate::model::stability)).
    ///
    /// # Errors
    /// As [`Decomposition::model`].
    pub fn stable_model(&self, order: usize, radius: f64) -> Result<Innovation, Error> {
        let fit = Regression::new(self, order)?;
        let mut a = fit.free_a()?;
        if spectral_radius(a.as_ref()) > radius {
            a = fit.stable_a(radius)?;
        }
        self.finish(&fit, a)
    }

    fn finish(&self, fit: &Regression<'_>, a: Mat<f64>) -> Result<Innovation, Error> {
        let (b, gain) = fit.input_and_gain(&a)?;
        let gain = fit.stable_gain(&a, &b, gain)?;
        let model = StateSpace { a, b, c: fit.c.clone(), d: fit.d.clone() };
        let y = &self.output_scale;
        Ok(Innovation {
            model: model.scaled(&self.input_scale, y),
            gain: Mat::from_fn(gain.nrows(), gain.ncols(), |i, j| gain[(i, j)] / y[j]),
        })
    }
}

/// One order's regressions, rows representing samples.
struct Regression<'a> {
    now: MatRef<'a, f64>,
    next: MatRef<'a, f64>,
    u: MatRef<'a, f64>,
    c: Mat<f64>,
    d: Mat<f64>,
    error: Mat<f64>,
    noisy: Vec<usize>,
}

impl<'a> Regression<'a> {
    fn new(from: &'a Decomposition, order: usize) -> Result<Self, Error> {
        if order == 0 || order > from.largest_order() {
            return Err(Error::OrderAboveHorizon { order, horizon: from.largest_order() });
        }
        let (m, p) = (from.u.ncols(), from.y.ncols());
        let now = from.now.get(.., ..order);
        let regressors =
            if from.feedthrough { hcat(&[now, from.u.as_ref()]) } else { now.to_owned() };
        let theta = least_squares(regressors.as_ref(), from.y.as_ref(), RANK_TOLERANCE)?;
        let error = &from.y - regressors * &theta;
        let noisy =
            (0..p).filter(|&i| error.col(i).norm_l2() > 1e-10 * from.y.col(i).norm_l2()).collect();
        let d = if from.feedthrough {
            theta.get(order.., ..).transpose().to_owned()
        } else {
            Mat::zeros(p, m)
        };
        Ok(Self {
            now,
            next: from.next.get(.., ..order),
            u: from.u.as_ref(),
            c: theta.get(..order, ..).transpose().to_owned(),
            d,
            error,
            noisy,
        })
    }

    fn drives(&self) -> Mat<f64> {
        let e = Mat::from_fn(self.error.nrows(), self.noisy.len(), |i, j| {
            self.error[(i, self.noisy[j])]
        });
        hcat(&[self.u, e.as_ref()])
    }

    fn free_a(&self) -> Result<Mat<f64>, Error> {
        let n = self.now.ncols();
        let regressors = hcat(&[self.now, self.drives().as_ref()]);
        let theta = least_squares(regressors.as_ref(), self.next, RANK_TOLERANCE)?;
        Ok(theta.get(..n, ..).transpose().to_owned())
    }

    /// The same with a penalty on A; what u and e explain is taken out of both first.
    fn stable_a(&self, radius: f64) -> Result<Mat<f64>, Error> {
        let drives = self.drives();
        let rest = |x: MatRef<'_, f64>| -> Result<Mat<f64>, Error> {
            Ok(x - &drives * least_squares(drives.as_ref(), x, RANK_TOLERANCE)?)
        };
        let a = stable_fit(rest(self.now)?.as_ref(), rest(self.next)?.as_ref(), radius);
        a.map(|a| a.transpose().to_owned())
            .ok_or(Error::Numerical { what: "states of a stable model" })
    }

    fn input_and_gain(&self, a: &Mat<f64>) -> Result<(Mat<f64>, Mat<f64>), Error> {
        let (n, m) = (self.now.ncols(), self.u.ncols());
        let target = self.next - self.now * a.transpose();
        let theta = least_squares(self.drives().as_ref(), target.as_ref(), RANK_TOLERANCE)?;
        let mut gain = Mat::zeros(n, self.error.ncols());
        for (k, &i) in self.noisy.iter().enumerate() {
            for row in 0..n {
                gain[(row, i)] = theta[(m + k, row)];
            }
        }
        Ok((theta.get(..m, ..).transpose().to_owned(), gain))
    }

    /// The regression's gain where A − K C is stable, else that of the Riccati equation.
    fn stable_gain(&self, a: &Mat<f64>, b: &Mat<f64>, gain: Mat<f64>) -> Result<Mat<f64>, Error> {
        if spectral_radius((a - &gain * &self.c).as_ref()) < 1.0 {
            return Ok(gain);
        }
        let w = self.next - self.now * a.transpose() - self.u * b.transpose();
        let (n, p) = (a.nrows(), self.error.ncols());
        // A ridge far below the signals (of unit power) makes the noise regular.
        let ridge = |k: usize| Mat::from_fn(k, k, |i, j| if i == j { 1e-12 } else { 0.0 });
        let q = w.transpose() * &w + ridge(n);
        let r = self.error.transpose() * &self.error + ridge(p);
        let s = w.transpose() * &self.error;
        let filter = kalman_filter(a.as_ref(), self.c.as_ref(), q.as_ref(), r.as_ref(), s.as_ref());
        match filter {
            Some(filter) => Ok(filter.gain),
            None if spectral_radius(a.as_ref()) < 1.0 => Ok(Mat::zeros(n, p)),
            None => Err(Error::no_model(format!("no filter makes the model of order {n} stable"))),
        }
    }
}

/// PBSID-opt (A. Chiuso, Automatica 43, 2007): the map from z_p to the states, rows in order of the
/// singular values, and these. Block row i of ΓK is (Ξ_p … Ξ_1) shifted by i, with zeros for Ãᵖ ≈
/// 0; ΓK Z_p = U S Vᵀ over the data, and the state is S^{1/2} Vᵀ = S^{−1/2} Uᵀ ΓK Z_p.
pub(super) fn pbsid(
    windows: &Windows,
    predictor: &Predictor,
    future: usize,
) -> Result<(Mat<f64>, Vec<f64>), Error> {
    let (p, width, past) = (windows.outputs, windows.channels(), predictor.past());
    let product = Mat::from_fn(future * p, past * width, |i, j| {
        let (row, lag) = (i / p, j / width);
        if lag < row { 0.0 } else { predictor.markov[past - 1 - (lag - row)][(i % p, j % width)] }
    });
    let z = windows.take(0..past, Signals::Z);
    let f = svd((&product * z.transpose()).as_ref())?;
    let cut = RANK_TOLERANCE * f.s.first().copied().unwrap_or(0.0);
    let inverse = |s: f64| if s > cut { 1.0 / s.sqrt() } else { 0.0 };
    let ut = Mat::from_fn(f.s.len(), f.u.nrows(), |i, j| f.u[(j, i)] * inverse(f.s[i]));
    Ok((ut * product, f.s))
}

/// SSARX (M. Jansson, IFAC SYSID 2003): as [`pbsid`], by canonical correlations. The rest `ỹ_f =
/// y_f − Φ̃ u_f − Ψ̃ y_f`, Φ̃ and Ψ̃ block Toeplitz of D and the Markov parameters, is a regression
/// of low rank on the past: the state is S^{1/2} Vᵀ of `(Ỹ Ỹᵀ)^{−1/2} Ỹ Zᵀ (Z Zᵀ)^{−1/2} = U S Vᵀ`,
/// times (Z Zᵀ)^{−1/2} Z.
pub(super) fn ssarx(
    windows: &Windows,
    predictor: &Predictor,
    future: usize,
) -> Result<(Mat<f64>, Vec<f64>), Error> {
    let past = predictor.past();
    let z = windows.take(0..past, Signals::Z);
    let rest = without_the_known(windows, predictor, future);
    let (from_past, weight) = whitened(z.as_ref())?;
    let (from_future, _) = whitened(rest.as_ref())?;
    let f = svd((from_future.transpose() * &from_past).as_ref())?;
    let vt = Mat::from_fn(f.s.len(), f.v.nrows(), |i, j| f.v[(j, i)] * f.s[i].sqrt());
    Ok((vt * weight.transpose(), f.s))
}

/// ỹ_f, samples by f·ny.
fn without_the_known(windows: &Windows, predictor: &Predictor, future: usize) -> Mat<f64> {
    let (p, past) = (windows.outputs, predictor.past());
    let mut out = windows.take(past..past + future, Signals::Y);
    for row in 0..future {
        let now = past + row;
        let mut known = windows.take(now..now + 1, Signals::U) * predictor.feedthrough.transpose();
        for j in 1..=row.min(past) {
            known += windows.take(now - j..now - j + 1, Signals::Z)
                * predictor.markov[j - 1].transpose();
        }
        let mut part = out.get_mut(.., row * p..(row + 1) * p);
        part -= known;
    }
    out
}

/// An orthonormal basis of the column space of `m`, and the matrix that makes it of `m`.
fn whitened(m: MatRef<'_, f64>) -> Result<(Mat<f64>, Mat<f64>), Error> {
    let Svd { u, s, v } = svd(m)?;
    let cut = RANK_TOLERANCE * s.first().copied().unwrap_or(0.0);
    let rank = s.iter().take_while(|x| **x > cut).count();
    let weight = Mat::from_fn(v.nrows(), rank, |i, j| v[(i, j)] / s[j]);
    Ok((u.get(.., ..rank).to_owned(), weight))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn column(values: [f64; 4]) -> Mat<f64> {
        Mat::from_fn(4, 1, |i, _| values[i])
    }

    /// x⁺ = 0.5 x + 2 u + k e, y = x + e, with x, u and e orthogonal over the rows.
    fn decomposition(k: f64) -> Decomposition {
        let (x, u, e) = ([1.0; 4], [1.0, -1.0, 1.0, -1.0], [1.0, 1.0, -1.0, -1.0]);
        Decomposition {
            singular_values: vec![1.0],
            now: column(x),
            next: column(std::array::from_fn(|i| 0.5 * x[i] + 2.0 * u[i] + k * e[i])),
            u: column(u),
            y: column(std::array::from_fn(|i| x[i] + e[i])),
            feedthrough: false,
            input_scale: vec![1.0],
            output_scale: vec![1.0],
        }
    }

    /// A gain that makes A − K C unstable is replaced by that of the same spectrum which does not: with
    /// H(z) = (z − (a − k))/(z − a), the zero a − k is replaced by its mirror image 1/(a − k).
    #[test]
    fn a_predictor_that_forgets_nothing_gets_its_stable_twin() {
        for (k, expected) in [(0.7, 0.7), (2.5, 0.5 + 1.0 / 2.0), (-1.5, 0.5 - 1.0 / 2.0)] {
            let found = decomposition(k).model(1).unwrap();
            assert!((found.model.a[(0, 0)] - 0.5).abs() < 1e-12, "{k}");
            assert!((found.model.b[(0, 0)] - 2.0).abs() < 1e-12, "{k}");
            assert!((found.gain[(0, 0)] - expected).abs() < 1e-6, "{k}: {:?}", found.gain);
        }
    }
}
