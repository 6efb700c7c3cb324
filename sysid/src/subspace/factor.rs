//! The LQ factorisation of the stacked block Hankel matrices, by whichever way the data allow.

use crate::Error;
use crate::subspace::conditioning::{
    Conditioning, Decomposition, MOST_FOR_GRAM, MOST_OF_INPUT, condition,
};
use crate::subspace::tall::lower;
use faer::{Mat, Side};
use std::ops::Range;

/// The least horizon of any use: a first-order model sees its own shift in it.
const LEAST_HORIZON: usize = 2;

/// L of the data, rows in the order U_f, U_p, Y_p, Y_f, divided by √j so that products are
/// covariances.
#[derive(Debug, Clone)]
pub struct Factor {
    /// Block rows s of past and of future.
    pub horizon: usize,
    /// Number of inputs.
    pub inputs: usize,
    /// Number of outputs.
    pub outputs: usize,
    /// Number of columns j of the Hankel matrices.
    pub columns: usize,
    /// Lower triangular, 2s(nu+ny) square.
    pub l: Mat<f64>,
    /// How it was computed, and the condition behind that.
    pub conditioning: Conditioning,
    /// What other horizons are cut from.
    source: Source,
}

/// All windows, variables in order of time.
#[derive(Debug, Clone)]
struct Source {
    decomposed: Decomposed,
    mean: Vec<f64>,
    about_mean: bool,
    full: usize,
    /// The longest horizon that the input excites, and its condition at the full one.
    longest: usize,
    input_condition: f64,
}

/// The windows about their mean, divided by √j.
#[derive(Debug, Clone)]
pub(crate) enum Decomposed {
    Gram(Mat<f64>),
    Qr(Mat<f64>),
}

impl Factor {
    /// The factor for a smaller horizon from the same pass over the data.
    ///
    /// # Errors
    /// [`Error::OrderAboveHorizon`] where the horizon is larger than that of the pass.
    pub fn with_horizon(&self, horizon: usize) -> Result<Self, Error> {
        let full = self.source.full;
        if horizon == 0 || horizon > full {
            return Err(Error::OrderAboveHorizon { order: horizon, horizon: full });
        }
        self.source.cut(horizon, (self.inputs, self.outputs), self.columns)
    }

    /// The factor of the windows about their mean: constants on inputs and outputs have no part in it.
    ///
    /// # Errors
    /// [`Error::Numerical`] where the decomposition fails.
    pub fn about_mean(&self) -> Result<Self, Error> {
        let source = Source { about_mean: true, ..self.source.clone() };
        source.cut(self.horizon, (self.inputs, self.outputs), self.columns)
    }

    /// From moments in order of time; `cancellation` is by which centring has cancelled.
    pub(crate) fn from_moments(
        decomposed: Decomposed,
        mean: Vec<f64>,
        cancellation: f64,
        horizon: usize,
        channels: (usize, usize),
        columns: usize,
    ) -> Result<Self, Error> {
        let mut source = Source {
            decomposed,
            mean,
            about_mean: false,
            full: horizon,
            longest: horizon,
            input_condition: 1.0,
        };
        if matches!(source.decomposed, Decomposed::Qr(_)) {
            source.check_channels(channels)?;
            source.limit_horizon(channels)?;
            return source.cut(horizon, channels, columns);
        }
        let ill = |condition: f64| Error::IllConditioned { condition };
        let factor = source.cut(horizon, channels, columns).map_err(|_| ill(f64::INFINITY))?;
        let worst = factor.conditioning.condition * cancellation.sqrt();
        if worst < MOST_FOR_GRAM { Ok(factor) } else { Err(ill(worst)) }
    }

    /// R with columns u(0), y(0), u(1), … over all lags of the pass, whatever the horizon.
    pub(crate) fn by_time(&self) -> Result<Mat<f64>, Error> {
        let order: Vec<usize> = (0..self.source.mean.len()).collect();
        let l = self.source.with_mean(self.source.of_deviations(&order)?, &order);
        Ok(l.transpose().to_owned())
    }

    /// Means of the first input and the first output over all windows, mean or not in L.
    pub(crate) fn means(&self) -> (f64, f64) {
        let width = self.inputs + self.outputs;
        let of = |channel: usize| {
            let lags = self.source.mean.iter().skip(channel).step_by(width);
            lags.sum::<f64>() / (self.source.mean.len() / width) as f64
        };
        (of(0), of(self.inputs))
    }

    /// Row where W_p starts.
    pub(crate) fn past(&self) -> usize {
        self.horizon * self.inputs
    }

    /// Row where Y_f starts.
    pub(crate) fn future(&self) -> usize {
        self.horizon * (2 * self.inputs + self.outputs)
    }
}

