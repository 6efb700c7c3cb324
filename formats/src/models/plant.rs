//! `plant.json`: the identified lateral dynamics, steering angle in, yaw rate out.

use crate::document::{Checker, Document};
use crate::facts::{Described, Fact, Facts, quality_facts};
use crate::matrix::Matrix;
use crate::models::evidence::Evidence;
use crate::models::sideslip::Sideslip;
use crate::models::state_space::{Continuous, Discrete};
use crate::models::uncertainty::Uncertainty;
use crate::provenance::Provenance;
use crate::quality::Quality;
use serde::{Deserialize, Serialize};

/// The identified plant: model, operating point, noise, evidence and provenance.
///
/// The model's input is `steering − steering_offset_rad` (times speed where
/// [`InputKind::SteeringTimesSpeed`]), delayed by `input_delay_s`; its output is
/// `yaw rate − yaw_rate_offset_radps`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Plant {
    /// `steerwright/plant/1`.
    pub schema: String,
    /// A name, such as the log's.
    pub name: String,
    /// Input of the model.
    pub input: InputKind,
    /// Steering angle over road-wheel angle.
    pub steering_ratio: f64,
    /// Pure delay from steering angle to the model's input, in seconds.
    pub input_delay_s: f64,
    /// The point about which the model is valid.
    pub operating_point: OperatingPoint,
    /// The model in innovation form (eq 3–5).
    pub discrete: Discrete,
    /// The continuous model (eq 6–11); absent if A has no real logarithm.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub continuous: Option<Continuous>,
    /// The noise as identified.
    pub noise: Noise,
    /// The sideslip; absent if the drive does not determine it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub sideslip: Option<Sideslip>,
    /// The uncertainty of the model; absent if it was not estimated.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub uncertainty: Option<Uncertainty>,
    /// The evidence for the quality of the model.
    pub evidence: Evidence,
    /// Whether a controller may be designed on the model.
    #[serde(default)]
    pub quality: Quality,
    /// The sources of the file.
    pub provenance: Provenance,
}

/// Input of the model.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum InputKind {
    /// The steering angle.
    #[serde(rename = "steering")]
    Steering,
    /// The product of steering angle and speed.
    #[serde(rename = "steering*speed")]
    SteeringTimesSpeed,
}

crate::words!(InputKind { Steering = "steering", SteeringTimesSpeed = "steering*speed" });

/// The point about which the model is linear.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct OperatingPoint {
    /// Mean speed of the drive, m/s.
    pub speed_mps: f64,
    /// The steering angle that drives straight, in steering coordinates.
    pub steering_offset_rad: f64,
    /// The yaw rate at that angle; zero if the model has a steady-state gain, by which the steering
    /// offset then represents it.
    pub yaw_rate_offset_radps: f64,
}

/// The noise as identified.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Noise {
    /// Variance of the innovation e, (rad/s)².
    pub innovation_variance: f64,
}

impl Plant {
    /// Order n of the model.
    #[must_use]
    pub fn order(&self) -> usize {
        self.discrete.a.rows()
    }

    /// The number of standard normal numbers that [`Plant::ensemble_member`] needs; 0 if the file has no
    /// uncertainty.
    #[must_use]
    pub fn ensemble_dimension(&self) -> usize {
        self.uncertainty.as_ref().map_or(0, |u| u.directions.rows())
    }

    /// The plant whose discrete model is `nominal + Σ ξ_i · direction_i`: for independent standard
    /// normal ξ a draw from the estimate's distribution, to first order. It carries no continuous
    /// model and has no uncertainty.
    ///
    /// `None` if the plant has no uncertainty, if the number of ξ is not
    /// [`Plant::ensemble_dimension`], or if the drawn model is unstable: draw again for the
    /// distribution of stable models.
    #[must_use]
    pub fn ensemble_member(&self, xi: &[f64]) -> Option<Self> {
        let directions = &self.uncertainty.as_ref()?.directions;
        if xi.len() != directions.rows() {
            return None;
        }
        let mut member = self.clone();
        let d = &mut member.discrete;
        let places =
            [&mut d.a, &mut d.b, &mut d.c, &mut d.d, &mut d.k].into_iter().flat_map(|m| &mut m.0);
        for (k, entry) in places.flatten().enumerate() {
            for (row, xi) in directions.0.iter().zip(xi) {
                *entry += xi * row.get(k)?;
            }
        }
        member.continuous = None;
        member.uncertainty = None;
        if is_stable(&member.discrete.a) { Some(member) } else { None }
    }
}

