//! `speed_controller.json`: a controller of the speed with the evidence that it meets its specification.

use crate::controllers::loop_metrics::Shortfall;
use crate::document::{Checker, Document};
use crate::facts::{Described, Fact, Facts, quality_facts};
use crate::models::Longitudinal;
use crate::provenance::Provenance;
use crate::quality::Quality;
use serde::{Deserialize, Serialize};

/// The controller, its specification, the results of its design, and the model that it inverts.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SpeedController {
    /// `steerwright/speed-controller/1`.
    pub schema: String,
    /// A name.
    pub name: String,
    /// Sample time, s.
    pub sample_time_s: f64,
    /// Gains.
    pub gains: SpeedGains,
    /// Limits and thresholds.
    pub limits: SpeedLimits,
    /// The specification.
    pub specification: SpeedSpecification,
    /// The results of the design.
    pub evidence: SpeedEvidence,
    /// Whether the controller may be used: the quality of the model, and of the design.
    #[serde(default)]
    pub quality: Quality,
    /// The model that the controller was designed on, and that its feedforward inverts.
    pub model: Longitudinal,
    /// The sources of the file.
    pub provenance: Provenance,
}

/// Gains of a speed controller.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SpeedGains {
    /// Proportional gain, acceleration per error of the speed, 1/s.
    pub kp_per_s: f64,
    /// Integral gain, 1/s².
    pub ki_per_s2: f64,
    /// Rate at which the reference model approaches the speed reference, 1/s.
    pub reference_rate_per_s: f64,
}

/// Limits and thresholds of a speed controller.
// `ProfileLimits` are others: a share of these, so that the controller can follow the profile, or unlimited.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SpeedLimits {
    /// Largest acceleration, m/s².
    pub max_acceleration_mps2: f64,
    /// Largest deceleration, m/s².
    pub max_deceleration_mps2: f64,
    /// Largest jerk to either side, m/s³.
    pub max_jerk_mps3: f64,
    /// Demand beyond 0 at which the other pedal is used, m/s².
    pub pedal_hysteresis_mps2: f64,
    /// Speed below which the vehicle is held where the speed reference is 0, m/s; the brake is released from this
    /// reference on.
    pub hold_speed_mps: f64,
    /// Deceleration of the held brake in addition to that which the grade requires, m/s².
    pub hold_deceleration_mps2: f64,
}

/// The specification of a speed controller. Every requirement is optional; the other fields define the test it refers to.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SpeedSpecification {
    /// Largest overshoot, percent of the step.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub overshoot_percent: Option<f64>,
    /// Longest settling time, s.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub settling_time_s: Option<f64>,
    /// Largest steady-state error, percent of the step: on the step, and on the grade.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub steady_state_error_percent: Option<f64>,
    /// Band within which the response has settled, percent of the step to either side.
    pub settling_band_percent: f64,
    /// Height of the step of the speed, m/s.
    pub step_mps: f64,
    /// Grade that begins at once and is not measured, percent.
    pub grade_percent: f64,
    /// When the steady-state error is read, s after the step or the beginning of the grade.
    pub steady_state_time_s: f64,
    /// Lowest and highest speed of the design, m/s.
    pub speeds_mps: [f64; 2],
}

/// The results of the design of a speed controller.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SpeedEvidence {
    /// Whether the nominal model keeps every requirement at every speed.
    pub met: bool,
    /// The requirements that the nominal model misses, each at its worst speed.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub shortfalls: Vec<Shortfall>,
    /// The responses of the nominal model at speeds of the range.
    pub speeds: Vec<SpeedResponses>,
    /// The same responses in the loop of the packed FMUs, coupled as by Gauss and Seidel, from the tick at which the
    /// controller reads the reference.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub fmu_loop: Vec<SpeedResponses>,
    /// The vehicles drawn from the covariance of the model; absent where none were drawn.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub ensemble: Option<SpeedEnsemble>,
    /// What limits the design, and what would allow it.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub advice: Vec<String>,
}

/// The responses at a speed.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SpeedResponses {
    /// Speed before the step up, after the step down, and on the grade, m/s.
    pub speed_mps: f64,
    /// Step up.
    pub up: SpeedStep,
    /// Step down.
    pub down: SpeedStep,
    /// Error on the grade at the steady-state time, percent of the step.
    pub error_on_grade_percent: f64,
    /// Largest loss of speed on the grade, m/s.
    pub largest_loss_on_grade_mps: f64,
}

/// A step of the speed.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SpeedStep {
    /// Overshoot, percent of the step.
    pub overshoot_percent: f64,
    /// Time after which the response stays within the band; absent if it never does.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub settling_time_s: Option<f64>,
    /// Error at the steady-state time, percent of the step.
    pub steady_state_error_percent: f64,
}

/// The vehicles drawn from the covariance of the model.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SpeedEnsemble {
    /// Number of vehicles.
    pub vehicles: usize,
    /// Vehicles that keep every requirement at every speed.
    pub keeping: usize,
    /// Largest overshoot of all, percent of the step.
    pub overshoot_percent: f64,
    /// Longest settling time of all, s; absent if one never settles.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub settling_time_s: Option<f64>,
    /// Largest steady-state error of all, percent of the step.
    pub steady_state_error_percent: f64,
}

impl Document for SpeedController {
    const SCHEMA: &'static str = "steerwright/speed-controller/1";

    fn check(&self, c: &mut Checker) {
        c.within(self.sample_time_s, 1e-6, 1.0, "sample_time_s");
        check_fields!(c.not_negative(self.gains, "gains."): kp_per_s ki_per_s2);
        c.positive(self.gains.reference_rate_per_s, "gains.reference_rate_per_s");
        check_fields!(c.positive(self.limits, "limits."): max_acceleration_mps2 max_deceleration_mps2
            max_jerk_mps3);
        check_fields!(c.not_negative(self.limits, "limits."): pedal_hysteresis_mps2 hold_speed_mps
            hold_deceleration_mps2);
        let s = &self.specification;
        for (bound, key) in [
            (s.overshoot_percent, "overshoot_percent"),
            (s.settling_time_s, "settling_time_s"),
            (s.steady_state_error_percent, "steady_state_error_percent"),
        ] {
            c.not_negative(bound.unwrap_or(0.0), &format!("specification.{key}"));
        }
        check_fields!(c.positive(s, "specification."): settling_band_percent step_mps
            steady_state_time_s);
        c.finite(s.grade_percent, "specification.grade_percent");
        for (i, speed) in s.speeds_mps.iter().enumerate() {
            c.not_negative(*speed, &format!("specification.speeds_mps[{i}]"));
        }
        self.quality.check(c, "quality.");
        if let Err(error) = self.model.checked("model") {
            c.require(false, "model", || error.to_string());
        }
    }
}

impl Described for SpeedController {
    fn facts(self) -> Facts {
        let (e, s) = (self.evidence, self.specification);
        let mut facts = quality_facts(self.quality);
        facts.extend([
            Fact::new("requirements_met", e.met, ""),
            Fact::new("lowest_speed", s.speeds_mps[0], "m/s"),
            Fact::new("highest_speed", s.speeds_mps[1], "m/s"),
            Fact::new("model", self.model.name, ""),
            Fact::new("command_unit", self.model.command_unit, ""),
        ]);
        if let Some(ensemble) = e.ensemble {
            facts.push(Fact::new("ensemble_vehicles", ensemble.vehicles, ""));
            facts.push(Fact::new("ensemble_vehicles_keeping", ensemble.keeping, ""));
        }
        Facts { name: self.name, provenance: Some(self.provenance), evidence: facts }
    }
}
