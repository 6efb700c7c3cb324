//! What stands behind a model of absorbed drives, and the plant with it.

use super::Absorbed;
use super::file::input_name;
use super::identify::{Candidate, Choice, choose};
use super::windows::{Windows, parzen};
use crate::conversion::to_continuous;
use crate::identify::evidence::{
    DRIFT, GOOD_FIT, HIGHEST_SHOWN, INFORMATIVE, LAGS, LARGEST_NOISE, LEAST_BAND, LEAST_STEERING,
    Recorded, failed, faults,
};
use crate::identify::order::Errors;
use crate::identify::{continuous_form, discrete, evidence, operating_point};
use crate::model::StateSpace;
use crate::statistics::{Z99, chi_squared_quantile};
use crate::validation::{Response, bandwidth_hz, implausible};
use crate::{Detrend, Error, IdentifyOptions, Signals};
use faer::MatRef;
use formats::{
    CoherencePoint, Document, Evidence, Excitation, Fits, Grade, HeldOut, InputKind, Noise,
    OrderRow, Plant, PredictionFit, Provenance, Quality, Reason, ReasonCode, ResidualTest,
};

const FREQUENCIES: usize = 50;

/// What the windows cannot tell.
const MISSING: &str = "identified from absorbed windows: simulation fits are of the second half of each window, from the state that its first half gives; there is no simulation of whole drives, no estimate of the delay, no test of residuals against the input, no measured frequency response and no uncertainty of the parameters";

impl Absorbed {
    /// Identifies the plant from all that was absorbed. The direct gain is zero unless asked for.
    ///
    /// # Errors
    /// [`Error::Option`] for what the windows cannot give: a delay, another detrending than by means,
    /// another input than was absorbed; else as [`identify`](crate::identify).
    pub fn identify(&self, options: &IdentifyOptions) -> Result<Plant, Error> {
        options.check()?;
        self.check(options)?;
        let factor = self.estimation.factor()?;
        let means = factor.means();
        let factor = factor.about_mean()?;
        let step = self.sample_time_s();
        let windows = Windows::new(&factor, step, None)?;
        let choice = choose(&factor, &windows, self.estimation.samples(), options)?;
        // Without enough held-out windows the model is not judged.
        let held_out = self.validation.factor().and_then(|f| f.about_mean());
        let held_out = held_out.and_then(|f| Windows::new(&f, step, Some(windows.scales)));
        let chosen = &choice.candidates[choice.chosen];
        let [u, y] = windows.scales;
        let model = chosen.model.scaled(&[u], &[y]);
        let gain: Vec<f64> = (0..model.order()).map(|i| choice.gain[(i, 0)] / y).collect();
        let continuous = to_continuous(model.a.as_ref(), model.b.as_ref(), step);
        let errors = windows.predicted_ahead(&chosen.model, choice.gain.as_ref())?;
        let residual = windows.variance_ahead(&errors);
        let mut evidence = self.evidence(&windows, held_out.as_ref().ok(), &choice, residual)?;
        if let Err(reason) = &held_out {
            evidence.warnings.push(format!(
                "no held-out windows to judge the model by (one block in {} of {} samples is held out): {reason}",
                super::HELD_OUT,
                super::BLOCK
            ));
        }
        evidence
            .warnings
            .extend(factor.conditioning.is_reduced().then(|| factor.conditioning.to_string()));
        if let Err(reason) = &continuous {
            evidence.warnings.push(format!("the model stays discrete: {reason}"));
        }
        evidence.factor = Some(evidence::data_factor(&factor.conditioning));
        let continuous = continuous.ok();
        evidence.conversion_round_trip = continuous.as_ref().map(|c| c.round_trip);
        let map = evidence::poles_and_zeros(&model, continuous.as_ref(), step, None);
        evidence.poles_and_zeros = Some(map);
        let speed_mps = self.speed().map_or(0.0, |(mean, _)| mean);
        let per_speed = match self.input_kind {
            InputKind::Steering => 1.0,
            InputKind::SteeringTimesSpeed => speed_mps.max(0.1),
        };
        let at = |hz: f64| {
            let (re, im) = model.frequency_response(0, 0, std::f64::consts::TAU * hz * step);
            let per_angle = per_speed * self.steering_ratio;
            (per_angle * re, per_angle * im)
        };
        let zeros = evidence.poles_and_zeros.as_ref().map_or(&[][..], |m| &m.continuous_zeros);
        let mut found = implausible(&Response {
            at: &at,
            speed_mps,
            steering_ratio: self.steering_ratio,
            zeros,
            spreads: &[],
        });
        let point = operating_point(means, windows.scales, &model, speed_mps, self.input_kind);
        let straight = point.steering_offset_rad / self.steering_ratio;
        found.extend(faults(&Recorded {
            channels: &evidence.channels,
            play: None,
            delay_s: None,
            yaw_rate_lead_s: None,
            yaw_rate_lag_s: None,
            road_wheel_std_rad: evidence.excitation.road_wheel_std_rad,
            yaw_rate_std_radps: evidence.excitation.yaw_rate_std_radps,
            steering_ratio: self.steering_ratio,
            noise_radps: residual.sqrt() * y,
            seconds: (self.estimation.samples() + self.validation.samples()) as f64 * step,
            road_wheel_offset_rad: straight,
            yaw_rate_offset_radps: point.yaw_rate_offset_radps - at(0.0).0 * straight,
        }));
        found.extend(evidence::slow_log(&evidence.channels, bandwidth_hz(&at, 0.5 / step)));
        let quality = quality(&evidence, held_out.is_ok(), continuous.is_some(), found);
        let mut used = self.options.clone();
        used.extend(options.to_map());
        used.insert("horizon_absorbed".into(), self.horizon.to_string());
        used.insert("model_input".into(), input_name(self.input_kind).into());
        used.insert("realization".into(), chosen.realization.name().into());
        for unused in ["validation_fraction", "delay_s"] {
            used.remove(unused);
        }
        let plant = Plant {
            schema: Plant::SCHEMA.into(),
            name: self.name.clone(),
            input: self.input_kind,
            steering_ratio: self.steering_ratio,
            input_delay_s: 0.0,
            operating_point: point,
            discrete: discrete(&model, &gain, &vec![0.0; model.order()], step),
            continuous: continuous.map(|c| continuous_form(&c, &model)),
            noise: Noise { innovation_variance: residual * y * y },
            sideslip: None,
            uncertainty: None,
            evidence,
            quality,
            provenance: Provenance {
                version: env!("CARGO_PKG_VERSION").into(),
                sources: self.sources.clone(),
                options: used,
            },
        };
        plant.checked("plant.json").map_err(|e| Error::NoModel { problem: e.to_string() })?;
        Ok(plant)
    }

