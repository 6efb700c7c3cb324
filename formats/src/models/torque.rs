//! `torque.json`: the response of the lateral acceleration to a steering torque or its normalised command.

use crate::document::{Checker, Document};
use crate::matrix::Matrix;
use crate::models::evidence::ChannelSummary;
use crate::models::uncertainty::Estimate;
use crate::provenance::Provenance;
use crate::quality::Quality;
use serde::{Deserialize, Serialize};

/// `a(t) = K·(u(t − d) − f·tanh(ω/ω0)) + ρ·g·sin(roll) + b`, with the lateral acceleration a, the command u, and the
/// rate ω of the steering angle. Positive to the left, in the coordinates of the log.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Torque {
    /// `steerwright/torque/1`.
    pub schema: String,
    /// A name, such as the log's.
    pub name: String,
    /// Unit of the command: `Nm`, or `1` for a normalised one.
    pub command_unit: String,
    /// K, lateral acceleration per command, m/s² per unit of the command.
    pub acceleration_per_command: Estimate,
    /// f, command that overcomes the friction of the steering.
    pub friction: Estimate,
    /// ω0, rate of the steering angle at which friction reaches 76 % of f, rad/s in coordinates of the log.
    pub friction_rate_radps: f64,
    /// ρ, share of the gravity along the banked road that acts on the lateral acceleration; absent if the log has no
    /// roll.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub roll_coefficient: Option<Estimate>,
    /// b, lateral acceleration without command on a level road, m/s².
    pub offset_mps2: Estimate,
    /// d, delay from command to lateral acceleration, s.
    pub delay_s: Estimate,
    /// Covariance of (K, K·f, ρ, b, d), 5 by 5, in the units of these; zeros where ρ is absent.
    pub covariance: Matrix,
    /// The evidence.
    pub evidence: TorqueEvidence,
    /// Whether the model may be used.
    #[serde(default)]
    pub quality: Quality,
    /// The sources of the file.
    pub provenance: Provenance,
}

/// The data of a torque model, and its errors.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TorqueEvidence {
    /// What was read from each column.
    pub channels: Vec<ChannelSummary>,
    /// Number of estimation samples.
    pub estimation_samples: usize,
    /// Number of validation samples.
    pub validation_samples: usize,
    /// Sample time, s.
    pub sample_time_s: f64,
    /// Number of blocks of time whose sums of errors determine the covariance.
    pub blocks: usize,
    /// Lowest speed of the samples, m/s.
    pub least_speed_mps: f64,
    /// Mean speed of the estimation samples, m/s.
    pub mean_speed_mps: f64,
    /// Standard deviation of the errors on the estimation data, m/s².
    pub error_mps2: f64,
    /// Fit on the estimation data, percent.
    pub estimation_fit: f64,
    /// Fit on validation data, percent.
    pub validation_fit: f64,
    /// Warnings of the reader.
    pub warnings: Vec<String>,
}

impl Document for Torque {
    const SCHEMA: &'static str = "steerwright/torque/1";

    fn check(&self, c: &mut Checker) {
        let estimates = [
            (Some(self.acceleration_per_command), "acceleration_per_command"),
            (Some(self.friction), "friction"),
            (self.roll_coefficient, "roll_coefficient"),
            (Some(self.offset_mps2), "offset_mps2"),
            (Some(self.delay_s), "delay_s"),
        ];
        for (estimate, key) in estimates {
            let Some(estimate) = estimate else { continue };
            c.finite(estimate.value, &format!("{key}.value"));
            c.not_negative(estimate.standard_error, &format!("{key}.standard_error"));
        }
        c.positive(self.friction_rate_radps, "friction_rate_radps");
        c.covariance(&self.covariance, 5, "covariance");
        let e = &self.evidence;
        c.positive(e.sample_time_s, "evidence.sample_time_s");
        check_fields!(c.finite(e, "evidence."): estimation_fit validation_fit error_mps2
            least_speed_mps mean_speed_mps);
        self.quality.check(c, "quality.");
    }
}
