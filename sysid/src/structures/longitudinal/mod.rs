//! The structure `longitudinal`: the response of the speed to accelerator and brake, or to an acceleration command
//! (docs/methods/longitudinal.md).
//!
//! The acceleration is that of a delayed and lagged command times a gain over the speed or by gear, of a delayed and lagged
//! brake, of resistances and of the grade. It is estimated by least squares of prediction errors, since drives are closed
//! loops of a driver or a cruise control (`noise`), over pieces of the drive above a lowest speed (`signals`).

mod fit;
mod model;
mod noise;
mod options;
mod quality;
mod signals;
mod start;
mod validate;
mod variation;

pub use options::LongitudinalOptions;

use crate::Error;
use crate::structures::longitudinal::fit::{Fit, prediction_errors};
use crate::structures::longitudinal::model::{
    BRAKE_DELAY, BRAKE_GAIN, BRAKE_LAG, COUNT, DELAY, DRAG, GRADE, LAG, PEDAL, Point, RESISTANCE,
    RESISTANCE_PER_SPEED, Schedule, Simulation,
};
use crate::structures::longitudinal::quality::{Changes, Demands, check_excitation, quality};
use crate::structures::longitudinal::signals::{Piece, Signals};
use crate::structures::longitudinal::validate::{WINDOW_S, Windows, residual_tests, slope};
use crate::structures::model::{IdentifiedModel, StructureOptions};
use crate::structures::multivariable::ChannelTraces;
use steerwright_drivelog::{DriveLog, Response};
use steerwright_formats::{
    Brake, Document, Estimate, GearGain, Longitudinal, LongitudinalEvidence, LongitudinalNoise,
    Matrix, Model, Provenance, Quality, SpeedGain, Structure,
};

impl StructureOptions for LongitudinalOptions {
    fn structure(&self) -> Structure {
        Structure::Longitudinal
    }

    fn response(&self) -> Response {
        Response::Speed
    }

    fn identify(&self, log: &DriveLog) -> Result<IdentifiedModel, Error> {
        let (model, signals) = identify_with_signals(log, self)?;
        Ok(IdentifiedModel {
            model: Model::Longitudinal(Box::new(model)),
            traces: None,
            channels: Some(signals),
        })
    }
}

/// Identifies the model in a log of the response of the speed.
///
/// # Errors
/// [`Error::SpeedLogNeeded`] for another log, [`Error::TooSlow`] and [`Error::TooFewSamples`] at or above the lowest
/// speed, [`Error::NotExciting`] if the command hardly varies there, [`Error::Option`].
pub fn identify_longitudinal(
    log: &DriveLog,
    options: &LongitudinalOptions,
) -> Result<Longitudinal, Error> {
    Ok(identify_with_signals(log, options)?.0)
}

/// The same with the signals behind the plots: the speed is simulated in the windows of the fit.
fn identify_with_signals(
    log: &DriveLog,
    options: &LongitudinalOptions,
) -> Result<(Longitudinal, ChannelTraces), Error> {
    options.check()?;
    if log.response != Response::Speed {
        return Err(Error::SpeedLogNeeded { response: log.response });
    }
    let fastest_mps = log.output.iter().copied().fold(0.0, f64::max);
    if fastest_mps < options.least_speed_mps {
        return Err(Error::TooSlow { least_mps: options.least_speed_mps, fastest_mps });
    }
    let signals = Signals::new(log);
    if options.single_gear && signals.gears.len() > 1 {
        let gears = format!("{:?}", signals.gears);
        return Err(Error::option(
            "single gear",
            "true",
            format!("the gear of the log to be one, and it is {gears}"),
        ));
    }
    let [estimation, validation] = signals.split(options)?;
    check_excitation(&signals, &estimation)?;
    let fit = Fit::estimate(&signals, &estimation)?;
    let windows = |pieces: &[Piece]| Windows::simulate(&signals, &fit.schedule, &fit.point, pieces);
    let (estimated, validated) = (windows(&estimation), windows(&validation));
    let errors = prediction_errors(&fit, &signals, &validation);
    let (prediction_error_ratio, residual_correlation, correlation_standard_error) =
        residual_tests(&errors, &validation, &signals);
    let count = |pieces: &[Piece]| pieces.iter().map(|piece| piece.range.len()).sum::<usize>();
    let evidence = LongitudinalEvidence {
        channels: log.channels.clone(),
        gain_variation: variation::gain_variation(&fit, &signals, &estimation),
        estimation_samples: count(&estimation),
        validation_samples: count(&validation),
        sample_time_s: log.sample_time_s,
        least_speed_mps: options.least_speed_mps,
        speed_mps: speeds(&signals, &estimation),
        window_s: WINDOW_S,
        estimation_fit: estimated.fit(),
        validation_fit: validated.fit(),
        validation_fit_standard_error: validated.standard_error(),
        validation_windows: validated.count(),
        prediction_error_ratio,
        residual_correlation,
        correlation_standard_error,
        warnings: log.warnings.clone(),
    };
    let mut model = document(&signals, &fit, evidence, options);
    let traces = traces(&signals, [&estimated, &validated], &validation);
    let changes = Changes {
        rms_mps: validated.change_rms(count(&validation)),
        slope: slope([&estimated, &validated]),
    };
    let demands = Demands::new(&signals, &fit, &estimation);
    model.quality = quality(&model, &fit, demands, changes, options.single_gear);
    model.checked("longitudinal.json").map_err(|e| Error::no_model(e.to_string()))?;
    Ok((model, traces))
}

