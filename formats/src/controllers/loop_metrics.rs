//! The metrics of a closed loop: its steps, its margins, and the requirements that it does not meet.

use serde::{Deserialize, Serialize};

/// Metrics of one step response.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct StepMetrics {
    /// Overshoot, percent of the step.
    pub overshoot_percent: f64,
    /// Time after which the response stays within the band; absent if it never does.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub settling_time_s: Option<f64>,
    /// Error at the steady-state time, percent of the step.
    pub steady_state_error_percent: f64,
    /// Time from 10 % to 90 %; absent if 90 % is never reached.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rise_time_s: Option<f64>,
    /// Largest steering angle used, rad, in steering coordinates.
    pub largest_angle_rad: f64,
    /// Largest change in a sample, rad.
    pub largest_increment_rad: f64,
    /// Integral of the absolute error over the step's height, s.
    #[serde(default)]
    pub integral_absolute_error_s: f64,
}

/// On a curve of constant curvature that begins at once, at the speed of the design.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct OnACurve {
    /// Curvature of the path, 1/m.
    pub curvature_1pm: f64,
    /// Yaw less the path's heading at the steady-state time, percent of the step's height.
    pub steady_state_error_percent: f64,
    /// The largest such difference before that, percent of the step's height.
    pub largest_error_percent: f64,
}

/// Margins of the linear sampled loop, broken at the plant's input, with its delay.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Margins {
    /// Gain margin, dB; absent if unlimited.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub gain_margin_db: Option<f64>,
    /// Phase margin, degrees; absent if the gain never crosses 1.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub phase_margin_deg: Option<f64>,
    /// Delay margin, s; absent if unlimited.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub delay_margin_s: Option<f64>,
    /// Smallest distance of the loop from −1.
    pub modulus_margin: f64,
    /// Disk margin with zero skew, `1/max|S − ½|`: gain and phase may change together by that much.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub disk_margin: Option<f64>,
    /// Gain crossover, rad/s.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub crossover_radps: Option<f64>,
}

/// An unmet requirement.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Shortfall {
    /// The requirement.
    pub requirement: String,
    /// The requirement.
    pub required: f64,
    /// The value reached.
    pub reached: f64,
}
