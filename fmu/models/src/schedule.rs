//! Parameters over speed: linear between the speeds of a table, constant beyond its ends.
//!
//! A parameter follows the table as long as it has its start value. One that was set to another value holds
//! at every speed, so that a value that is set is the value that acts.

use crate::guidance::GuidanceParameters;
use crate::pid::PidParameters;

macro_rules! over_speed {
    ($(#[$doc:meta])* $name:ident of $parameters:ident: $($($field:ident).+)+) => {
        $(#[$doc])*
        #[derive(Debug, Clone, PartialEq)]
        pub struct $name {
            start: $parameters,
            /// Ascending, m/s.
            speeds: Vec<f64>,
            entries: Vec<$parameters>,
        }

        impl $name {
            /// A table of parameters at speeds (m/s), in any order, with the start values of the parameters.
            #[must_use]
            pub fn new(start: $parameters, mut entries: Vec<(f64, $parameters)>) -> Self {
                entries.sort_by(|a, b| a.0.total_cmp(&b.0));
                let (speeds, entries) = entries.into_iter().unzip();
                Self { start, speeds, entries }
            }

            /// The parameters `p` with those that have their start value from the table at a speed, m/s.
            #[must_use]
            pub fn parameters_at(&self, p: &$parameters, speed: f64) -> $parameters {
                let (below, above, share) = place(&self.speeds, speed);
                let mut now = *p;
                if let (Some(a), Some(b)) = (self.entries.get(below), self.entries.get(above)) {
                    $(if p.$($field).+ == self.start.$($field).+ {
                        now.$($field).+ = a.$($field).+ + share * (b.$($field).+ - a.$($field).+);
                    })+
                }
                now
            }
        }
    };
}

over_speed! {
    /// Gains of the yaw controller over speed, with what else depends on it.
    PidSchedule of PidParameters: gains.kp gains.ki gains.kd gains.derivative_filter_time_s
        gains.setpoint_weight_proportional gains.setpoint_weight_derivative gains.anti_windup_time_s
        large_errors.yaw_rate_lag_s large_errors.rate_reserve_time_s
}

over_speed! {
    /// Preview, feedforward, path gains and look-ahead over speed.
    GuidanceSchedule of GuidanceParameters: guidance.lookahead_time_s guidance.lookahead_min_m
        guidance.preview_time_s guidance.feedforward_gain_radm guidance.yaw_acceleration_gain_s2
        guidance.yaw_jerk_gain_s3
}

/// The entries next to a speed, and the share of the second; the same entry twice at its speed and beyond
/// the ends.
fn place(speeds: &[f64], speed: f64) -> (usize, usize, f64) {
    let above = speeds.partition_point(|s| *s <= speed);
    let last = speeds.len().saturating_sub(1);
    if above == 0 || above > last {
        let end = above.min(last);
        return (end, end, 0.0);
    }
    let (low, high) = (speeds[above - 1], speeds[above]);
    (above - 1, above, (speed - low) / (high - low))
}