    /// Options that need the samples themselves are refused.
    fn check(&self, options: &IdentifyOptions) -> Result<(), Error> {
        let refused = |option, value: String, expected: String| {
            Err(Error::Option { option, value, expected })
        };
        if let Some(delay) = options.delay_s.filter(|d| *d != 0.0) {
            let expected = "none where a factor is identified from".into();
            return refused("--delay", format!("{delay} s"), expected);
        }
        if options.detrend != Detrend::Mean {
            let expected = "mean where a factor is identified from".into();
            return refused("--detrend", options.detrend.name().into(), expected);
        }
        if options.input_kind != InputKind::Steering && options.input_kind != self.input_kind {
            let value = input_name(options.input_kind).into();
            let expected = format!("{}, which was absorbed", input_name(self.input_kind));
            return refused("--model-input", value, expected);
        }
        match options.horizon {
            Some(s) if s > self.horizon => {
                let expected = format!("{} at most, which was absorbed", self.horizon);
                refused("--horizon", s.to_string(), expected)
            }
            _ => Ok(()),
        }
    }

    fn evidence(
        &self,
        windows: &Windows,
        held_out: Option<&Windows>,
        choice: &Choice,
        residual: f64,
    ) -> Result<Evidence, Error> {
        let chosen = &choice.candidates[choice.chosen];
        let simulation = |on: &Windows, c: &Candidate| -> f64 {
            on.ahead(&c.model).map_or(0.0, |e| bounded(on.fit(on.variance_ahead(&e))))
        };
        let order_table = choice.candidates.iter().map(|c| OrderRow {
            order: c.model.order(),
            // Those of another decomposition are others.
            singular_value: (c.approach == chosen.approach && c.horizon == chosen.horizon)
                .then_some(c.singular_value),
            estimation_fit: simulation(windows, c),
            validation_fit: held_out.map_or(0.0, |on| simulation(on, c)),
            stable: c.stabilised_from.is_none(),
            criterion: c.criterion,
        });
        let mut evidence = Evidence {
            method: chosen.approach.name().into(),
            horizon: chosen.horizon,
            estimation_samples: self.estimation.samples(),
            validation_samples: if held_out.is_some() { self.validation.samples() } else { 0 },
            fit: Fits {
                estimation: simulation(windows, chosen),
                validation: held_out.map_or(0.0, |on| simulation(on, chosen)),
                validation_one_step: 0.0,
            },
            order_table: order_table.collect(),
            feedback: choice.feedback.map(crate::identify::feedback_test),
            excitation: self.excitation(windows, residual),
            stabilised_from: chosen.stabilised_from,
            channels: self.channels.clone(),
            warnings: self.warnings.clone(),
            ..Evidence::default()
        };
        evidence.warnings.extend(choice.warnings.clone());
        evidence.warnings.push(MISSING.into());
        if self.speed.is_none() {
            evidence
                .warnings
                .push("no speed channel: the operating point's speed is written as 0".into());
        }
        if let Some(on) = held_out {
            judge(&mut evidence, on, &chosen.model, choice.gain.as_ref())?;
        }
        Ok(evidence)
    }

