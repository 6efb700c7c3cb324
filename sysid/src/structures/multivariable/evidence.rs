//! What validates a plant of several channels: by output and by pair.

use crate::Error;
use crate::data::{DataSet, Signals, fit_percent};
use crate::model::StateSpace;
use crate::pem::Uncertain;
use crate::selection::candidate::Choice;
use crate::selection::initial_conditions::InitialConditions;
use crate::selection::order::{Errors, errors, fit};
use crate::structures::multivariable::filter::{Filter, Scaled};
use crate::structures::state_space::automatic::Units;
use crate::structures::state_space::plant::{feedback_test, order_table};
use crate::validation::residuals::correlation::{independence, whiteness};
use crate::validation::residuals::fit::fit_with_error;
use crate::validation::response::modelled::{LAGS, rounded};
use crate::validation::response::multiple::MultipleSpectra;
use std::f64::consts::TAU;
use steerwright_formats::{
    ChannelSummary, CoherencePoint, Estimate, Fits, FrequencyBand, MeasuredPoint,
    MultivariableEvidence, OutputEvidence, PairDelay, PairEvidence,
};

/// Frequencies of the model's response, evenly spaced on a logarithmic axis up to just below half the sample rate.
const FREQUENCIES: usize = 30;
const DECADES: f64 = 2.7;
/// Risk of the bounds on measured responses and coherences.
const RISK: f64 = 0.05;
/// Most measured frequencies in the file: a selection of the high ones, which are close together on a logarithmic axis.
const MOST_MEASURED: usize = 40;

pub(super) struct Found<'a> {
    /// Names of inputs and outputs.
    pub(super) names: [Vec<String>; 2],
    pub(super) scaled: &'a Scaled,
    pub(super) choice: &'a Choice,
    pub(super) filter: &'a Filter,
    pub(super) units: &'a Units,
    /// In the units of the channels, as the model.
    pub(super) uncertain: Option<&'a Uncertain>,
    pub(super) model: &'a StateSpace,
    /// Samples before the first response of each output and input.
    pub(super) pair_delays: &'a [Vec<Option<usize>>],
    /// Delay of each input, samples.
    pub(super) delay: &'a [usize],
    pub(super) warnings: Vec<String>,
    pub(super) channels: &'a [ChannelSummary],
    pub(super) round_trip: Option<f64>,
}

