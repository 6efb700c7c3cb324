//! `pid.json`: the steering controller of eq 14 with the proof that it meets its specification.

use crate::{Checker, Document, Provenance};
use serde::{Deserialize, Serialize};

/// The controller, what it was designed for, and what it reaches.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Pid {
    /// `steerwright/pid/1`.
    pub schema: String,
    /// A name for people.
    pub name: String,
    /// Sample time, s.
    pub sample_time_s: f64,
    /// Gains and weights.
    pub gains: PidGains,
    /// Limits in steering coordinates.
    pub limits: Limits,
    /// What the controller was designed on.
    pub designed_for: DesignedFor,
    /// What was asked for.
    pub specification: Specification,
    /// What was reached.
    pub evidence: DesignEvidence,
    /// What a path follower around this loop should use.
    pub guidance: GuidanceAdvice,
    /// Where it came from.
    pub provenance: Provenance,
}

/// Gains of `K(s) = Kp + Ki/s + Kd·s` (eq 14), parallel form, with setpoint weights and filter.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PidGains {
    /// Kp, steering angle per yaw error.
    pub kp: f64,
    /// Ki, 1/s.
    pub ki: f64,
    /// Kd, s.
    pub kd: f64,
    /// Time constant of the derivative filter, s.
    pub derivative_filter_time_s: f64,
    /// Weight of the reference in the proportional action.
    pub setpoint_weight_proportional: f64,
    /// Weight of the reference in the derivative action.
    pub setpoint_weight_derivative: f64,
    /// Time constant of the anti-windup back-calculation, s.
    pub anti_windup_time_s: f64,
}

/// Limits of the steering angle, in steering coordinates.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Limits {
    /// Largest angle to either side, rad.
    pub max_angle_rad: f64,
    /// Largest change in one sample, rad.
    pub max_increment_rad: f64,
    /// Largest rate, rad/s.
    pub max_rate_radps: f64,
}

/// The model and the loop the controller was designed for.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct DesignedFor {
    /// `plant` (identified) or `bicycle`.
    pub model: String,
    /// The model's name.
    pub name: String,
    /// SHA-256 of the model's file.
    pub sha256: String,
    /// Speed, m/s.
    pub speed_mps: f64,
    /// Steering angle over road-wheel angle.
    pub steering_ratio: f64,
    /// Delay of the loop beyond the model's own, s (0 under a Gauss–Seidel master).
    pub loop_delay_s: f64,
}

/// What was asked for, on a yaw step.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Specification {
    /// Largest overshoot, percent of the step.
    pub overshoot_percent: f64,
    /// Longest settling time, s.
    pub settling_time_s: f64,
    /// Largest steady-state error, percent of the step; also the settling band.
    pub steady_state_error_percent: f64,
    /// Height of the step, rad.
    pub step_rad: f64,
    /// Steering offset of the second step, rad at the road wheel.
    pub steering_offset_rad: f64,
    /// When the steady-state error is read, s after the step.
    pub steady_state_time_s: f64,
    /// Smallest modulus margin.
    pub modulus_margin: f64,
}

impl Specification {
    /// Whether a response to the specification's step meets overshoot, settling time and
    /// steady-state error, up to rounding.
    #[must_use]
    pub fn is_met_by(&self, step: &StepMetrics) -> bool {
        let within = |reached: f64, asked: f64| reached <= asked * (1.0 + 1e-9);
        within(step.overshoot_percent, self.overshoot_percent)
            && step.settling_time_s.is_some_and(|t| within(t, self.settling_time_s))
            && within(step.steady_state_error_percent, self.steady_state_error_percent)
    }
}

/// What was reached.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct DesignEvidence {
    /// Whether every requirement is met.
    pub met: bool,
    /// Each requirement that is not, and by how much.
    pub shortfalls: Vec<Shortfall>,
    /// On the step of the specification.
    pub step: StepMetrics,
    /// On the same step with the steering offset.
    pub step_with_offset: StepMetrics,
    /// On a tenth of the step, where the limits act that much less: aimed at as the step is, so that
    /// no limit is what keeps the overshoot down, but not required.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub small_step: Option<StepMetrics>,
    /// Margins of the linear sampled loop, broken at the plant's input.
    pub margins: Margins,
}

/// A requirement that is not met.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Shortfall {
    /// The requirement.
    pub requirement: String,
    /// What was asked.
    pub required: f64,
    /// What was reached.
    pub reached: f64,
}

/// Metrics of one step response.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct StepMetrics {
    /// Overshoot, percent of the step.
    pub overshoot_percent: f64,
    /// Time after which the response stays within the band; absent where it never does.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub settling_time_s: Option<f64>,
    /// Error at the steady-state time, percent of the step.
    pub steady_state_error_percent: f64,
    /// Time from 10 % to 90 %; absent where 90 % is never reached.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rise_time_s: Option<f64>,
    /// Largest steering angle used, rad, in steering coordinates.
    pub largest_angle_rad: f64,
    /// Largest change in a sample, rad.
    pub largest_increment_rad: f64,
}

/// Margins of the linear sampled loop, broken at the plant's input, with its delay.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Margins {
    /// Gain margin, dB; absent where unlimited.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub gain_margin_db: Option<f64>,
    /// Phase margin, degrees; absent where the gain never crosses 1.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub phase_margin_deg: Option<f64>,
    /// Delay margin, s; absent where unlimited.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub delay_margin_s: Option<f64>,
    /// Smallest distance of the loop from −1.
    pub modulus_margin: f64,
    /// Gain crossover, rad/s.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub crossover_radps: Option<f64>,
}

/// What a path follower around this loop should use.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct GuidanceAdvice {
    /// Steering angle per path curvature, rad·m: what a curve needs beyond what the previewed yaw
    /// reference already makes the loop steer. Not the whole steering of a steady turn, so neither
    /// this nor the preview is to be used without the other.
    pub feedforward_gain_radm: f64,
    /// Time by which the closed loop lags a yaw ramp, kp·(1 − b)/ki, s.
    pub preview_time_s: f64,
}

impl Document for Pid {
    const SCHEMA: &'static str = "steerwright/pid/1";

    fn schema(&self) -> &str {
        &self.schema
    }

    fn check(&self, c: &mut Checker) {
        let g = &self.gains;
        c.positive(self.sample_time_s, "sample_time_s");
        c.not_negative(g.kp, "gains.kp");
        c.not_negative(g.ki, "gains.ki");
        c.not_negative(g.kd, "gains.kd");
        c.not_negative(g.derivative_filter_time_s, "gains.derivative_filter_time_s");
        c.finite(g.setpoint_weight_proportional, "gains.setpoint_weight_proportional");
        c.finite(g.setpoint_weight_derivative, "gains.setpoint_weight_derivative");
        c.positive(g.anti_windup_time_s, "gains.anti_windup_time_s");
        c.positive(self.limits.max_angle_rad, "limits.max_angle_rad");
        c.positive(self.limits.max_increment_rad, "limits.max_increment_rad");
        c.positive(self.limits.max_rate_radps, "limits.max_rate_radps");
        c.finite(self.guidance.feedforward_gain_radm, "guidance.feedforward_gain_radm");
        c.not_negative(self.guidance.preview_time_s, "guidance.preview_time_s");
    }
}
