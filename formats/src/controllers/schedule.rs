//! Tables over speed of `pid.json` and `path.json`.

use crate::controllers::gains::{GuidanceAdvice, PidGains};
use crate::document::Checker;
use crate::is_zero;
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
