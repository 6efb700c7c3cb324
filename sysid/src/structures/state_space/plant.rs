//! What goes into `plant.json`.

use crate::Error;
use crate::data::scaled::Data;
use crate::model::StateSpace;
use crate::model::conversion::ContinuousModel;
use crate::selection::candidate::{Candidate, Choice, simulated_whole};
use crate::selection::options::IdentifyOptions;
use crate::structures::held::with_open_hold;
use crate::subspace::closed_loop::Feedback;
use crate::validation::faults::open_hold::widened;
use crate::validation::plausible::{Response, implausible};
use crate::validation::quality::quality;
use crate::validation::residuals::rate::slow_log;
use crate::validation::response::modelled::bandwidth_hz;
use crate::validation::response::poles::poles_and_zeros;
use crate::validation::response::sweep::Drive;
use crate::validation::response::uncertain_response::ResponseError;
use crate::validation::vehicle_class::implausible_vehicle;
use faer::Mat;
use std::collections::BTreeMap;
use std::f64::consts::TAU;
use std::ops::Range;
use steerwright_drivelog::{DriveLog, VehicleClass};
use steerwright_formats::{
    Continuous, Discrete, Document, Evidence, InputKind, Matrix, Noise, OperatingPoint, OrderRow,
    Plant, Provenance, ResidualTest, Sideslip, SourceFile, Uncertainty,
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
    /// Simulated yaw rate, rad/s, from an initial state at the start of each segment of the log.
    pub simulated_yaw_rate_radps: Vec<f64>,
    /// Whether the sample is validation data.
    pub is_validation: Vec<bool>,
    /// Integral of the measured yaw rate from 0, rad; nothing is added over a gap.
    pub yaw_rad: Vec<f64>,
    /// Integral of the simulated yaw rate from 0, rad.
    pub simulated_yaw_rad: Vec<f64>,
}

impl Traces {
    /// With the simulated yaw rate, rad/s, and the validation samples.
    pub(crate) fn new(log: &DriveLog, simulated: Vec<f64>, validation: &[Range<usize>]) -> Self {
        let mut is_validation = vec![false; log.len()];
        validation.iter().for_each(|r| is_validation[r.clone()].fill(true));
        Self {
            time_s: log.time_s(),
            steering_rad: log.input.clone(),
            yaw_rate_radps: log.output.clone(),
            is_validation,
            yaw_rad: log.yaw(&log.output),
            simulated_yaw_rad: log.yaw(&simulated),
            simulated_yaw_rate_radps: simulated,
        }
    }
}

pub(crate) fn feedback_test(feedback: Feedback) -> ResidualTest {
    ResidualTest {
        lags: feedback.degrees,
        statistic: feedback.statistic,
        bound: feedback.bound,
        pass: !feedback.detected,
    }
}

/// By rising order; singular values are those of the chosen decomposition.
pub(crate) fn order_table(choice: &Choice) -> Vec<OrderRow> {
    let values = &choice.candidates[choice.chosen].singular_values;
    let row = |c: &Candidate| OrderRow {
        order: c.model.order(),
        singular_value: values.get(c.model.order() - 1).copied(),
        estimation_fit: c.estimation_fit,
        validation_fit: c.validation_fit,
        stable: c.stabilised.is_none(),
        criterion: c.criterion,
    };
    let mut rows: Vec<OrderRow> = choice.candidates.iter().map(row).collect();
    rows.sort_by_key(|row| row.order);
    rows
}

/// A model with what its plant and its quality depend on in addition to the evidence.
pub(crate) struct Outcome<'a> {
    pub(crate) options: &'a IdentifyOptions,
    pub(crate) name: &'a str,
    pub(crate) input_kind: InputKind,
    pub(crate) steering_ratio: f64,
    pub(crate) vehicle_class: Option<VehicleClass>,
    /// Wheelbase of the drive with its standard error, m, where that is determined.
    pub(crate) wheelbase: Option<[f64; 2]>,
    pub(crate) delay_s: f64,
    pub(crate) sample_time_s: f64,
    pub(crate) model: &'a StateSpace,
    pub(crate) continuous: Option<&'a ContinuousModel>,
    pub(crate) gain: &'a [f64],
    pub(crate) x0: &'a [f64],
    /// Means of input and output that the model is about, and the units that it was estimated in.
    pub(crate) means: (f64, f64),
    pub(crate) scales: [f64; 2],
    /// Mean and standard deviation of the speed, m/s; zeros without a channel of it.
    pub(crate) speed: (f64, f64),
    pub(crate) steering: &'a [f64],
    /// Length without what was left out, s.
    pub(crate) seconds: f64,
    /// Variance of the one-step residuals in units of the output's scale.
    pub(crate) residual: f64,
    pub(crate) uncertainty: Option<Uncertainty>,
    /// Period of a steering, s, of which it is open whether it is held between its samples; the uncertainty does not cover it.
    pub(crate) open_hold_s: Option<f64>,
    pub(crate) sideslip: Option<Sideslip>,
    pub(crate) sources: &'a [SourceFile],
    pub(crate) used: BTreeMap<String, String>,
}