    /// How strongly was driven, and where in frequency the yaw rate follows the steering: spectra of
    /// the windows' covariances (R. B. Blackman, J. W. Tukey, *The Measurement of Power Spectra*, 1958)
    /// under Parzen's lag window.
    fn excitation(&self, windows: &Windows, residual: f64) -> Excitation {
        let lags = windows.length;
        let table = |a: usize, b: usize| -> Vec<f64> {
            (0..lags).map(|k| parzen(k, lags) * windows.covariance(a, b, k)).collect()
        };
        let (uu, yy, uy, yu) = (table(0, 0), table(1, 1), table(0, 1), table(1, 0));
        let step = self.sample_time_s();
        let highest = HIGHEST_SHOWN.min(0.5 / step);
        let at = |frequency_hz: f64| {
            let angle = |k: usize| std::f64::consts::TAU * frequency_hz * step * k as f64;
            let power =
                |r: &[f64]| r[0] + 2.0 * (1..lags).map(|k| r[k] * angle(k).cos()).sum::<f64>();
            let re = uy[0] + (1..lags).map(|k| (uy[k] + yu[k]) * angle(k).cos()).sum::<f64>();
            let im = (1..lags).map(|k| (yu[k] - uy[k]) * angle(k).sin()).sum::<f64>();
            let coherence = (re * re + im * im) / (power(&uu) * power(&yy));
            let coherence = if coherence.is_finite() { coherence.clamp(0.0, 1.0) } else { 0.0 };
            CoherencePoint { frequency_hz, coherence }
        };
        let frequencies = (0..=FREQUENCIES).map(|k| highest * k as f64 / FREQUENCIES as f64);
        let coherence: Vec<CoherencePoint> = frequencies.map(at).collect();
        let mut informative_up_to_hz = 0.0;
        for point in &coherence {
            if point.coherence >= INFORMATIVE {
                informative_up_to_hz = point.frequency_hz;
            } else if informative_up_to_hz > 0.0 || point.frequency_hz > DRIFT {
                break;
            }
        }
        let per_input = match (self.input_kind, self.speed()) {
            (InputKind::SteeringTimesSpeed, Some((mean, _))) => 1.0 / mean.max(0.1),
            _ => 1.0,
        };
        Excitation {
            road_wheel_std_rad: windows.scales[0] * per_input / self.steering_ratio,
            yaw_rate_std_radps: windows.scales[1],
            noise_to_signal: residual.sqrt(),
            informative_up_to_hz,
            coherence,
            ..Excitation::default()
        }
    }
}

/// What the held-out windows say.
fn judge(
    evidence: &mut Evidence,
    on: &Windows,
    model: &StateSpace,
    gain: MatRef<'_, f64>,
) -> Result<(), Error> {
    let whole = on.covariance(1, 1, 0);
    // In units of the estimation windows' standard deviation, as the covariance is.
    let noise = evidence.excitation.noise_to_signal;
    let row = |steps: Option<usize>, variance: f64| PredictionFit {
        steps,
        ahead_s: steps.map(|k| k as f64 * on.data.sample_time_s()),
        fit: bounded(on.fit(variance)),
        variance_accounted_for: bounded(100.0 * (1.0 - variance / whole)),
    };
    let predicted = on.predicted_ahead(model, gain)?;
    let simulated = on.variance_ahead(&on.ahead(model)?);
    let rows = vec![row(Some(1), on.variance_ahead(&predicted)), row(None, simulated)];
    evidence.fit.validation_one_step = rows[0].fit;
    evidence.whiteness = whiteness(&predicted, on.count);
    evidence.held_out = Some(HeldOut {
        selection: "windows".into(),
        fit_bound: Some(bounded(100.0 * (1.0 - noise / whole.sqrt()))),
        variance_accounted_for: rows[1].variance_accounted_for,
        predictions: rows,
        ..HeldOut::default()
    });
    Ok(())
}