impl Found<'_> {
    pub(super) fn evidence(self) -> Result<MultivariableEvidence, Error> {
        let chosen = &self.choice.candidates[self.choice.chosen];
        let simulated = |data: &DataSet| -> Result<Errors, Error> {
            let x0 = InitialConditions::new(&chosen.model, data, false)?.x0;
            Ok(errors(&chosen.model, &x0, data))
        };
        let (estimation, validation) = (&self.scaled.estimation, &self.scaled.validation);
        let of_estimation = simulated(estimation)?;
        let of_validation = simulated(validation)?;
        let one_step = &self.filter.validation_residuals;
        let spectra = MultipleSpectra::welch(&self.scaled.whole);
        let lags = LAGS.min(validation.samples() / 8).max(1);
        let outputs = self.names[1].iter().enumerate().map(|(i, name)| {
            let (y, y_hat) = measured_and_simulated(validation, &of_validation, i);
            let pairs: Vec<(&[f64], &[f64])> =
                y.iter().map(Vec::as_slice).zip(y_hat.iter().map(Vec::as_slice)).collect();
            let with_error = fit_with_error(&pairs, validation.sample_time_s());
            let residuals: Vec<&[f64]> = one_step.iter().map(|e| e.row(i)).collect();
            let square: f64 = residuals.iter().flat_map(|e| e.iter()).map(|e| e * e).sum();
            let deviation = (square / validation.samples() as f64).sqrt();
            OutputEvidence {
                output: name.clone(),
                fit: Fits {
                    estimation: fit_of(estimation, &of_estimation, i),
                    validation: fit_of(validation, &of_validation, i),
                    validation_one_step: fit_of(validation, one_step, i),
                },
                fit_standard_error: with_error.standard_error,
                one_step_error: deviation * self.units.output.scales[i],
                whiteness: whiteness(&residuals, lags),
                coherence: shown(&spectra)
                    .map(|k| CoherencePoint {
                        frequency_hz: rounded(spectra.frequency_hz[k]),
                        coherence: rounded(spectra.coherence(i, k)),
                    })
                    .collect(),
                coherence_of_chance: rounded(spectra.significance(RISK)),
            }
        });
        let outputs = outputs.collect();
        let mut pairs = Vec::new();
        for (i, output) in self.names[1].iter().enumerate() {
            for (j, input) in self.names[0].iter().enumerate() {
                let residuals: Vec<&[f64]> = one_step.iter().map(|e| e.row(i)).collect();
                let driving: Vec<&[f64]> =
                    validation.segments().iter().map(|s| s.u.row(j)).collect();
                pairs.push(PairEvidence {
                    output: output.clone(),
                    input: input.clone(),
                    delay: self.delay_of(i, j),
                    independence: independence(&residuals, &driving, lags),
                    steady_state_gain: self.uncertain.and_then(|u| {
                        let (value, standard_error) = u.steady_state_gain(i, j)?;
                        Some(Estimate { value, standard_error })
                    }),
                    frequency_response: self.response(i, j),
                    measured: self.measured(&spectra, i, j),
                });
            }
        }
        Ok(MultivariableEvidence {
            method: chosen.method.name().into(),
            horizon: chosen.horizon,
            estimation_samples: estimation.samples(),
            validation_samples: validation.samples(),
            fit: Fits {
                estimation: bounded(fit(estimation, &of_estimation)),
                validation: bounded(fit(validation, &of_validation)),
                validation_one_step: bounded(fit(validation, one_step)),
            },
            outputs,
            pairs,
            order_table: self.orders(),
            feedback: self.choice.feedback.map(feedback_test),
            stabilised_from: chosen.stabilised.map(|s| s.radius),
            conversion_round_trip: self.round_trip,
            channels: self.channels.to_vec(),
            warnings: self.warnings,
        })
    }

    /// Numbers that a file holds, of orders whose simulation stays finite.
    fn orders(&self) -> Vec<steerwright_formats::OrderRow> {
        let mut rows = order_table(self.choice);
        for row in &mut rows {
            row.estimation_fit = bounded(row.estimation_fit);
            row.validation_fit = bounded(row.validation_fit);
            if !row.criterion.is_finite() {
                row.criterion = f64::MAX;
            }
        }
        rows
    }

    fn delay_of(&self, output: usize, input: usize) -> Option<PairDelay> {
        let step = self.scaled.estimation.sample_time_s();
        let samples = self.pair_delays[output][input]?;
        let own = self.delay[input].min(samples);
        Some(PairDelay { estimate_s: samples as f64 * step, in_input_s: own as f64 * step })
    }

    /// The response of the model with its input's delay, in the units of the channels.
    fn response(&self, output: usize, input: usize) -> Vec<FrequencyBand> {
        let step = self.scaled.estimation.sample_time_s();
        let band = |k: usize| {
            let decades = DECADES * (k as f64 / FREQUENCIES as f64 - 1.0);
            let omega = std::f64::consts::PI * 10_f64.powf(decades);
            let (magnitude, phase, magnitude_error, phase_error) = match self.uncertain {
                Some(uncertain) => {
                    let r = uncertain.frequency_response(output, input, omega);
                    (r.re.hypot(r.im), r.im.atan2(r.re), r.magnitude_error, r.phase_error)
                }
                None => {
                    let (re, im) = self.model.frequency_response(output, input, omega);
                    (re.hypot(im), im.atan2(re), 0.0, 0.0)
                }
            };
            FrequencyBand {
                frequency_hz: omega / TAU / step,
                magnitude,
                phase_rad: wrapped(phase - omega * self.delay[input] as f64),
                magnitude_standard_error: magnitude_error,
                phase_standard_error_rad: phase_error,
            }
        };
        let all = (0..FREQUENCIES).map(band);
        all.filter(|b| {
            (b.magnitude + b.magnitude_standard_error + b.phase_standard_error_rad).is_finite()
        })
        .collect()
    }

    fn measured(
        &self,
        spectra: &MultipleSpectra,
        output: usize,
        input: usize,
    ) -> Vec<MeasuredPoint> {
        let per_unit = self.units.output.scales[output] / self.units.input.scales[input];
        let omega =
            |k: usize| TAU * spectra.frequency_hz[k] * self.scaled.estimation.sample_time_s();
        shown(spectra)
            .map(|k| {
                // The inputs of the scaled data are delayed already.
                let (gain, phase) = spectra.response(output, input, k);
                let phase = wrapped(phase - omega(k) * self.delay[input] as f64);
                MeasuredPoint {
                    frequency_hz: rounded(spectra.frequency_hz[k]),
                    gain: rounded(per_unit * gain),
                    phase_rad: rounded(phase),
                    radius: rounded(per_unit * spectra.radius(output, input, k, RISK)),
                }
            })
            .collect()
    }
}

/// Places of the frequencies that the file states.
fn shown(spectra: &MultipleSpectra) -> impl Iterator<Item = usize> {
    let count = spectra.frequency_hz.len();
    let mut places: Vec<usize> = Vec::new();
    for k in 0..MOST_MEASURED {
        let at = (count as f64).powf(k as f64 / (MOST_MEASURED - 1) as f64).round() as usize;
        let at = at.clamp(1, count.max(1)) - 1;
        if at < count && places.last() != Some(&at) {
            places.push(at);
        }
    }
    places.into_iter()
}

fn wrapped(phase: f64) -> f64 {
    let turns = (phase / TAU).round();
    phase - TAU * turns
}

/// A file holds finite numbers only.
fn bounded(percent: f64) -> f64 {
    if percent.is_nan() { -1e9 } else { percent.max(-1e9) }
}

fn measured_and_simulated(
    data: &DataSet,
    errors: &Errors,
    output: usize,
) -> (Vec<Vec<f64>>, Vec<Vec<f64>>) {
    let row = |signals: &Signals| signals.row(output).to_vec();
    let y: Vec<Vec<f64>> = data.segments().iter().map(|s| row(&s.y)).collect();
    let less =
        |(y, e): (&Vec<f64>, &Signals)| y.iter().zip(e.row(output)).map(|(y, e)| y - e).collect();
    let y_hat = y.iter().zip(errors).map(less).collect();
    (y, y_hat)
}

/// Fit of one output over all segments, percent.
pub(super) fn fit_of(data: &DataSet, errors: &Errors, output: usize) -> f64 {
    let (y, y_hat) = measured_and_simulated(data, errors, output);
    bounded(fit_percent(&y.concat(), &y_hat.concat()))
}
