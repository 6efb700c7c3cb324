//! The evidence of a model of accumulated drives, and the plant with it.

use crate::Error;
use crate::data::Signals;
use crate::data::scaled::Detrend;
use crate::data::statistics::{Z99, chi_squared_quantile};
use crate::model::StateSpace;
use crate::model::conversion::to_continuous;
use crate::selection::options::IdentifyOptions;
use crate::selection::order::Errors;
use crate::selection::search::mirroring_warning;
use crate::structures::state_space::accumulated::in_windows::{choose, kalman_gain};
use crate::structures::state_space::accumulated::windows::Windows;
use crate::structures::state_space::accumulated::{Accumulated, BLOCK, VALIDATION_PERIOD};
use crate::structures::state_space::plant::{Outcome, feedback_test, order_table};
use crate::validation::response::frequencies::{data_factor, of_spectra};
use crate::validation::response::modelled::{LAGS, Modelled};
use faer::MatRef;
use steerwright_formats::{
    Evidence, Excitation, Fits, HeldOut, InputKind, Plant, PredictionFit, ResidualTest,
};

const MISSING: &str = "identified from accumulated windows: simulation fits are of the second half of each window, from the state of its first half; there is no simulation of whole drives, no estimate of the delay, no check of the steering's play and of the channels' clocks, no test of residuals against the input and no uncertainty of the parameters; the measured frequency response is that of all drives, with what its windows smear";

