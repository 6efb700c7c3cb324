//! `vehicle.json` of a single-track model.
//!
//! The NonlinearVehicle has four tyres of one friction coefficient, whose axles lose grip by the lateral load
//! transfer, no longitudinal forces, no lift and no relaxation. An axle with the relative transfer q has the
//! peak `μ·F_z·(1 − k_μ·q²)`; μ, the axles' shares in the roll stiffness and, where it must, k_μ are chosen
//! so that both axles have their identified peaks at the front axle's limit. What the axles lose of their
//! stiffness by lateral load transfer is part of their identified characteristic, so k_C is zero.

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

/// Time constant of the load transfer, which is not identified, s.
const ROLL_TIME_CONSTANT_S: f64 = 0.12;
/// Largest rate (rad/s) and angle (rad) of the road wheels, which are not identified.
const ROAD_WHEEL_LIMITS: [f64; 2] = [1.0, 0.7];
/// Least and largest k_μ.
const SENSITIVITIES: [f64; 2] = [0.02, 0.9];

impl SingleTrackModel {
    /// The vehicle of this model, without what a vehicle does not have; a negative delay becomes zero.
    #[must_use]
    pub fn vehicle(&self, options: &VehicleOptions) -> Vehicle {
        let p = |parameter| self.get(parameter);
        let (wheelbase, share) = (p(Parameter::Wheelbase), p(Parameter::FrontShare));
        let (a, b) = (wheelbase * (1.0 - share), wheelbase * share);
        let weight = options.mass_kg * crate::structures::single_track::dynamics::GRAVITY;
        let height = p(Parameter::HeightRatio) * wheelbase;
        let track = options.track_width_m.unwrap_or(0.58 * wheelbase);
        let grip = self.grip(2.0 * height / track);
        Vehicle {
            schema: Vehicle::SCHEMA.into(),
            name: options.name.clone(),
            body: Body {
                mass_kg: options.mass_kg,
                yaw_inertia_kgm2: p(Parameter::DynamicIndex) * options.mass_kg * a * b,
                distance_front_m: a,
                distance_rear_m: b,
                centre_of_gravity_height_m: height,
                track_width_m: track,
                roll_stiffness_front: grip.share,
                roll_time_constant_s: ROLL_TIME_CONSTANT_S,
            },
            tyres: Tyres {
                cornering_stiffness_front_npr: p(Parameter::StiffnessFront) * weight * share,
                cornering_stiffness_rear_npr: p(Parameter::StiffnessRear) * weight * (1.0 - share),
                friction_coefficient: grip.friction,
                shape_factor: p(Parameter::ShapeFactor),
                curvature_factor: p(Parameter::CurvatureFactor),
                friction_load_sensitivity: grip.sensitivity,
                stiffness_load_sensitivity: 0.0,
            },
            actuator: SteeringActuator {
                steering_ratio: options.steering_ratio / p(Parameter::SteeringFactor),
                time_constant_s: p(Parameter::Lag),
                delay_s: p(Parameter::Delay).max(0.0),
                road_wheel_rate_max_radps: ROAD_WHEEL_LIMITS[0],
                road_wheel_angle_max_rad: ROAD_WHEEL_LIMITS[1],
            },
            speed_mps: options.speed_mps,
            evidence: None,
            quality: Quality::default(),
            provenance: None,
        }
    }

    /// Friction whose loss by load transfer leaves the identified peaks; `lever` is 2·h/track.
    fn grip(&self, lever: f64) -> Grip {
        let p = |parameter| self.get(parameter);
        let (friction, balance) = (p(Parameter::FrictionFront), p(Parameter::FrictionBalance));
        let front_share = p(Parameter::FrontShare);
        // Transfers over the static wheel loads at the limit of the front axle; a wheel may lift.
        let transfers = |share: f64| {
            let all = lever * friction;
            [
                (share * all / front_share).min(1.0),
                ((1.0 - share) * all / (1.0 - front_share)).min(1.0),
            ]
        };
        let balance_of = |share: f64, k: f64| {
            let [front, rear] = transfers(share);
            (1.0 - k * rear * rear) / (1.0 - k * front * front)
        };
        let [least, most] = SENSITIVITIES;
        let mut sensitivity = p(Parameter::FrictionLoadSensitivity).clamp(least, most);
        let reached = |k: f64| (balance_of(0.0, k)..=balance_of(1.0, k)).contains(&balance);
        while !reached(sensitivity) && sensitivity < most {
            sensitivity = (1.05 * sensitivity).min(most);
        }
        // The balance rises with the front axle's share.
        let (mut low, mut high) = (0.0, 1.0);
        for _ in 0..50 {
            let middle = 0.5 * (low + high);
            if balance_of(middle, sensitivity) < balance { low = middle } else { high = middle }
        }
        let share = 0.5 * (low + high);
        let [front, _] = transfers(share);
        Grip { friction: friction / (1.0 - sensitivity * front * front), sensitivity, share }
    }
}

/// μ, k_μ and the front axle's share in the roll stiffness.
struct Grip {
    friction: f64,
    sensitivity: f64,
    share: f64,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_vehicle_has_the_peaks_of_the_model() {
        for balance in [0.95, 1.0, 1.15, 1.3] {
            let model = SingleTrackModel::default().with(Parameter::FrictionBalance, balance);
            let vehicle = model.vehicle(&VehicleOptions::default());
            vehicle.clone().checked("vehicle.json").unwrap();
            let (body, tyres) = (vehicle.body, vehicle.tyres);
            let limit = model.get(Parameter::FrictionFront) * 9.81;
            let peak = |share: f64, of_weight: f64| {
                let transfer = share * body.centre_of_gravity_height_m * limit / body.track_width_m;
                // Beyond 1 the inner wheel is off the road.
                let q = (transfer / (0.5 * of_weight * 9.81)).min(1.0);
                tyres.friction_coefficient * (1.0 - tyres.friction_load_sensitivity * q * q)
            };
            let share = model.get(Parameter::FrontShare);
            let front = peak(body.roll_stiffness_front, share);
            let rear = peak(1.0 - body.roll_stiffness_front, 1.0 - share);
            assert!((front / model.get(Parameter::FrictionFront) - 1.0).abs() < 1e-6);
            assert!((rear / front - balance).abs() < 1e-6, "{balance}: {}", rear / front);
        }
    }
}