/// Whether the powers A, A², A⁴, A⁸ … vanish.
fn is_stable(a: &Matrix) -> bool {
    let n = a.rows();
    if a.columns() != Some(n) {
        return false;
    }
    let mut power = a.0.clone();
    for _ in 0..48 {
        let size = power.iter().flatten().fold(0.0_f64, |s, x| s + x * x).sqrt();
        if size < 0.5 {
            return true;
        }
        if !size.is_finite() || size > 1e100 {
            return false;
        }
        let square = |i: usize, j: usize| (0..n).map(|k| power[i][k] * power[k][j]).sum();
        power = (0..n).map(|i| (0..n).map(|j| square(i, j)).collect()).collect();
    }
    false
}

impl Document for Plant {
    const SCHEMA: &'static str = "steerwright/plant/1";

    fn check(&self, c: &mut Checker) {
        let d = &self.discrete;
        let n = d.a.rows();
        c.positive(self.steering_ratio, "steering_ratio");
        c.not_negative(self.input_delay_s, "input_delay_s");
        c.not_negative(self.operating_point.speed_mps, "operating_point.speed_mps");
        check_fields!(c.finite(self.operating_point, "operating_point."):
            steering_offset_rad yaw_rate_offset_radps);
        c.positive(d.sample_time_s, "discrete.sample_time_s");
        c.require((1..=64).contains(&n), "discrete.A", || {
            format!("the order is {n}, expected 1 to 64")
        });
        c.shape(&d.a, n, n, "discrete.A");
        c.shape(&d.b, n, 1, "discrete.B");
        c.shape(&d.c, 1, n, "discrete.C");
        c.shape(&d.d, 1, 1, "discrete.D");
        c.shape(&d.k, n, 1, "discrete.K");
        c.require(d.x0.len() == n, "discrete.x0", || {
            format!("{} entries, expected {n}", d.x0.len())
        });
        for (i, x) in d.x0.iter().enumerate() {
            c.finite(*x, &format!("discrete.x0[{i}]"));
        }
        if let Some(actuator) = &self.evidence.actuator {
            actuator.check(c, "evidence.actuator.");
        }
        if let Some(vehicle) = &self.evidence.held_for {
            vehicle.check(c, vehicle.f.rows(), "evidence.held_for");
        }
        if let Some(continuous) = &self.continuous {
            continuous.check(c, n, "continuous");
        }
        c.not_negative(self.noise.innovation_variance, "noise.innovation_variance");
        if let Some(s) = &self.sideslip {
            s.check(c);
        }
        if let Some(uncertainty) = &self.uncertainty {
            uncertainty.check(n, c);
        }
        self.quality.check(c, "quality.");
    }
}

impl Described for Plant {
    fn facts(self) -> Facts {
        let order = self.order();
        let e = self.evidence;
        let mut facts = quality_facts(self.quality);
        facts.extend(e.warnings.into_iter().map(|line| Fact::new("warning", line, "")));
        facts.extend([
            Fact::new("fit_held_out", e.fit.validation, "%"),
            Fact::new("fit_held_out_one_step", e.fit.validation_one_step, "%"),
            Fact::new("fit_estimation", e.fit.estimation, "%"),
            Fact::new("method", e.method, ""),
            Fact::new("order", order, ""),
            Fact::new("horizon", e.horizon, ""),
            Fact::new("estimation_samples", e.estimation_samples, ""),
            Fact::new("held_out_samples", e.validation_samples, ""),
            Fact::new("sample_time", self.discrete.sample_time_s, "s"),
            Fact::new("informative_up_to", e.excitation.informative_up_to_hz, "Hz"),
            Fact::new("speed", self.operating_point.speed_mps, "m/s"),
            Fact::new("steering_ratio", self.steering_ratio, ""),
            Fact::new("input_delay", self.input_delay_s, "s"),
        ]);
        Facts { name: self.name, provenance: Some(self.provenance), evidence: facts }
    }
}
