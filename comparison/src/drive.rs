//! The models compared with a drive (the paper's Fig. 3): simulated yaw rate and yaw on the validation
//! data.

use crate::Error;
use crate::model::validate_model;
use crate::models::ComparedModel;
use steerwright_drivelog::DriveLog;
use steerwright_formats::SourceFile;
use steerwright_sysid::sideslip::unused_fixes;
use steerwright_sysid::{IdentifyOptions, Validated, fit_percent, variance_accounted_for};

/// The validation data of a drive. Each gap is a NaN.
#[allow(missing_docs)]
pub struct ComparedDrive {
    pub name: String,
    pub sources: Vec<SourceFile>,
    pub sample_time_s: f64,
    pub samples: usize,
    pub time_s: Vec<f64>,
    /// Measured yaw rate, rad/s.
    pub yaw_rate_radps: Vec<f64>,
    /// Its integral, rad.
    pub yaw_rad: Vec<f64>,
    /// In the order of the models.
    pub models: Vec<OnDrive>,
    /// What limits the result.
    pub remarks: Vec<String>,
}

/// The simulation of a drive by a model, from the steering alone.
#[allow(missing_docs)]
pub struct OnDrive {
    pub fit_percent: f64,
    /// Share of the yaw rate's variance that the simulation accounts for, percent.
    pub variance_accounted_for_percent: f64,
    pub yaw_rate_rms_radps: f64,
    /// RMS of the yaw's error, rad; both are integrated from the start of the validation data.
    pub yaw_rms_rad: f64,
    pub yaw_rate_radps: Vec<f64>,
    pub yaw_rad: Vec<f64>,
}

/// Validates every model on the end of the log.
pub(crate) fn validate(
    models: &[ComparedModel],
    log: &DriveLog,
    options: &IdentifyOptions,
) -> Result<ComparedDrive, Error> {
    let mut remarks = log.warnings.clone();
    remarks.extend(unused_fixes(log, "the sideslip of each plant is read from a turn"));
    let mut validated = Vec::new();
    for model in models {
        validated.push(on_log(model, log, options).map_err(|e| e.within(&model.label))?);
        remarks.extend(remark(model, log, options));
    }
    let first = validated.iter().map(|j| j.first_validation_sample).max().unwrap_or(0);
    let gaps: Vec<usize> =
        log.segments.iter().map(|s| s.range.start).filter(|k| *k > first).collect();
    let validation = |values: &[f64]| -> Vec<f64> {
        let mut out = Vec::with_capacity(values.len() - first + gaps.len());
        for (k, value) in values.iter().enumerate().skip(first) {
            if gaps.contains(&k) {
                out.push(f64::NAN);
            }
            out.push(*value);
        }
        out
    };
    // Both yaws start where the validation data start.
    let yaw_of = |rate: &[f64]| -> Vec<f64> {
        let yaw = log.yaw(rate);
        let from = yaw.get(first).copied().unwrap_or(0.0);
        yaw.iter().map(|yaw| yaw - from).collect()
    };
    let yaw = yaw_of(&log.output);
    let on_drive = |j: Validated| {
        let rate = &j.simulated_yaw_rate_radps;
        let simulated = yaw_of(rate);
        OnDrive {
            fit_percent: fit_percent(&log.output[first..], &rate[first..]),
            variance_accounted_for_percent: variance_accounted_for(
                &log.output[first..],
                &rate[first..],
            ),
            yaw_rate_rms_radps: rms(&log.output[first..], &rate[first..]),
            yaw_rms_rad: rms(&yaw[first..], &simulated[first..]),
            yaw_rate_radps: validation(rate),
            yaw_rad: validation(&simulated),
        }
    };
    Ok(ComparedDrive {
        name: log.name.clone(),
        sources: log.sources.clone(),
        sample_time_s: log.sample_time_s,
        samples: log.len() - first,
        time_s: validation(&log.time_s()),
        yaw_rate_radps: validation(&log.output),
        yaw_rad: validation(&yaw),
        models: validated.into_iter().map(on_drive).collect(),
        remarks,
    })
}

fn on_log(
    model: &ComparedModel,
    log: &DriveLog,
    options: &IdentifyOptions,
) -> Result<Validated, Error> {
    let ratio = model.design.steering_ratio / log.steering_ratio;
    if !(0.8..=1.25).contains(&ratio) {
        return Err(Error::LogSteeringRatio {
            model: model.design.steering_ratio,
            log: log.steering_ratio,
        });
    }
    validate_model(&model.document, log, options)
}

/// A warning, if the model was estimated on the validation data.
fn remark(model: &ComparedModel, log: &DriveLog, options: &IdentifyOptions) -> Option<String> {
    let provenance = model.document.provenance()?;
    let own = provenance.sources.iter().any(|s| log.sources.iter().any(|l| l.sha256 == s.sha256));
    let own_fraction: Option<f64> =
        provenance.options.get("validation_fraction").and_then(|text| text.parse().ok());
    let seen = own_fraction.is_some_and(|h| h < options.validation.fraction - 1e-9);
    if own && seen {
        Some(format!(
            "{} was estimated on a part of these validation data: validate on {} % of the log",
            model.label,
            100.0 * own_fraction.unwrap_or_default()
        ))
    } else {
        None
    }
}

fn rms(a: &[f64], b: &[f64]) -> f64 {
    let sum: f64 = a.iter().zip(b).map(|(a, b)| (a - b).powi(2)).sum();
    (sum / a.len().max(1) as f64).sqrt()
}
