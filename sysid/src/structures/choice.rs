//! The choice of a structure: linear at one speed, the bicycle scheduled by the speed, or the single-track
//! model up to the limit of grip: the one with the smallest error of the yaw rate on the validation data.
//!
//! All are compared on the samples that validate all of them. Structures without a chance are not tried: the speed hardly
//! varies, or the lateral acceleration is that of linear tyres and the bicycle reproduces the drive. A model that diverges
//! on the validation data is none, and a single-track model that is near a spin on its own drive is not chosen.

use crate::Error;
use crate::data::moving::{least_speed, moving};
use crate::error::check_yaw_rate;
use crate::selection::options::IdentifyOptions;
use crate::structures::bicycle::{self, BicycleOptions};
use crate::structures::held::Steering;
use crate::structures::model::IdentifiedModel;
use crate::structures::multivariable::identify_channels;
use crate::structures::single_track::{self, IdentifyVehicleOptions};
use crate::structures::state_space;
use crate::structures::state_space::plant::Traces;
use crate::validation::residuals::fit::{FitWithError, fit_with_error};
use std::borrow::Cow;
use steerwright_drivelog::signal::{mean, standard_deviation};
use steerwright_drivelog::{DriveLog, Response};
use steerwright_formats::{BLOCK_S, LEAST_SPREAD, ReasonCode, Structure};

/// Lateral acceleration to which tyres are linear, m/s²: its 99th percentile.
const LINEAR_MPS2: f64 = 4.0;

/// A structure and what became of it.
#[derive(Debug, Clone, PartialEq)]
pub struct StructureRow {
    /// Which.
    pub structure: Structure,
    /// Fit of yaw rate on the validation samples that all structures have, %, with its standard error; or why there is
    /// no model.
    pub fit: Result<(f64, Option<f64>), String>,
    /// Errors over those of the chosen structure, and the standard error of that ratio, of the block jackknife over
    /// blocks of 3 s.
    pub errors: Option<(f64, f64)>,
    /// Why it is not chosen whatever its fit.
    pub excluded: Option<&'static str>,
}

/// The chosen model with the table of all structures.
#[derive(Debug, Clone, PartialEq)]
pub struct Choice {
    /// The model.
    pub identified: IdentifiedModel,
    /// All structures, the simplest first.
    pub rows: Vec<StructureRow>,
}

/// Options of the structures that a choice has.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct ChoiceOptions {
    /// Of state space.
    pub state_space: IdentifyOptions,
    /// Of the bicycle.
    pub bicycle: BicycleOptions,
    /// Of the single-track model.
    pub single_track: IdentifyVehicleOptions,
}

/// Identifies the structure with the smallest error on the validation data.
///
/// # Errors
/// That of the state space, where no structure gives a model.
pub fn identify_structure(log: &DriveLog, options: &ChoiceOptions) -> Result<Choice, Error> {
    if log.response == Response::Channels {
        let identified = IdentifiedModel::from(identify_channels(log, &options.state_space)?);
        return Ok(Choice { identified, rows: Vec::new() });
    }
    options.bicycle.check()?;
    options.single_track.check()?;
    check_yaw_rate(log)?;
    let stated = options.bicycle.least_speed_mps;
    let least_mps = least_speed(log, stated, options.bicycle.wheelbase_m);
    // All see the same samples: what crawls is left out, unless nothing else is there.
    let (log, too_slow) = match moving(log, least_mps) {
        Ok(moving) => (moving, None),
        Err(error) => (Cow::Borrowed(log), Some(error.to_string())),
    };
    let log = &*log;
    let chance = |no_chance: fn(&DriveLog) -> Option<String>| match &too_slow {
        Some(reason) => Err(reason.clone()),
        None => no_chance(log).map_or(Ok(()), Err),
    };
    let text = |error: Error| error.to_string();
    let steering = Steering::new(log, &options.state_space);
    let plant = state_space::identify_judged(&steering, &options.state_space);
    let first_error = plant.as_ref().err().cloned();
    let bicycle = chance(one_speed).and_then(|()| {
        let found = bicycle::identify_moving(&steering, least_mps, &options.bicycle);
        found.map_err(text).map(IdentifiedModel::from).and_then(bounded)
    });
    // Tyres may be at their limit in turns that are gentle by the lateral acceleration, as on a slippery road.
    let gentle =
        if chance(one_speed).is_ok() && !is_reproduced(&bicycle) { no_speed } else { gentle };
    let vehicle = chance(gentle).and_then(|()| {
        let found = single_track::identify_moving(&steering, least_mps, &options.single_track);
        found.map_err(text).map(IdentifiedModel::from).and_then(bounded)
    });
    let models = vec![
        (Structure::StateSpace, plant.map(IdentifiedModel::from).map_err(text)),
        (Structure::Bicycle, bicycle),
        (Structure::SingleTrack, vehicle),
    ];
    choose(log, models, first_error)
}

