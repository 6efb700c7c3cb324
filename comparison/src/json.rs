//! A comparison as JSON, in SI units.

use crate::compare::Comparison;
use crate::outcome::Outcome;
use crate::verdict::Verdict;
use serde::Serialize;
use steerwright_formats::{Guidance, LoopCoupling, PidGains, SourceFile, StepMetrics};

/// A comparison for scripts.
#[derive(Serialize)]
pub struct Overview<'a> {
    version: &'static str,
    coupling: LoopCoupling,
    sample_time_s: f64,
    road: RoadOverview<'a>,
    models: Vec<ModelOverview<'a>>,
    controllers: Vec<ControllerOverview<'a>>,
    plants: Vec<PlantOverview<'a>>,
    runs: Vec<RunOverview<'a>>,
    verdict: &'a Verdict,
    remarks: &'a [String],
    /// Read.
    sources: &'a [SourceFile],
    /// Written, below the output folder.
    files: &'a [SourceFile],
}

#[derive(Serialize)]
struct RoadOverview<'a> {
    name: &'a str,
    length_m: f64,
    speed_mps: f64,
    largest_lateral_acceleration_mps2: f64,
    max_cross_track_error_m: f64,
    /// How it was made.
    options: &'a std::collections::BTreeMap<String, String>,
}

#[derive(Serialize)]
struct ModelOverview<'a> {
    name: &'a str,
    file: &'a SourceFile,
    kind: String,
    speed_mps: f64,
    steering_ratio: f64,
    /// Absent without a drive.
    held_out: Option<OnDriveOverview>,
}

#[derive(Serialize)]
struct OnDriveOverview {
    samples: usize,
    fit_percent: f64,
    variance_accounted_for_percent: f64,
    yaw_rate_error_rms_radps: f64,
    yaw_error_rms_rad: f64,
}

#[derive(Serialize)]
struct ControllerOverview<'a> {
    name: &'a str,
    model: &'a str,
    /// Absent where it was designed here.
    file: Option<&'a SourceFile>,
    gains: &'a PidGains,
    guidance: Guidance,
    limits: &'a steerwright_formats::Limits,
    specification: &'a steerwright_formats::Specification,
    met_on_its_model: bool,
    margins: &'a steerwright_formats::Margins,
    predicted_step: &'a StepMetrics,
}

#[derive(Serialize)]
struct PlantOverview<'a> {
    name: &'a str,
    is_truth: bool,
    gain_per_s: f64,
    sideslip_per_yaw_rate_s: f64,
    sideslip_per_yaw_acceleration_s2: f64,
}

#[derive(Serialize)]
struct RunOverview<'a> {
    controller: &'a str,
    plant: &'a str,
    own_plant: bool,
    off_path_at_m: Option<f64>,
    cross_track_rms_m: f64,
    cross_track_largest_m: f64,
    yaw_error_rms_rad: f64,
    yaw_error_largest_rad: f64,
    steering_largest_rad: f64,
    steering_rate_rms_radps: f64,
    steering_rate_largest_radps: f64,
    modulus_margin: Option<f64>,
    step: &'a StepMetrics,
    step_meets_specification: bool,
    #[serde(flatten)]
    outcome: &'a Outcome,
}

/// The comparison for scripts; `files` were written.
#[must_use]
pub fn json<'a>(c: &'a Comparison, files: &'a [SourceFile]) -> Overview<'a> {
    let on_drive = |index: usize| {
        let drive = c.drive.as_ref()?;
        let d = drive.models.get(index)?;
        Some(OnDriveOverview {
            samples: drive.samples,
            fit_percent: d.fit_percent,
            variance_accounted_for_percent: d.variance_accounted_for_percent,
            yaw_rate_error_rms_radps: d.yaw_rate_rms_radps,
            yaw_error_rms_rad: d.yaw_rms_rad,
        })
    };
    let models = c.models.iter().enumerate().map(|(index, m)| ModelOverview {
        name: &m.label,
        file: &m.source,
        kind: m.kind(),
        speed_mps: m.design.speed,
        steering_ratio: m.design.steering_ratio,
        held_out: on_drive(index),
    });
    let controllers = c.controllers.iter().map(|k| ControllerOverview {
        name: &k.label,
        model: &c.models[k.model].label,
        file: k.source.as_ref(),
        gains: &k.pid.gains,
        guidance: k.guidance(&c.road),
        limits: &k.pid.limits,
        specification: &k.pid.specification,
        met_on_its_model: k.pid.evidence.met,
        margins: &k.pid.evidence.margins,
        predicted_step: &k.predicted,
    });
    let plants = c.plants.iter().map(|p| PlantOverview {
        name: &p.label,
        is_truth: p.model.is_none(),
        gain_per_s: p.gain,
        sideslip_per_yaw_rate_s: p.sideslip.per_yaw_rate,
        sideslip_per_yaw_acceleration_s2: p.sideslip.per_yaw_acceleration,
    });
    let runs = c.runs.iter().map(|r| RunOverview {
        controller: &c.controllers[r.controller].label,
        plant: &c.plants[r.plant].label,
        own_plant: c.is_own(r),
        off_path_at_m: r.off_path_at_m,
        cross_track_rms_m: r.errors.cross_track_rms_m,
        cross_track_largest_m: r.errors.cross_track_max_m,
        yaw_error_rms_rad: r.errors.heading_rms_rad,
        yaw_error_largest_rad: r.errors.heading_max_rad,
        steering_largest_rad: r.effort.angle_max_rad,
        steering_rate_rms_radps: r.effort.rate_rms_radps,
        steering_rate_largest_radps: r.effort.rate_max_radps,
        modulus_margin: r.modulus_margin,
        step: &r.step,
        step_meets_specification: c.outcome(r).shortfalls.is_empty(),
        outcome: c.outcome(r),
    });
    Overview {
        version: env!("CARGO_PKG_VERSION"),
        coupling: c.coupling,
        sample_time_s: c.controllers.first().map_or(0.0, |k| k.pid.sample_time_s),
        road: RoadOverview {
            name: &c.road.name,
            length_m: c.length(),
            speed_mps: c.road.speed_mps,
            largest_lateral_acceleration_mps2: c.lateral_acceleration(),
            max_cross_track_error_m: c.max_cross_track_error_m,
            options: &c.road.provenance.options,
        },
        models: models.collect(),
        controllers: controllers.collect(),
        plants: plants.collect(),
        runs: runs.collect(),
        verdict: &c.verdict,
        remarks: &c.remarks,
        sources: &c.sources,
        files,
    }
}
