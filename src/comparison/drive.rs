//! The models against a drive (the paper's Fig. 3): simulated yaw rate and yaw over its held-out end.

use super::models::{Kind, Model};
use crate::failure::Failure;
use drivelog::DriveLog;
use formats::SourceFile;
use sysid::{IdentifyOptions, Judged, fit_percent, variance_accounted_for};

/// The held-out end of a drive. A NaN stands in every gap.
pub(crate) struct Drive {
    pub(crate) name: String,
    pub(crate) sources: Vec<SourceFile>,
    pub(crate) sample_time_s: f64,
    /// Samples judged on.
    pub(crate) samples: usize,
    pub(crate) time_s: Vec<f64>,
    pub(crate) yaw_rate_radps: Vec<f64>,
    pub(crate) yaw_rad: Vec<f64>,
    /// In the order of the models.
    pub(crate) models: Vec<OnDrive>,
    pub(crate) remarks: Vec<String>,
}

/// How a model follows the drive from its steering alone.
pub(crate) struct OnDrive {
    /// Fit of the yaw rate, percent.
    pub(crate) fit_percent: f64,
    /// Share of the yaw rate's variance that the simulation accounts for, percent.
    pub(crate) variance_accounted_for_percent: f64,
    /// RMS of the yaw rate's error, rad/s.
    pub(crate) yaw_rate_rms_radps: f64,
    /// RMS of the yaw's error, rad; both are integrated from the start of the held-out end.
    pub(crate) yaw_rms_rad: f64,
    pub(crate) yaw_rate_radps: Vec<f64>,
    pub(crate) yaw_rad: Vec<f64>,
}

/// Judges every model on the log's held-out end.
pub(crate) fn judge(
    models: &[Model],
    log: &DriveLog,
    options: &IdentifyOptions,
) -> Result<Drive, Failure> {
    let mut remarks = [log.warnings.clone(), sysid::sideslip::sideslip(log).warnings].concat();
    let mut judged = Vec::new();
    for model in models {
        judged.push(judged_on(model, log, options).map_err(|e| e.about(&model.label))?);
        remarks.extend(remark(model, log, options));
    }
    let first = judged.iter().map(|j| j.first_held_out).max().unwrap_or(0);
    let gaps: Vec<usize> =
        log.segments.iter().map(|s| s.range.start).filter(|k| *k > first).collect();
    let held_out = |values: &[f64]| -> Vec<f64> {
        let mut out = Vec::with_capacity(values.len() - first + gaps.len());
        for (k, value) in values.iter().enumerate().skip(first) {
            if gaps.contains(&k) {
                out.push(f64::NAN);
            }
            out.push(*value);
        }
        out
    };
    // Both yaws start where the held-out end starts.
    let yaw_of = |rate: &[f64]| -> Vec<f64> {
        let yaw = log.yaw(rate);
        let from = yaw.get(first).copied().unwrap_or(0.0);
        yaw.iter().map(|yaw| yaw - from).collect()
    };
    let yaw = yaw_of(&log.output);
    let on_drive = |j: Judged| {
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
            yaw_rate_radps: held_out(rate),
            yaw_rad: held_out(&simulated),
        }
    };
    Ok(Drive {
        name: log.name.clone(),
        sources: log.sources.clone(),
        sample_time_s: log.sample_time_s,
        samples: log.len() - first,
        time_s: held_out(&log.time_s()),
        yaw_rate_radps: held_out(&log.output),
        yaw_rad: held_out(&yaw),
        models: judged.into_iter().map(on_drive).collect(),
        remarks,
    })
}

fn judged_on(model: &Model, log: &DriveLog, options: &IdentifyOptions) -> Result<Judged, Failure> {
    let ratio = model.design.steering_ratio / log.steering_ratio;
    if !(0.8..=1.25).contains(&ratio) {
        return Err(Failure::new(
            format!(
                "it has a steering ratio of {}, the log of {}",
                model.design.steering_ratio, log.steering_ratio
            ),
            "state the log's --steering-ratio, or give the column of the same steering angle with \
             --input",
        ));
    }
    Ok(match &model.document {
        Kind::Identified(plant) => sysid::judge_plant(log, options, plant)?,
        Kind::Bicycle(bicycle) => sysid::bicycle::judge_bicycle(log, options, bicycle)?,
    })
}

/// What has to be said of a model on this drive.
fn remark(model: &Model, log: &DriveLog, options: &IdentifyOptions) -> Option<String> {
    let provenance = model.provenance();
    let own = provenance.sources.iter().any(|s| log.sources.iter().any(|l| l.sha256 == s.sha256));
    let held_out: Option<f64> =
        provenance.options.get("validation_fraction").and_then(|text| text.parse().ok());
    let seen = held_out.is_some_and(|h| h < options.validation_fraction - 1e-9);
    (own && seen).then(|| {
        format!(
            "{} was estimated on a part of what is held out here: give --hold-out {}%",
            model.label,
            100.0 * held_out.unwrap_or_default()
        )
    })
}

fn rms(a: &[f64], b: &[f64]) -> f64 {
    let sum: f64 = a.iter().zip(b).map(|(a, b)| (a - b).powi(2)).sum();
    (sum / a.len().max(1) as f64).sqrt()
}
