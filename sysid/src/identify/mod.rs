//! From a recording to `plant.json`: data → candidates → noise → evidence.

mod approach;
mod automatic;
mod candidates;
mod colour;
mod comparison;
mod conditions;
mod data;
mod delayed;
pub(crate) mod evidence;
mod external;
mod feedthrough;
mod filter;
mod judge;
mod level;
pub(crate) mod logarithm;
mod options;
pub(crate) mod order;
mod predicted;
mod starts;
mod vehicle;

use crate::Error;
use crate::closed_loop::Feedback;
use crate::conversion::{ContinuousModel, to_continuous};
use crate::model::StateSpace;
use crate::sideslip::sideslip;
use crate::statistics::{independence, whiteness};
use crate::validation::{
    Pair, Response, bandwidth_hz, implausible, steering_play, yaw_rate_lag, yaw_rate_lead,
};
use candidates::{Candidate, Choice, choose, initial_states, output};
use data::{Data, driving_input};
use delayed::delayed;
use drivelog::DriveLog;
use drivelog::signal::{mean, standard_deviation};
use evidence::LAGS;
use faer::Mat;
use filter::{filter, uncertainty};
use formats::{
    Continuous, Discrete, Document, Evidence, Fits, InputKind, Matrix, Noise, OperatingPoint,
    OrderRow, Plant, Provenance, ResidualTest,
};

use std::f64::consts::TAU;

pub use approach::Approach;
pub use automatic::{Automatic, TriedOrder, automatic};
pub use judge::{Judged, judge, judge_plant};
pub use options::{Detrend, IdentifyOptions};

/// Samples in which play and clocks are looked for: more change nothing.
const MOST_FOR_FAULTS: usize = 60_000;

/// A plant with the signals behind its plots.
#[derive(Debug, Clone, PartialEq)]
pub struct Identified {
    /// What goes into `plant.json`.
    pub plant: Plant,
    /// Measured and simulated signals.
    pub traces: Traces,
}

/// Signals on the recording's grid.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Traces {
    /// The log's time, s.
    pub time_s: Vec<f64>,
    /// Steering angle, rad, in the log's coordinates.
    pub steering_rad: Vec<f64>,
    /// Measured yaw rate, rad/s.
    pub yaw_rate_radps: Vec<f64>,
    /// Simulated yaw rate, rad/s; the initial state is estimated at the start of each part.
    pub simulated_yaw_rate_radps: Vec<f64>,
    /// Whether the sample was held out.
    pub is_validation: Vec<bool>,
    /// Integral of the measured yaw rate from 0, rad; nothing is added over a gap.
    pub yaw_rad: Vec<f64>,
    /// Integral of the simulated yaw rate from 0, rad.
    pub simulated_yaw_rad: Vec<f64>,
}

