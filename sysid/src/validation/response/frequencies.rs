//! The data by frequency: excitation, coherence, and the measured response compared with the model's.

use crate::subspace::Conditioning;
use crate::validation::residuals::correlation::{autocorrelation, cross_correlation, feedback};
use crate::validation::response::bands::{bands, persistence};
use crate::validation::response::measured::response;
use crate::validation::response::modelled::{
    DRIFT, HIGHEST_SHOWN, INFORMATIVE, LAGS, Modelled, rounded,
};
use crate::validation::response::spectra::Spectra;
use steerwright_drivelog::DriveLog;
use steerwright_drivelog::signal::{mean, standard_deviation};
use steerwright_formats::{
    CoherencePoint, DataFactor, Excitation, FrequencyResponse, ResidualCorrelation,
};

/// Excitation and frequency response of the whole log, with the model's response.
pub(crate) fn frequencies(
    log: &DriveLog,
    modelled: &Modelled<'_>,
    noise_to_signal: f64,
) -> (Excitation, FrequencyResponse) {
    let ranges = || log.segments.iter().map(|s| s.range.clone());
    let inputs: Vec<&[f64]> = ranges().map(|r| &modelled.input[r]).collect();
    let with = |output: &[f64]| {
        let pairs: Vec<(&[f64], &[f64])> =
            inputs.iter().copied().zip(ranges().map(|r| &output[r])).collect();
        Spectra::welch(&pairs, log.sample_time_s)
    };
    let spectra = with(&log.output);
    let simulated = with(modelled.simulated);
    let straight = mean(&log.input);
    let largest_angle = log.input.iter().map(|u| (u - straight).abs()).fold(0.0, f64::max);
    let (coherent, response) = of_spectra(&spectra, Some(&simulated), modelled, log.sample_time_s);
    let excitation = Excitation {
        road_wheel_std_rad: standard_deviation(&log.input) / log.steering_ratio,
        yaw_rate_std_radps: standard_deviation(&log.output),
        noise_to_signal,
        persistence: Some(persistence(&inputs)),
        largest_steering_rad: Some(rounded(largest_angle)),
        largest_steering_rate_radps: Some(rounded(log.fastest_steering())),
        ..coherent
    };
    (excitation, response)
}

/// Excitation and response; the simulation's spectra, if known, show what windows smear.
pub(crate) fn of_spectra(
    spectra: &Spectra,
    simulated: Option<&Spectra>,
    modelled: &Modelled<'_>,
    sample_time_s: f64,
) -> (Excitation, FrequencyResponse) {
    let shown = |k: &usize| spectra.frequency_hz[*k] <= HIGHEST_SHOWN;
    let coherence = (0..spectra.len()).filter(shown).map(|k| CoherencePoint {
        frequency_hz: rounded(spectra.frequency_hz[k]),
        coherence: rounded(spectra.coherence(k)),
    });
    let excitation = Excitation {
        informative_up_to_hz: informative_up_to(spectra),
        coherence: coherence.collect(),
        bands: bands(spectra, modelled),
        ..Excitation::default()
    };
    let response = response(spectra, simulated, modelled, sample_time_s, HIGHEST_SHOWN);
    (excitation, response)
}

/// Largest frequency up to which the coherence stays informative, Hz.
fn informative_up_to(spectra: &Spectra) -> f64 {
    let all: Vec<f64> = (0..spectra.len()).map(|k| spectra.coherence(k)).collect();
    // Three neighbouring frequencies together, since a single estimate scatters.
    let smooth = |i: usize| {
        let near = &all[i.saturating_sub(1)..(i + 2).min(all.len())];
        near.iter().sum::<f64>() / near.len() as f64
    };
    let threshold = INFORMATIVE.max(spectra.significance(0.01));
    let mut limit = 0.0;
    for (i, frequency) in spectra.frequency_hz.iter().enumerate() {
        if smooth(i) >= threshold {
            limit = *frequency;
        } else if limit > 0.0 || *frequency > DRIFT {
            break;
        }
    }
    limit
}

pub(crate) fn correlations(residuals: &[&[f64]], input: &[&[f64]]) -> ResidualCorrelation {
    let own = autocorrelation(residuals, LAGS);
    let cross = cross_correlation(residuals, input, LAGS);
    ResidualCorrelation {
        autocorrelation: own.values.iter().copied().map(rounded).collect(),
        autocorrelation_bound: rounded(own.bound),
        with_input: cross.values.iter().copied().map(rounded).collect(),
        with_input_bound: rounded(cross.bound),
        feedback: feedback(residuals, input, LAGS),
    }
}

pub(crate) fn data_factor(c: &Conditioning) -> DataFactor {
    let finite =
        |condition: f64| if condition.is_finite() { Some(rounded(condition)) } else { None };
    DataFactor {
        method: c.method,
        condition: finite(c.condition),
        input_condition: finite(c.input_condition),
        asked_horizon: c.requested_horizon,
        horizon: c.horizon,
    }
}