impl Accumulated {
    /// Identifies the plant from all that was accumulated. The direct gain is zero unless it is
    /// requested.
    ///
    /// # Errors
    /// [`Error::Option`] for what does not follow from windows: a delay, another detrending than by
    /// means, another input than was accumulated; else as [`identify`](crate::identify).
    pub fn identify(&self, options: &IdentifyOptions) -> Result<Plant, Error> {
        options.check()?;
        self.check(options)?;
        let factor = self.estimation.factor()?;
        let means = factor.means();
        let factor = factor.about_mean()?;
        let step = self.sample_time_s();
        let windows = Windows::new(&factor, step, None)?;
        let mut choice = choose(&factor, &windows, self.estimation.samples(), options)?;
        // Without enough validation windows the model is not validated.
        let validation = self.validation.factor().and_then(|f| f.about_mean());
        let validation = validation.and_then(|f| Windows::new(&f, step, Some(windows.scales)));
        let mut warnings = self.warnings.clone();
        let cost = choice.candidates[choice.chosen].mirroring_cost;
        warnings.extend(cost.map(mirroring_warning));
        let kalman = kalman_gain(&windows, &choice, &mut warnings)?;
        let fit = |on: &Windows, model: &StateSpace| {
            on.ahead(model).map_or(0.0, |e| bounded(on.fit(on.variance_ahead(&e))))
        };
        for c in &mut choice.candidates {
            c.estimation_fit = fit(&windows, &c.model);
            c.validation_fit = validation.as_ref().map_or(0.0, |on| fit(on, &c.model));
        }
        let chosen = &choice.candidates[choice.chosen];
        let [u, y] = windows.scales;
        let model = chosen.model.scaled(&[u], &[y]);
        let gain: Vec<f64> = (0..model.order()).map(|i| kalman[(i, 0)] / y).collect();
        let continuous = to_continuous(model.a.as_ref(), model.b.as_ref(), step);
        let errors = windows.predicted_ahead(&chosen.model, kalman.as_ref())?;
        let residual = windows.variance_ahead(&errors);

        let mut used = self.options.clone();
        used.extend(options.to_map());
        used.insert("horizon_absorbed".into(), self.horizon.to_string());
        used.insert("model_input".into(), self.input_kind.name().into());
        used.insert("realization".into(), chosen.realization.name().into());
        for unused in ["validation_fraction", "delay_s"] {
            used.remove(unused);
        }
        let (estimated, validated) = self.samples();
        let outcome = Outcome {
            options,
            name: &self.name,
            input_kind: self.input_kind,
            steering_ratio: self.steering_ratio,
            vehicle_class: None,
            wheelbase: None,
            delay_s: 0.0,
            sample_time_s: step,
            model: &model,
            continuous: continuous.as_ref().ok(),
            gain: &gain,
            x0: &vec![0.0; model.order()],
            means,
            scales: windows.scales,
            speed: self.speed().unwrap_or_default(),
            steering: &[],
            seconds: (estimated + validated) as f64 * step,
            residual,
            uncertainty: None,
            open_hold_s: None,
            sideslip: None,
            sources: &self.sources,
            used,
        };
        let to_road_wheel = outcome.to_road_wheel();
        let modelled =
            Modelled { model: &model, delay_s: 0.0, input: &[], simulated: &[], to_road_wheel };
        let (coherent, response) = of_spectra(&self.spectra.spectra(step), None, &modelled, step);
        let excitation = Excitation {
            road_wheel_std_rad: windows.scales[0] * to_road_wheel,
            yaw_rate_std_radps: windows.scales[1],
            noise_to_signal: residual.sqrt(),
            ..coherent
        };
        warnings.push(MISSING.into());
        if self.speed.is_none() {
            warnings.push("no speed channel: the operating point's speed is written as 0".into());
        }
        if let Err(reason) = &validation {
            warnings.push(format!(
                "no validation windows for the model (one block in {VALIDATION_PERIOD} of {BLOCK} samples is validation data): {reason}"
            ));
        }
        warnings.extend(if factor.conditioning.is_reduced() {
            Some(factor.conditioning.to_string())
        } else {
            None
        });
        if let Err(reason) = &continuous {
            warnings.push(format!("the model stays discrete: {reason}"));
        }
        let mut evidence = Evidence {
            method: chosen.method.name().into(),
            horizon: chosen.horizon,
            factor: Some(data_factor(&factor.conditioning)),
            estimation_samples: estimated,
            validation_samples: if validation.is_ok() { validated } else { 0 },
            fit: Fits {
                estimation: chosen.estimation_fit,
                validation: chosen.validation_fit,
                validation_one_step: 0.0,
            },
            order_table: order_table(&choice),
            feedback: choice.feedback.map(feedback_test),
            excitation,
            frequency_response: Some(response),
            stabilised_from: chosen.stabilised.map(|s| s.radius),
            channels: self.channels.clone(),
            warnings,
            ..Evidence::default()
        };
        if let Ok(on) = &validation {
            validate(&mut evidence, on, &chosen.model, kalman.as_ref())?;
        }
        let mut plant = outcome.plant(evidence)?;
        plant.quality.advice.push(
            "identify from one of the logs itself too: that tests what windows cannot show"
                .to_owned(),
        );
        Ok(plant)
    }

    fn check(&self, options: &IdentifyOptions) -> Result<(), Error> {
        if let Some(delay) = options.delay_s.filter(|d| *d != 0.0) {
            let expected = "none for an identification from an R factor";
            return Err(Error::option("delay", format!("{delay} s"), expected));
        }
        if options.detrend != Detrend::Mean {
            let expected = "mean for an identification from an R factor";
            return Err(Error::option("detrend", options.detrend.name(), expected));
        }
        if options.input_kind != InputKind::Steering && options.input_kind != self.input_kind {
            let expected = format!("{}, which was accumulated", self.input_kind);
            return Err(Error::option("model input", options.input_kind, expected));
        }
        match options.horizon {
            Some(s) if s > self.horizon => {
                let expected = format!("{} at most, which was accumulated", self.horizon);
                Err(Error::option("horizon", s, expected))
            }
            _ => Ok(()),
        }
    }
}

fn validate(
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
        let sums = errors
            .iter()
            .map(|e| crate::linalg::dense::dot(&e.row(0)[..length - k], &e.row(0)[k..]));
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