/// Inputs, and the speed as measured and as simulated in the windows; beside these it is not simulated.
fn traces(signals: &Signals<'_>, windows: [&Windows; 2], validation: &[Piece]) -> ChannelTraces {
    let log = signals.log;
    let mut simulated = vec![f64::NAN; log.len()];
    windows.into_iter().for_each(|windows| windows.write_to(&mut simulated));
    let mut is_validation = vec![false; log.len()];
    validation.iter().for_each(|piece| is_validation[piece.range.clone()].fill(true));
    let command = if signals.is_acceleration { "acceleration_command_mps2" } else { "accelerator" };
    let mut inputs = vec![(command.to_owned(), log.input.clone())];
    inputs.extend(signals.brake.map(|brake| ("brake".to_owned(), brake.to_vec())));
    let outputs = vec![("speed_mps".to_owned(), log.output.clone(), simulated)];
    ChannelTraces { time_s: log.time_s(), inputs, outputs, is_validation }
}

/// Fit of a model to the parts of a log that validate with these options, percent: as the file states it for the log that it
/// was identified from.
///
/// # Errors
/// As [`identify_longitudinal`].
pub fn validate_longitudinal(
    log: &DriveLog,
    options: &LongitudinalOptions,
    model: &Longitudinal,
) -> Result<f64, Error> {
    options.check()?;
    if log.response != Response::Speed {
        return Err(Error::SpeedLogNeeded { response: log.response });
    }
    let signals = Signals::new(log);
    let [_, validation] = signals.split(options)?;
    let (schedule, point) = parameters(model);
    Ok(Windows::simulate(&signals, &schedule, &point, &validation).fit())
}

/// The speed, m/s, that a model has at each sample of a log from its inputs, gears and grade alone. Each segment of the log
/// begins at its mean measured speed, with lags in the steady state of its first inputs.
///
/// # Errors
/// [`Error::SpeedLogNeeded`] for another log.
pub fn simulate_longitudinal(log: &DriveLog, model: &Longitudinal) -> Result<Vec<f64>, Error> {
    if log.response != Response::Speed {
        return Err(Error::SpeedLogNeeded { response: log.response });
    }
    let signals = Signals::new(log);
    let (schedule, point) = parameters(model);
    let simulation = Simulation::new(&signals, &schedule, point);
    let mut speeds = Vec::with_capacity(log.len());
    for segment in &log.segments {
        let from = segment.range.start;
        let mut lags = simulation.steady(from);
        let mut speed = signals.mean_speed[from];
        for k in segment.range.clone() {
            speeds.push(speed);
            speed = (speed + simulation.increment(&mut lags, from, k, speed)).max(0.0);
        }
    }
    Ok(speeds)
}

/// Smallest, mean and largest speed.
fn speeds(signals: &Signals<'_>, pieces: &[Piece]) -> [f64; 3] {
    let (mut low, mut sum, mut high, mut count) = (f64::INFINITY, 0.0, 0.0_f64, 0.0);
    for piece in pieces {
        for speed in &signals.mean_speed[piece.range.clone()] {
            low = low.min(*speed);
            high = high.max(*speed);
            sum += speed;
            count += 1.0;
        }
    }
    [low, sum / f64::max(count, 1.0), high]
}

/// Name of a parameter in the file.
fn name(schedule: &Schedule, index: usize) -> String {
    match index {
        PEDAL => "pedal_curvature".into(),
        LAG => "time_constant_s".into(),
        DELAY => "delay_s".into(),
        BRAKE_GAIN => "brake.gain_mps2".into(),
        BRAKE_LAG => "brake.time_constant_s".into(),
        BRAKE_DELAY => "brake.delay_s".into(),
        RESISTANCE => "resistance_mps2".into(),
        RESISTANCE_PER_SPEED => "resistance_per_speed".into(),
        DRAG => "drag_per_m".into(),
        GRADE => "grade_coefficient".into(),
        gain => match schedule {
            Schedule::Speeds(_) => format!("gains[{gain}].gain"),
            Schedule::Gears(_) => format!("gear_gains[{gain}].gain"),
        },
    }
}

