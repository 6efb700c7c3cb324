//! `vehicle.json` of a single-track model: the same equations and numbers, so that a file is what was validated.
//!
//! The identified characteristics of an axle are those of its two tyres, with what it loses by lateral load transfer.
//! So the tyres have no sensitivity to the load, and the height of the centre of gravity matters to braking and
//! driving alone.

use crate::structures::single_track::dynamics::ROLL_TIME_CONSTANT_S;
use crate::structures::single_track::model::SingleTrackModel;
use crate::structures::single_track::parameters::Parameter;
use steerwright_formats::{Body, Document, Quality, SteeringActuator, Tyres, Vehicle};

/// What a single-track model does not have.
#[derive(Debug, Clone, PartialEq)]
pub struct VehicleOptions {
    /// A name.
    pub name: String,
    /// Mass, kg.
    pub mass_kg: f64,
    /// Left to right wheel, m; 0.58 wheelbases where `None`.
    pub track_width_m: Option<f64>,
    /// The steering ratio of the drive that the model was identified on.
    pub steering_ratio: f64,
    /// Speed that the vehicle starts with, m/s.
    pub speed_mps: f64,
}

impl Default for VehicleOptions {
    fn default() -> Self {
        Self {
            name: "identified vehicle".into(),
            mass_kg: 1500.0,
            track_width_m: None,
            steering_ratio: 1.0,
            speed_mps: 20.0,
        }
    }
}

/// Largest rate (rad/s) and angle (rad) of the road wheels, which are not identified: beyond those of any drive.
const ROAD_WHEEL_LIMITS: [f64; 2] = [10.0, 0.7];

impl SingleTrackModel {
    /// The vehicle of this model.
    #[must_use]
    pub fn vehicle(&self, options: &VehicleOptions) -> Vehicle {
        let p = |parameter| self.get(parameter);
        let (wheelbase, share) = (p(Parameter::Wheelbase), p(Parameter::FrontShare));
        let (a, b) = (wheelbase * (1.0 - share), wheelbase * share);
        let weight = options.mass_kg * crate::structures::single_track::dynamics::GRAVITY;
        Vehicle {
            schema: Vehicle::SCHEMA.into(),
            name: options.name.clone(),
            body: Body {
                mass_kg: options.mass_kg,
                yaw_inertia_kgm2: p(Parameter::DynamicIndex) * options.mass_kg * a * b,
                distance_front_m: a,
                distance_rear_m: b,
                centre_of_gravity_height_m: p(Parameter::HeightRatio) * wheelbase,
                track_width_m: options.track_width_m.unwrap_or(0.58 * wheelbase),
                roll_stiffness_front: 0.5,
                roll_time_constant_s: ROLL_TIME_CONSTANT_S,
                drive_share_front: p(Parameter::DriveShare),
                brake_share_front: p(Parameter::BrakeShare),
                side_force_area_m2: 0.0,
                side_force_arm_m: 0.0,
            },
            tyres: Tyres {
                cornering_stiffness_front_npr: p(Parameter::StiffnessFront) * weight * share,
                cornering_stiffness_rear_npr: p(Parameter::StiffnessRear) * weight * (1.0 - share),
                friction_coefficient: p(Parameter::FrictionFront),
                friction_balance_rear: p(Parameter::FrictionBalance),
                shape_factor: p(Parameter::ShapeFactor),
                curvature_factor: p(Parameter::CurvatureFactor),
                friction_load_sensitivity: 0.0,
                stiffness_load_sensitivity: 0.0,
                combined_slip: 1.0,
            },
            actuator: SteeringActuator {
                steering_ratio: options.steering_ratio / p(Parameter::SteeringFactor),
                time_constant_s: p(Parameter::Lag),
                delay_s: p(Parameter::Delay),
                road_wheel_rate_max_radps: ROAD_WHEEL_LIMITS[0],
                road_wheel_angle_max_rad: ROAD_WHEEL_LIMITS[1],
                play_rad: 0.0,
            },
            speed_mps: options.speed_mps,
            sideslip: None,
            evidence: None,
            quality: Quality::default(),
            provenance: None,
        }
    }
}
