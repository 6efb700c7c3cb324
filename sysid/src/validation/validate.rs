//! A model on a drive that need not be its own, validated as an identified one is on its own.

use crate::Error;
use crate::data::held_input::{Between, ContinuousResponse, held_for};
use crate::data::scaled::{Data, Part, Preparation};
use crate::data::statistics::fit_percent;
use crate::model::StateSpace;
use crate::model::conversion::discretize;
use crate::selection::candidate::simulated_whole;
use crate::selection::initial_conditions::{InitialConditions, needs_output_offset};
use crate::selection::options::IdentifyOptions;
use faer::Mat;
use std::borrow::Cow;
use steerwright_drivelog::{DriveLog, Role};
use steerwright_formats::{ChannelSummary, Continuous, InputKind, Intersample, Matrix, Plant};

/// How well a given model follows a drive, by the measures of [`steerwright_formats::Fits`].
#[derive(Debug, Clone, PartialEq)]
pub struct Validated {
    /// Simulation fit on the estimation data, percent.
    pub estimation_fit: f64,
    /// Simulation fit on the validation data, percent.
    pub validation_fit: f64,
    /// Simulated yaw rate over the whole drive, rad/s; the initial state is estimated at the start
    /// of each segment.
    pub simulated_yaw_rate_radps: Vec<f64>,
    /// The first sample of the validation data.
    pub first_validation_sample: usize,
}

/// Validates a model from steering angle (rad) to yaw rate (rad/s) on a drive, prepared as in
/// [`identify`](crate::identify).
///
/// # Errors
/// As [`identify`](crate::identify) for a drive that is too short or does not move, and
/// [`Error::NoModel`] for matrices that do not fit each other.
pub fn validate(
    log: &DriveLog,
    options: &IdentifyOptions,
    model: &Continuous,
) -> Result<Validated, Error> {
    let none = Matrix::from_fn(1, 1, |_, _| 0.0);
    let matrices = [&model.f, &model.g, &model.h, &none];
    let [a, b, c, d] = sampled(matrices, Some(log.sample_time_s))?;
    let log = held_for(log, Between::AsRead, Some(&continuous(matrices)?));
    validated(&log, options, InputKind::Steering, StateSpace { a, b, c, d })
}

/// Validates an identified plant on a drive, its own or another, as [`validate`] does: by its discrete
/// form on the log's samples where they are its own, else by its continuous one; with its input delay.
///
/// # Errors
/// As [`validate`]; [`Error::NoModel`] where the log's sample time is not the plant's and the plant has
/// no continuous form.
pub fn validate_plant(
    log: &DriveLog,
    options: &IdentifyOptions,
    plant: &Plant,
) -> Result<Validated, Error> {
    let discrete = &plant.discrete;
    let own = (discrete.sample_time_s - log.sample_time_s).abs() <= 1e-9 * log.sample_time_s;
    let [a, b, c, d] = match &plant.continuous {
        _ if own => sampled([&discrete.a, &discrete.b, &discrete.c, &discrete.d], None)?,
        Some(m) => sampled([&m.f, &m.g, &m.h, &discrete.d], Some(log.sample_time_s))?,
        None => {
            return Err(Error::no_model(format!(
                "{} steps every {} s and has no continuous form, the log is read every {} s",
                plant.name, discrete.sample_time_s, log.sample_time_s
            )));
        }
    };
    let model = StateSpace { a, b, c, d };
    let is_open = plant.uncertainty.as_ref().is_some_and(|u| u.open_hold_s.is_some());
    let held = held_as(log, &plant.evidence.channels, is_open, plant.evidence.held_for.as_ref())?;
    let log = &*held;
    if plant.input_delay_s > 0.0 {
        let late = log.with_input_delayed(plant.input_delay_s);
        return validated(&late, options, plant.input, model);
    }
    validated(log, options, plant.input, model)
}