/// Identifies the lateral dynamics in `log`.
///
/// The end of the log is held out. It estimates and chooses nothing; it gives the fits by which the
/// model is judged, and its one-step residuals are those that are tested.
///
/// # Errors
/// [`Error`] where the log or the options allow no model. A poor model is no error: the evidence
/// and the quality report it.
pub fn identify(log: &DriveLog, options: &IdentifyOptions) -> Result<Identified, Error> {
    options.check()?;
    let measured = log;
    let (log, delay) = delayed(measured, options)?;
    let log = &*log;
    let input = driving_input(log, options.input_kind)?;
    let data = Data::new(log, options)?;
    let choice = choose(&data, options)?;
    let chosen = &choice.candidates[choice.chosen];
    let data = match chosen.conditions.levels.as_deref() {
        Some([level]) => data.about(*level)?,
        _ => data,
    };
    let from_fixes = sideslip(log);
    let mut warnings = log.warnings.clone();
    warnings.extend(from_fixes.warnings);
    let could_estimate = log.len() - data.validation.len();
    if options
        .max_samples
        .is_some_and(|most| (data.estimation.len()..could_estimate).contains(&most))
    {
        warnings.push(format!(
            "the log is long: {} of {} samples that could estimate the model do, in {} blocks spread over them",
            data.estimation.len(),
            could_estimate,
            data.estimation.ranges.len()
        ));
    }
    warnings.extend(delay.told.clone());
    if choice.factor.conditioning.is_reduced() {
        warnings.push(choice.factor.conditioning.to_string());
    }
    let filter = filter(&data, &choice.factor, chosen, options.refine, &mut warnings)?;

    // Back to SI: u' = (u − ū)/s_u, y' = (y − ȳ)/s_y.
    let model = chosen.model.scaled(&[data.input_scale], &[data.output_scale]);
    let gain: Vec<f64> =
        (0..model.order()).map(|i| filter.gain[(i, 0)] / data.output_scale).collect();
    let continuous = to_continuous(model.a.as_ref(), model.b.as_ref(), data.sample_time);
    warnings.extend(chosen.mirroring_cost.map(logarithm::told));
    if let Err(reason) = &continuous {
        warnings.push(format!("the model stays discrete: {reason}"));
    }
    let continuous = continuous.ok();
    if let Some(s) = chosen.stabilised {
        let refined = if options.refine {
            format!("; refinement brought it to {:.1} %", chosen.estimation_fit)
        } else {
            String::new()
        };
        warnings.push(format!(
            "the subspace estimate was unstable (spectral radius {:.4}) and has been stabilised, which took its fit to the estimation data from {} to {:.1} %{refined}",
            s.radius,
            // An unstable simulation may fit by minus any number.
            if s.fit_before > -100.0 { format!("{:.1}", s.fit_before) } else { "nothing".into() },
            s.fit_after
        ));
    }

    let residual =
        filter.residuals.iter().map(|e| e * e).sum::<f64>() / filter.residuals.len().max(1) as f64;
    let uncertainty = match uncertainty(&data, &choice, &filter.gain, options.refine) {
        Ok(uncertainty) => Some(uncertainty),
        Err(error) => {
            warnings.push(format!("the model's uncertainty cannot be told: {error}"));
            None
        }
    };
    let speed = log.speed.as_deref().unwrap_or_default();
    if log.speed.is_none() {
        warnings.push("no speed channel: the operating point's speed is written as 0".into());
    }
    let mut traces = traces(log, &data, chosen, options)?;
    traces.steering_rad.clone_from(&measured.input);
    let part = &data.validation;
    let simulated = output(&chosen.model, part, &initial_states(&chosen.model, part)?);
    let residuals = part.stretches(&filter.validation_residuals);
    let held_out_input = part.of(&input);
    let held_out_input = part.stretches(&held_out_input);
    let instants = log.time_s();
    let held_out = evidence::held_out(&evidence::Prediction {
        model: &chosen.model,
        gain: &(0..model.order()).map(|i| filter.gain[(i, 0)]).collect::<Vec<_>>(),
        output: &part.stretches(&part.output),
        simulated: &part.stretches(&simulated),
        residuals: &residuals,
        sample_time_s: data.sample_time,
        selection: data.selection.name(),
        segments_s: part.ranges.iter().map(|r| [instants[r.start], instants[r.end - 1]]).collect(),
        noise: residual.sqrt(),
    });
    let per_input = match options.input_kind {
        InputKind::Steering => 1.0,
        InputKind::SteeringTimesSpeed => 1.0 / mean(speed).max(0.1),
    };
    let modelled = evidence::Modelled {
        model: &model,
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
    let (excitation, frequency_response) = evidence::frequencies(log, &modelled, residual.sqrt());
    let evidence = Evidence {
        method: chosen.approach.name().into(),
        horizon: chosen.horizon,
        factor: Some(evidence::data_factor(&choice.factor.conditioning)),
        delay: delay.estimate,
        estimation_samples: data.estimation.len(),
        validation_samples: data.validation.len(),
        fit: Fits {
            estimation: chosen.estimation_fit,
            validation: chosen.validation_fit,
            validation_one_step: filter.validation_fit,
        },
        order_table: order_table(&choice),
        feedback: choice.feedback.map(feedback_test),
        whiteness: whiteness(&residuals, LAGS),
        independence: independence(&residuals, &held_out_input, LAGS),
        excitation,
        held_out: Some(held_out),
        play,
        yaw_rate_lead_s,
        yaw_rate_lag_s,
        residuals: Some(evidence::correlations(&residuals, &held_out_input)),
        frequency_response: Some(frequency_response),
        poles_and_zeros: Some(evidence::poles_and_zeros(
            &model,
            continuous.as_ref(),
            data.sample_time,
            uncertainty.as_ref(),
        )),
        stabilised_from: chosen.stabilised.map(|s| s.radius),
        conversion_round_trip: continuous.as_ref().map(|c| c.round_trip),
        channels: log.channels.clone(),
        warnings,
    };
    let point = operating_point(
        (data.input_mean, data.output_mean),
        [data.input_scale, data.output_scale],
        &model,
        mean(speed),
        options.input_kind,
    );
    let spread =
        if speed.is_empty() { 0.0 } else { standard_deviation(speed) / mean(speed).max(0.1) };
    let map = evidence.poles_and_zeros.clone().unwrap_or_default();
    let implausible = implausible(&Response {
        at: &at,
        excitation: Some(&evidence.excitation),
        speed_mps: mean(speed),
        steering_ratio: log.steering_ratio,
        zeros: &map.continuous_zeros,
        spreads: &map.continuous_zero_spreads,
    });
    let drive = evidence::Drive {
        has_continuous: continuous.is_some(),
        speed_mps: mean(speed),
        speed_spread: spread,
        steering_ratio: log.steering_ratio,
        to_road_wheel: modelled.to_road_wheel,
        steering: &log.input,
        seconds: log.len() as f64 * data.sample_time,
        order: model.order(),
        slow_log: evidence::slow_log(&log.channels, bandwidth_hz(&at, 0.5 / data.sample_time)),
        noise_radps: residual.sqrt() * data.output_scale,
        road_wheel_offset_rad: point.steering_offset_rad / log.steering_ratio,
        yaw_rate_offset_radps: point.yaw_rate_offset_radps
            - at(0.0).0 * point.steering_offset_rad / log.steering_ratio,
        implausible,
    };
    let quality = evidence::quality(&evidence, &drive, options);

    let mut used = log.options.clone();
    used.extend(options.to_map());
    used.insert("realization".into(), chosen.realization.name().into());
    let plant = Plant {
        schema: Plant::SCHEMA.into(),
        name: log.name.clone(),
        input: options.input_kind,
        steering_ratio: log.steering_ratio,
        input_delay_s: delay.seconds,
        operating_point: point,
        discrete: discrete(&model, &gain, &chosen.conditions.x0[0], data.sample_time),
        continuous: continuous.map(|c| continuous_form(&c, &model)),
        noise: Noise { innovation_variance: residual * data.output_scale * data.output_scale },
        sideslip: from_fixes.sideslip,
        uncertainty,
        evidence,
        quality,
        provenance: Provenance {
            version: env!("CARGO_PKG_VERSION").into(),
            sources: log.sources.clone(),
            options: used,
        },
    };
    plant.checked("plant.json").map_err(|e| Error::NoModel { problem: e.to_string() })?;
    Ok(Identified { plant, traces })
}

/// Steering, yaw rate and speed of the log's segments, as many as are needed to find faults.
pub(crate) fn pairs(log: &DriveLog) -> Vec<Pair<'_>> {
    let mut left = MOST_FOR_FAULTS;
    let ranges = log.segments.iter().map(|s| {
        let range = s.range.start..s.range.end.min(s.range.start + left);
        left -= range.len();
        range
    });
    let pair = |r: std::ops::Range<usize>| Pair {
        steering: &log.input[r.clone()],
        yaw_rate: &log.output[r.clone()],
        speed: log.speed.as_ref().map(|v| &v[r]),
    };
    ranges.filter(|r| !r.is_empty()).map(pair).collect()
}

