//! `pid.json`: the steering controller of eq 14 with the evidence that it meets its specification.

use crate::controllers::design::{DesignEvidence, Specification};
use crate::controllers::gains::{GuidanceAdvice, PidGains};
use crate::controllers::schedule::{ScheduleEntry, check_speeds};
use crate::document::{Checker, Document};
use crate::facts::{Described, Fact, Facts, quality_facts};
use crate::is_zero;
use crate::provenance::Provenance;
use crate::quality::Quality;
use serde::{Deserialize, Serialize};

/// The controller, its specification, and the results of its design.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Pid {
    /// `steerwright/pid/1`.
    pub schema: String,
    /// A name.
    pub name: String,
    /// Sample time, s.
    pub sample_time_s: f64,
    /// Gains and weights.
    pub gains: PidGains,
    /// Limits in steering coordinates.
    pub limits: Limits,
    /// The model that the controller was designed on.
    pub designed_for: DesignedFor,
    /// The specification.
    pub specification: Specification,
    /// The results of the design.
    pub evidence: DesignEvidence,
    /// Recommended settings of a path follower around this loop.
    pub guidance: GuidanceAdvice,
    /// Gains and guidance over speed, at increasing speeds; linear between them and constant beyond the ends.
    /// Empty or omitted if those above hold at every speed.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub schedule: Vec<ScheduleEntry>,
    /// The sources of the file.
    pub provenance: Provenance,
}

impl Pid {
    /// Largest steering angle to either side at the design speed, rad.
    #[must_use]
    pub fn largest_angle_rad(&self) -> f64 {
        self.limits.largest_angle_rad(self.designed_for.speed_mps)
    }
}

/// Limits of the steering angle, in steering coordinates, and of the yaw error.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Limits {
    /// Largest angle to either side, rad.
    pub max_angle_rad: f64,
    /// Largest change in one sample, rad.
    pub max_increment_rad: f64,
    /// Largest rate, rad/s.
    pub max_rate_radps: f64,
    /// The limits for large yaw errors; absent if the controller acts on them directly.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub large_errors: Option<LargeErrors>,
    /// The largest angle by speed; absent if it is the same at every speed.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub lateral_acceleration: Option<LateralAcceleration>,
}

/// Limits for large yaw errors, which reduce the overshoot of large steps with a rate-limited actuator.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LargeErrors {
    /// Largest yaw error, beyond the lag behind a ramp, that the controller acts on at once, rad; the rest
    /// is released as a ramp.
    pub max_yaw_error_rad: f64,
    /// Lag of the yaw rate behind the steering angle that was sent, s: by it the controller notices an actuator
    /// that turns more slowly than the largest rate. 0 may be omitted: no such actuator is looked for.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub yaw_rate_lag_s: f64,
    /// Rate with the slowest actuator that is looked for, rad/s.
    pub sustained_rate_radps: f64,
    /// Reserve of time at the largest rate, s, after which the anti-windup is quicker: longer than a step of the
    /// specification needs.
    pub rate_reserve_time_s: f64,
}

/// A bound on the lateral acceleration a, and the steering angle of a steady turn at speed v:
/// `a·(steering_per_curvature/v² + understeer_gradient)`.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LateralAcceleration {
    /// The bound, m/s².
    pub max_mps2: f64,
    /// Steering angle per curvature in a slow turn, rad·m.
    pub steering_per_curvature_radm: f64,
    /// Steering angle per lateral acceleration beyond that, rad·s²/m.
    pub understeer_gradient_rads2pm: f64,
}

impl Limits {
    /// Largest steering angle to either side at a speed, rad.
    #[must_use]
    pub fn largest_angle_rad(&self, speed_mps: f64) -> f64 {
        match &self.lateral_acceleration {
            Some(bound) => bound.largest_angle_rad(speed_mps, self.max_angle_rad),
            None => self.max_angle_rad,
        }
    }
}

impl LateralAcceleration {
    /// Speed below which the bound does not follow it, m/s.
    pub const LEAST_SPEED_MPS: f64 = 1.0;

