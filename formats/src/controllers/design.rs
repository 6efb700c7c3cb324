//! The specification of a controller and the results of its design: the evidence in `pid.json`.

use crate::controllers::loop_metrics::{Margins, OnACurve, Shortfall, StepMetrics};
use crate::controllers::over_speed::OverSpeed;
use serde::{Deserialize, Serialize};
use std::f64::consts::PI;

/// The specification. Every requirement is optional; the other fields define the test it refers to.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Specification {
    /// Largest overshoot, percent of the step.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub overshoot_percent: Option<f64>,
    /// Longest settling time, s.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub settling_time_s: Option<f64>,
    /// Largest steady-state error, percent of the step: on the step, with the steering offset, and on
    /// the curve.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub steady_state_error_percent: Option<f64>,
    /// Longest rise time, 10 to 90 %, s.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rise_time_s: Option<f64>,
    /// Largest integral of absolute error over the step's height, s.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub integral_absolute_error_s: Option<f64>,
    /// Smallest gain margin, dB.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub gain_margin_db: Option<f64>,
    /// Smallest phase margin, degrees.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub phase_margin_deg: Option<f64>,
    /// Smallest modulus margin.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub modulus_margin: Option<f64>,
    /// Smallest delay margin, s.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub delay_margin_s: Option<f64>,
    /// Smallest disk margin, with zero skew.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub disk_margin: Option<f64>,
    /// Band within which the response has settled, percent of the step to either side.
    #[serde(default = "settling_band")]
    pub settling_band_percent: f64,
    /// Height of the step, rad.
    pub step_rad: f64,
    /// Steering offset of the second step, rad at the road wheel; at a speed at which the steering is limited to little
    /// more, 0.8 of that limit.
    pub steering_offset_rad: f64,
    /// When the steady-state error is read, s after the step.
    pub steady_state_time_s: f64,
    /// Lateral acceleration on the curve of constant curvature, m/s².
    #[serde(default = "curve_acceleration")]
    pub curve_lateral_acceleration_mps2: f64,
}

fn settling_band() -> f64 {
    2.0
}

fn curve_acceleration() -> f64 {
    2.0
}

impl Default for Specification {
    /// The paper's: overshoot 1 %, settling 1 s, error 2 % on a step of 5°; modulus margin 0.5.
    fn default() -> Self {
        Self {
            overshoot_percent: Some(1.0),
            settling_time_s: Some(1.0),
            steady_state_error_percent: Some(2.0),
            modulus_margin: Some(0.5),
            ..Self::none()
        }
    }
}

impl Specification {
    /// Share of the largest steering angle that the steering offset takes at most: the rest corrects the heading.
    const LARGEST_OFFSET: f64 = 0.8;

    /// Steering offset of the second step where the controller steers by at most `largest_angle_rad`, both in steering
    /// coordinates, rad.
    #[must_use]
    pub fn steering_offset_within(&self, largest_angle_rad: f64, steering_ratio: f64) -> f64 {
        (steering_ratio * self.steering_offset_rad).min(Self::LARGEST_OFFSET * largest_angle_rad)
    }

    /// The step, the offset and the curve, without requirements.
    #[must_use]
    pub fn none() -> Self {
        Self {
            overshoot_percent: None,
            settling_time_s: None,
            steady_state_error_percent: None,
            rise_time_s: None,
            integral_absolute_error_s: None,
            gain_margin_db: None,
            phase_margin_deg: None,
            modulus_margin: None,
            delay_margin_s: None,
            disk_margin: None,
            settling_band_percent: settling_band(),
            step_rad: 5.0 / 180.0 * PI,
            steering_offset_rad: 1.0 / 180.0 * PI,
            steady_state_time_s: 5.0,
            curve_lateral_acceleration_mps2: curve_acceleration(),
        }
    }

    /// Whether a response to the specification's step meets the requirements, up to rounding.
    #[must_use]
    pub fn is_met_by(&self, step: &StepMetrics) -> bool {
        let within = |reached: Option<f64>, limit: Option<f64>| match (reached, limit) {
            (_, None) => true,
            (None, Some(_)) => false,
            (Some(reached), Some(limit)) => reached <= limit * (1.0 + 1e-9),
        };
        within(Some(step.overshoot_percent), self.overshoot_percent)
            && within(step.settling_time_s, self.settling_time_s)
            && within(step.rise_time_s, self.rise_time_s)
            && within(Some(step.integral_absolute_error_s), self.integral_absolute_error_s)
            && self.error_is_met_by(step)
    }

    /// Whether the error at the end of a response meets its requirement.
    #[must_use]
    pub fn error_is_met_by(&self, step: &StepMetrics) -> bool {
        let limit = self.steady_state_error_percent;
        limit.is_none_or(|limit| step.steady_state_error_percent <= limit * (1.0 + 1e-9))
    }
}

