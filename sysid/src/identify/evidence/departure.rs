//! By how much the model departs from the measured response, band by band.
//!
//! Over a band, the measured response is regressed on the model's, weighted by the power of the
//! model's output: with Ĝ measured, G the model's and S_u the power of the input,
//!
//! `ρ = Σ S_u G* Ĝ / Σ S_u |G|²`
//!
//! is the complex factor that brings the model to the measurement, whose real and imaginary part
//! scatter, with noise of density S_v, by `σ² = Σ S_u |G|² S_v / (Σ S_u |G|²)² · 1.5/(2 n_d)` each (as
//! in [`super::bands`]). Many frequencies together tell small departures from chance, and one outlier
//! does not make one.
//!
//! How much is too much: with the complementary sensitivity T of a loop, the controller that
//! stabilises the model stabilises what departs from it by a share below 1/|T| (Skogestad and
//! Postlethwaite 2005, section 7.5); |T| is at most about 1.3 in a loop with little overshoot, and
//! below half of that share its margins remain ones.

use super::bands::{COUPLED, inside};
use super::{INFORMATIVE, Modelled, rounded};
use crate::signal::Spectra;
use formats::BandDeparture;

/// Departures in those of the given bands in which steering explains most of the yaw rate, from the
/// measured responses at all frequencies.
pub(crate) fn departures(
    spectra: &Spectra,
    modelled: &Modelled<'_>,
    measured: &[(f64, f64)],
    sample_time_s: f64,
) -> Vec<BandDeparture> {
    super::bands::ENDS
        .windows(2)
        .filter_map(|ends| {
            let (mut factor, mut power, mut scatter) = ((0.0, 0.0), 0.0, 0.0);
            let (mut noise, mut output, mut count) = (0.0, 0.0, 0.0);
            for k in (0..measured.len()).filter(|k| inside(ends, spectra.frequency_hz[*k])) {
                let model = modelled.response(spectra.frequency_hz[k], sample_time_s);
                let (u, v) = (spectra.input[k], spectra.noise(k));
                let size = model.0 * model.0 + model.1 * model.1;
                factor.0 += u * (model.0 * measured[k].0 + model.1 * measured[k].1);
                factor.1 += u * (model.0 * measured[k].1 - model.1 * measured[k].0);
                power += u * size;
                scatter += u * size * v;
                noise += v;
                output += spectra.output[k];
                count += 1.0;
            }
            let significant = spectra.significance(0.01).max(INFORMATIVE);
            if !(power > 0.0 && noise < (1.0 - significant) * output) {
                return None;
            }
            let (re, im) = (factor.0 / power, factor.1 / power);
            let size = re.hypot(im);
            let coupled = COUPLED.min(count) / (2.0 * spectra.averages.max(1.0));
            let standard_error = (scatter * coupled).sqrt() / (power * size);
            // |G − Ĝ|/|Ĝ| = |1 − ρ|/|ρ|.
            let apart = (1.0 - re).hypot(im) / size;
            (apart.is_finite() && standard_error.is_finite()).then(|| BandDeparture {
                from_hz: ends[0],
                to_hz: ends[1],
                gain_ratio: rounded(1.0 / size),
                phase_ahead_rad: rounded(-im.atan2(re)),
                standard_error: rounded(standard_error),
                departure: rounded((apart - 2.0 * standard_error).max(0.0)),
            })
        })
        .collect()
}
