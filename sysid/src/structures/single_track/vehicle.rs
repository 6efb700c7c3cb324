//! `vehicle.json` of a single-track model: the same equations and numbers, so that a file is what was validated.
//!
//! The identified characteristics of an axle are those of its two tyres, with what it loses by lateral load transfer.
//! So the tyres have no sensitivity to the load, and the height of the centre of gravity matters to braking and
//! driving alone.

use crate::structures::single_track::dynamics::ROLL_TIME_CONSTANT_S;
use crate::structures::single_track::model::SingleTrackModel;
use crate::structures::single_track::parameters::Parameter;
use steerwright_formats::{Body, Document, Quality, SteeringActuator, Tyres, Vehicle, VehicleData};

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

/// Largest rate (rad/s) and angle (rad) of the road wheels, beyond those of any drive: a rate that the drive does not show, and
/// the angle, which is not identified.
pub(crate) const ROAD_WHEEL_LIMITS: [f64; 2] = [10.0, 0.7];

impl SingleTrackModel {
    /// Of the data of a bicycle, with the tyres beyond their cornering stiffness and what braking and driving do by the means of
    /// the priors.
    #[must_use]
    pub fn from_bicycle(data: &VehicleData) -> Self {
        let (a, b) = (data.distance_front_m, data.distance_rear_m);
        let (wheelbase, mass) = (a + b, data.mass_kg);
        let weight = mass * crate::structures::single_track::dynamics::GRAVITY;
        [
            (
                Parameter::StiffnessFront,
                data.cornering_stiffness_front_npr * wheelbase / (weight * b),
            ),
            (
                Parameter::StiffnessRear,
                data.cornering_stiffness_rear_npr * wheelbase / (weight * a),
            ),
            (Parameter::Wheelbase, wheelbase),
            (Parameter::DynamicIndex, data.yaw_inertia_kgm2 / (mass * a * b)),
            (Parameter::FrontShare, b / wheelbase),
            (Parameter::Lag, data.actuator_time_constant_s),
            (Parameter::Delay, data.actuator_delay_s),
        ]
        .into_iter()
        .fold(Self::default(), |model, (parameter, value)| model.with(parameter, value))
    }

    /// The reverse of [`SingleTrackModel::vehicle`], by the steering ratio of the vehicle. Sensitivities to the load, which the
    /// model does not have, are left out.
    #[must_use]
    pub fn from_vehicle(vehicle: &Vehicle) -> Self {
        let (body, tyres) = (&vehicle.body, &vehicle.tyres);
        let wheelbase = body.distance_front_m + body.distance_rear_m;
        [
            (Parameter::FrictionFront, tyres.friction_coefficient),
            (Parameter::FrictionBalance, tyres.friction_balance_rear),
            (Parameter::ShapeFactor, tyres.shape_factor),
            (Parameter::CurvatureFactor, tyres.curvature_factor),
            (Parameter::HeightRatio, body.centre_of_gravity_height_m / wheelbase),
            (Parameter::DriveShare, body.drive_share_front),
            (Parameter::BrakeShare, body.brake_share_front),
            (Parameter::RateMax, vehicle.actuator.road_wheel_rate_max_radps),
        ]
        .into_iter()
        .fold(Self::from_bicycle(&vehicle.in_gentle_driving()), |model, (parameter, value)| {
            model.with(parameter, value)
        })
    }

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
                // But for the rounding of its logarithm.
                road_wheel_rate_max_radps: if p(Parameter::RateMax)
                    < (1.0 - 1e-9) * ROAD_WHEEL_LIMITS[0]
                {
                    p(Parameter::RateMax)
                } else {
                    ROAD_WHEEL_LIMITS[0]
                },
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
