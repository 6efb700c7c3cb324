//! The uncertainty of the identified model: standard errors of quantities that do not depend on the
//! state's basis, and the covariance factor from which models can be drawn.
//!
//! Standard errors are one standard deviation of the estimate, to first order (delta method): the
//! truth lies within 1.96 of them with 95 % probability, for a model of the right order.

use crate::document::Checker;
use crate::matrix::Matrix;
use serde::{Deserialize, Serialize};

/// Standard errors in a 95 % interval.
pub const NORMAL_95: f64 = 1.959_963_984_540_054;

/// The uncertainty of an identified plant's model.
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
    /// Period of the steering in the log, s, where it is not known whether the steering is held between its samples: the
    /// standard errors of `frequency_response` then also cover the other case, in phase by half a period or more. Absent
    /// where it is known, and in files of earlier versions.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub open_hold_s: Option<f64>,
    /// The covariance factor, with one row for each independent standard normal number ξ: the change of
    /// the entries of A, B, C, D, K, each row by row, for ξ = 1. A model drawn from the estimate's
    /// distribution is `nominal + Σ ξ_i · row_i`. Changes of the state's basis only are left out.
    pub directions: Matrix,
}

/// The errors that the estimate minimises.
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
    /// Standard error of the phase, rad; not meaningful if that of the magnitude reaches the magnitude.
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
    /// Standard errors at a frequency in Hz: of the magnitude over the magnitude, and of the phase in rad. Between the
    /// frequencies of the file they are interpolated by logarithms; `None` outside.
    #[must_use]
    pub fn errors_at(&self, frequency_hz: f64) -> Option<[f64; 2]> {
        let bands = &self.frequency_response;
        let above = bands.iter().position(|b| b.frequency_hz >= frequency_hz)?;
        let (low, high) = (bands.get(above.checked_sub(1)?)?, &bands[above]);
        let share =
            (frequency_hz / low.frequency_hz).ln() / (high.frequency_hz / low.frequency_hz).ln();
        let between = |a: f64, b: f64| a.powf(1.0 - share) * b.powf(share);
        let relative = |b: &FrequencyBand| b.magnitude_standard_error / b.magnitude;
        Some([
            between(relative(low), relative(high)),
            between(low.phase_standard_error_rad, high.phase_standard_error_rad),
        ])
    }

    /// Checks values and, against a model of order n, shapes.
    pub(crate) fn check(&self, n: usize, c: &mut Checker) {
        let at = |field: &str, i: usize| format!("uncertainty.{field}[{i}].");
        c.require(self.poles.len() == n, "uncertainty.poles", || {
            format!("{} poles, expected {n}", self.poles.len())
        });
        for (i, pole) in self.poles.iter().enumerate() {
            let at = at("poles", i);
            check_fields!(c.finite(pole, at): re im);
            check_fields!(c.not_negative(pole, at): variance_re variance_im);
            check_fields!(c.finite(pole, at): covariance);
        }
        if let Some(gain) = &self.steady_state_gain {
            c.finite(gain.value, "uncertainty.steady_state_gain.value");
            c.not_negative(gain.standard_error, "uncertainty.steady_state_gain.standard_error");
        }
        for (i, band) in self.frequency_response.iter().enumerate() {
            let at = at("frequency_response", i);
            check_fields!(c.not_negative(band, at): frequency_hz magnitude);
            check_fields!(c.finite(band, at): phase_rad);
            check_fields!(c.not_negative(band, at):
                magnitude_standard_error phase_standard_error_rad);
        }
        for (i, band) in self.step_response.iter().enumerate() {
            let at = at("step_response", i);
            check_fields!(c.not_negative(band, at): time_s);
            check_fields!(c.finite(band, at): value);
            check_fields!(c.not_negative(band, at): standard_error);
        }
        if let Some(period) = self.open_hold_s {
            c.positive(period, "uncertainty.open_hold_s");
        }
        // Those of A, B, C, D and K.
        let entries = n * n + 3 * n + 1;
        let rows = self.directions.rows();
        c.require(rows <= entries, "uncertainty.directions", || {
            format!("{rows} directions, a model of order {n} has at most {entries}")
        });
        if rows > 0 {
            c.shape(&self.directions, rows, entries, "uncertainty.directions");
        }
    }
}