/// The log with its steering held as that of a model was, whose evidence has these channels and was held for this
/// vehicle. Where both logs leave it open whether the steering is held, it is read as the model's own was.
///
/// # Errors
/// [`Error`] where the vehicle's matrices have other shapes or no finite numbers.
pub fn held_as<'a>(
    log: &'a DriveLog,
    channels: &[ChannelSummary],
    is_open: bool,
    held_for_vehicle: Option<&Continuous>,
) -> Result<Cow<'a, DriveLog>, Error> {
    let own = channels.iter().find(|c| c.role == Role::Steering.key());
    let is_held = is_open && own.is_some_and(|c| c.intersample == Some(Intersample::Zoh));
    // A command that was set more often than it was logged is so in other logs of the same column; so is an angle that
    // goes along straight lines.
    let mut same = log.channels.iter().filter(|c| c.role == Role::Steering.key());
    let is_same = same.any(|c| own.is_some_and(|own| own.column == c.column));
    let moves_on = is_same && own.is_some_and(|c| c.intersample == Some(Intersample::Foh));
    let is_along_lines = is_same && own.is_some_and(|c| c.along_lines);
    let between = match [Intersample::Bl, Intersample::Zoh]
        .map(|read| log.assumed_period_s(Role::Steering, read))
    {
        [Some(period_s), _] if is_held => Between::Held(period_s),
        [Some(_), _] if is_along_lines => Between::Lines,
        [_, Some(_)] if moves_on => Between::MovingOn,
        _ => Between::AsRead,
    };
    let vehicle = held_for_vehicle.map(|m| {
        let none = Matrix::from_fn(1, 1, |_, _| 0.0);
        continuous([&m.f, &m.g, &m.h, &none])
    });
    Ok(held_for(log, between, vehicle.transpose()?.as_ref()))
}

/// The model that holds the steering; its matrices are checked.
fn continuous(matrices: [&Matrix; 4]) -> Result<ContinuousResponse, Error> {
    let [f, g, h, d] = sampled(matrices, None)?;
    Ok(ContinuousResponse { f, g, h, d: d[(0, 0)] })
}

/// Checked matrices; sampled where a sample time is given, with the input held.
fn sampled(matrices: [&Matrix; 4], step: Option<f64>) -> Result<[Mat<f64>; 4], Error> {
    let n = matrices[0].rows();
    let shapes = [(n, n), (n, 1), (1, n), (1, 1)];
    if matrices.iter().zip(shapes).any(|(m, (r, c))| m.rows() != r || m.columns() != Some(c)) {
        let problem = "the matrices from steering angle to yaw rate do not fit each other";
        return Err(Error::no_model(problem));
    }
    let dense = |i: usize| {
        let (rows, columns) = shapes[i];
        Mat::from_fn(rows, columns, |r, c| matrices[i].entry(r, c))
    };
    let (mut a, mut b) = (dense(0), dense(1));
    if let Some(step) = step {
        (a, b) = discretize(a.as_ref(), b.as_ref(), step);
    }
    Ok([a, b, dense(2), dense(3)])
}

fn validated(
    log: &DriveLog,
    options: &IdentifyOptions,
    input_kind: InputKind,
    model: StateSpace,
) -> Result<Validated, Error> {
    options.check()?;
    // Models are compared on the same part of a log: its end.
    let data = Data::of_end(log, &Preparation { input_kind, ..options.preparation() })?;
    // Into the scaled signals of the data: u' = (u − ū)/s_u, y' = (y − ȳ)/s_y.
    let scaled = model.scaled(&[1.0 / data.input_scale], &[1.0 / data.output_scale]);

    // About the output offset that suits it on the estimation data.
    let part = &data.estimation.data;
    let offset = options.has_output_offset() && needs_output_offset(&scaled, part)?;
    let initial_conditions = InitialConditions::new(&scaled, part, offset)?;
    let data = match initial_conditions.offsets.as_deref() {
        Some([offset]) => data.about(*offset)?,
        _ => data,
    };
    let mut simulated = simulated_whole(&scaled, &data)?;
    let fit = |part: &Part| fit_percent(&part.output, &part.samples(&simulated));
    let (estimation_fit, validation_fit) = (fit(&data.estimation), fit(&data.validation));
    data.restore(log, &mut simulated);
    Ok(Validated {
        estimation_fit,
        validation_fit,
        simulated_yaw_rate_radps: simulated,
        first_validation_sample: data.estimation.len(),
    })
}