/// The results of the design.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct DesignEvidence {
    /// Whether every requirement is met on the model it was designed on.
    pub met: bool,
    /// Each unmet requirement with its shortfall.
    pub shortfalls: Vec<Shortfall>,
    /// Remarks, such as the requirement that makes another one infeasible.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub advice: Vec<String>,
    /// On the step of the specification.
    pub step: StepMetrics,
    /// On the same step with the steering offset.
    pub step_with_offset: StepMetrics,
    /// On a tenth of the step, where the limits act less: a design target like the step, so that the
    /// overshoot is not small because of a limit, but not a requirement.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub small_step: Option<StepMetrics>,
    /// The step by linear theory, without limits.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub without_limits: Option<StepMetrics>,
    /// On the curve of constant curvature, with the advised feedforward and preview.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub curve: Option<OnACurve>,
    /// In the loop of the packed FMUs.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub fmu_loops: Vec<FmuLoop>,
    /// Steps of other heights on the model designed on, with the limits.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub steps: Vec<HeightStep>,
    /// The offsets from which the loop returns to a straight path.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub engagement: Option<Engagement>,
    /// Margins of the linear sampled loop, broken at the plant's input.
    pub margins: Margins,
    /// For the plants within the uncertainty, other latencies and other speeds.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub robustness: Option<Robustness>,
    /// The shortest settling time at each modulus margin, with the other requirements met.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub trade_off: Vec<TradeOff>,
    /// The controller over its range of speeds; absent for one set of gains.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub over_speed: Option<OverSpeed>,
}

/// A step of some height.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct HeightStep {
    /// Height of the step, rad.
    pub height_rad: f64,
    /// The metrics of the response; percentages are of this height.
    pub step: StepMetrics,
}

/// The offsets from which the loop with its path follower returns to a straight path, at constant speed.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Engagement {
    /// The simulated plant: whether its tyres saturate.
    pub plant: String,
    /// Lateral offsets that were tried, m, to the left of the path.
    pub offsets_m: Vec<f64>,
    /// Each speed and heading error.
    pub rows: Vec<EngagementRow>,
}

/// One speed and heading error.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct EngagementRow {
    /// Speed, m/s.
    pub speed_mps: f64,
    /// Yaw less the path's heading at the start, rad; positive away from the path.
    pub heading_error_rad: f64,
    /// Largest tried offset from which, as from all smaller ones, it returns; absent if it returns from
    /// none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub largest_offset_m: Option<f64>,
}

/// The order of exchange between the FMUs of a loop.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum LoopCoupling {
    /// One FMU after the other, each with the values that those before it have just computed: plant, path, controller.
    #[default]
    GaussSeidel,
    /// All FMUs with the values at the start of the step: the yaw loop is late by a step.
    Jacobi,
}

impl LoopCoupling {
    /// The delay that it puts into the yaw loop, s.
    #[must_use]
    pub fn loop_delay_s(self, step_s: f64) -> f64 {
        match self {
            Self::GaussSeidel => 0.0,
            Self::Jacobi => step_s,
        }
    }
}

crate::words!(LoopCoupling { GaussSeidel = "gauss-seidel", Jacobi = "jacobi" });

/// The specification's steps in the loop of the packed FMUs.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FmuLoop {
    /// `gauss-seidel` or `jacobi`.
    #[serde(alias = "master")]
    pub coupling: LoopCoupling,
    /// The delay that this coupling puts into the yaw loop, s.
    pub loop_delay_s: f64,
    /// On the step.
    pub step: StepMetrics,
    /// The same by the design's own simulation with that delay.
    pub predicted: StepMetrics,
    /// On the step with the steering offset; absent if the plant has no such parameter.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub step_with_offset: Option<StepMetrics>,
}

/// The same gains on plants other than the nominal one.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Robustness {
    /// Whether every evaluated plant meets every requirement.
    pub met: bool,
    /// Plants drawn from the identified uncertainty; 0 if none is stated.
    pub members: usize,
    /// Plants that were asked for; more than `members` where draws are unstable or have no continuous form, whose
    /// shares of the requirements are then unknown. Absent where all were drawn.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub members_wanted: Option<usize>,
    /// The seed of the draws.
    pub seed: u64,
    /// Lowest and highest delay of the yaw loop beyond the model's own, s.
    pub loop_delay_range_s: [f64; 2],
    /// Lowest and highest gain of the plant over the nominal one: beyond the lateral acceleration of
    /// the drive the tyres saturate, which no uncertainty of a linear model contains.
    pub gain_range: [f64; 2],
    /// Lowest and highest speed, m/s, if the model is valid at several.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub speed_range_mps: Option<[f64; 2]>,
    /// Evaluated plants: members, at the latencies and speeds of the ranges.
    pub plants: usize,
    /// Each requirement over them.
    pub requirements: Vec<OverEnsemble>,
    /// Delay of the yaw loop beyond the model's own at which each requirement fails, s; nominal plant.
    pub latency: Vec<Breaking>,
    /// Speed at which each requirement fails, m/s; nominal plant.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub speed: Vec<Breaking>,
}

/// One requirement over many plants.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct OverEnsemble {
    /// The requirement.
    pub requirement: String,
    /// The requirement.
    pub required: f64,
    /// The worst value of all plants.
    pub worst: f64,
    /// Share of the plants that meet it.
    pub share_kept: f64,
    /// Share of the drawn plants that meet it at the latency and speed of the design; absent without
    /// drawn plants.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub share_kept_at_nominal: Option<f64>,
}

/// The range around the design value in which one requirement is met.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Breaking {
    /// The requirement.
    pub requirement: String,
    /// Not met below this; absent if it is met down to the lowest evaluated value.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub below: Option<f64>,
    /// Not met above this; absent if it is met up to the highest evaluated value.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub above: Option<f64>,
    /// The lowest and the highest evaluated value.
    pub looked: [f64; 2],
}

/// The settling time that a modulus margin costs.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TradeOff {
    /// The modulus margin.
    pub modulus_margin: f64,
    /// The shortest settling time found with it, the other requirements met; absent if none was found.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub settling_time_s: Option<f64>,
}
