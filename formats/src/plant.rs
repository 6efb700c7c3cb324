//! `plant.json`: the identified lateral dynamics, steering angle in, yaw rate out.

use crate::{Checker, Document, Evidence, Matrix, Provenance, Quality, Uncertainty};
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
    /// A name for people, such as the log's.
    pub name: String,
    /// What drives the model.
    pub input: InputKind,
    /// Steering angle over road-wheel angle.
    pub steering_ratio: f64,
    /// Pure delay from steering angle to the model's input, in seconds.
    pub input_delay_s: f64,
    /// Where the model holds.
    pub operating_point: OperatingPoint,
    /// The model in innovation form (eq 3–5).
    pub discrete: Discrete,
    /// The continuous model (eq 6–11), absent where A has no real logarithm.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub continuous: Option<Continuous>,
    /// The noise as identified.
    pub noise: Noise,
    /// How far the course leads the yaw, absent where the drive did not determine it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub sideslip: Option<Sideslip>,
    /// How uncertain the model is, absent where that was not estimated.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub uncertainty: Option<Uncertainty>,
    /// How far the model can be trusted.
    pub evidence: Evidence,
    /// Whether a controller may be designed on the model.
    #[serde(default)]
    pub quality: Quality,
    /// Where it came from.
    pub provenance: Provenance,
}

/// What drives the model.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum InputKind {
    /// The steering angle.
    #[serde(rename = "steering")]
    Steering,
    /// The product of steering angle and speed.
    #[serde(rename = "steering*speed")]
    SteeringTimesSpeed,
}

/// The point about which the model is linear.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct OperatingPoint {
    /// Mean speed of the drive, m/s.
    pub speed_mps: f64,
    /// The steering angle that drives straight, in steering coordinates.
    pub steering_offset_rad: f64,
    /// The yaw rate at that angle; not zero only where the model has no steady-state gain to put
    /// it on the steering offset.
    pub yaw_rate_offset_radps: f64,
}

/// `x⁺ = A x + B u + K e`, `y = C x + D u + e` (eq 3–5).
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Discrete {
    /// Sample time T.
    pub sample_time_s: f64,
    /// State matrix, n by n.
    #[serde(rename = "A")]
    pub a: Matrix,
    /// Input matrix, n by 1.
    #[serde(rename = "B")]
    pub b: Matrix,
    /// Output matrix, 1 by n.
    #[serde(rename = "C")]
    pub c: Matrix,
    /// Feedthrough, 1 by 1.
    #[serde(rename = "D")]
    pub d: Matrix,
    /// Kalman gain, n by 1.
    #[serde(rename = "K")]
    pub k: Matrix,
    /// State at the log's first sample.
    pub x0: Vec<f64>,
}

/// `ẋ = F x + G u`, `y = H x + D u` (eq 6–8), the exact zero-order-hold inverse of [`Discrete`].
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Continuous {
    /// State matrix, n by n.
    #[serde(rename = "F")]
    pub f: Matrix,
    /// Input matrix, n by 1.
    #[serde(rename = "G")]
    pub g: Matrix,
    /// Output matrix, 1 by n.
    #[serde(rename = "H")]
    pub h: Matrix,
}

/// The noise as identified.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Noise {
    /// Variance of the innovation e, (rad/s)².
    pub innovation_variance: f64,
}

/// The sideslip of the centre of gravity, from where a receiver's fixes lead: with the yaw rate r and
/// the lateral acceleration `a = v·r`, course minus yaw is `(S + Q·a²)·r + C·dr/dt`.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Sideslip {
    /// S, sideslip angle per yaw rate, s: in gentle turns where the growth is stated, else a mean over
    /// the drive's turns.
    pub sideslip_per_yaw_rate_s: f64,
    /// Its standard error, s; of the fixes' and the gyro's noise, and of the fixes' age where that is
    /// estimated.
    pub standard_error_s: f64,
    /// Q, what S grows by per squared lateral acceleration, s⁵/m²; absent where the drive does not
    /// determine it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub sideslip_growth_s5pm2: Option<SideslipTerm>,
    /// C, sideslip angle per yaw acceleration, s²; absent where the drive does not determine it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub sideslip_per_yaw_acceleration_s2: Option<SideslipTerm>,
    /// The age of a fix in the identification, s: an error of it is an error of the sideslip.
    pub gnss_latency_s: f64,
    /// The standard error of that age, s; absent where the age was stated.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub gnss_latency_standard_error_s: Option<f64>,
    /// The antenna ahead of the centre of gravity in the identification, m.
    pub antenna_x_m: f64,
}

