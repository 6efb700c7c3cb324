//! Information in the log by frequency, compared with the model.

use serde::{Deserialize, Serialize};

/// Information in the log about the dynamics.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Excitation {
    /// Standard deviation of the steering angle at the road wheel, rad.
    pub road_wheel_std_rad: f64,
    /// Standard deviation of the yaw rate, rad/s.
    pub yaw_rate_std_radps: f64,
    /// Standard deviation of the innovation over that of the yaw rate.
    pub noise_to_signal: f64,
    /// Largest frequency below which the coherence stays above 0.5, Hz; 0 if it never does.
    pub informative_up_to_hz: f64,
    /// Coherence of steering and yaw rate.
    pub coherence: Vec<CoherencePoint>,
    /// Information in the log by bands of frequency.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub bands: Vec<ExcitationBand>,
    /// The order of persistent excitation of the input.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub persistence: Option<Persistence>,
    /// Largest angle steered to either side of the mean, rad, in steering coordinates.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub largest_steering_rad: Option<f64>,
    /// Fastest steering, rad/s in steering coordinates, by [`Excitation::largest_rate`].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub largest_steering_rate_radps: Option<f64>,
}

/// The time over which a rate of steering is computed, s: the difference of neighbouring samples is
/// mostly sensor noise.
const RATE_OVER_S: f64 = 0.1;
/// The percentile that is used as the largest rate, so that single spikes of a sensor do not count.
const FASTEST_SHARE: f64 = 0.999;

impl Excitation {
    /// The rate of a signal, in its unit per second: the 99.9th percentile of its mean rate over a tenth
    /// of a second, which a few spikes of a sensor do not change. With less than 1000 samples it is the
    /// largest.
    #[must_use]
    pub fn largest_rate(signal: &[f64], sample_time_s: f64) -> f64 {
        let apart = ((RATE_OVER_S / sample_time_s).round() as usize).max(1);
        let over = apart as f64 * sample_time_s;
        let mut rates: Vec<f64> =
            signal.windows(apart + 1).map(|w| (w[apart] - w[0]).abs() / over).collect();
        rates.sort_by(f64::total_cmp);
        let most = (FASTEST_SHARE * rates.len() as f64).ceil() as usize;
        rates.get(most.saturating_sub(1)).copied().unwrap_or(0.0)
    }

    /// The frequency above which no band has information, Hz; `None` if the highest has some.
    #[must_use]
    pub fn silent_from_hz(&self) -> Option<f64> {
        let silent = |b: &&ExcitationBand| b.information == Information::None;
        self.bands.iter().rev().take_while(silent).last().map(|b| b.from_hz)
    }
}

/// Coherence at one frequency.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CoherencePoint {
    /// Frequency, Hz.
    pub frequency_hz: f64,
    /// Magnitude-squared coherence, 0 to 1.
    pub coherence: f64,
}

/// Information in a log in a band of frequency.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ExcitationBand {
    /// Lower end, Hz.
    pub from_hz: f64,
    /// Upper end, Hz.
    pub to_hz: f64,
    /// Standard deviation of the steering within the band, at the road wheel, rad.
    pub road_wheel_std_rad: f64,
    /// Standard deviation of the yaw rate within the band, rad/s.
    pub yaw_rate_std_radps: f64,
    /// Share of that yaw rate's power that the steering explains, 0 to 1.
    pub coherence: f64,
    /// Standard error of the band's gain from the spectra alone, over that gain: it falls
    /// with the square root of the time recorded, and as the steering grows.
    pub relative_error: f64,
    /// The conclusion.
    pub information: Information,
}

/// Whether a log is informative.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Information {
    /// Yaw rate follows the steering, and the gain is determined.
    Good,
    /// It does so in part.
    Weak,
    /// The log has no information in this band.
    None,
}

/// Order of persistent excitation.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Persistence {
    /// Largest order found.
    pub order: usize,
    /// Largest order tried; the order may be higher if both are equal.
    pub tried: usize,
}

/// Frequency response measured (Welch's method, H1, less the smear of its windows as the model's own
/// simulation shows it), and the model's.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FrequencyResponse {
    /// Probability of each band at one frequency.
    pub confidence: f64,
    /// Independent averages of the spectra.
    pub averages: f64,
    /// Distance of two frequencies, Hz.
    pub resolution_hz: f64,
    /// Coherence that unrelated signals exceed with a probability of 1 %.
    pub significant_coherence: f64,
    /// Frequencies that are compared: those whose coherence is significant and above 0.5.
    pub compared: usize,
    /// Share of these at which the model lies within the band.
    pub within: f64,
    /// The model compared with the measured response, in frequency bands in which the log is coherent.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub bands: Vec<BandDeparture>,
    /// For the plot: all low frequencies, and a selection of the high ones, which are close together on
    /// a logarithmic axis.
    pub points: Vec<ResponsePoint>,
}

/// The model error in a band: the complex factor from the simulated to the measured yaw rate, over all
/// frequencies of the band, weighted by the power of the simulation.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct BandDeparture {
    /// Lower end, Hz.
    pub from_hz: f64,
    /// Upper end, Hz.
    pub to_hz: f64,
    /// The model's gain over the measured one.
    pub gain_ratio: f64,
    /// The model's phase minus the measured one, rad; positive if the model leads.
    pub phase_ahead_rad: f64,
    /// Standard error of the gain ratio over itself, and of the phase in rad.
    pub standard_error: f64,
    /// The relative model error, |model − measured|/|measured|, minus twice its standard error; 0 if it
    /// is within twice the standard error.
    pub departure: f64,
}

/// Measured and modelled response at one frequency; gains in yaw rate over the model's input.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ResponsePoint {
    /// Frequency, Hz.
    pub frequency_hz: f64,
    /// Measured gain.
    pub gain: f64,
    /// Measured phase, rad, continuous over frequency.
    pub phase_rad: f64,
    /// Radius of the confidence disk about the measured response, in the unit of the gain.
    pub radius: f64,
    /// Magnitude-squared coherence.
    pub coherence: f64,
    /// Its lower confidence bound.
    pub coherence_low: f64,
    /// Its upper confidence bound.
    pub coherence_high: f64,
    /// The model's gain.
    pub model_gain: f64,
    /// The model's phase, rad, with its input delay.
    pub model_phase_rad: f64,
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A sweep of 0.4 rad/s at 100 Hz for 60 s, with spikes of 0.5 rad in it: 5 rad/s over a tenth of a
    /// second.
    #[test]
    fn spikes_are_no_fast_steering() {
        let steering = |k: usize| 0.2 * (2.0 * 0.01 * k as f64).sin();
        let mut signal: Vec<f64> = (0..6000).map(steering).collect();
        let clean = Excitation::largest_rate(&signal, 0.01);
        assert!((clean - 0.4).abs() < 0.004, "{clean}");
        signal[1234] += 0.5;
        signal[4321] -= 0.5;
        let spiked = Excitation::largest_rate(&signal, 0.01);
        assert!((spiked - clean).abs() < 0.004, "{spiked} {clean}");
        assert_eq!(Excitation::largest_rate(&[1.0], 0.01), 0.0);
        assert!((Excitation::largest_rate(&[0.0, 0.0, 0.03], 0.1) - 0.3).abs() < 1e-12);
    }
}
