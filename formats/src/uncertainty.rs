//! How uncertain the identified model is: standard errors of what does not depend on the state's
//! basis, and the directions by which whole models can be drawn.
//!
//! Standard errors are one standard deviation of the estimate, to first order (delta method): the
//! truth lies within 1.96 of them with 95 % probability, for a model of the right order.

use crate::{Checker, Matrix, Plant};
use serde::{Deserialize, Serialize};

/// Standard errors in a 95 % interval.
pub const NORMAL_95: f64 = 1.959_963_984_540_054;

/// The uncertainty of a [`Plant`]'s model.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Uncertainty {
    /// The errors that the estimate minimises, which determines the covariance.
    pub focus: EstimationFocus,
    /// The eigenvalues of A.
    pub poles: Vec<UncertainPole>,
    /// Yaw rate over the model's input at rest; absent for an integrator.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub steady_state_gain: Option<Estimate>,
    /// From the model's input to yaw rate, without the input delay.
    pub frequency_response: Vec<FrequencyBand>,
    /// Yaw rate after a unit step of the model's input, without the input delay.
    pub step_response: Vec<StepBand>,
    /// One row for each independent standard normal number ξ: the move of the entries of A, B, C, D,
    /// K, each row by row, for ξ = 1. A model drawn from the estimate's distribution is
    /// `nominal + Σ ξ_i · row_i`. Moves that would only change the state's basis are left out.
    pub directions: Matrix,
}

/// What the estimate made small.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum EstimationFocus {
    /// The one-step prediction errors; covariance σ²(JᵀJ)⁻¹.
    Prediction,
    /// The simulation errors; covariance with the autocovariance of these errors.
    Simulation,
}

/// A number with its standard error.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Estimate {
    /// The estimate.
    pub value: f64,
    /// Its standard deviation.
    pub standard_error: f64,
}

/// A discrete pole; of a complex pair both are listed.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct UncertainPole {
    /// Real part.
    pub re: f64,
    /// Imaginary part.
    pub im: f64,
    /// Variance of the real part.
    pub variance_re: f64,
    /// Variance of the imaginary part.
    pub variance_im: f64,
    /// Covariance of the two.
    pub covariance: f64,
}

/// The response at one frequency.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FrequencyBand {
    /// Frequency, Hz.
    pub frequency_hz: f64,
    /// Yaw rate over input.
    pub magnitude: f64,
    /// Phase, rad, within ±π.
    pub phase_rad: f64,
    /// Standard error of the magnitude.
    pub magnitude_standard_error: f64,
    /// Standard error of the phase, rad; not meaningful where the magnitude's reaches it.
    pub phase_standard_error_rad: f64,
}

/// The step response at one time.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct StepBand {
    /// Time after the step, s.
    pub time_s: f64,
    /// Yaw rate over the step of the model's input.
    pub value: f64,
    /// Its standard error.
    pub standard_error: f64,
}

impl Uncertainty {
    /// Checks values and, against a model of order n, shapes.
    pub(crate) fn check(&self, n: usize, c: &mut Checker) {
        let at = |field: &str, i: usize, of: &str| format!("uncertainty.{field}[{i}].{of}");
        c.require(self.poles.len() == n, "uncertainty.poles", || {
            format!("{} poles, expected {n}", self.poles.len())
        });
        for (i, pole) in self.poles.iter().enumerate() {
            c.finite(pole.re, &at("poles", i, "re"));
            c.finite(pole.im, &at("poles", i, "im"));
            c.not_negative(pole.variance_re, &at("poles", i, "variance_re"));
            c.not_negative(pole.variance_im, &at("poles", i, "variance_im"));
            c.finite(pole.covariance, &at("poles", i, "covariance"));
        }
        if let Some(gain) = &self.steady_state_gain {
            c.finite(gain.value, "uncertainty.steady_state_gain.value");
            c.not_negative(gain.standard_error, "uncertainty.steady_state_gain.standard_error");
        }
        for (i, band) in self.frequency_response.iter().enumerate() {
            let at = |of| at("frequency_response", i, of);
            c.not_negative(band.frequency_hz, &at("frequency_hz"));
            c.not_negative(band.magnitude, &at("magnitude"));
            c.finite(band.phase_rad, &at("phase_rad"));
            c.not_negative(band.magnitude_standard_error, &at("magnitude_standard_error"));
            c.not_negative(band.phase_standard_error_rad, &at("phase_standard_error_rad"));
        }
        for (i, band) in self.step_response.iter().enumerate() {
            let at = |of| at("step_response", i, of);
            c.not_negative(band.time_s, &at("time_s"));
            c.finite(band.value, &at("value"));
            c.not_negative(band.standard_error, &at("standard_error"));
        }
        let entries = entries(n);
        let rows = self.directions.rows();
        c.require(rows <= entries, "uncertainty.directions", || {
            format!("{rows} directions, a model of order {n} has at most {entries}")
        });
        if rows > 0 {
            c.shape(&self.directions, rows, entries, "uncertainty.directions");
        }
    }
}

/// Entries of A, B, C, D and K.
fn entries(n: usize) -> usize {
    n * n + 3 * n + 1
}

impl Plant {
    /// How many standard normal numbers [`Plant::ensemble_member`] takes; 0 where the file states no
    /// uncertainty.
    #[must_use]
    pub fn ensemble_dimension(&self) -> usize {
        self.uncertainty.as_ref().map_or(0, |u| u.directions.rows())
    }

    /// The plant whose discrete model is `nominal + Σ ξ_i · direction_i`: for independent standard
    /// normal ξ a draw from the estimate's distribution, to first order. It carries no continuous
    /// model and has no uncertainty.
    ///
    /// `None` where the plant states no uncertainty, where there are not
    /// [`Plant::ensemble_dimension`] numbers, and where the model drawn is not stable: the
    /// distribution of stable models is then got by drawing again.
    #[must_use]
    pub fn ensemble_member(&self, xi: &[f64]) -> Option<Self> {
        let directions = &self.uncertainty.as_ref()?.directions;
        if xi.len() != directions.rows() {
            return None;
        }
        let mut member = self.clone();
        let d = &mut member.discrete;
        let places =
            [&mut d.a, &mut d.b, &mut d.c, &mut d.d, &mut d.k].into_iter().flat_map(|m| &mut m.0);
        for (k, entry) in places.flatten().enumerate() {
            for (row, xi) in directions.0.iter().zip(xi) {
                *entry += xi * row.get(k)?;
            }
        }
        member.continuous = None;
        member.uncertainty = None;
        is_stable(&member.discrete.a).then_some(member)
    }
}

/// Whether the powers A, A², A⁴, A⁸ … vanish.
fn is_stable(a: &Matrix) -> bool {
    let n = a.rows();
    if a.columns() != Some(n) {
        return false;
    }
    let mut power = a.0.clone();
    for _ in 0..48 {
        let size = power.iter().flatten().fold(0.0_f64, |s, x| s + x * x).sqrt();
        if size < 0.5 {
            return true;
        }
        if !size.is_finite() || size > 1e100 {
            return false;
        }
        let square = |i: usize, j: usize| (0..n).map(|k| power[i][k] * power[k][j]).sum();
        power = (0..n).map(|i| (0..n).map(|j| square(i, j)).collect()).collect();
    }
    false
}
