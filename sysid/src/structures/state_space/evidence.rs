//! What validates a model on its drive.

use crate::Error;
use crate::actuator::identified_actuator;
use crate::data::scaled::{Data, driving_input};
use crate::selection::candidate::{Choice, simulated};
use crate::selection::filter::Filter;
use crate::structures::state_space::plant::{Outcome, Traces, feedback_test, order_table};
use crate::validation::faults::play::steering_play;
use crate::validation::faults::steering_faults::SteeringFaults;
use crate::validation::residuals::correlation::{independence, whiteness};
use crate::validation::residuals::prediction::{Prediction, on_validation_data};
use crate::validation::response::frequencies::{correlations, data_factor, frequencies};
use crate::validation::response::modelled::{LAGS, Modelled};
use std::f64::consts::TAU;
use steerwright_drivelog::DriveLog;
use steerwright_formats::{DelayEstimate, Evidence, Fits};

pub(super) struct Found<'a> {
    /// The drive with its steering delayed as the model takes it.
    pub(super) log: &'a DriveLog,
    pub(super) delay: Option<DelayEstimate>,
    pub(super) data: &'a Data,
    pub(super) choice: &'a Choice,
    pub(super) filter: &'a Filter,
    pub(super) steering_faults: SteeringFaults,
}

impl Found<'_> {
    /// The evidence of a model; `traces` are measured and simulated signals.
    pub(super) fn evidence(
        &self,
        outcome: &Outcome<'_>,
        traces: &Traces,
        mut warnings: Vec<String>,
    ) -> Result<Evidence, Error> {
        let &Self { log, delay, data, choice, filter, steering_faults } = self;
        let &Outcome { model, residual, .. } = outcome;
        let chosen = &choice.candidates[choice.chosen];
        let input = driving_input(&log.input, log.speed.as_deref(), outcome.input_kind)?;
        let part = &data.validation;
        let simulated = simulated(&chosen.model, data, part)?;
        let residuals = part.segments_of(&filter.validation_residuals);
        let validation_input = part.samples(&input);
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
        let modelled = Modelled {
            model,
            delay_s: 0.0,
            input: &input,
            simulated: &traces.simulated_yaw_rate_radps,
            to_road_wheel: outcome.to_road_wheel(),
        };
        let play = steering_faults
            .play_rad
            .map(|width| steering_play(width, &|w| outcome.response_at(w / TAU)));
        let (excitation, frequency_response) = frequencies(log, &modelled, residual.sqrt());
        let actuator = identified_actuator(log, &mut warnings);
        Ok(Evidence {
            method: chosen.method.name().into(),
            horizon: chosen.horizon,
            factor: Some(data_factor(&choice.factor.conditioning)),
            delay,
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
            actuator,
            yaw_rate_lead_s: steering_faults.yaw_rate_lead_s,
            yaw_rate_lag_s: steering_faults.yaw_rate_lag_s,
            residuals: Some(correlations(&residuals, &validation_input)),
            frequency_response: Some(frequency_response),
            stabilised_from: chosen.stabilised.map(|s| s.radius),
            channels: log.channels.clone(),
            warnings,
            ..Evidence::default()
        })
    }
}
