//! The R factor of the windows, read as data: simulation and prediction errors of a model are
//! linear combinations of a window's samples and its initial state, so that R's rows, each a
//! segment of 2·horizon samples, represent all windows in least squares
//! (docs/methods/accumulate.md).

use crate::Error;
use crate::data::{DataSet, Segment, Signals};
use crate::model::{StateSpace, initial_state, predictions, predictor, predictor_state, simulate};
use crate::selection::order::Errors;
use crate::subspace::Factor;
use crate::validation::residuals::correlation::parzen;
use faer::{Mat, MatRef};

/// Windows about their mean, in units of each channel's standard deviation.
pub(crate) struct Windows {
    /// A segment for each row of R.
    pub(crate) data: DataSet,
    pub(crate) length: usize,
    pub(crate) count: usize,
    pub(crate) scales: [f64; 2],
    /// Autocovariance of the input at all lags, under Parzen's lag window.
    pub(crate) input: Vec<f64>,
    /// R in these units; columns u(0), y(0), u(1), …
    r: Mat<f64>,
}

impl Windows {
    /// Of a factor about its mean, in units of its own or of `scales`.
    pub(crate) fn new(
        factor: &Factor,
        sample_time_s: f64,
        scales: Option<[f64; 2]>,
    ) -> Result<Self, Error> {
        let mut r = factor.by_time()?;
        let length = r.ncols() / 2;
        let scales = scales.unwrap_or_else(|| {
            [0, 1].map(|c| {
                let squares: f64 =
                    (0..length).map(|lag| r.col(2 * lag + c).squared_norm_l2()).sum();
                (squares / length as f64).sqrt()
            })
        });
        for j in 0..r.ncols() {
            for i in 0..r.nrows() {
                r[(i, j)] /= scales[j % 2];
            }
        }
        let channel = |i: usize, c: usize| -> Vec<f64> {
            (0..length).map(|lag| r[(i, 2 * lag + c)]).collect()
        };
        let segments = (0..r.nrows()).map(|i| Segment::new(channel(i, 0), channel(i, 1)));
        let data = DataSet::new(sample_time_s, segments.collect())?;
        let mut windows =
            Self { data, length, count: factor.columns, scales, input: Vec::new(), r };
        // Under these weights the covariances stay those of some signal.
        let own = |lag: usize| parzen(lag as f64 / length as f64) * windows.covariance(0, 0, lag);
        windows.input = (0..length).map(own).collect();
        Ok(windows)
    }

    /// Covariance of channel a now and channel b `lag` samples later; 0 is the input, 1 the output.
    pub(crate) fn covariance(&self, a: usize, b: usize, lag: usize) -> f64 {
        let pairs = self.length - lag;
        let sum: f64 = (0..pairs)
            .map(|t| self.r.col(2 * t + a).transpose() * self.r.col(2 * (t + lag) + b))
            .sum();
        sum / pairs as f64
    }

    /// A weighted sum of each window's samples, for the rows of R.
    pub(crate) fn times(&self, weights: &[f64]) -> Vec<f64> {
        let mut sums = vec![0.0; self.r.nrows()];
        for (j, w) in weights.iter().enumerate() {
            // Zeros are below the diagonal.
            for (i, sum) in sums.iter_mut().enumerate().take(j + 1) {
                *sum += w * self.r[(i, j)];
            }
        }
        sums
    }

    /// Errors of the second half of every window, simulated from the state of its first half.
    pub(crate) fn ahead(&self, model: &StateSpace) -> Result<Errors, Error> {
        let state = |s: &Segment, n| initial_state(model, s.u.columns(0..n), s.y.columns(0..n));
        self.second_halves(state, |s, x0| simulate(model, s.u.as_ref(), x0))
    }

    /// As [`ahead`](Self::ahead), of the one-step predictions.
    pub(crate) fn predicted_ahead(
        &self,
        model: &StateSpace,
        gain: MatRef<'_, f64>,
    ) -> Result<Errors, Error> {
        let predictor = predictor(model, gain);
        self.second_halves(
            |s, n| predictor_state(&predictor, s.u.columns(0..n), s.y.columns(0..n)),
            |s, x0| predictions(&predictor, s.u.as_ref(), s.y.as_ref(), x0),
        )
    }

    fn second_halves(
        &self,
        state: impl Fn(&Segment, usize) -> Result<Vec<f64>, Error>,
        output: impl Fn(&Segment, &[f64]) -> Signals,
    ) -> Result<Errors, Error> {
        let half = self.length / 2;
        let of = |s: &Segment| -> Result<Signals, Error> {
            let y = output(s, &state(s, half)?);
            let errors = s.y.row(0).iter().zip(y.row(0)).skip(half).map(|(y, s)| y - s);
            Ok(errors.collect::<Vec<f64>>().into())
        };
        self.data.segments().iter().map(of).collect()
    }

    /// Variance of such errors; ∞ where they are not finite.
    pub(crate) fn variance_ahead(&self, errors: &Errors) -> f64 {
        self.variance(errors, self.length / 2)
    }

    /// The states from which the one-step predictions of each window err least.
    pub(crate) fn predictor_states(
        &self,
        model: &StateSpace,
        gain: MatRef<'_, f64>,
    ) -> Result<Vec<Vec<f64>>, Error> {
        let predictor = predictor(model, gain);
        let segments = self.data.segments().iter();
        segments.map(|s| predictor_state(&predictor, s.u.as_ref(), s.y.as_ref())).collect()
    }

    /// Variance of errors with `order` fitted initial states each; ∞ where they are not finite.
    pub(crate) fn variance(&self, errors: &Errors, order: usize) -> f64 {
        let squares = crate::selection::order::sum_of_squares(errors);
        let free = self.length.saturating_sub(order).max(1);
        if squares.is_finite() { squares / free as f64 } else { f64::INFINITY }
    }

    pub(crate) fn fit(&self, variance: f64) -> f64 {
        let fit = 100.0 * (1.0 - (variance / self.covariance(1, 1, 0)).sqrt());
        if fit.is_nan() { f64::NEG_INFINITY } else { fit }
    }
}