pub(crate) fn feedback_test(feedback: Feedback) -> ResidualTest {
    ResidualTest {
        lags: feedback.degrees,
        statistic: feedback.statistic,
        bound: feedback.bound,
        pass: !feedback.detected,
    }
}

/// By rising order; singular values are those of one decomposition, since those of another method or
/// horizon are others.
fn order_table(choice: &Choice) -> Vec<OrderRow> {
    let values = &choice.candidates[choice.chosen].singular_values;
    let mut rows: Vec<OrderRow> =
        choice.candidates.iter().map(|c| order_row(c, values.get(c.model.order() - 1))).collect();
    rows.sort_by_key(|row| row.order);
    rows
}

fn order_row(candidate: &Candidate, singular_value: Option<&f64>) -> OrderRow {
    OrderRow {
        order: candidate.model.order(),
        singular_value: singular_value.copied(),
        estimation_fit: candidate.estimation_fit,
        validation_fit: candidate.validation_fit,
        stable: candidate.stabilised.is_none(),
        criterion: candidate.criterion,
    }
}

/// The means' difference is put on the steering, `δ0 = ū − ȳ/G(0)`, since a car that yaws at rest
/// steering has a crooked wheel; where the steady-state gain is too small against the signals' ratio
/// to tell, both means stay.
pub(crate) fn operating_point(
    (u, y): (f64, f64),
    [input_scale, output_scale]: [f64; 2],
    model: &StateSpace,
    speed_mps: f64,
    kind: InputKind,
) -> OperatingPoint {
    const LEAST_RELATIVE_GAIN: f64 = 0.05;
    let per_steering = match kind {
        InputKind::Steering => 1.0,
        InputKind::SteeringTimesSpeed => speed_mps.max(1e-3),
    };
    let least = LEAST_RELATIVE_GAIN * output_scale / input_scale;
    let shift = model.steady_state_gain(0, 0).filter(|g| g.abs() > least).map(|g| y / g);
    match shift {
        Some(shift) if shift.abs() < 5.0 * input_scale => OperatingPoint {
            speed_mps,
            steering_offset_rad: (u - shift) / per_steering,
            yaw_rate_offset_radps: 0.0,
        },
        _ => OperatingPoint {
            speed_mps,
            steering_offset_rad: u / per_steering,
            yaw_rate_offset_radps: y,
        },
    }
}