/// A model that has a simulated value at each sample of the validation data.
fn bounded(found: IdentifiedModel) -> Result<IdentifiedModel, String> {
    let is_bounded = found.traces.as_ref().is_none_or(|traces| {
        let simulated = traces.simulated_yaw_rate_radps.iter().zip(&traces.is_validation);
        simulated.filter(|(_, is_validation)| **is_validation).all(|(rate, _)| rate.is_finite())
    });
    if is_bounded { Ok(found) } else { Err("the model diverges on the validation data".into()) }
}

/// Whether there is a model whose fit on the validation data is no reason to doubt it.
fn is_reproduced(found: &Result<IdentifiedModel, String>) -> bool {
    found.as_ref().is_ok_and(|found| {
        let reasons = &found.model.quality().reasons;
        reasons.iter().all(|reason| reason.code != ReasonCode::LowValidationFit)
    })
}

fn no_speed(log: &DriveLog) -> Option<String> {
    let has_speed = log.speed.as_ref().is_some_and(|v| v.len() == log.len() && !v.is_empty());
    if has_speed { None } else { Some("the log has no speed".into()) }
}

/// Why a bicycle that is scheduled by the speed cannot be better than a model of one speed.
fn one_speed(log: &DriveLog) -> Option<String> {
    if let Some(reason) = no_speed(log) {
        return Some(reason);
    }
    let speed = log.speed.as_deref().unwrap_or_default();
    let (level, spread) = (mean(speed), standard_deviation(speed));
    if spread < LEAST_SPREAD * level {
        return Some(format!("the speed hardly varies ({level:.1} m/s ± {spread:.1})"));
    }
    None
}

/// Why a model of the limit of grip cannot be better than one of linear tyres.
fn gentle(log: &DriveLog) -> Option<String> {
    if let Some(reason) = no_speed(log) {
        return Some(reason);
    }
    let speed = log.speed.as_deref().unwrap_or_default();
    let mut lateral: Vec<f64> = speed.iter().zip(&log.output).map(|(v, r)| (v * r).abs()).collect();
    lateral.sort_by(f64::total_cmp);
    let largest = lateral[(0.99 * (lateral.len() - 1) as f64) as usize];
    if largest < LINEAR_MPS2 {
        return Some(format!(
            "not tried: the lateral acceleration of {largest:.1} m/s² is below {LINEAR_MPS2} m/s²"
        ));
    }
    None
}

fn choose(
    log: &DriveLog,
    models: Vec<(Structure, Result<IdentifiedModel, String>)>,
    error: Option<Error>,
) -> Result<Choice, Error> {
    let mut exclusions = Vec::new();
    let mut traces: Vec<&Traces> = Vec::new();
    for (_, model) in &models {
        if let Ok(IdentifiedModel { traces: Some(signals), .. }) = model {
            exclusions.extend(model.as_ref().map(IdentifiedModel::exclusion));
            traces.push(signals);
        }
    }
    let common: Vec<usize> =
        (0..log.len()).filter(|&k| traces.iter().all(|t| t.is_validation[k])).collect();
    let of = |signal: &[f64]| -> Vec<f64> { common.iter().map(|&k| signal[k]).collect() };
    let measured = of(&log.output);
    let simulated: Vec<Vec<f64>> = traces.iter().map(|t| of(&t.simulated_yaw_rate_radps)).collect();
    let fits: Vec<FitWithError> =
        simulated.iter().map(|y| fit_with_error(&[(&measured, y)], log.sample_time_s)).collect();
    let may_be_chosen = (0..fits.len()).filter(|&place| exclusions[place].is_none());
    // A simulation that leaves all numbers has no fit. The simplest of equal ones comes first.
    let fit = |place: usize| if fits[place].fit.is_nan() { f64::MIN } else { fits[place].fit };
    let best = may_be_chosen.min_by(|&a, &b| fit(b).total_cmp(&fit(a)));
    let (mut rows, mut chosen, mut place) = (Vec::new(), None, 0);
    for (structure, model) in models {
        let mut row =
            StructureRow { structure, fit: Ok((0.0, None)), errors: None, excluded: None };
        match model {
            Ok(model) => {
                row.fit = Ok((fits[place].fit, fits[place].standard_error));
                row.excluded = exclusions[place];
                row.errors = best.map(|best| {
                    growth(&measured, &simulated[place], &simulated[best], log.sample_time_s)
                });
                if best == Some(place) {
                    chosen = Some(model);
                }
                place += 1;
            }
            Err(reason) => row.fit = Err(reason),
        }
        rows.push(row);
    }
    match (chosen, error) {
        (Some(identified), _) => Ok(Choice { identified, rows }),
        (None, Some(error)) => Err(error),
        (None, None) => Err(Error::no_model("no structure gives a model")),
    }
}

