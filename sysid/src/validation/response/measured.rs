//! The measured frequency response, with the model's. The model's own simulation from the same
//! input shows what windows of finite length smear, which is taken off the measured response: H1
//! from the input to the simulation's error (Ljung 1999, section 16.6) is compared against the
//! confidence disk of the measured response.

use crate::validation::residuals::model_error::band_errors;
use crate::validation::response::modelled::{INFORMATIVE, Modelled, rounded};
use crate::validation::response::spectra::Spectra;
use std::f64::consts::{PI, TAU};
use steerwright_formats::{FrequencyResponse, NORMAL_95, ResponsePoint};

const RISK: f64 = 0.05;
/// Frequencies closer than by this factor are one on a plot.
pub(crate) const CLOSE: f64 = 1.05;

pub(crate) fn response(
    spectra: &Spectra,
    simulated: Option<&Spectra>,
    modelled: &Modelled<'_>,
    sample_time_s: f64,
    highest_hz: f64,
) -> FrequencyResponse {
    let significant = spectra.significance(0.01);
    let comparable = significant.max(INFORMATIVE);
    let (mut compared, mut within) = (0, 0);
    let (mut points, mut all) = (Vec::new(), Vec::new());
    let mut shown_hz = 0.0;
    let mut before = [0.0; 2];
    for k in 0..spectra.len() {
        let frequency_hz = spectra.frequency_hz[k];
        if frequency_hz > highest_hz {
            break;
        }
        let model = modelled.response(frequency_hz, sample_time_s);
        let (with_noise, without) =
            (spectra.response(k), simulated.map_or(model, |s| s.response(k)));
        let error = (with_noise.0 - without.0, with_noise.1 - without.1);
        let measured = (model.0 + error.0, model.1 + error.1);
        all.push(measured);
        let radius = spectra.radius(k, RISK);
        let coherence = spectra.coherence(k);
        if coherence > comparable {
            compared += 1;
            within += usize::from(error.0.hypot(error.1) <= radius);
        }
        let (low, high) = spectra.coherence_bounds(k, NORMAL_95);
        // Phases continue from one frequency to the next.
        for (before, z) in before.iter_mut().zip([measured, model]) {
            let phase = z.1.atan2(z.0);
            *before = phase + TAU * ((*before - phase) / TAU).round();
        }
        // The measured phase wanders where nothing is measured: it stays near the model's.
        let turns = ((before[1] - before[0]) / TAU).round();
        if frequency_hz < CLOSE * shown_hz {
            continue;
        }
        shown_hz = frequency_hz;
        points.push(ResponsePoint {
            frequency_hz: rounded(frequency_hz),
            gain: rounded(measured.0.hypot(measured.1)),
            phase_rad: rounded(before[0] + TAU * turns),
            radius: rounded(radius.min(1e9)),
            coherence: rounded(coherence),
            coherence_low: rounded(low),
            coherence_high: rounded(high),
            model_gain: rounded(model.0.hypot(model.1)),
            model_phase_rad: rounded(before[1]),
        });
    }
    FrequencyResponse {
        confidence: 1.0 - RISK,
        averages: rounded(spectra.averages),
        resolution_hz: rounded(spectra.resolution_hz()),
        significant_coherence: rounded(significant),
        compared,
        within: if compared > 0 { within as f64 / compared as f64 } else { 0.0 },
        bands: band_errors(spectra, modelled, &all, sample_time_s),
        points,
    }
}

impl Modelled<'_> {
    pub(crate) fn response(&self, frequency_hz: f64, sample_time_s: f64) -> (f64, f64) {
        let omega = (TAU * frequency_hz * sample_time_s).min(PI);
        let (re, im) = self.model.frequency_response(0, 0, omega);
        let (s, c) = (-TAU * frequency_hz * self.delay_s).sin_cos();
        (re * c - im * s, re * s + im * c)
    }
}
