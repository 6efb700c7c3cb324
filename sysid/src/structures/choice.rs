//! The choice of a structure: linear at one speed, the bicycle scheduled by the speed, or the single-track
//! model up to the limit of grip. The simplest that the validation data do not reject is chosen.
//!
//! A structure is rejected where a less simple one has smaller errors of the yaw rate on the validation data,
//! by more than a share and by more than two standard errors, of the block jackknife over blocks of 3 s. Structures
//! without a chance are not tried: the speed hardly varies, or the lateral acceleration is that of linear tyres.
//! The single-track model is tried for comparison only, as long as its file is not the model that was validated.

use crate::Error;
use crate::data::moving::{least_speed, moving};
use crate::error::check_yaw_rate;
use crate::selection::options::IdentifyOptions;
use crate::structures::bicycle::{self, BicycleOptions};
use crate::structures::held::Steering;
use crate::structures::model::IdentifiedModel;
use crate::structures::single_track::quality::NOT_AS_VALIDATED;
use crate::structures::single_track::{self, IdentifyVehicleOptions};
use crate::structures::state_space;
use crate::structures::state_space::plant::Traces;
use crate::validation::fit::{FitWithError, fit_with_error};
use std::borrow::Cow;
use steerwright_drivelog::DriveLog;
use steerwright_drivelog::signal::{mean, standard_deviation};
use steerwright_formats::{BLOCK_S, LEAST_SPREAD, Structure};

/// Lateral acceleration to which tyres are linear, m/s²: its 99th percentile.
const LINEAR_MPS2: f64 = 4.0;
/// Growth of the errors from which a structure is rejected, if it is beyond two standard errors.
const LARGEST_GROWTH: f64 = 1.05;

/// A structure and what became of it.
#[derive(Debug, Clone, PartialEq)]
pub struct StructureRow {
    /// Which.
    pub structure: Structure,
    /// Fit of yaw rate on the validation samples that all structures have, %, with its standard error; or why there is
    /// no model.
    pub fit: Result<(f64, Option<f64>), String>,
    /// Errors over those of the best structure that may be chosen, and the standard error of that ratio.
    pub errors: Option<(f64, f64)>,
    /// Whether the validation data reject it.
    pub is_rejected: bool,
    /// Why it is not chosen whatever the data.
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

/// Identifies the simplest structure that the validation data do not reject.
///
/// # Errors
/// That of the state space, where no structure gives a model.
pub fn identify_structure(log: &DriveLog, options: &ChoiceOptions) -> Result<Choice, Error> {
    check_yaw_rate(log)?;
    let stated = options.bicycle.least_speed_mps;
    let least_mps = least_speed(log, stated, options.bicycle.wheelbase_m);
    // All see the same samples: what crawls is left out, unless nothing else is there.
    let (log, too_slow) = match moving(log, least_mps) {
        Ok(moving) => (moving, None),
        Err(error) => (Cow::Borrowed(log), Some(error.to_string())),
    };
    let log = &*log;
    let chance = |structure| match &too_slow {
        Some(reason) => Err(reason.clone()),
        None => no_chance(log, structure).map_or(Ok(()), Err),
    };
    let text = |error: Error| error.to_string();
    let steering = Steering::new(log, &options.state_space);
    let plant = state_space::identify_judged(&steering, &options.state_space);
    let first_error = plant.as_ref().err().cloned();
    let bicycle = chance(Structure::Bicycle).and_then(|()| {
        bicycle::identify_moving(&steering, least_mps, &options.bicycle).map_err(text)
    });
    let vehicle = chance(Structure::SingleTrack).and_then(|()| {
        single_track::identify_moving(&steering, least_mps, &options.single_track).map_err(text)
    });
    let models = vec![
        (Structure::StateSpace, plant.map(IdentifiedModel::from).map_err(text)),
        (Structure::Bicycle, bicycle.map(IdentifiedModel::from)),
        (Structure::SingleTrack, vehicle.map(IdentifiedModel::from)),
    ];
    choose(log, models, first_error)
}

/// Why a structure is not chosen whatever the data.
fn exclusion(structure: Structure) -> Option<&'static str> {
    match structure {
        Structure::StateSpace | Structure::Bicycle | Structure::Torque => None,
        Structure::SingleTrack => Some(NOT_AS_VALIDATED),
    }
}

/// Why a structure cannot be better than a simpler one on this log.
fn no_chance(log: &DriveLog, structure: Structure) -> Option<String> {
    let Some(speed) = log.speed.as_ref().filter(|v| v.len() == log.len() && !v.is_empty()) else {
        return Some("the log has no speed".into());
    };
    let (level, spread) = (mean(speed), standard_deviation(speed));
    if structure == Structure::Bicycle {
        return (spread < LEAST_SPREAD * level)
            .then(|| format!("the speed hardly varies ({level:.1} m/s ± {spread:.1})"));
    }
    let mut lateral: Vec<f64> = speed.iter().zip(&log.output).map(|(v, r)| (v * r).abs()).collect();
    lateral.sort_by(f64::total_cmp);
    let largest = lateral[(0.99 * (lateral.len() - 1) as f64) as usize];
    (largest < LINEAR_MPS2).then(|| format!("{largest:.1} m/s² is no limit of grip"))
}

fn choose(
    log: &DriveLog,
    models: Vec<(Structure, Result<IdentifiedModel, String>)>,
    error: Option<Error>,
) -> Result<Choice, Error> {
    let mut simulated_structures = Vec::new();
    let mut traces: Vec<&Traces> = Vec::new();
    for (structure, model) in &models {
        if let Ok(IdentifiedModel { traces: Some(signals), .. }) = model {
            simulated_structures.push(*structure);
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
    let mut best: Option<usize> = None;
    for (place, structure) in simulated_structures.iter().enumerate() {
        let is_better = best.is_none_or(|best| fits[place].fit > fits[best].fit);
        if exclusion(*structure).is_none() && is_better {
            best = Some(place);
        }
    }
    let mut rows = Vec::new();
    let mut place = 0;
    for (structure, model) in &models {
        let fit = model.as_ref().map(|_| (fits[place].fit, fits[place].standard_error));
        let errors = best
            .filter(|_| model.is_ok())
            .map(|best| growth(&measured, &simulated[place], &simulated[best], log.sample_time_s));
        place += usize::from(model.is_ok());
        rows.push(StructureRow {
            structure: *structure,
            fit: fit.map_err(Clone::clone),
            errors,
            is_rejected: errors
                .is_some_and(|(ratio, error)| ratio > LARGEST_GROWTH && ratio - 1.0 > 2.0 * error),
            excluded: exclusion(*structure),
        });
    }
    let mut chosen = None;
    for ((_, model), row) in models.into_iter().zip(&rows) {
        if chosen.is_none() && !row.is_rejected && row.excluded.is_none() {
            chosen = model.ok();
        }
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
