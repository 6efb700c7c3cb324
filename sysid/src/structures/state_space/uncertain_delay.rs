//! What the error of an estimated delay adds to the standard errors of the response.
//!
//! The other standard errors are those of the model with the delay as it is. With a longer delay another model fits best,
//! which takes over a part of the difference, all of it at low frequencies. So the model is refined once with the delay
//! as it is and once with one that is longer by a standard error; what lies between the two responses, delays
//! included, is one standard error, independent of the others.

use crate::data::scaled::Data;
use crate::model::StateSpace;
use crate::selection::candidate::{Candidate, FINE, refine};
use crate::selection::delay::Delay;
use crate::selection::options::IdentifyOptions;
use faer::c64;
use std::f64::consts::TAU;
use steerwright_drivelog::DriveLog;
use steerwright_formats::Uncertainty;

/// Adds the uncertainty of its delay to that of a model of `log`, whose input is not delayed yet. Where no model can be
/// refined, the whole difference of the phase counts.
pub(super) fn with_uncertain_delay(
    stated: &mut Uncertainty,
    log: &DriveLog,
    delay: &Delay,
    chosen: &Candidate,
    options: &IdentifyOptions,
) {
    let longer_s = delay.standard_error_s;
    if delay.seconds == 0.0 || !longer_s.is_finite() {
        return;
    }
    let model = |delay_s: f64| {
        options.refine.then(|| refined(&log.with_input_delayed(delay_s), chosen, options)).flatten()
    };
    let models = model(delay.seconds).zip(model(delay.seconds + longer_s));
    for band in &mut stated.frequency_response {
        let omega = TAU * band.frequency_hz;
        let mut apart = c64::cis(-omega * longer_s);
        if let Some((as_is, longer)) = &models {
            let ratio = response(longer, omega) / response(as_is, omega);
            if ratio.re.is_finite() && ratio.im.is_finite() {
                apart *= ratio;
            }
        }
        let gain = (apart.re.hypot(apart.im) - 1.0) * band.magnitude;
        let phase_rad = apart.im.atan2(apart.re);
        band.magnitude_standard_error = band.magnitude_standard_error.hypot(gain);
        band.phase_standard_error_rad = band.phase_standard_error_rad.hypot(phase_rad);
    }
}

/// A model in SI units with its sample time, s.
struct Sampled {
    model: StateSpace,
    sample_time_s: f64,
}

fn refined(log: &DriveLog, chosen: &Candidate, options: &IdentifyOptions) -> Option<Sampled> {
    let mut data = Data::new(log, &options.preparation()).ok()?;
    if let Some([offset]) = chosen.initial_conditions.offsets.as_deref() {
        data = data.about(*offset).ok()?;
    }
    let mut candidate = chosen.clone();
    refine(&data.estimation.data, &mut candidate, FINE).ok()?;
    Some(Sampled {
        model: candidate.model.scaled(&[data.input_scale], &[data.output_scale]),
        sample_time_s: data.sample_time,
    })
}

fn response(of: &Sampled, omega: f64) -> c64 {
    let (re, im) = of.model.frequency_response(0, 0, omega * of.sample_time_s);
    c64::new(re, im)
}
