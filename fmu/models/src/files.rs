//! From the files of the stages to the models that run in the FMUs.
//!
//! Design and FMUs both read their files by these functions: a controller that was tuned on a file
//! is the one that runs from it. Nothing is computed here and no unit changes: SI and radians on
//! both sides. Matrices go from rows of rows to row-major vectors.

use crate::bicycle::BicycleParameters;
use crate::error::Error;
use crate::guidance::GuidanceParameters;
use crate::identified::{Continuous, IdentifiedData, IdentifiedModel};
use crate::longitudinal::LongitudinalParameters;
use crate::nonlinear::NonlinearParameters;
use crate::path::{PathGeometry, SpeedReference};
use crate::pid::PidParameters;
use crate::pose::PoseParameters;
use crate::quadrature::Pose;
use crate::schedule::{GuidanceSchedule, PidSchedule};
use crate::sideslip::Sideslip;
use steerwright_formats::{
    Estimator, Guidance, GuidanceEntry, Limits, Longitudinal, Matrix, Path, Pid, PidGains, Plant,
    ScheduleEntry, Vehicle, VehicleData,
};

/// The identified model of `plant.json`.
///
/// # Errors
/// Names the matrix or quantity that cannot be, or that contradicts another (eq 9–11).
pub fn identified_model(plant: &Plant) -> Result<IdentifiedModel, Error> {
    let discrete = &plant.discrete;
    let point = &plant.operating_point;
    IdentifiedModel::new(IdentifiedData {
        sample_time: discrete.sample_time_s,
        a: entries(&discrete.a),
        b: entries(&discrete.b),
        c: entries(&discrete.c),
        d: discrete.d.entry(0, 0),
        k: entries(&discrete.k),
        continuous: plant.continuous.as_ref().map(|c| Continuous {
            f: entries(&c.f),
            g: entries(&c.g),
            h: entries(&c.h),
        }),
        input: plant.input,
        delay: plant.input_delay_s,
        steering_offset: point.steering_offset_rad,
        yaw_rate_offset: point.yaw_rate_offset_radps,
        speed: point.speed_mps,
        innovation_std: plant.noise.innovation_variance.sqrt(),
        sideslip: match &plant.sideslip {
            Some(stated) => sideslip(stated, point.speed_mps),
            None => Sideslip::default(),
        },
    })
}

/// The sideslip that a model's document states; `speed` in m/s is that of the document, where it states no other.
#[must_use]
pub fn sideslip(stated: &steerwright_formats::Sideslip, speed: f64) -> Sideslip {
    Sideslip {
        per_yaw_rate: stated.sideslip_per_yaw_rate_s,
        growth: stated.growth(),
        per_yaw_acceleration: stated.per_yaw_acceleration(),
        reference_speed: stated.speed_mps.unwrap_or(speed),
        distance_rear: stated.distance_rear(),
    }
}

/// The vehicle of `bicycle.json`. Its speed is no parameter but an input of the plant.
#[must_use]
pub fn bicycle_parameters(vehicle: &VehicleData) -> BicycleParameters {
    vehicle.into()
}

/// The vehicle of `vehicle.json`. Its speed is no parameter but an input.
#[must_use]
pub fn nonlinear_parameters(vehicle: &Vehicle) -> NonlinearParameters {
    NonlinearParameters { body: vehicle.body, tyres: vehicle.tyres, actuator: vehicle.actuator }
}

/// The parameters of `longitudinal.json`; its gains are read where they are.
#[must_use]
pub fn longitudinal_parameters(model: &Longitudinal) -> LongitudinalParameters {
    let mut parameters = LongitudinalParameters {
        pedal_curvature: 0.0,
        time_constant: model.time_constant_s.value,
        delay: model.delay_s.value,
        brake_gain: 0.0,
        // Without a brake its lag has no effect, and must not be 0.
        brake_time_constant: 1.0,
        brake_delay: 0.0,
        resistance: model.resistance_mps2.value,
        resistance_per_speed: 0.0,
        drag: model.drag_per_m.value,
        grade_coefficient: 1.0,
    };
    if let Some(curvature) = model.pedal_curvature {
        parameters.pedal_curvature = curvature.value;
    }
    if let Some(brake) = &model.brake {
        parameters.brake_gain = brake.gain_mps2.value;
        parameters.brake_time_constant = brake.time_constant_s.value;
        parameters.brake_delay = brake.delay_s.value;
    }
    if let Some(resistance) = model.resistance_per_speed {
        parameters.resistance_per_speed = resistance.value;
    }
    if let Some(coefficient) = model.grade_coefficient {
        parameters.grade_coefficient = coefficient.value;
    }
    parameters
}

/// The controller of `pid.json`, at the speed of the design.
#[must_use]
pub fn pid_parameters(pid: &Pid) -> PidParameters {
    controller_parameters(&pid.gains, &pid.limits, pid.sample_time_s)
}

