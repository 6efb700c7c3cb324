//! What goes into `plant.json`.

use crate::Error;
use crate::data::scaled::Data;
use crate::model::StateSpace;
use crate::model::conversion::ContinuousModel;
use crate::selection::candidate::{Candidate, Choice, initial_states, output};
use crate::selection::options::IdentifyOptions;
use crate::subspace::closed_loop::Feedback;
use drivelog::DriveLog;
use faer::Mat;
use formats::{
    Continuous, Discrete, InputKind, Matrix, OperatingPoint, OrderRow, Plant, ResidualTest,
};

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
    /// Whether the sample is validation data.
    pub is_validation: Vec<bool>,
    /// Integral of the measured yaw rate from 0, rad; nothing is added over a gap.
    pub yaw_rad: Vec<f64>,
    /// Integral of the simulated yaw rate from 0, rad.
    pub simulated_yaw_rad: Vec<f64>,
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
pub(crate) fn order_table(choice: &Choice) -> Vec<OrderRow> {
    let values = &choice.candidates[choice.chosen].singular_values;
    let mut rows: Vec<OrderRow> =
        choice.candidates.iter().map(|c| order_row(c, values.get(c.model.order() - 1))).collect();
    rows.sort_by_key(|row| row.order);
    rows
}

pub(crate) fn order_row(candidate: &Candidate, singular_value: Option<&f64>) -> OrderRow {
    OrderRow {
        order: candidate.model.order(),
        singular_value: singular_value.copied(),
        estimation_fit: candidate.estimation_fit,
        validation_fit: candidate.validation_fit,
        stable: candidate.stabilised.is_none(),
        criterion: candidate.criterion,
    }
}

/// The means' difference is attributed to the steering, `δ0 = ū − ȳ/G(0)`, since a car that yaws at a
/// steering angle of zero has a steering offset; where the steady-state gain is too small against the
/// signals' ratio to determine it, both means stay.
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

pub(crate) fn matrix(m: &Mat<f64>) -> Matrix {
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

pub(crate) fn traces(
    log: &DriveLog,
    data: &Data,
    chosen: &Candidate,
    options: &IdentifyOptions,
) -> Result<Traces, Error> {
    let validation = &data.validation;
    let x0 = initial_states(&chosen.model, validation)?;
    let mut simulated = vec![0.0; log.len()];
    let own = output(&chosen.model, &data.estimation, &chosen.initial_conditions.x0);
    data.estimation.put(&own, &mut simulated);
    validation.put(&output(&chosen.model, validation, &x0), &mut simulated);
    if let Some(unused) = data.unused(log, &options.preparation())? {
        let x0 = initial_states(&chosen.model, &unused)?;
        unused.put(&output(&chosen.model, &unused, &x0), &mut simulated);
    }
    let mut is_validation = vec![false; log.len()];
    validation.ranges.iter().for_each(|r| is_validation[r.clone()].fill(true));
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
