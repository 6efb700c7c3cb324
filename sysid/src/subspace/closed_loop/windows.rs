//! The R factor of the data in order of time, read as data: inner products of the columns u(0),
//! y(0), u(1), …, y(L−1) of all windows are those of R, so that least squares and projections among
//! the lags are done on R.

use crate::Error;
use crate::linalg::dense::is_finite;
use crate::subspace::factor::Factor;
use faer::Mat;
use std::ops::Range;

/// Signals at each lag, every channel in units of its root mean square.
pub(crate) struct Windows {
    /// Rows represent samples, columns channels at lags.
    r: Mat<f64>,
    pub(crate) lags: usize,
    pub(crate) inputs: usize,
    pub(crate) outputs: usize,
    pub(crate) count: usize,
    pub(crate) input_scale: Vec<f64>,
    pub(crate) output_scale: Vec<f64>,
}

/// A part of the channels.
#[derive(Clone, Copy)]
pub(crate) enum Signals {
    U,
    Y,
    /// z = [u; y].
    Z,
}

impl Windows {
    pub(crate) fn new(factor: &Factor) -> Result<Self, Error> {
        let (m, p) = (factor.inputs, factor.outputs);
        let by_time = factor.by_time()?;
        let width = m + p;
        let lags = by_time.ncols() / width;
        if !is_finite(by_time.as_ref()) {
            return Err(Error::Numerical { what: "R factor of the data" });
        }
        if m == 0 {
            return Err(Error::no_model("there is no input"));
        }
        let mut scale = Vec::with_capacity(width);
        for channel in 0..width {
            let at = |lag: usize| by_time.col(lag * width + channel);
            let power: f64 = (0..lags).map(|lag| at(lag).squared_norm_l2()).sum();
            let rms = (power / lags as f64).sqrt();
            let moves = (1..lags).any(|lag| (at(lag) - at(0)).norm_l2() > 1e-12 * rms);
            if !(rms > 0.0 && rms.is_finite() && moves) {
                let (name, k) =
                    if channel < m { ("input", channel) } else { ("output", channel - m) };
                return Err(Error::no_model(format!("{name} {k} does not move")));
            }
            scale.push(rms);
        }
        let r = Mat::from_fn(by_time.nrows(), by_time.ncols(), |i, j| {
            by_time[(i, j)] / scale[j % width]
        });
        let output_scale = scale.split_off(m);
        let count = factor.columns;
        Ok(Self { r, lags, inputs: m, outputs: p, count, input_scale: scale, output_scale })
    }

    /// Refuses what needs more lags than there are.
    pub(crate) fn holds(&self, lags: usize) -> Result<(), Error> {
        if lags > self.lags {
            let (order, horizon) = (lags.div_ceil(2), self.lags / 2);
            return Err(Error::OrderAboveHorizon { order, horizon });
        }
        Ok(())
    }

    /// The signals at these lags, lag by lag: samples by lags·channels.
    pub(crate) fn take(&self, lags: Range<usize>, signals: Signals) -> Mat<f64> {
        let width = self.inputs + self.outputs;
        let (first, count) = match signals {
            Signals::U => (0, self.inputs),
            Signals::Y => (self.inputs, self.outputs),
            Signals::Z => (0, width),
        };
        Mat::from_fn(self.r.nrows(), lags.len() * count, |i, j| {
            self.r[(i, (lags.start + j / count) * width + first + j % count)]
        })
    }

    pub(crate) fn channels(&self) -> usize {
        self.inputs + self.outputs
    }
}