    /// Largest steering angle to either side at a speed that is at most the one of every speed, rad.
    #[must_use]
    #[inline(always)]
    pub fn largest_angle_rad(&self, speed_mps: f64, max_angle_rad: f64) -> f64 {
        // `max` and `min` return the other bound for NaN.
        let v = speed_mps.max(Self::LEAST_SPEED_MPS);
        let per_acceleration =
            self.steering_per_curvature_radm / (v * v) + self.understeer_gradient_rads2pm;
        (self.max_mps2 * per_acceleration).max(0.0).min(max_angle_rad)
    }
}

/// The model and the loop that the controller was designed for.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
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
    /// Delay of the yaw loop beyond the model's own, s (0 under a Gauss–Seidel coupling).
    pub loop_delay_s: f64,
    /// Delay of the loop through the path beyond the model's own, s.
    #[serde(default)]
    pub path_delay_s: f64,
    /// Delay of the loop through pose estimator and path beyond the model's own, s.
    #[serde(default)]
    pub estimator_delay_s: f64,
    /// The actuator before the model; absent where the model has its own, and in files of earlier versions.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub actuator: Option<StatedActuator>,
    /// The quality of the model.
    #[serde(default)]
    pub quality: Quality,
}

/// What moves the steering to a commanded angle, where the model's drive has the angle behind it: `T δ̇ + δ = u(t − τ)`.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct StatedActuator {
    /// Time constant T, s.
    pub time_constant_s: f64,
    /// Delay τ, s.
    pub delay_s: f64,
}

impl Document for Pid {
    const SCHEMA: &'static str = "steerwright/pid/1";

    fn check(&self, c: &mut Checker) {
        c.positive(self.sample_time_s, "sample_time_s");
        self.gains.check(c, "gains.");
        check_fields!(c.positive(self.limits, "limits."):
            max_angle_rad max_increment_rad max_rate_radps);
        if let Some(l) = self.limits.large_errors {
            check_fields!(c.positive(l, "limits.large_errors."):
                max_yaw_error_rad sustained_rate_radps rate_reserve_time_s);
            check_fields!(c.not_negative(l, "limits.large_errors."): yaw_rate_lag_s);
        }
        if let Some(l) = self.limits.lateral_acceleration {
            let at = "limits.lateral_acceleration.";
            check_fields!(c.positive(l, at): max_mps2 steering_per_curvature_radm);
            check_fields!(c.not_negative(l, at): understeer_gradient_rads2pm);
        }
        check_fields!(c.positive(self.specification, "specification."):
            step_rad steady_state_time_s settling_band_percent);
        check_fields!(c.not_negative(self.designed_for, "designed_for."):
            loop_delay_s path_delay_s estimator_delay_s);
        if let Some(actuator) = self.designed_for.actuator {
            check_fields!(c.not_negative(actuator, "designed_for.actuator."):
                time_constant_s delay_s);
        }
        self.designed_for.quality.check(c, "designed_for.quality.");
        self.guidance.check(c, "guidance.");
        check_speeds(c, self.schedule.iter().map(|entry| entry.speed_mps));
        for (i, entry) in self.schedule.iter().enumerate() {
            entry.check(c, &format!("schedule[{i}]."));
        }
    }
}

impl Described for Pid {
    fn facts(self) -> Facts {
        let (e, d) = (self.evidence, self.designed_for);
        let mut facts = quality_facts(d.quality);
        facts.push(Fact::new("specification_met", e.met, ""));
        facts.extend(e.shortfalls.into_iter().map(|s| {
            let line = format!("{}: {} required, {} reached", s.requirement, s.required, s.reached);
            Fact::new("shortfall", line, "")
        }));
        facts.extend([
            Fact::new("designed_for", d.name, ""),
            Fact::new("designed_for_sha256", d.sha256, ""),
            Fact::new("speed", d.speed_mps, "m/s"),
            Fact::new("loop_delay", d.loop_delay_s, "s"),
            Fact::new("overshoot", e.step.overshoot_percent, "%"),
        ]);
        facts.extend(e.step.settling_time_s.map(|time| Fact::new("settling_time", time, "s")));
        facts.push(Fact::new("steady_state_error", e.step.steady_state_error_percent, "%"));
        facts.push(Fact::new("modulus_margin", e.margins.modulus_margin, ""));
        facts.extend(
            e.margins.phase_margin_deg.map(|margin| Fact::new("phase_margin", margin, "deg")),
        );
        Facts { name: self.name, provenance: Some(self.provenance), evidence: facts }
    }
}
