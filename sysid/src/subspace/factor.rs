//! The LQ factorisation of the stacked block Hankel matrices, in blocks of bounded memory.

use crate::dense::triangle;
use crate::{DataSet, Error};
use faer::Mat;

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
    /// The triangle with the variables in order of time, from which other horizons are cut.
    by_time: Mat<f64>,
}

impl Factor {
    /// Factors the data with `horizon` block rows.
    ///
    /// Columns of the Hankel matrices are taken in blocks, and each block's triangle is factored
    /// together with the last one (Golub and Van Loan, 5.2.8), so memory does not grow with N. No
    /// column reaches from one segment into another.
    ///
    /// # Errors
    /// [`Error::TooFewSamples`] where there are fewer columns than rows.
    pub fn new(data: &DataSet, horizon: usize) -> Result<Self, Error> {
        let (m, p) = (data.inputs(), data.outputs());
        let window = 2 * horizon;
        let size = window * (m + p);
        let columns: usize =
            data.segments().iter().map(|s| (s.len() + 1).saturating_sub(window)).sum();
        if columns < size {
            let (got, sample_time_s) = (data.samples(), data.sample_time_s());
            return Err(Error::TooFewSamples { got, need: window + size - 1, sample_time_s });
        }
        let block = (4 * size).max(256);
        let mut r: Mat<f64> = Mat::zeros(0, size);
        for segment in data.segments() {
            let columns = (segment.len() + 1).saturating_sub(window);
            let mut start = 0;
            while start < columns {
                let count = block.min(columns - start);
                let kept = r.nrows();
                let stacked = Mat::from_fn(kept + count, size, |i, j| {
                    if i < kept {
                        return r[(i, j)];
                    }
                    let (lag, channel) = (j / (m + p), j % (m + p));
                    let t = start + i - kept + lag;
                    if channel < m { segment.u[(channel, t)] } else { segment.y[(channel - m, t)] }
                });
                r = triangle(stacked.as_ref());
                start += count;
            }
        }
        let scale = 1.0 / (columns as f64).sqrt();
        let by_time = Mat::from_fn(size, size, |i, j| r[(i, j)] * scale);
        Ok(Self::cut(by_time, horizon, horizon, m, p, columns))
    }

    /// The factor for a smaller horizon from the same pass over the data.
    ///
    /// # Errors
    /// [`Error::OrderAboveHorizon`] where the horizon is larger than this one's.
    pub fn with_horizon(&self, horizon: usize) -> Result<Self, Error> {
        let full = self.by_time.ncols() / (2 * (self.inputs + self.outputs));
        if horizon == 0 || horizon > full {
            return Err(Error::OrderAboveHorizon { order: horizon, horizon: full });
        }
        let by_time = self.by_time.clone();
        Ok(Self::cut(by_time, full, horizon, self.inputs, self.outputs, self.columns))
    }

    fn cut(by_time: Mat<f64>, full: usize, s: usize, m: usize, p: usize, columns: usize) -> Self {
        let lags = |from: usize, channels: std::ops::Range<usize>| {
            (from..from + s)
                .flat_map(move |lag| channels.clone().map(move |c| lag * (m + p) + c))
                .collect::<Vec<_>>()
        };
        let mut order = lags(full, 0..m);
        order.extend(lags(full - s, 0..m));
        order.extend(lags(full - s, m..m + p));
        order.extend(lags(full, m..m + p));
        let chosen = Mat::from_fn(by_time.nrows(), order.len(), |i, j| by_time[(i, order[j])]);
        let r = triangle(chosen.as_ref());
        // Signs of the rows of R are arbitrary; a positive diagonal makes the factor unique.
        let l = Mat::from_fn(r.ncols(), r.ncols(), |i, j| {
            if j >= r.nrows() {
                0.0
            } else if r[(j, j)] < 0.0 {
                -r[(j, i)]
            } else {
                r[(j, i)]
            }
        });
        Self { horizon: s, inputs: m, outputs: p, columns, l, by_time }
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
