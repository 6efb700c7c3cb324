//! Tables over speed of `pid.json` and `path.json`, and the evidence of a controller over a range of speeds.

use crate::{
    Checker, GuidanceAdvice, Margins, OnACurve, PidGains, Shortfall, StepMetrics, is_zero,
};
use serde::{Deserialize, Serialize};

/// The controller at one speed.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ScheduleEntry {
    /// Speed, m/s.
    pub speed_mps: f64,
    /// Gains and weights.
    pub gains: PidGains,
    /// Lag of the yaw rate, s, instead of that in `limits.large_errors`; absent if that holds.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub yaw_rate_lag_s: Option<f64>,
    /// Reserve of time at the largest rate, s, instead of that in `limits.large_errors`; absent if that holds.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rate_reserve_time_s: Option<f64>,
    /// Recommended settings of a path follower around this loop.
    pub guidance: GuidanceAdvice,
}

/// The parameters of the guidance law at one speed.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct GuidanceEntry {
    /// Speed, m/s.
    pub speed_mps: f64,
    /// Look-ahead distance over speed, s.
    pub lookahead_time_s: f64,
    /// Smallest look-ahead distance, m.
    pub lookahead_min_m: f64,
    /// Preview time of heading and curvature, s.
    pub preview_time_s: f64,
    /// Steering angle per curvature, rad·m.
    pub feedforward_gain_radm: f64,
    /// Gain from the path's yaw acceleration to the yaw reference, s²; 0 may be omitted.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub yaw_acceleration_gain_s2: f64,
    /// Gain from the path's yaw jerk to the yaw reference, s³; 0 may be omitted.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub yaw_jerk_gain_s3: f64,
}

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

impl ScheduleEntry {
    pub(crate) fn check(&self, c: &mut Checker, at: &str) {
        self.gains.check(c, &format!("{at}gains."));
        // A change of the gains is bumpless with an integral action.
        c.positive(self.gains.ki, &format!("{at}gains.ki"));
        self.guidance.check(c, &format!("{at}guidance."));
        if let Some(reserve) = self.rate_reserve_time_s {
            c.positive(reserve, &format!("{at}rate_reserve_time_s"));
        }
        if let Some(lag) = self.yaw_rate_lag_s {
            c.not_negative(lag, &format!("{at}yaw_rate_lag_s"));
        }
    }
}

impl GuidanceEntry {
    pub(crate) fn check(&self, c: &mut Checker, at: &str) {
        check_fields!(c.not_negative(self, at): lookahead_time_s preview_time_s);
        check_fields!(c.positive(self, at): lookahead_min_m);
        check_fields!(c.finite(self, at):
            feedforward_gain_radm yaw_acceleration_gain_s2 yaw_jerk_gain_s3);
    }
}

/// Checks that the speeds of a table are positive and increase.
pub(crate) fn check_speeds(c: &mut Checker, speeds: impl Iterator<Item = f64>) {
    let mut before = 0.0;
    for (i, speed) in speeds.enumerate() {
        let at = format!("schedule[{i}].speed_mps");
        c.positive(speed, &at);
        c.require(speed > before, &at, || {
            format!("speed {speed} does not increase (before it {before})")
        });
        before = speed;
    }
}
