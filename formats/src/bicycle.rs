//! `bicycle.json`: the two-wheel bicycle model of eq 13.

use crate::{BicycleEvidence, Checker, Document, Matrix, Provenance, Quality};
use serde::{Deserialize, Serialize};

/// Vehicle data as a person writes them (the TOML that `steerwright bicycle` reads).
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct VehicleData {
    /// A name for people.
    pub name: String,
    /// Mass m, kg.
    pub mass_kg: f64,
    /// Yaw inertia J, kg·m².
    pub yaw_inertia_kgm2: f64,
    /// Centre of gravity to front axle L_f, m.
    pub distance_front_m: f64,
    /// Centre of gravity to rear axle L_r, m.
    pub distance_rear_m: f64,
    /// Cornering stiffness of the front axle C_f, N/rad.
    pub cornering_stiffness_front_npr: f64,
    /// Cornering stiffness of the rear axle C_r, N/rad.
    pub cornering_stiffness_rear_npr: f64,
    /// Time constant of the steering actuator T_n, s.
    pub actuator_time_constant_s: f64,
    /// Steering angle over road-wheel angle, 1/n.
    pub steering_ratio: f64,
    /// Longitudinal velocity V, m/s.
    pub speed_mps: f64,
}

/// The five-state model of eq 13 at constant speed, with the data it was made from.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Bicycle {
    /// `steerwright/bicycle/1`.
    pub schema: String,
    /// The vehicle.
    pub vehicle: VehicleData,
    /// The coefficients of eq 13.
    pub coefficients: BicycleCoefficients,
    /// State matrix of eq 13 for (y, ẏ, ψ, ψ̇, δ), 5 by 5.
    pub state_matrix: Matrix,
    /// Input matrix of eq 13, 5 by 1.
    pub input_matrix: Matrix,
    /// How far it can be trusted, where it was identified from a log.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub evidence: Option<BicycleEvidence>,
    /// Whether a controller may be designed on it.
    #[serde(default)]
    pub quality: Quality,
    /// Where it came from.
    pub provenance: Provenance,
}

/// The coefficients of eq 13 in the paper's letters.
#[allow(missing_docs)]
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct BicycleCoefficients {
    #[serde(rename = "A1")]
    pub a1: f64,
    #[serde(rename = "A2")]
    pub a2: f64,
    #[serde(rename = "A3")]
    pub a3: f64,
    #[serde(rename = "A4")]
    pub a4: f64,
    #[serde(rename = "B1")]
    pub b1: f64,
    #[serde(rename = "B2")]
    pub b2: f64,
    pub n: f64,
    #[serde(rename = "Tn")]
    pub tn: f64,
}

impl VehicleData {
    /// Reports values that no vehicle has; `at` is put before each key, such as `vehicle.`.
    pub fn check(&self, c: &mut Checker, at: &str) {
        for (value, key) in [
            (self.mass_kg, "mass_kg"),
            (self.yaw_inertia_kgm2, "yaw_inertia_kgm2"),
            (self.distance_front_m, "distance_front_m"),
            (self.distance_rear_m, "distance_rear_m"),
            (self.cornering_stiffness_front_npr, "cornering_stiffness_front_npr"),
            (self.cornering_stiffness_rear_npr, "cornering_stiffness_rear_npr"),
            (self.actuator_time_constant_s, "actuator_time_constant_s"),
            (self.steering_ratio, "steering_ratio"),
            (self.speed_mps, "speed_mps"),
        ] {
            c.positive(value, &format!("{at}{key}"));
        }
    }
}

impl Document for Bicycle {
    const SCHEMA: &'static str = "steerwright/bicycle/1";

    fn schema(&self) -> &str {
        &self.schema
    }

    fn check(&self, c: &mut Checker) {
        self.vehicle.check(c, "vehicle.");
        c.shape(&self.state_matrix, 5, 5, "state_matrix");
        c.shape(&self.input_matrix, 5, 1, "input_matrix");
        if let Some(evidence) = &self.evidence {
            evidence.check(c, "evidence.");
        }
        self.quality.check(c, "quality.");
    }
}
