//! What the choice of order and delay leaves open in the response, added to its standard errors.
//!
//! The other standard errors are those of the model with its order and delay as they are, widened by other orders with
//! their weights by BIC. BIC prefers the lesser order also where the response of a larger one is the likelier: for the
//! response the weights are those of Akaike's criterion where these are larger (Burnham and Anderson 2002).
//!
//! With a longer delay another model fits best, which takes over a part of the difference, all of it at low frequencies.
//! So the model is refined once with the delay as it is and once with one that is longer by a standard error; what lies
//! between the two responses, delays included, is one standard error, independent of the others.

use crate::data::scaled::Data;
use crate::model::StateSpace;
use crate::selection::candidate::{Candidate, Choice, FINE, refine};
use crate::selection::delay::Delay;
use crate::selection::options::IdentifyOptions;
use crate::selection::order::{parameters, weights};
use faer::c64;
use std::f64::consts::TAU;
use steerwright_drivelog::DriveLog;
use steerwright_formats::{FrequencyBand, Uncertainty};

/// Adds to the bands of the chosen model what other orders would change, by so much as their weights by Akaike's criterion
/// exceed those by BIC, which are in the bands.
pub(super) fn with_other_orders(stated: &mut Uncertainty, data: &Data, choice: &Choice) {
    let counted = |c: &Candidate| {
        let model = &c.model;
        (c.criterion, parameters(model.order(), model.inputs(), model.outputs(), c.feedthrough))
    };
    let models: Vec<_> = choice.candidates.iter().map(counted).collect();
    let akaike = weights(&models, (data.estimation.len() as f64).max(2.0).ln() - 2.0);
    let bayes = weights(&models, 0.0);
    let chosen = Sampled::new(&choice.candidates[choice.chosen], data);
    for (k, candidate) in choice.candidates.iter().enumerate() {
        let more = akaike[k] - bayes[k];
        if k == choice.chosen || more.is_nan() || more <= 0.0 {
            continue;
        }
        let other = Sampled::new(candidate, data);
        for band in &mut stated.frequency_response {
            let omega = TAU * band.frequency_hz;
            widen(band, other.response(omega) / chosen.response(omega), more.sqrt());
        }
    }
}

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
        if options.refine {
            refined(&log.with_input_delayed(delay_s), chosen, options)
        } else {
            None
        }
    };
    // The first is one step: the chosen model is refined with that delay already, unless its data were two-stage.
    let models = model(delay.seconds).zip(model(delay.seconds + longer_s));
    for band in &mut stated.frequency_response {
        let omega = TAU * band.frequency_hz;
        let mut apart = c64::cis(-omega * longer_s);
        if let Some((as_is, longer)) = &models {
            let ratio = longer.response(omega) / as_is.response(omega);
            if ratio.re.is_finite() && ratio.im.is_finite() {
                apart *= ratio;
            }
        }
        widen(band, apart, 1.0);
    }
}

/// Adds so many times what lies between two responses of that ratio to the standard errors.
fn widen(band: &mut FrequencyBand, apart: c64, times: f64) {
    let gain = times * (apart.re.hypot(apart.im) - 1.0) * band.magnitude;
    let phase_rad = times * apart.im.atan2(apart.re);
    if gain.is_finite() && phase_rad.is_finite() {
        band.magnitude_standard_error = band.magnitude_standard_error.hypot(gain);
        band.phase_standard_error_rad = band.phase_standard_error_rad.hypot(phase_rad);
    }
}

fn refined(log: &DriveLog, chosen: &Candidate, options: &IdentifyOptions) -> Option<Sampled> {
    let mut data = Data::new(log, &options.preparation()).ok()?;
    if let Some([offset]) = chosen.initial_conditions.offsets.as_deref() {
        data = data.about(*offset).ok()?;
    }
    let mut candidate = chosen.clone();
    refine(&data.estimation.data, &mut candidate, FINE).ok()?;
    Some(Sampled::new(&candidate, &data))
}

/// A model in SI units with its sample time, s.
struct Sampled {
    model: StateSpace,
    sample_time_s: f64,
}

impl Sampled {
    fn new(candidate: &Candidate, data: &Data) -> Self {
        let model = candidate.model.scaled(&[data.input_scale], &[data.output_scale]);
        Self { model, sample_time_s: data.sample_time }
    }

    fn response(&self, omega: f64) -> c64 {
        let (re, im) = self.model.frequency_response(0, 0, omega * self.sample_time_s);
        c64::new(re, im)
    }
}
