//! Least squares of (K, K·f, ρ, b, d), and their covariance.

use super::signals::{LARGEST_DELAY, Signals};
use crate::Error;
use nalgebra::{SMatrix, SVector};

/// Duration of a block of errors, s: longer than they are correlated.
pub(super) const BLOCK_S: f64 = 10.0;
/// Step between the delays that are tried first, s.
const DELAY_STEP: f64 = 0.02;
/// Newton steps from the best of these.
const STEPS: usize = 8;
/// Smallest eigenvalue of the correlation of the regressors.
const LEAST_EIGENVALUE: f64 = 1e-8;

type Square = SMatrix<f64, 5, 5>;
type Vector = SVector<f64, 5>;

pub(super) struct Fit {
    /// K, K·f, ρ, b, d.
    pub(super) parameters: [f64; 5],
    pub(super) covariance: Square,
    pub(super) blocks: usize,
}

impl Fit {
    pub(super) fn estimate(signals: &Signals<'_>, rows: &[usize]) -> Result<Self, Error> {
        let not_exciting = || Error::NotExciting {
            problem: "command, steering rate and roll do not vary independently".into(),
        };
        let delays = (0..=(LARGEST_DELAY / DELAY_STEP) as usize).map(|i| i as f64 * DELAY_STEP);
        let tried = delays.filter_map(|delay| linear(signals, rows, delay));
        let best = tried.min_by(|a, b| a.1.total_cmp(&b.1)).ok_or_else(not_exciting)?;
        let mut parameters = best.0;
        let mut inverse = Square::zeros();
        for _ in 0..STEPS {
            let (mut gram, mut right) = (Square::zeros(), Vector::zeros());
            for (jacobian, error) in errors(signals, rows, &parameters) {
                gram += jacobian * jacobian.transpose();
                right += jacobian * error;
            }
            inverse = inverted(&gram, signals).ok_or_else(not_exciting)?;
            let step = inverse * right;
            for (parameter, step) in parameters.iter_mut().zip(&step).take(4) {
                *parameter += step;
            }
            let delay = parameters[4] + step[4].clamp(-DELAY_STEP, DELAY_STEP);
            parameters[4] = delay.clamp(0.0, LARGEST_DELAY);
        }
        let (covariance, blocks) = covariance(signals, rows, &parameters, &inverse);
        Ok(Self { parameters, covariance, blocks })
    }

    /// Fit in percent, and standard deviation of the errors.
    pub(super) fn fit_and_deviation(&self, signals: &Signals<'_>, rows: &[usize]) -> (f64, f64) {
        if rows.is_empty() {
            return (0.0, 0.0);
        }
        let outputs = || rows.iter().map(|&k| signals.acceleration[k]);
        let n = rows.len() as f64;
        let mean = outputs().sum::<f64>() / n;
        let spread: f64 = outputs().map(|y| (y - mean).powi(2)).sum();
        let sum: f64 = errors(signals, rows, &self.parameters).map(|(_, e)| e * e).sum();
        (100.0 * (1.0 - (sum / spread.max(f64::MIN_POSITIVE)).sqrt()).max(-1e9), (sum / n).sqrt())
    }

    /// Writes the acceleration that the model has at each of the samples to its place.
    pub(super) fn write_to(&self, signal: &mut [f64], signals: &Signals<'_>, rows: &[usize]) {
        for (row, (_, error)) in rows.iter().zip(errors(signals, rows, &self.parameters)) {
            signal[*row] = signals.acceleration[*row] - error;
        }
    }
}

/// Derivatives of the prediction and prediction error at each sample.
fn errors<'a>(
    signals: &'a Signals<'_>,
    rows: &'a [usize],
    parameters: &[f64; 5],
) -> impl Iterator<Item = (Vector, f64)> + 'a {
    let [k, kf, rho, b, delay] = *parameters;
    let step = 0.05 * signals.log.sample_time_s;
    let command = signals.command(delay);
    let (later, earlier) =
        (signals.command(delay + step), signals.command((delay - step).max(0.0)));
    let between = step + delay.min(step);
    rows.iter().map(move |&row| {
        let x = signals.regressors(command[row], row);
        let predicted: f64 = x.iter().zip([k, kf, rho, b]).map(|(x, p)| x * p).sum();
        let of_delay = k * (later[row] - earlier[row]) / between;
        let error = signals.acceleration[row] - predicted;
        (Vector::new(x[0], x[1], x[2], x[3], of_delay), error)
    })
}

/// The linear parameters for a delay, and the sum of squared errors.
fn linear(signals: &Signals<'_>, rows: &[usize], delay: f64) -> Option<([f64; 5], f64)> {
    let command = signals.command(delay);
    let (mut gram, mut right, mut square) = (Square::zeros(), Vector::zeros(), 0.0);
    for &row in rows {
        let [a, b, c, d] = signals.regressors(command[row], row);
        let x = Vector::new(a, b, c, d, 0.0);
        let y = signals.acceleration[row];
        gram += x * x.transpose();
        right += x * y;
        square += y * y;
    }
    gram[(4, 4)] = 1.0;
    let found = inverted(&gram, signals)? * right;
    Some(([found[0], found[1], found[2], found[3], delay], square - found.dot(&right)))
}

/// Inverse of a Gram matrix, scaled to ones on its diagonal; the parameter of an absent roll stays 0. `None` if a
/// parameter is not determined.
fn inverted(gram: &Square, signals: &Signals<'_>) -> Option<Square> {
    let mut gram = *gram;
    if !signals.has_roll() {
        gram[(2, 2)] = 1.0;
    }
    let scale = gram.diagonal().map(|x| 1.0 / x.sqrt());
    if scale.iter().any(|s| !s.is_finite()) {
        return None;
    }
    let scaled = Square::from_fn(|i, j| gram[(i, j)] * scale[i] * scale[j]);
    let smallest = scaled.symmetric_eigenvalues().min();
    let mut inverse = (smallest > LEAST_EIGENVALUE).then(|| scaled.try_inverse()).flatten()?;
    inverse = Square::from_fn(|i, j| inverse[(i, j)] * scale[i] * scale[j]);
    Some(inverse)
}

/// From sums of the derivatives times the errors over blocks of time; and the number of blocks.
fn covariance(
    signals: &Signals<'_>,
    rows: &[usize],
    parameters: &[f64; 5],
    inverse: &Square,
) -> (Square, usize) {
    let per_block = (BLOCK_S / signals.log.sample_time_s).ceil() as usize;
    let mut sums: Vec<Vector> = Vec::new();
    let mut begun = None;
    for (&row, (jacobian, error)) in rows.iter().zip(errors(signals, rows, parameters)) {
        if begun.is_none_or(|begun| row >= begun + per_block) {
            begun = Some(row);
            sums.push(Vector::zeros());
        }
        if let Some(sum) = sums.last_mut() {
            *sum += jacobian * error;
        }
    }
    let freedom = sums.len().saturating_sub(5).max(1);
    let scale = sums.len() as f64 / freedom as f64;
    let mut covariance = Square::zeros();
    for sum in &sums {
        let change = inverse * sum;
        covariance += change * change.transpose() * scale;
    }
    (covariance, sums.len())
}
