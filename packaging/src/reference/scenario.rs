//! The inputs of a reference run.
//!
//! Steering left, right and in a weave; a step of the reference with a yaw that lags it and one second disabled;
//! a path with an offset; two turns with poor fixes, an outlier and a drop-out;
//! pedals on hills, until the vehicle stands. Others keep their start values.

use crate::Error;
use model_description::{Kind, Value, Variable};
use std::f64::consts::TAU;
use steerwright_formats::{
    Bicycle, Document, Estimator, Longitudinal, Path, PathPoint, Pid, Plant, Vehicle,
};
use steerwright_units::Fmu;

pub(super) struct Scenario {
    /// Seconds of the scenario's ten for a second of the run.
    pace: f64,
    script: Script,
}

enum Script {
    /// Steering about a centre, rad; speed, m/s.
    Steer { centre: f64, amplitude: f64, speed: f64 },
    /// A step of the yaw reference, and feedforward as large as that part of the limit, rad.
    Track { step: f64, feedforward: f64 },
    /// Along the road at a speed, m/s.
    Drive { points: Vec<PathPoint>, speed: f64 },
    /// Pedals, or an acceleration command of a size (m/s²), in two gears.
    Pedals { command: Option<f64>, gears: Option<[i64; 2]> },
    /// Through two turns at a speed, m/s, with fixes that are late by so much, s.
    Locate { speed: f64, latency: f64 },
}

/// Steering of a plant that was not identified from a drive, at the road wheel, rad.
const ROAD_WHEEL_ANGLE: f64 = 0.02;

/// How much more the nonlinear vehicle is steered, so that its tyres saturate.
const NEAR_THE_LIMIT: f64 = 3.0;

impl Scenario {
    /// The scenario of an FMU made from this document, for a run of that many seconds.
    pub(super) fn new(fmu: Fmu, document: &str, file: &str, duration: f64) -> Result<Self, Error> {
        let script = match fmu {
            Fmu::IdentifiedPlant => {
                let plant = Plant::from_json(document, file)?;
                let seen = plant.evidence.excitation.road_wheel_std_rad;
                let angle = if seen > 0.0 { seen } else { ROAD_WHEEL_ANGLE };
                Script::Steer {
                    centre: plant.operating_point.steering_offset_rad,
                    amplitude: angle * plant.steering_ratio,
                    speed: plant.operating_point.speed_mps,
                }
            }
            Fmu::BicyclePlant => {
                let vehicle = Bicycle::from_json(document, file)?.vehicle;
                Script::Steer {
                    centre: 0.0,
                    amplitude: ROAD_WHEEL_ANGLE * vehicle.steering_ratio,
                    speed: vehicle.speed_mps,
                }
            }
            Fmu::NonlinearVehicle => {
                let vehicle = Vehicle::from_json(document, file)?;
                Script::Steer {
                    centre: 0.0,
                    amplitude: NEAR_THE_LIMIT * ROAD_WHEEL_ANGLE * vehicle.actuator.steering_ratio,
                    speed: vehicle.speed_mps,
                }
            }
            Fmu::LongitudinalPlant => {
                let model = Longitudinal::from_json(document, file)?;
                let is_commanded = model.command_unit == "m/s2";
                let gears = match model.gear_gains.as_slice() {
                    [] => None,
                    [first, .., last] => Some([first.gear, last.gear]),
                    [only] => Some([only.gear, only.gear + 1]),
                };
                Script::Pedals { command: is_commanded.then_some(2.0), gears }
            }
            Fmu::LateralPid => {
                let pid = Pid::from_json(document, file)?;
                Script::Track {
                    step: pid.specification.step_rad,
                    feedforward: 0.1 * pid.limits.max_angle_rad,
                }
            }
            Fmu::ReferencePath => {
                let path = Path::from_json(document, file)?;
                Script::Drive { points: path.points, speed: path.speed_mps }
            }
            Fmu::PoseEstimator => {
                let file = Estimator::from_json(document, file)?;
                Script::Locate { speed: file.speed_mps, latency: file.gnss.latency_s }
            }
        };
        Ok(Self { pace: 10.0 / duration, script })
    }

