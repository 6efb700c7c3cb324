//! The evidence of a controller over a range of speeds.

use crate::controllers::loop_metrics::{Margins, OnACurve, Shortfall, StepMetrics};
use serde::{Deserialize, Serialize};

/// The evidence of a controller over a range of speeds.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct OverSpeed {
    /// Whether every requirement is met at every evaluated speed.
    pub met: bool,
    /// The loop at constant speeds, at the breakpoints of the table and between them, in ascending order.
    pub frozen: Vec<FrozenSpeed>,
    /// The loop while the speed changes.
    pub ramps: Vec<SpeedRamp>,
}

/// The loop at one constant speed.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FrozenSpeed {
    /// Speed, m/s.
    pub speed_mps: f64,
    /// Whether the table has an entry at this speed; otherwise the gains are interpolated.
    pub breakpoint: bool,
    /// Kp, steering angle per yaw error.
    pub kp: f64,
    /// Ki, 1/s.
    pub ki: f64,
    /// Kd, s.
    pub kd: f64,
    /// Largest steering angle that is allowed at this speed, rad, in steering coordinates.
    pub max_angle_rad: f64,
    /// On the step of the specification.
    pub step: StepMetrics,
    /// On the same step with the steering offset.
    pub step_with_offset: StepMetrics,
    /// On the curve of constant curvature, with feedforward and preview of this speed.
    pub curve: OnACurve,
    /// Margins of the linear sampled loop, broken at the plant's input.
    pub margins: Margins,
    /// Whether every requirement is met.
    pub met: bool,
    /// Each unmet requirement with its shortfall.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub shortfalls: Vec<Shortfall>,
    /// Why requirements are not met; absent if all are.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub reason: Option<String>,
    /// Evaluated plants of the ensemble: drawn ones, other latencies and gains. 0 without an ensemble.
    pub plants: usize,
    /// Share of these plants that meet every requirement; absent without an ensemble.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub share_kept: Option<f64>,
}

/// What the vehicle does while its speed changes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum SpeedRampKind {
    /// Yaw steps of the specification, one after the other.
    YawSteps,
    /// A path of constant radius.
    ConstantRadius,
}

/// The scheduled controller on the model while the speed changes at a constant rate.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SpeedRamp {
    /// The manoeuvre.
    pub manoeuvre: SpeedRampKind,
    /// Change of the speed, m/s².
    pub acceleration_mps2: f64,
    /// Speed at the start, m/s.
    pub from_mps: f64,
    /// Speed at the end, m/s.
    pub to_mps: f64,
    /// Largest overshoot of a step, percent of the step; absent on a path.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub overshoot_percent: Option<f64>,
    /// Longest settling time of a step, s; absent on a path, or if a step never settles.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub settling_time_s: Option<f64>,
    /// Radius of the path, m; absent for steps.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub radius_m: Option<f64>,
    /// Root mean square of the distance from the path, m; absent for steps.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rms_cross_track_error_m: Option<f64>,
    /// Largest distance from the path, m; absent for steps.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub largest_cross_track_error_m: Option<f64>,
}