/// Autocorrelation of the windows' prediction errors against χ².
fn whiteness(errors: &Errors, count: usize) -> ResidualTest {
    let length = errors.first().map_or(0, Signals::ncols);
    let lags = LAGS.min(length / 2);
    let at = |k: usize| -> f64 {
        let sums =
            errors.iter().map(|e| crate::signal::dot(&e.row(0)[..length - k], &e.row(0)[k..]));
        sums.sum::<f64>() / (length - k) as f64
    };
    let power = at(0);
    let statistic = count as f64 * (1..=lags).map(|k| (at(k) / power).powi(2)).sum::<f64>();
    let bound = chi_squared_quantile(lags, Z99);
    ResidualTest { lags, statistic: bounded(statistic), bound, pass: statistic <= bound }
}

fn bounded(x: f64) -> f64 {
    if x.is_finite() { x } else { 0.0 }
}

fn quality(
    evidence: &Evidence,
    judged: bool,
    has_continuous: bool,
    found: Vec<(Reason, String)>,
) -> Quality {
    let e = &evidence.excitation;
    let (mut reasons, mut advice): (Vec<Reason>, Vec<String>) = found.into_iter().unzip();
    if e.road_wheel_std_rad < LEAST_STEERING {
        let degrees = e.road_wheel_std_rad.to_degrees();
        let message = format!("the road wheel moves by {degrees:.2}° (standard deviation) only");
        let limit = LEAST_STEERING.to_degrees();
        reasons.push(failed(ReasonCode::WeakSteering, message).compared(degrees, limit, "deg"));
        advice.push("drive a slalom of changing pace, 0.2 to 2 Hz".to_owned());
    }
    if e.informative_up_to_hz < LEAST_BAND {
        let hz = e.informative_up_to_hz;
        let message = format!("yaw rate follows the steering up to {hz:.1} Hz only");
        reasons.push(failed(ReasonCode::NarrowBand, message).compared(hz, LEAST_BAND, "Hz"));
    }
    if e.noise_to_signal > LARGEST_NOISE {
        let percent = 100.0 * e.noise_to_signal;
        let message = format!("noise is {percent:.0} % of the yaw rate");
        let reason = failed(ReasonCode::NoisyYawRate, message);
        reasons.push(reason.compared(percent, 100.0 * LARGEST_NOISE, "%"));
    }
    if !judged {
        let message = "there are no validation data";
        reasons.push(failed(ReasonCode::NotValidated, message));
    } else if evidence.fit.validation < GOOD_FIT {
        let fit = evidence.fit.validation;
        let message = format!("the fit on validation windows is {fit:.0} %, below {GOOD_FIT} %");
        let reason = failed(ReasonCode::LowValidationFit, message);
        reasons.push(reason.compared(fit, GOOD_FIT, "%"));
        advice.push("absorb drives of one speed, with --speed-window".to_owned());
    }
    if !has_continuous {
        let message = "the model has no continuous counterpart";
        reasons.push(failed(ReasonCode::NoContinuousModel, message));
        advice.push("try another --order".to_owned());
    }
    advice.push(
        "identify from one of the logs itself too: that tests what windows cannot tell".to_owned(),
    );
    let summary = if reasons.is_empty() {
        format!(
            "The fit on validation windows is {:.1} %, and the drives are informative up to {:.1} Hz: fit to design on.",
            evidence.fit.validation, e.informative_up_to_hz
        )
    } else {
        let messages: Vec<&str> = reasons.iter().map(|r| r.message.as_str()).collect();
        let failed = reasons.iter().any(|r| r.grade == Grade::Fail);
        let what = if failed { "Validation failed" } else { "Fit to design on with reservations" };
        format!("{what}: {}.", messages.join("; "))
    };
    Quality::new(summary, reasons, advice)
}
