//! The uncertainty as it is written in `plant.json`: one input, one output.

use crate::Error;
use crate::pem::uncertain::Uncertain;
use steerwright_formats::{Estimate, FrequencyBand, Matrix, StepBand, UncertainPole, Uncertainty};

/// Frequencies of the band, evenly spaced on a logarithmic axis up to just below half the sample rate.
const FREQUENCIES: usize = 30;
/// From the lowest frequency to half the sample rate.
const DECADES: f64 = 2.7;
/// Times of the step response, over so many time constants of the slowest pole.
const STEPS: usize = 25;
const TIME_CONSTANTS: f64 = 5.0;
const MOST_SAMPLES: f64 = 2000.0;

impl Uncertain {
    /// The uncertainty of input 0 → output 0 for a sample time in seconds. What is not finite, as the
    /// variance of a double pole, leaves its part out; where a pole's is, the file has none.
    ///
    /// # Errors
    /// [`Error::NoModel`] where the poles' variances are not finite, [`Error::Numerical`] where the
    /// poles cannot be had.
    pub fn to_file(&self, sample_time_s: f64) -> Result<Uncertainty, Error> {
        let poles = self.poles()?;
        let finite = |p: &UncertainPole| (p.variance_re + p.variance_im + p.covariance).is_finite();
        if !(poles.iter().all(finite) && crate::linalg::dense::is_finite(self.factor.as_ref())) {
            return Err(Error::no_model("a pole's variance is not finite"));
        }
        let directions =
            Matrix::from_fn(self.factor.ncols(), self.factor.nrows(), |i, j| self.factor[(j, i)]);
        Ok(Uncertainty {
            focus: self.focus,
            poles,
            steady_state_gain: self
                .steady_state_gain(0, 0)
                .map(|(value, standard_error)| Estimate { value, standard_error }),
            frequency_response: self.bands(sample_time_s),
            step_response: self.steps(sample_time_s),
            open_hold_s: None,
            directions,
        })
    }

    fn bands(&self, sample_time_s: f64) -> Vec<FrequencyBand> {
        let half = 0.5 / sample_time_s;
        let band = |k: usize| {
            let decades = DECADES * (k as f64 / FREQUENCIES as f64 - 1.0);
            let frequency_hz = half * 10_f64.powf(decades);
            let omega = std::f64::consts::TAU * frequency_hz * sample_time_s;
            let response = self.frequency_response(0, 0, omega);
            FrequencyBand {
                frequency_hz,
                magnitude: response.re.hypot(response.im),
                phase_rad: response.im.atan2(response.re),
                magnitude_standard_error: response.magnitude_error,
                phase_standard_error_rad: response.phase_error,
            }
        };
        (0..FREQUENCIES)
            .map(band)
            .filter(|b| {
                (b.magnitude + b.magnitude_standard_error + b.phase_standard_error_rad).is_finite()
            })
            .collect()
    }

    fn steps(&self, sample_time_s: f64) -> Vec<StepBand> {
        let radius = self.innovation.model.spectral_radius();
        let samples = TIME_CONSTANTS / -radius.clamp(1e-3, 1.0 - 1e-9).ln();
        let last = samples.clamp(STEPS as f64, MOST_SAMPLES).ceil() as usize;
        let response = self.step_response(0, 0, last + 1);
        (0..=STEPS)
            .map(|k| k * last / STEPS)
            .filter_map(|at| {
                let (value, standard_error) = *response.get(at)?;
                if (value + standard_error).is_finite() {
                    Some(StepBand { time_s: at as f64 * sample_time_s, value, standard_error })
                } else {
                    None
                }
            })
            .collect()
    }
}