/// RMS error of a simulation over that of another, with the standard error of the block jackknife.
fn growth(measured: &[f64], of: &[f64], other: &[f64], sample_time_s: f64) -> (f64, f64) {
    let length = ((BLOCK_S / sample_time_s).ceil() as usize).max(1);
    let square = |y: &[f64], at: usize| -> f64 {
        let range = at..(at + length).min(measured.len());
        measured[range.clone()].iter().zip(&y[range]).map(|(a, b)| (a - b) * (a - b)).sum()
    };
    let blocks: Vec<[f64; 2]> =
        (0..measured.len()).step_by(length).map(|at| [square(of, at), square(other, at)]).collect();
    let total = blocks.iter().fold([0.0; 2], |t, b| [t[0] + b[0], t[1] + b[1]]);
    let ratio = |[a, b]: [f64; 2]| (a.max(0.0) / b.max(f64::MIN_POSITIVE)).sqrt();
    let without: Vec<f64> =
        blocks.iter().map(|b| ratio([total[0] - b[0], total[1] - b[1]])).collect();
    let middle = mean(&without);
    let count = without.len().max(1) as f64;
    let scatter: f64 = without.iter().map(|r| (r - middle) * (r - middle)).sum();
    (ratio(total), (scatter * (count - 1.0) / count).sqrt())
}

#[cfg(test)]
mod tests {
    use super::*;
    use steerwright_drivelog::{LogOptions, read_log};
    use steerwright_formats::{Document, Model, Vehicle};

    fn log() -> DriveLog {
        let mut csv = String::from("time_s,roadwheel_angle_rad,yaw_rate_radps,speed_mps\n");
        for k in 0..2000 {
            let t = 0.01 * f64::from(k);
            csv += &format!("{t:.2},{:.6},{:.6},20\n", 0.05 * t.sin(), 0.3 * t.sin());
        }
        read_log(&[("log.csv".into(), csv.into_bytes())], &LogOptions::default()).unwrap()
    }

    /// A vehicle with a spin margin, whose yaw rate is by a share too large.
    fn vehicle(log: &DriveLog, spin_margin: f64, share: f64) -> IdentifiedModel {
        let text = include_str!("../../../examples/drives/multibody/vehicle.json");
        let evidence = format!(
            r#"{{"channels": [], "estimation_samples": 1, "validation_samples": 1, "sample_time_s": 0.01,
            "speed": {{"min_mps": 20, "mean_mps": 20, "max_mps": 20, "standard_deviation_mps": 0}},
            "lateral_acceleration_mps2": 6, "fitted": [], "estimation": {{"yaw_rate": 99, "worst_window_radps": 0}},
            "parameters": [], "covariance": [], "directions": [], "largest_steering_rate_radps": 0.1,
            "spin_margin": {spin_margin}, "warnings": []}}"#
        );
        let mut vehicle = Vehicle::from_json(text, "vehicle.json").unwrap();
        vehicle.evidence = Some(serde_json::from_str(&evidence).unwrap());
        let simulated = log.output.iter().map(|rate| (1.0 + share) * rate).collect();
        let validation = log.len() / 2..log.len();
        IdentifiedModel {
            model: Model::SingleTrack(vehicle.into()),
            traces: Some(Traces::new(log, simulated, std::slice::from_ref(&validation))),
            channels: None,
        }
    }

    /// A model without a value at some of the validation data is none, however well it fits elsewhere.
    #[test]
    fn what_diverges_is_not_chosen() {
        let log = log();
        let mut diverged = vehicle(&log, 0.2, 0.0);
        let traces = diverged.traces.as_mut().unwrap();
        traces.simulated_yaw_rate_radps[10] = f64::NAN;
        assert!(bounded(diverged.clone()).is_ok(), "of the estimation data");
        let traces = diverged.traces.as_mut().unwrap();
        traces.simulated_yaw_rate_radps[log.len() - 1] = f64::NAN;
        let diverged = bounded(diverged);
        assert!(!is_reproduced(&diverged));
        let good = bounded(vehicle(&log, 0.2, 0.05));
        assert!(is_reproduced(&good));
        let models = vec![(Structure::Bicycle, diverged), (Structure::SingleTrack, good)];
        let found = choose(&log, models, None).unwrap();
        assert_eq!(found.identified.model.structure(), Structure::SingleTrack);
        assert!(found.rows[0].fit.as_ref().unwrap_err().contains("diverges"));
    }

    /// Of two vehicles the better one is chosen, but not where it spins with hardly less friction.
    #[test]
    fn what_nearly_spins_is_not_chosen() {
        let log = log();
        let chosen = |margin: f64| {
            let models = vec![
                (Structure::Bicycle, Ok(vehicle(&log, 0.2, 0.05))),
                (Structure::SingleTrack, Ok(vehicle(&log, margin, 0.01))),
            ];
            let found = choose(&log, models, None).unwrap();
            let excluded: Vec<bool> = found.rows.iter().map(|row| row.excluded.is_some()).collect();
            let Model::SingleTrack(vehicle) = &found.identified.model else { panic!() };
            (vehicle.evidence.as_ref().unwrap().spin_margin, excluded)
        };
        assert_eq!(chosen(0.02), (0.02, vec![false, false]));
        assert_eq!(chosen(0.015), (0.2, vec![false, true]));
    }
}