    /// The value of an input from `time` (s) on; `None` where it keeps its start value.
    pub(super) fn value(&self, variable: &Variable, time: f64) -> Option<Value> {
        let name = variable.name.as_str();
        // The course of the scenario, whatever the length of the run.
        let t = time * self.pace;
        let from = |start: f64, value: f64| if t < start { 0.0 } else { value };
        let number = match (&self.script, name) {
            (Script::Steer { centre, amplitude, .. }, "steering_angle") => {
                centre + amplitude * weave(t)
            }
            (Script::Steer { speed, .. }, "speed") => speed * if t < 8.0 { 1.0 } else { 0.95 },
            (Script::Track { step, .. }, "yaw_reference") => from(1.0, *step),
            (Script::Track { step, .. }, "yaw") => {
                from(1.2, step * (1.0 - (-(t - 1.2) / 0.5).exp()))
            }
            (Script::Track { feedforward, .. }, "steering_feedforward") => {
                from(5.0, feedforward * (TAU * 0.5 * (t - 5.0)).sin())
            }
            (Script::Track { .. }, "enabled") => {
                return Some(Value::Boolean(!(7.0..8.0).contains(&t)));
            }
            (Script::Drive { points, speed }, "x" | "y" | "yaw") => {
                let place = along(points, speed * time)?;
                // A quarter of a metre to either side, and a degree or so off the heading.
                let offset = 0.25 * (TAU * 0.2 * t).sin();
                match name {
                    "x" => place.x_m - offset * place.heading_rad.sin(),
                    "y" => place.y_m + offset * place.heading_rad.cos(),
                    _ => place.heading_rad + 0.02 * (TAU * 0.2 * t).cos(),
                }
            }
            (Script::Drive { .. }, "sideslip_per_yaw_rate_offset") => {
                from(2.0, 0.02 * (TAU * 0.1 * (t - 2.0)).sin())
            }
            (Script::Pedals { command: None, .. }, "accelerator") => weave(t).max(0.0),
            (Script::Pedals { command: Some(size), .. }, "acceleration_command") => size * weave(t),
            (Script::Pedals { .. }, "brake") => {
                if t < 8.5 {
                    0.2 * (-weave(t)).max(0.0)
                } else {
                    1.0
                }
            }
            (Script::Pedals { .. }, "grade") => 0.05 * (TAU * 0.1 * t).sin(),
            (Script::Pedals { gears: Some([first, second]), .. }, "gear") => {
                (if t < 5.0 { *first } else { *second }) as f64
            }
            (Script::Locate { speed, latency }, _) => locate(name, time, *speed, *latency)?,
            _ => return None,
        };
        if variable.kind == Kind::Integer {
            #[allow(clippy::cast_possible_truncation)] // saturates
            return Some(Value::Integer(number as i32));
        }
        let within =
            number.max(variable.min.unwrap_or(f64::MIN)).min(variable.max.unwrap_or(f64::MAX));
        (variable.kind == Kind::Real).then(|| Value::Real(super::rounded(within)))
    }
}

/// Nothing, left, right, then to and fro at 0.5 Hz and 1 Hz; in [−1, 1].
fn weave(t: f64) -> f64 {
    match t {
        t if t < 0.5 => 0.0,
        t if t < 2.0 => 1.0,
        t if t < 3.5 => -1.0,
        t if t < 7.5 => (TAU * 0.5 * (t - 3.5)).sin(),
        t => 0.5 * (TAU * (t - 7.5)).sin(),
    }
}

/// Yaw rate of the two turns, rad/s; the gyro reads a little more.
const TURN: f64 = 0.2;
const GYRO_BIAS: f64 = 0.01;

/// An input of the estimator at a time, s: five seconds to the left, then to the right.
fn locate(name: &str, time: f64, speed: f64, latency: f64) -> Option<f64> {
    // The latest fix: ten a second, none from 6 s to 8 s.
    let count = if (6.0..8.0).contains(&time) { 60.0 } else { (10.0 * time + 1e-6).floor() };
    let valid = (0.1 * count - latency).max(0.0);
    let radius = speed / TURN;
    let (left, right) = (TURN * valid.min(5.0), TURN * (valid - 5.0).max(0.0));
    Some(match name {
        "yaw_rate" => GYRO_BIAS + if time < 5.0 { TURN } else { -TURN },
        "speed" => speed,
        "gnss_fix_count" => count,
        "gnss_std" if (40.0..=60.0).contains(&count) => 0.5,
        "gnss_std" => 0.02,
        "gnss_x" => {
            let outlier = if count == 30.0 { 5.0 } else { 0.0 };
            outlier + radius * (left.sin() + left.sin() - (left - right).sin())
        }
        "gnss_y" => radius * (1.0 - left.cos() + (left - right).cos() - left.cos()),
        _ => return None,
    })
}

/// The place at that distance along the path, at most its end.
fn along(points: &[PathPoint], distance: f64) -> Option<PathPoint> {
    let last = points.last()?;
    let distance = (points.first()?.distance_m + distance).min(last.distance_m);
    let after = points.partition_point(|p| p.distance_m <= distance);
    let (Some(a), Some(b)) = (points.get(after.checked_sub(1)?), points.get(after)) else {
        return Some(*last);
    };
    let part = (distance - a.distance_m) / (b.distance_m - a.distance_m);
    let between = |a: f64, b: f64| a + part * (b - a);
    Some(PathPoint {
        distance_m: distance,
        x_m: between(a.x_m, b.x_m),
        y_m: between(a.y_m, b.y_m),
        heading_rad: between(a.heading_rad, b.heading_rad),
        curvature_per_m: between(a.curvature_per_m, b.curvature_per_m),
    })
}
