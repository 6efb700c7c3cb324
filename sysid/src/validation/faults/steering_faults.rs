//! Faults between the recorded steering and the yaw rate: play, and clocks that are apart. They are the recording's
//! and no model's, so they are decided once for all structures, by [`crate::structures::bicycle::reference`].

use crate::structures::bicycle::reference::Reference;
use crate::validation::faults::clocks::{yaw_rate_lag, yaw_rate_lead};
use crate::validation::faults::play::play;
use crate::validation::residuals::pairs::pairs;
use steerwright_drivelog::{DriveLog, Role};
use steerwright_formats::Intersample;

/// Share of the yaw rate that the reference may leave: a recording that it does not follow is not judged by it.
const MOST_LEFT: f64 = 0.5;

/// What was found, nothing of which is certain where a field is `None`.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct SteeringFaults {
    /// Width of the play at the road wheel and its standard error, rad.
    pub(crate) play_rad: Option<(f64, f64)>,
    /// The yaw rate comes at least so much before the steering, s.
    pub(crate) yaw_rate_lead_s: Option<f64>,
    /// It comes so much later than the steering, s, which is later than a vehicle's.
    pub(crate) yaw_rate_lag_s: Option<f64>,
    /// Delay of the yaw rate after the steering as it was read, with its standard error, s, by a bicycle with the speed
    /// of each sample; no fault by itself.
    pub(crate) delay_s: Option<[f64; 2]>,
}

impl SteeringFaults {
    /// Those of a log of steering and yaw rate.
    pub(crate) fn from_log(log: &DriveLog) -> Self {
        let is_even = |signal: &Vec<f64>| signal.len() == log.len();
        if !(is_even(&log.output) && log.speed.as_ref().is_none_or(is_even)) {
            return Self::default();
        }
        let pairs = pairs(log);
        let Some(reference) = Reference::new(&pairs, log.sample_time_s) else {
            return Self::default();
        };
        let Some(recorded) = reference.recorded() else { return Self::default() };
        if recorded.left() > MOST_LEFT * reference.variation() {
            return Self::default();
        }
        let to_road_wheel = reference.unit / log.steering_ratio;
        let open_s = 0.5 * log.sample_time_s;
        Self {
            delay_s: recorded.delay_error_s().map(|error| [recorded.delay_s(), error]),
            play_rad: play(&reference, &recorded)
                .map(|(width, error)| (width * to_road_wheel, error * to_road_wheel)),
            yaw_rate_lead_s: yaw_rate_lead(&reference, &recorded, open_s),
            yaw_rate_lag_s: yaw_rate_lag(
                &reference,
                &recorded,
                0.5 * log.assumed_period_s(Role::Steering, Intersample::Bl).unwrap_or_default(),
            ),
        }
    }
}