impl Outcome<'_> {
    pub(crate) fn to_road_wheel(&self) -> f64 {
        let per_input = match self.input_kind {
            InputKind::Steering => 1.0,
            InputKind::SteeringTimesSpeed => 1.0 / self.speed.0.max(0.1),
        };
        per_input / self.steering_ratio
    }

    /// Yaw rate over road-wheel angle, 1/s, at a frequency in Hz.
    pub(crate) fn response_at(&self, hz: f64) -> (f64, f64) {
        let (re, im) = self.model.frequency_response(0, 0, TAU * hz * self.sample_time_s);
        let (sin, cos) = (-TAU * hz * self.delay_s).sin_cos();
        let per_angle = 1.0 / self.to_road_wheel();
        (per_angle * (re * cos - im * sin), per_angle * (re * sin + im * cos))
    }

    /// The plant with its quality; poles, zeros and the conversion's round trip join the evidence.
    pub(crate) fn plant(self, mut evidence: Evidence) -> Result<Plant, Error> {
        let (model, step) = (self.model, self.sample_time_s);
        let map = poles_and_zeros(model, self.continuous, step, self.uncertainty.as_ref());
        let (speed_mps, deviation) = self.speed;
        let at = |hz: f64| self.response_at(hz);
        let mut implausible = implausible(&Response {
            at: &at,
            excitation: Some(&evidence.excitation),
            speed_mps,
            steering_ratio: self.steering_ratio,
            zeros: &map.continuous_zeros,
            spreads: &map.continuous_zero_spreads,
        });
        implausible.extend(implausible_vehicle(self.vehicle_class, self.wheelbase, speed_mps));
        evidence.poles_and_zeros = Some(map);
        evidence.conversion_round_trip = self.continuous.map(|c| c.round_trip);
        let point = self.operating_point();
        let straight = point.steering_offset_rad / self.steering_ratio;
        let [_, y] = self.scales;
        let response_errors =
            ResponseError::of_plant(self.uncertainty.as_ref(), &evidence.excitation.bands);
        let (response_errors, open_hold_s) = with_open_hold(response_errors, self.open_hold_s);
        let drive = Drive {
            has_continuous: self.continuous.is_some(),
            speed_mps,
            speed_spread: deviation / speed_mps.max(0.1),
            steering_ratio: self.steering_ratio,
            to_road_wheel: self.to_road_wheel(),
            steering: self.steering,
            seconds: self.seconds,
            order: model.order(),
            slow_log: slow_log(&evidence.channels, bandwidth_hz(&at, 0.5 / step)),
            noise_radps: self.residual.sqrt() * y,
            road_wheel_offset_rad: straight,
            yaw_rate_offset_radps: point.yaw_rate_offset_radps - at(0.0).0 * straight,
            implausible,
            open_hold_s,
            response_errors,
        };
        let quality = quality(&evidence, &drive, self.options);
        let uncertainty = match (self.uncertainty, self.open_hold_s) {
            (Some(stated), Some(period_s)) => {
                Some(widened(stated, period_s, self.continuous, model))
            }
            (stated, _) => stated,
        };
        let plant = Plant {
            schema: Plant::SCHEMA.into(),
            name: self.name.into(),
            input: self.input_kind,
            steering_ratio: self.steering_ratio,
            input_delay_s: self.delay_s,
            operating_point: point,
            discrete: Discrete {
                sample_time_s: step,
                a: matrix(&model.a),
                b: matrix(&model.b),
                c: matrix(&model.c),
                d: matrix(&model.d),
                k: Matrix::column(self.gain),
                x0: self.x0.to_vec(),
            },
            continuous: self.continuous.map(|c| Continuous {
                f: matrix(&c.f),
                g: matrix(&c.g),
                h: matrix(&model.c),
            }),
            noise: Noise { innovation_variance: self.residual * y * y },
            sideslip: self.sideslip,
            uncertainty,
            evidence,
            quality,
            provenance: Provenance {
                version: env!("CARGO_PKG_VERSION").into(),
                sources: self.sources.to_vec(),
                options: self.used,
            },
        };
        plant.checked("plant.json").map_err(|e| Error::no_model(e.to_string()))?;
        Ok(plant)
    }

    /// The means' difference is a steering offset, `δ0 = ū − ȳ/G(0)`, unless G(0) is too small to
    /// determine it.
    fn operating_point(&self) -> OperatingPoint {
        const LEAST_RELATIVE_GAIN: f64 = 0.05;
        let ((u, y), [input_scale, output_scale], speed_mps) =
            (self.means, self.scales, self.speed.0);
        let per_steering = match self.input_kind {
            InputKind::Steering => 1.0,
            InputKind::SteeringTimesSpeed => speed_mps.max(1e-3),
        };
        let least = LEAST_RELATIVE_GAIN * output_scale / input_scale;
        let gain = self.model.steady_state_gain(0, 0).filter(|g| g.abs() > least);
        let shift = gain.map(|g| y / g).filter(|shift| shift.abs() < 5.0 * input_scale);
        let (steering, yaw_rate_offset_radps) = shift.map_or((u, y), |shift| (u - shift, 0.0));
        let steering_offset_rad = steering / per_steering;
        OperatingPoint { speed_mps, steering_offset_rad, yaw_rate_offset_radps }
    }
}

pub(crate) fn matrix(m: &Mat<f64>) -> Matrix {
    Matrix::from_fn(m.nrows(), m.ncols(), |i, j| m[(i, j)])
}

pub(crate) fn traces(log: &DriveLog, data: &Data, model: &StateSpace) -> Result<Traces, Error> {
    let mut all = simulated_whole(model, data)?;
    all.resize(log.len(), 0.0);
    data.restore(log, &mut all);
    Ok(Traces::new(log, all, &data.validation.ranges))
}