fn document(
    signals: &Signals<'_>,
    fit: &Fit,
    evidence: LongitudinalEvidence,
    options: &LongitudinalOptions,
) -> Longitudinal {
    let log = signals.log;
    let estimate =
        |i: usize| Estimate { value: fit.point[i], standard_error: fit.standard_error(i) };
    let if_free = |i: usize| if fit.free.contains(&i) { Some(estimate(i)) } else { None };
    let (mut gains, mut gear_gains) = (Vec::new(), Vec::new());
    match &fit.schedule {
        Schedule::Speeds(speeds) => {
            for (i, speed_mps) in speeds.iter().enumerate() {
                gains.push(SpeedGain { speed_mps: *speed_mps, gain: estimate(i) });
            }
        }
        Schedule::Gears(gears) => {
            for (i, gear) in gears.iter().enumerate() {
                gear_gains.push(GearGain { gear: *gear, gain: estimate(i) });
            }
            gains.push(SpeedGain { speed_mps: 0.0, gain: fit.mean_gain() });
        }
    }
    let rows = |i: &usize| fit.free.iter().map(|j| fit.covariance[(*i, *j)]).collect();
    let noise = fit.noise;
    let mut used = log.options.clone();
    used.extend(options.to_map());
    Longitudinal {
        schema: Longitudinal::SCHEMA.into(),
        name: log.name.clone(),
        command_unit: if signals.is_acceleration { "m/s2" } else { "1" }.into(),
        gains,
        gear_gains,
        pedal_curvature: if_free(PEDAL),
        time_constant_s: estimate(LAG),
        delay_s: estimate(DELAY),
        brake: signals.brake.map(|_| Brake {
            gain_mps2: estimate(BRAKE_GAIN),
            time_constant_s: estimate(BRAKE_LAG),
            delay_s: estimate(BRAKE_DELAY),
        }),
        resistance_mps2: estimate(RESISTANCE),
        resistance_per_speed: if_free(RESISTANCE_PER_SPEED),
        drag_per_m: estimate(DRAG),
        grade_source: signals.grade_source.name().into(),
        grade_coefficient: if_free(GRADE),
        noise: LongitudinalNoise {
            speed_mps: noise.speed,
            disturbance_mps2: noise.speed * noise.ratio,
            disturbance_time_constant_s: noise.time,
        },
        parameters: fit.free.iter().map(|i| name(&fit.schedule, *i)).collect(),
        covariance: Matrix(fit.free.iter().map(rows).collect()),
        evidence,
        quality: Quality::default(),
        provenance: Provenance {
            version: env!("CARGO_PKG_VERSION").into(),
            sources: log.sources.clone(),
            options: used,
        },
    }
}

/// The parameters of a file.
fn parameters(model: &Longitudinal) -> (Schedule, Point) {
    let mut point = [0.0; COUNT];
    let schedule = if model.gear_gains.is_empty() {
        for (p, row) in point.iter_mut().zip(&model.gains) {
            *p = row.gain.value;
        }
        Schedule::Speeds(model.gains.iter().map(|row| row.speed_mps).collect())
    } else {
        for (p, row) in point.iter_mut().zip(&model.gear_gains) {
            *p = row.gain.value;
        }
        Schedule::Gears(model.gear_gains.iter().map(|row| row.gear).collect())
    };
    point[PEDAL] = model.pedal_curvature.map_or(0.0, |curvature| curvature.value);
    point[LAG] = model.time_constant_s.value;
    point[DELAY] = model.delay_s.value;
    // Without a brake its lag has no effect, and must not be 0.
    point[BRAKE_LAG] = 1.0;
    if let Some(brake) = &model.brake {
        point[BRAKE_GAIN] = brake.gain_mps2.value;
        point[BRAKE_LAG] = brake.time_constant_s.value;
        point[BRAKE_DELAY] = brake.delay_s.value;
    }
    point[RESISTANCE] = model.resistance_mps2.value;
    point[RESISTANCE_PER_SPEED] = model.resistance_per_speed.map_or(0.0, |c| c.value);
    point[DRAG] = model.drag_per_m.value;
    point[GRADE] = model.grade_coefficient.map_or(1.0, |c| c.value);
    (schedule, point)
}

#[cfg(test)]
mod tests;