/// A term of the sideslip, in the unit of its name.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SideslipTerm {
    /// As found.
    pub value: f64,
    /// Its standard error, of the fixes' and the gyro's noise alone.
    pub standard_error: f64,
}

impl Sideslip {
    /// Q, s⁵/m²; 0 where it is not known.
    #[must_use]
    pub fn growth(&self) -> f64 {
        self.sideslip_growth_s5pm2.map_or(0.0, |term| term.value)
    }

    /// C, s²; 0 where it is not known.
    #[must_use]
    pub fn per_yaw_acceleration(&self) -> f64 {
        self.sideslip_per_yaw_acceleration_s2.map_or(0.0, |term| term.value)
    }

    fn check(&self, c: &mut Checker) {
        let mut within = |value: f64, limit: f64, field: &str| {
            c.require((-limit..=limit).contains(&value), &format!("sideslip.{field}"), || {
                format!("{value} must be from -{limit} to {limit}")
            });
        };
        within(self.sideslip_per_yaw_rate_s, 10.0, "sideslip_per_yaw_rate_s");
        let growth = "sideslip_growth_s5pm2";
        within(self.growth(), 1.0, &format!("{growth}.value"));
        let acceleration = "sideslip_per_yaw_acceleration_s2";
        within(self.per_yaw_acceleration(), 10.0, &format!("{acceleration}.value"));
        c.not_negative(self.standard_error_s, "sideslip.standard_error_s");
        let terms = [
            (self.sideslip_growth_s5pm2, growth),
            (self.sideslip_per_yaw_acceleration_s2, acceleration),
        ];
        for (term, name) in terms {
            let error = term.map_or(0.0, |term| term.standard_error);
            c.not_negative(error, &format!("sideslip.{name}.standard_error"));
        }
        c.not_negative(self.gnss_latency_s, "sideslip.gnss_latency_s");
        let age_error = self.gnss_latency_standard_error_s.unwrap_or(0.0);
        c.not_negative(age_error, "sideslip.gnss_latency_standard_error_s");
        c.finite(self.antenna_x_m, "sideslip.antenna_x_m");
    }
}

impl Plant {
    /// Sideslip per yaw rate, s; 0 where it is not known.
    #[must_use]
    pub fn sideslip_per_yaw_rate_s(&self) -> f64 {
        self.sideslip.map_or(0.0, |sideslip| sideslip.sideslip_per_yaw_rate_s)
    }

    /// Order n of the model.
    #[must_use]
    pub fn order(&self) -> usize {
        self.discrete.a.rows()
    }
}

impl Document for Plant {
    const SCHEMA: &'static str = "steerwright/plant/1";

    fn schema(&self) -> &str {
        &self.schema
    }

    fn check(&self, c: &mut Checker) {
        let d = &self.discrete;
        let n = d.a.rows();
        c.positive(self.steering_ratio, "steering_ratio");
        c.not_negative(self.input_delay_s, "input_delay_s");
        c.not_negative(self.operating_point.speed_mps, "operating_point.speed_mps");
        c.finite(self.operating_point.steering_offset_rad, "operating_point.steering_offset_rad");
        c.finite(
            self.operating_point.yaw_rate_offset_radps,
            "operating_point.yaw_rate_offset_radps",
        );
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
        if let Some(continuous) = &self.continuous {
            c.shape(&continuous.f, n, n, "continuous.F");
            c.shape(&continuous.g, n, 1, "continuous.G");
            c.shape(&continuous.h, 1, n, "continuous.H");
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
