//! Properties of the data, determined before the model is estimated, and play of the steering.

use crate::document::Checker;
use serde::{Deserialize, Serialize};

/// The reduction of the recorded windows to one R factor.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct DataFactor {
    /// The method, chosen by the condition.
    pub method: FactorMethod,
    /// Estimated condition number of the windows, scaled to equal size; absent if it is infinite, as for
    /// data without noise.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub condition: Option<f64>,
    /// The same for the windows of the input only, at the requested horizon: beyond 1e12 the input is
    /// reported as not exciting them.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub input_condition: Option<f64>,
    /// Requested block rows; with an automatic horizon, the longest that was tried.
    pub asked_horizon: usize,
    /// Block rows that the input excites, at most those requested.
    pub horizon: usize,
}

/// A method to compute the R factor.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum FactorMethod {
    /// Cholesky factor of the Gram matrix, for condition numbers whose square is small enough.
    Gram,
    /// QR factorisation of the windows.
    Qr,
}

/// The pure delay from steering to yaw rate, estimated on the estimation data.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct DelayEstimate {
    /// Delay of the best model with a delay, s.
    pub estimate_s: f64,
    /// Its standard error, s, from noise, the spread over model orders, and the ambiguity with a lag;
    /// absent if the data do not determine it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub standard_error_s: Option<f64>,
    /// Fastest time constant of the best model without a delay, s: the lag that the delay replaces.
    pub lag_without_s: f64,
    /// Difference in BIC by which the delay is preferred to lags; below 6 the delay is not used.
    pub evidence: f64,
    /// Whether it is used as the delay of the plant.
    pub taken: bool,
}

/// Fit of the measured angle that an actuator has to reach, %.
const LEAST_ACTUATOR_FIT: f64 = 80.0;
/// By how much the angle of a steady turn may differ from the command, as a share.
const ACTUATOR_GAIN_TOLERANCE: f64 = 0.1;

/// The actuator from a steering command to the measured angle beside it: `T δ̇ + δ = g u(t − τ) + c`, and no faster than its
/// largest rate where that shows.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct IdentifiedActuator {
    /// Time constant T, s.
    pub time_constant_s: f64,
    /// Its standard error, s.
    pub time_constant_standard_error_s: f64,
    /// Delay τ, s.
    pub delay_s: f64,
    /// Its standard error, s.
    pub delay_standard_error_s: f64,
    /// Angle over command g in a steady turn.
    pub gain: f64,
    /// Largest rate of the steering angle, rad/s; absent where the drive does not reach it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub max_rate_radps: Option<f64>,
    /// Fit of the measured angle by the simulation from the command, percent.
    pub fit: f64,
}

impl IdentifiedActuator {
    /// Why no controller is designed for it; `None` for one that explains the angle.
    #[must_use]
    pub fn fault(&self) -> Option<String> {
        if self.fit < LEAST_ACTUATOR_FIT {
            return Some(format!(
                "a lag behind a delay explains {:.0} % of the measured angle, less than {LEAST_ACTUATOR_FIT:.0} %",
                self.fit
            ));
        }
        if (self.gain - 1.0).abs() > ACTUATOR_GAIN_TOLERANCE {
            Some(format!(
                "the measured angle is {:.2} times the command in a steady turn: one of them may be of the steering wheel, the other of the road wheels, or a unit is wrong",
                self.gain
            ))
        } else {
            None
        }
    }

    /// Reports impossible numbers; `at` is the prefix of each key.
    pub(crate) fn check(&self, c: &mut Checker, at: &str) {
        check_fields!(c.positive(self, at): time_constant_s);
        check_fields!(c.not_negative(self, at): time_constant_standard_error_s delay_s delay_standard_error_s);
        check_fields!(c.finite(self, at): gain fit);
        if let Some(rate) = self.max_rate_radps {
            c.positive(rate, &format!("{at}max_rate_radps"));
        }
    }
}

/// Play between the recorded steering angle and the road wheels, as an angle at the road wheels.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SteeringPlay {
    /// Width of the play from stop to stop, rad at the road wheel.
    pub road_wheel_rad: f64,
    /// Its standard error, rad.
    pub standard_error_rad: f64,
    /// The limit cycle of a typical loop about the plant; absent if none is expected.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub limit_cycle: Option<LimitCycle>,
}

/// A self-sustained oscillation by the describing function of the play.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LimitCycle {
    /// Amplitude of the steering, rad at the road wheel.
    pub road_wheel_rad: f64,
    /// Amplitude of the yaw angle, rad.
    pub yaw_rad: f64,
    /// Period, s.
    pub period_s: f64,
}
