//! `vehicle.json`: a vehicle with saturating tyres, load transfer and a steering actuator.
//!
//! Identified in a log, or written by hand as the example in this repository, `examples/drives/multibody/vehicle.json`.
//! The README of `NonlinearVehicle` documents the numbers.

use crate::document::{Checker, Document};
use crate::facts::{Described, Fact, Facts, quality_facts};
use crate::models::sideslip::Sideslip;
use crate::models::vehicle_evidence::VehicleEvidence;
use crate::provenance::Provenance;
use crate::quality::Quality;
use serde::{Deserialize, Serialize};

/// A vehicle up to its limits.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Vehicle {
    /// `steerwright/vehicle/1`.
    pub schema: String,
    /// A name.
    pub name: String,
    /// Mass, inertia and dimensions.
    pub body: Body,
    /// The tyres: equal at all wheels except for the stiffness.
    pub tyres: Tyres,
    /// The steering.
    pub actuator: SteeringActuator,
    /// Longitudinal velocity that the `speed` input starts with, m/s.
    pub speed_mps: f64,
    /// The sideslip that the drive determines, which may differ from that of the model; absent if it determines none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub sideslip: Option<Sideslip>,
    /// The evidence for its quality, if it was identified from a log.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub evidence: Option<VehicleEvidence>,
    /// Whether a controller may be designed on it.
    #[serde(default, skip_serializing_if = "is_default")]
    pub quality: Quality,
    /// The sources of the file, if it was identified from a log.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub provenance: Option<Provenance>,
}

fn default_friction_balance() -> f64 {
    1.0
}

fn half() -> f64 {
    0.5
}

/// Brakes as in cars, which load the front axle.
fn brake_share() -> f64 {
    0.65
}

fn is_default(quality: &Quality) -> bool {
    *quality == Quality::default()
}

/// Mass, inertia and dimensions.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Body {
    /// Mass m, kg.
    pub mass_kg: f64,
    /// Yaw inertia J, kg·m².
    pub yaw_inertia_kgm2: f64,
    /// Centre of gravity to front axle L_f, m.
    pub distance_front_m: f64,
    /// Centre of gravity to rear axle L_r, m.
    pub distance_rear_m: f64,
    /// Height of the centre of gravity h, m.
    pub centre_of_gravity_height_m: f64,
    /// Left to right wheel, m.
    pub track_width_m: f64,
    /// Share of the front axle in the roll stiffness, 0 to 1.
    pub roll_stiffness_front: f64,
    /// Time constant of the load transfer, s.
    pub roll_time_constant_s: f64,
    /// Share of the front axle in the driving force, 0 to 1; 0.5 where it is not stated.
    #[serde(default = "half")]
    pub drive_share_front: f64,
    /// Share of the front axle in the braking force, 0 to 1; 0.65 where it is not stated.
    #[serde(default = "brake_share")]
    pub brake_share_front: f64,
    /// Area in a crosswind, m²: force to the side over dynamic pressure and angle of the air, rad; 0 where it is not stated:
    /// the wind then has no effect.
    #[serde(default)]
    pub side_force_area_m2: f64,
    /// How far ahead of the centre of gravity that force acts, m, negative behind; 0 where it is not stated.
    #[serde(default)]
    pub side_force_arm_m: f64,
}

/// Tyres by the magic formula.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Tyres {
    /// Cornering stiffness of the front axle at the static load, N/rad.
    pub cornering_stiffness_front_npr: f64,
    /// Cornering stiffness of the rear axle at the static load, N/rad.
    pub cornering_stiffness_rear_npr: f64,
    /// Peak lateral force over load at the static wheel load, of the front axle.
    pub friction_coefficient: f64,
    /// That of the rear axle over that of the front axle; 1 where it is not stated.
    #[serde(default = "default_friction_balance")]
    pub friction_balance_rear: f64,
    /// C of the magic formula, 1 to 1.99.
    pub shape_factor: f64,
    /// E of the magic formula, −1.5 to 1.
    pub curvature_factor: f64,
    /// Relative loss of friction at twice the static wheel load, 0 to 0.9.
    pub friction_load_sensitivity: f64,
    /// Relative loss of stiffness over load at twice the static wheel load, 0 to 0.9.
    pub stiffness_load_sensitivity: f64,
    /// Share of the driving and braking force that the friction bears beside the lateral force, 0 to 1; 0 where it is not
    /// stated: the lateral force is then that of wheels that roll freely.
    #[serde(default)]
    pub combined_slip: f64,
}