fn matrix(m: &Mat<f64>) -> Matrix {
    Matrix::from_fn(m.nrows(), m.ncols(), |i, j| m[(i, j)])
}

pub(crate) fn discrete(
    model: &StateSpace,
    gain: &[f64],
    x0: &[f64],
    sample_time_s: f64,
) -> Discrete {
    Discrete {
        sample_time_s,
        a: matrix(&model.a),
        b: matrix(&model.b),
        c: matrix(&model.c),
        d: matrix(&model.d),
        k: Matrix::column(gain),
        x0: x0.to_vec(),
    }
}

pub(crate) fn continuous_form(c: &ContinuousModel, model: &StateSpace) -> Continuous {
    Continuous { f: matrix(&c.f), g: matrix(&c.g), h: matrix(&model.c) }
}

fn traces(
    log: &DriveLog,
    data: &Data,
    chosen: &Candidate,
    options: &IdentifyOptions,
) -> Result<Traces, Error> {
    let held_out = &data.validation;
    let x0 = initial_states(&chosen.model, held_out)?;
    let mut simulated = vec![0.0; log.len()];
    let own = output(&chosen.model, &data.estimation, &chosen.conditions.x0);
    data.estimation.put(&own, &mut simulated);
    held_out.put(&output(&chosen.model, held_out, &x0), &mut simulated);
    if let Some(unused) = data.unused(log, options)? {
        let x0 = initial_states(&chosen.model, &unused)?;
        unused.put(&output(&chosen.model, &unused, &x0), &mut simulated);
    }
    let mut is_validation = vec![false; log.len()];
    held_out.ranges.iter().for_each(|r| is_validation[r.clone()].fill(true));
    data.restore(log, &mut simulated);
    Ok(Traces {
        time_s: log.time_s(),
        steering_rad: log.input.clone(),
        yaw_rate_radps: log.output.clone(),
        is_validation,
        yaw_rad: log.yaw(&log.output),
        simulated_yaw_rad: log.yaw(&simulated),
        simulated_yaw_rate_radps: simulated,
    })
}
