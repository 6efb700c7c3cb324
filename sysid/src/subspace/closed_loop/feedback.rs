//! Does the input depend on past outputs? A test for feedback (Sims 1972; Geweke, Meese and Dent
//! 1983; docs/methods/selection.md): whether u(t+1) … u(t+k) help to predict y(t) from past z and
//! present u.
//!
//! The statistic is the likelihood ratio `−(ν − (ny − d + 1)/2) ln(det Σ₁/det Σ₀)` with Bartlett's
//! correction (T. W. Anderson, *An Introduction to Multivariate Statistical Analysis*, 8.5), ν the
//! degrees of freedom of the residuals and d the number of independent future inputs; it is χ² with
//! d·ny degrees of freedom where there is no feedback. White noise on the sensor of u looks like
//! feedback.

use crate::Error;
use crate::data::DataSet;
use crate::data::statistics::{Z99, chi_squared_quantile};
use crate::linalg::dense::{RANK_TOLERANCE, hcat, least_squares, svd};
use crate::subspace::closed_loop::predictor::order_in;
use crate::subspace::closed_loop::windows::{Signals, Windows};
use crate::subspace::factor::Factor;
use faer::Mat;

/// One-step errors of a smaller share of an output are noise that biases no model, whoever answers to it.
const NEGLIGIBLE: f64 = 3e-3;

/// Outcome of the test.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Feedback {
    /// χ² statistic.
    pub statistic: f64,
    /// Its degrees of freedom; 0 where the past predicts the future input exactly.
    pub degrees: usize,
    /// What it stays below in 99 of 100 records without feedback.
    pub bound: f64,
    /// Statistic above bound.
    pub detected: bool,
}

/// Tests for feedback over `ahead_s` (a driver's reaction: 1 s), with the VARX order of least AIC
/// within `memory_s` (2 s does for a car), both cut to what the number of samples allows.
///
/// # Errors
/// [`Error::TooFewSamples`] for less than about 20 samples for each channel, and as
/// [`feedback_in`].
pub fn feedback(data: &DataSet, memory_s: f64, ahead_s: f64) -> Result<Feedback, Error> {
    let width = data.inputs() + data.outputs();
    // Twenty windows for each regressor, so that the theory of large samples holds.
    let most = (data.samples() / (20 * width)).clamp(4, 80);
    let (past, ahead) = feedback_lags((memory_s, ahead_s), data.sample_time_s(), most);
    feedback_in(&Factor::new(data, (past + ahead + 1).div_ceil(2))?, past, ahead)
}

/// Past and future samples of so many seconds, cut until they and the present are `most`.
pub(crate) fn feedback_lags(
    (memory_s, ahead_s): (f64, f64),
    sample_time_s: f64,
    most: usize,
) -> (usize, usize) {
    let samples = |s: f64| (s / sample_time_s).round().clamp(5.0, 40.0) as usize;
    let (mut past, mut ahead) = (samples(memory_s), samples(ahead_s));
    while past + ahead + 1 > most && past + ahead > 2 {
        if past > ahead { past -= 1 } else { ahead -= 1 }
    }
    (past, ahead)
}

/// The test on a factor of `past + ahead + 1` lags or more: `past` bounds the VARX order, `ahead`
/// is the number of future inputs. Data with next to no noise have a statistic of 0.
///
/// # Errors
/// [`Error::OrderAboveHorizon`] where the factor is too short, [`Error::Option`] where one of the
/// two is 0, [`Error::NoModel`] where a channel does not move, [`Error::Numerical`] where the factor
/// is not finite.
pub fn feedback_in(factor: &Factor, past: usize, ahead: usize) -> Result<Feedback, Error> {
    if past == 0 || ahead == 0 {
        let value = format!("{past} and {ahead}");
        return Err(Error::option("lags of the feedback test", value, "1 or more"));
    }
    let windows = Windows::new(factor)?;
    windows.holds(past + ahead + 1)?;
    let order = order_in(&windows, past, true)?;
    let known = hcat(&[
        windows.take(past - order..past, Signals::Z).as_ref(),
        windows.take(past..past + 1, Signals::U).as_ref(),
    ]);
    let rest = |x: Mat<f64>| -> Result<Mat<f64>, Error> {
        let theta = least_squares(known.as_ref(), x.as_ref(), RANK_TOLERANCE)?;
        Ok(x - &known * theta)
    };
    let y = windows.take(past..past + 1, Signals::Y);
    let size: Vec<f64> = (0..y.ncols()).map(|i| y.col(i).norm_l2()).collect();
    let error = rest(y)?;
    // What the past does not predict of the future input, channels in units of their root mean square.
    const LEAST_UNEXPLAINED: f64 = 1e-6;
    let unexplained = svd(rest(windows.take(past + 1..past + 1 + ahead, Signals::U))?.as_ref())?;
    let rank = unexplained.s.iter().take_while(|s| **s > LEAST_UNEXPLAINED).count();
    let outputs = error.ncols();
    let degrees = rank * outputs;
    let bound = chi_squared_quantile(degrees, Z99);
    let none = Feedback { statistic: 0.0, degrees, bound, detected: false };
    let noisy = (0..outputs).all(|i| error.col(i).norm_l2() > NEGLIGIBLE * size[i]);
    if degrees == 0 || !noisy {
        return Ok(none);
    }
    let part = unexplained.u.get(.., ..rank).transpose() * &error;
    let whole = error.transpose() * &error;
    let left = &whole - part.transpose() * &part;
    let free = windows.count as f64 - (known.ncols() + rank) as f64;
    let weight = free - 0.5 * (outputs as f64 - rank as f64 + 1.0);
    if weight < 1.0 {
        return Err(Error::Numerical { what: "feedback test of so few samples" });
    }
    let ratio = left.determinant() / whole.determinant();
    let statistic = -weight * ratio.max(f64::MIN_POSITIVE).ln();
    if !statistic.is_finite() {
        return Err(Error::Numerical { what: "likelihood ratio of the feedback test" });
    }
    Ok(Feedback { statistic, detected: statistic > bound, ..none })
}