impl Source {
    fn cut(
        &self,
        requested: usize,
        channels: (usize, usize),
        columns: usize,
    ) -> Result<Factor, Error> {
        let (m, p) = channels;
        let s = requested.min(self.longest);
        let (past, future) = (self.full - s..self.full, self.full..self.full + s);
        let mut order = places(channels, future.clone(), 0..m);
        order.extend(places(channels, past.clone(), 0..m));
        order.extend(places(channels, past, m..m + p));
        order.extend(places(channels, future, m..m + p));
        // Conditions are those of the windows about their mean, before it is added.
        let l = self.of_deviations(&order)?;
        let method = match &self.decomposed {
            Decomposed::Gram(_) => Decomposition::Gram,
            Decomposed::Qr(_) => Decomposition::Qr,
        };
        let of_input = || condition(l.get(..2 * s * m, ..2 * s * m));
        let conditioning = Conditioning {
            method,
            condition: condition(l.as_ref()),
            input_condition: if s < requested { self.input_condition } else { of_input() },
            requested_horizon: requested,
            horizon: s,
        };
        let l = self.with_mean(l, &order);
        Ok(Factor {
            horizon: s,
            inputs: m,
            outputs: p,
            columns,
            l,
            conditioning,
            source: self.clone(),
        })
    }

    /// Lower triangular factor of some of the variables about their mean.
    fn of_deviations(&self, order: &[usize]) -> Result<Mat<f64>, Error> {
        match &self.decomposed {
            Decomposed::Gram(covariance) => cholesky(covariance, order)
                .ok_or(Error::Numerical { what: "Cholesky factor of the Gram matrix" }),
            Decomposed::Qr(r) => Ok(chosen(r, order)),
        }
    }

    /// The same with their mean, unless that is to stay off.
    fn with_mean(&self, mut l: Mat<f64>, order: &[usize]) -> Mat<f64> {
        if !self.about_mean {
            let mut mean: Vec<f64> = order.iter().map(|k| self.mean[*k]).collect();
            add_column(&mut l, &mut mean);
        }
        l
    }

    fn check_channels(&self, (m, p): (usize, usize)) -> Result<(), Error> {
        let Decomposed::Qr(r) = &self.decomposed else { return Ok(()) };
        for c in 0..m + p {
            let lags = (c..r.ncols()).step_by(m + p);
            let spread = lags.map(|j| r.col(j).norm_l2()).fold(0.0, f64::max);
            let value = self.mean[c];
            if spread <= 1e-14 * value.abs() || spread < 1e-150 {
                let (what, k) = if c < m { ("input", c) } else { ("output", c - m) };
                let problem = format!("{what} {k} (counted from 0) is {value} throughout");
                return Err(Error::NotExciting { problem });
            }
        }
        Ok(())
    }

    fn limit_horizon(&mut self, channels: (usize, usize)) -> Result<(), Error> {
        let input_condition = |s: usize| match &self.decomposed {
            Decomposed::Qr(r) if channels.0 > 0 => {
                let lags = self.full - s..self.full + s;
                condition(chosen(r, &places(channels, lags, 0..channels.0)).as_ref())
            }
            _ => 1.0,
        };
        let full = input_condition(self.full);
        if full <= MOST_OF_INPUT {
            self.input_condition = full;
            return Ok(());
        }
        // Fewer lags never have a larger condition, so the limit is found by halving.
        let (mut good, mut bad) = (LEAST_HORIZON.min(self.full), self.full);
        let least = input_condition(good);
        if least > MOST_OF_INPUT {
            return Err(Error::NotExciting {
                problem: format!(
                    "the condition of {} samples of it in a row is {least:.1e}, {MOST_OF_INPUT:.0e} is the most that can be used",
                    2 * good
                ),
            });
        }
        while bad - good > 1 {
            let middle = usize::midpoint(good, bad);
            if input_condition(middle) <= MOST_OF_INPUT { good = middle } else { bad = middle }
        }
        self.longest = good;
        self.input_condition = full;
        Ok(())
    }
}

/// Places of some channels at some lags in the variables in order of time.
fn places((m, p): (usize, usize), lags: Range<usize>, channels: Range<usize>) -> Vec<usize> {
    lags.flat_map(|lag| channels.clone().map(move |c| lag * (m + p) + c)).collect()
}

fn chosen(r: &Mat<f64>, order: &[usize]) -> Mat<f64> {
    lower(Mat::from_fn(r.nrows(), order.len(), |i, j| r[(i, order[j])]).as_ref())
}

/// Cholesky factor of some rows and columns; `None` where not positive definite.
fn cholesky(covariance: &Mat<f64>, order: &[usize]) -> Option<Mat<f64>> {
    let size = order.len();
    let deviation: Vec<f64> = order.iter().map(|k| covariance[(*k, *k)].sqrt()).collect();
    if !deviation.iter().all(|d| d.is_normal()) {
        return None;
    }
    let scaled = Mat::from_fn(size, size, |i, j| {
        covariance[(order[i], order[j])] / deviation[i] / deviation[j]
    });
    let f = scaled.llt(Side::Lower).ok()?;
    let l = f.L();
    Some(Mat::from_fn(size, size, |i, j| if i < j { 0.0 } else { l[(i, j)] * deviation[i] }))
}

/// L with L Lᵀ + v vᵀ = L' L'ᵀ by Givens rotations (Gill, Golub, Murray and Saunders 1974, method
/// C1).
fn add_column(l: &mut Mat<f64>, v: &mut [f64]) {
    for k in 0..v.len() {
        let r = l[(k, k)].hypot(v[k]);
        if r == 0.0 {
            continue;
        }
        let (c, s) = (l[(k, k)] / r, v[k] / r);
        for i in k..v.len() {
            let (a, b) = (l[(i, k)], v[i]);
            l[(i, k)] = c * a + s * b;
            v[i] = c * b - s * a;
        }
    }
}
