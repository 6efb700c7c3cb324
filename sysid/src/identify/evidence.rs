//! What validates a model on its drive: the evidence, and the quality with its reasons.

use crate::Error;
use crate::data::scaled::{Data, driving_input};
use crate::identify::plant::{Traces, feedback_test, operating_point, order_table};
use crate::model::StateSpace;
use crate::model::conversion::ContinuousModel;
use crate::selection::candidate::{Choice, initial_states, output};
use crate::selection::filter::Filter;
use crate::selection::input_delay::InputDelay;
use crate::selection::options::IdentifyOptions;
use crate::validation::bandwidth::bandwidth_hz;
use crate::validation::correlation::{independence, whiteness};
use crate::validation::frequencies::{correlations, data_factor, frequencies};
use crate::validation::lead::{yaw_rate_lag, yaw_rate_lead};
use crate::validation::modelled::{LAGS, Modelled};
use crate::validation::plausible::{Response, implausible};
use crate::validation::play::steering_play;
use crate::validation::poles::poles_and_zeros;
use crate::validation::prediction::{Prediction, on_validation_data};
use crate::validation::quality::quality;
use crate::validation::rate::slow_log;
use crate::validation::regression::pairs;
use crate::validation::sweep::Drive;
use drivelog::DriveLog;
use drivelog::signal::{mean, standard_deviation};
use formats::{Evidence, Fits, InputKind, OperatingPoint, Quality, Uncertainty};
use std::f64::consts::TAU;

/// A model with all that it was found from.
pub(super) struct Found<'a> {
    /// The drive as it was recorded.
    pub(super) measured: &'a DriveLog,
    /// The drive with its steering delayed as the model takes it.
    pub(super) log: &'a DriveLog,
    pub(super) options: &'a IdentifyOptions,
    pub(super) delay: &'a InputDelay,
    pub(super) data: &'a Data,
    pub(super) choice: &'a Choice,
    pub(super) filter: &'a Filter,
    /// The chosen model in SI units.
    pub(super) model: &'a StateSpace,
    pub(super) continuous: Option<&'a ContinuousModel>,
    pub(super) uncertainty: Option<&'a Uncertainty>,
    /// Variance of the one-step residuals in scaled units.
    pub(super) residual: f64,
}

impl Found<'_> {
    /// The evidence, the quality and the operating point; `traces` are measured and simulated signals.
    pub(super) fn validated(
        &self,
        traces: &Traces,
        warnings: Vec<String>,
    ) -> Result<(Evidence, Quality, OperatingPoint), Error> {
        let &Self { measured, log, options, delay, data, choice, filter, model, residual, .. } =
            self;
        let chosen = &choice.candidates[choice.chosen];
        let input = driving_input(log, options.input_kind)?;
        let speed = log.speed.as_deref().unwrap_or_default();
        let part = &data.validation;
        let simulated = output(&chosen.model, part, &initial_states(&chosen.model, part)?);
        let residuals = part.segments_of(&filter.validation_residuals);
        let validation_input = part.of(&input);
        let validation_input = part.segments_of(&validation_input);
        let instants = log.time_s();
        let prediction = on_validation_data(&Prediction {
            model: &chosen.model,
            gain: &(0..model.order()).map(|i| filter.gain[(i, 0)]).collect::<Vec<_>>(),
            output: &part.segments_of(&part.output),
            simulated: &part.segments_of(&simulated),
            residuals: &residuals,
            sample_time_s: data.sample_time,
            selection: data.selection.name(),
            segments_s: part
                .ranges
                .iter()
                .map(|r| [instants[r.start], instants[r.end - 1]])
                .collect(),
            noise: residual.sqrt(),
        });
        let per_input = match options.input_kind {
            InputKind::Steering => 1.0,
            InputKind::SteeringTimesSpeed => 1.0 / mean(speed).max(0.1),
        };
        let modelled = Modelled {
            model,
            delay_s: 0.0,
            input: &input,
            simulated: &traces.simulated_yaw_rate_radps,
            to_road_wheel: per_input / log.steering_ratio,
        };
        // Yaw rate over road-wheel angle, 1/s, at a frequency in Hz.
        let at = |hz: f64| {
            let (re, im) = model.frequency_response(0, 0, TAU * hz * data.sample_time);
            let (sin, cos) = (-TAU * hz * delay.seconds).sin_cos();
            let per_angle = 1.0 / modelled.to_road_wheel;
            (per_angle * (re * cos - im * sin), per_angle * (re * sin + im * cos))
        };
        let pairs = pairs(measured);
        let play = steering_play(&pairs, data.sample_time, log.steering_ratio, &|w| at(w / TAU));
        let yaw_rate_lead_s = yaw_rate_lead(&pairs, data.sample_time);
        let yaw_rate_lag_s = yaw_rate_lag(&pairs, data.sample_time);
        let (excitation, frequency_response) = frequencies(log, &modelled, residual.sqrt());
        let evidence = Evidence {
            method: chosen.method.name().into(),
            horizon: chosen.horizon,
            factor: Some(data_factor(&choice.factor.conditioning)),
            delay: delay.estimate,
            estimation_samples: data.estimation.len(),
            validation_samples: data.validation.len(),
            fit: Fits {
                estimation: chosen.estimation_fit,
                validation: chosen.validation_fit,
                validation_one_step: filter.validation_fit,
            },
            order_table: order_table(choice),
            feedback: choice.feedback.map(feedback_test),
            whiteness: whiteness(&residuals, LAGS),
            independence: independence(&residuals, &validation_input, LAGS),
            excitation,
            held_out: Some(prediction),
            play,
            yaw_rate_lead_s,
            yaw_rate_lag_s,
            residuals: Some(correlations(&residuals, &validation_input)),
            frequency_response: Some(frequency_response),
            poles_and_zeros: Some(poles_and_zeros(
                model,
                self.continuous,
                data.sample_time,
                self.uncertainty,
            )),
            stabilised_from: chosen.stabilised.map(|s| s.radius),
            conversion_round_trip: self.continuous.map(|c| c.round_trip),
            channels: log.channels.clone(),
            warnings,
        };
        let point = operating_point(
            (data.input_mean, data.output_mean),
            [data.input_scale, data.output_scale],
            model,
            mean(speed),
            options.input_kind,
        );
        let spread =
            if speed.is_empty() { 0.0 } else { standard_deviation(speed) / mean(speed).max(0.1) };
        let map = evidence.poles_and_zeros.clone().unwrap_or_default();
        let doubts = implausible(&Response {
            at: &at,
            excitation: Some(&evidence.excitation),
            speed_mps: mean(speed),
            steering_ratio: log.steering_ratio,
            zeros: &map.continuous_zeros,
            spreads: &map.continuous_zero_spreads,
        });
        let drive = Drive {
            has_continuous: self.continuous.is_some(),
            speed_mps: mean(speed),
            speed_spread: spread,
            steering_ratio: log.steering_ratio,
            to_road_wheel: modelled.to_road_wheel,
            steering: &log.input,
            seconds: log.len() as f64 * data.sample_time,
            order: model.order(),
            slow_log: slow_log(&log.channels, bandwidth_hz(&at, 0.5 / data.sample_time)),
            noise_radps: residual.sqrt() * data.output_scale,
            road_wheel_offset_rad: point.steering_offset_rad / log.steering_ratio,
            yaw_rate_offset_radps: point.yaw_rate_offset_radps
                - at(0.0).0 * point.steering_offset_rad / log.steering_ratio,
            implausible: doubts,
        };
        let grade = quality(&evidence, &drive, options);
        Ok((evidence, grade, point))
    }
}