/// The controller of `pid.json` over speed; `None` where one set of gains holds at every speed.
#[must_use]
pub fn pid_schedule(pid: &Pid) -> Option<PidSchedule> {
    let at = |entry: &ScheduleEntry| {
        let mut now = controller_parameters(&entry.gains, &pid.limits, pid.sample_time_s);
        if let Some(lag) = entry.yaw_rate_lag_s {
            now.large_errors.yaw_rate_lag_s = lag;
        }
        if let Some(reserve) = entry.rate_reserve_time_s {
            now.large_errors.rate_reserve_time_s = reserve;
        }
        (entry.speed_mps, now)
    };
    if pid.schedule.is_empty() {
        None
    } else {
        Some(PidSchedule::new(pid_parameters(pid), pid.schedule.iter().map(at).collect()))
    }
}

/// The controller of `pid.json` as it runs at a speed, m/s.
#[must_use]
pub fn pid_parameters_at(pid: &Pid, speed: f64) -> PidParameters {
    let start = pid_parameters(pid);
    pid_schedule(pid).map_or(start, |schedule| schedule.parameters_at(&start, speed))
}

/// The controller of gains and limits, at a sample time, s.
#[must_use]
pub fn controller_parameters(gains: &PidGains, limits: &Limits, sample_time: f64) -> PidParameters {
    PidParameters {
        gains: *gains,
        max_angle: limits.max_angle_rad,
        max_increment: limits.max_increment_rad,
        max_rate: limits.max_rate_radps,
        large_errors: match limits.large_errors {
            Some(large_errors) => large_errors,
            None => PidParameters::any_error(limits.max_rate_radps),
        },
        lateral_acceleration: match limits.lateral_acceleration {
            Some(bound) => bound,
            None => PidParameters::ANY_ACCELERATION,
        },
        sample_time,
    }
}

/// The estimator of `estimator.json`; where it starts is no part of the file.
#[must_use]
pub fn pose_parameters(estimator: &Estimator) -> PoseParameters {
    PoseParameters {
        gnss: estimator.gnss,
        sideslip: Sideslip {
            per_yaw_rate: estimator.sideslip_per_yaw_rate_s,
            growth: estimator.sideslip_growth_s5pm2,
            per_yaw_acceleration: estimator.sideslip_per_yaw_acceleration_s2,
            reference_speed: estimator.speed_mps,
            distance_rear: estimator.distance_rear_m,
        },
        noise: estimator.noise,
        initial_pose: Pose::default(),
        initial: estimator.initial,
    }
}

/// The geometry of `path.json`.
///
/// # Errors
/// Names the point that contradicts its neighbours.
pub fn path_geometry(path: &Path) -> Result<PathGeometry, Error> {
    PathGeometry::new(&path.points, path.closed)
}

/// The speed along the path of `path.json`: that of its profile, otherwise the one that it was made for.
#[must_use]
pub fn speed_reference(path: &Path) -> SpeedReference {
    match &path.profile {
        Some(profile) => SpeedReference::new(profile, path.closed),
        None => SpeedReference::constant(path.speed_mps),
    }
}

/// The guidance law of `path.json`, whose sideslip is that at the speed of the path, m/s.
#[must_use]
pub fn guidance_parameters(guidance: &Guidance, speed: f64) -> GuidanceParameters {
    GuidanceParameters {
        guidance: *guidance,
        reference_speed: speed,
        ..GuidanceParameters::default()
    }
}

/// The guidance law of `path.json` over speed; `None` where its parameters hold at every speed.
#[must_use]
pub fn guidance_schedule(path: &Path) -> Option<GuidanceSchedule> {
    guidance_over_speed(guidance_parameters(&path.guidance, path.speed_mps), &path.schedule)
}

/// A guidance law with entries over speed; `None` without entries.
#[must_use]
pub fn guidance_over_speed(
    start: GuidanceParameters,
    entries: &[GuidanceEntry],
) -> Option<GuidanceSchedule> {
    let at = |entry: &GuidanceEntry| {
        let guidance = Guidance {
            lookahead_time_s: entry.lookahead_time_s,
            lookahead_min_m: entry.lookahead_min_m,
            preview_time_s: entry.preview_time_s,
            feedforward_gain_radm: entry.feedforward_gain_radm,
            yaw_acceleration_gain_s2: entry.yaw_acceleration_gain_s2,
            yaw_jerk_gain_s3: entry.yaw_jerk_gain_s3,
            ..start.guidance
        };
        (entry.speed_mps, GuidanceParameters { guidance, ..start })
    };
    if entries.is_empty() {
        None
    } else {
        Some(GuidanceSchedule::new(start, entries.iter().map(at).collect()))
    }
}

/// The entries row by row.
fn entries(matrix: &Matrix) -> Vec<f64> {
    matrix.0.concat()
}