/// The actuator of the road wheels.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SteeringActuator {
    /// Steering angle over road-wheel angle.
    pub steering_ratio: f64,
    /// Time constant, s.
    pub time_constant_s: f64,
    /// Pure delay before it, s.
    pub delay_s: f64,
    /// Largest rate of the road-wheel angle, rad/s.
    pub road_wheel_rate_max_radps: f64,
    /// Largest road-wheel angle to either side, rad.
    pub road_wheel_angle_max_rad: f64,
    /// Play between actuator and road wheels from stop to stop, rad at the road wheel; 0 where it is not stated.
    #[serde(default)]
    pub play_rad: f64,
}

impl Document for Vehicle {
    const SCHEMA: &'static str = "steerwright/vehicle/1";

    fn check(&self, c: &mut Checker) {
        let (b, t, a) = (&self.body, &self.tyres, &self.actuator);
        check_fields!(c.positive(b, "body."):
            mass_kg yaw_inertia_kgm2 distance_front_m distance_rear_m);
        c.not_negative(b.centre_of_gravity_height_m, "body.centre_of_gravity_height_m");
        c.positive(b.track_width_m, "body.track_width_m");
        c.within(b.roll_stiffness_front, 0.0, 1.0, "body.roll_stiffness_front");
        c.positive(b.roll_time_constant_s, "body.roll_time_constant_s");
        c.within(b.drive_share_front, 0.0, 1.0, "body.drive_share_front");
        c.within(b.brake_share_front, 0.0, 1.0, "body.brake_share_front");
        c.not_negative(b.side_force_area_m2, "body.side_force_area_m2");
        c.finite(b.side_force_arm_m, "body.side_force_arm_m");
        check_fields!(c.positive(t, "tyres."):
            cornering_stiffness_front_npr cornering_stiffness_rear_npr friction_coefficient
            friction_balance_rear);
        c.within(t.shape_factor, 1.0, 1.99, "tyres.shape_factor");
        c.within(t.curvature_factor, -1.5, 1.0, "tyres.curvature_factor");
        c.within(t.friction_load_sensitivity, 0.0, 0.9, "tyres.friction_load_sensitivity");
        c.within(t.stiffness_load_sensitivity, 0.0, 0.9, "tyres.stiffness_load_sensitivity");
        c.within(t.combined_slip, 0.0, 1.0, "tyres.combined_slip");
        check_fields!(c.positive(a, "actuator."): steering_ratio time_constant_s);
        c.not_negative(a.delay_s, "actuator.delay_s");
        check_fields!(c.positive(a, "actuator."): road_wheel_rate_max_radps road_wheel_angle_max_rad);
        c.not_negative(a.play_rad, "actuator.play_rad");
        c.not_negative(self.speed_mps, "speed_mps");
        if let Some(sideslip) = &self.sideslip {
            sideslip.check(c);
        }
        if let Some(evidence) = &self.evidence {
            evidence.check(c, "evidence.");
        }
        self.quality.check(c, "quality.");
    }
}

impl Described for Vehicle {
    fn facts(self) -> Facts {
        // One that was written by hand has no quality of its own.
        let identified = self.provenance.is_some();
        let mut facts = if identified { quality_facts(self.quality) } else { Vec::new() };
        facts.extend([
            Fact::new("speed", self.speed_mps, "m/s"),
            Fact::new("steering_ratio", self.actuator.steering_ratio, ""),
            Fact::new("friction_coefficient", self.tyres.friction_coefficient, ""),
        ]);
        Facts { name: self.name, provenance: self.provenance, evidence: facts }
    }
}
