//! What the vehicle is made of.

use crate::Error;
use crate::bicycle::BicycleParameters;
use serde::{Deserialize, Serialize};
use steerwright_formats::{Body, SteeringActuator, Tyres, VehicleData};

/// A vehicle with saturating tyres, load transfer and a steering actuator.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct NonlinearParameters {
    /// Mass, inertia and dimensions.
    pub body: Body,
    /// The tyres: equal at all wheels except for the stiffness.
    pub tyres: Tyres,
    /// The steering.
    pub actuator: SteeringActuator,
}

impl Default for NonlinearParameters {
    /// The BMW 320i of CommonRoad's parameter set 2 (commonroad-vehicle-models 3.0.2), with the steering
    /// at the road wheel; the README of `fmu/nonlinear-vehicle` has the sources of its tyres and its roll.
    ///
    /// CommonRoad leaves out the tyres' PDY2 = −0.18033 and PKY2 = 2.0012; at the mean static wheel load,
    /// 0.553 of the nominal one, these give the two sensitivities: 0.18033·0.553/1.0489, and 2/(p² + 1),
    /// the slope of sin(2 atan(F/(PKY2·4850 N)))/F, with p = 2.0012/0.553.
    fn default() -> Self {
        Self {
            body: Body {
                mass_kg: 1093.2952,
                yaw_inertia_kgm2: 1791.5995,
                distance_front_m: 1.156_195_7,
                distance_rear_m: 1.422_717_1,
                centre_of_gravity_height_m: 0.575,
                track_width_m: 1.375,
                roll_stiffness_front: 0.515,
                roll_time_constant_s: 0.123,
                drive_share_front: 0.5,
                brake_share_front: 0.65,
                side_force_area_m2: 4.4,
                side_force_arm_m: 0.3,
            },
            tyres: Tyres {
                cornering_stiffness_front_npr: 129_696.69,
                cornering_stiffness_rear_npr: 105_400.27,
                friction_coefficient: 1.0489,
                friction_balance_rear: 1.0,
                shape_factor: 1.3507,
                curvature_factor: -0.007_472_2,
                friction_load_sensitivity: 0.095,
                stiffness_load_sensitivity: 0.142,
                combined_slip: 0.0,
            },
            actuator: SteeringActuator {
                steering_ratio: 1.0,
                time_constant_s: 0.05,
                delay_s: 0.0,
                road_wheel_rate_max_radps: 0.4,
                road_wheel_angle_max_rad: 1.066,
                play_rad: 0.0,
            },
        }
    }
}

impl NonlinearParameters {
    /// The bicycle that this vehicle is at small slip.
    #[must_use]
    pub fn bicycle(&self) -> BicycleParameters {
        let Self { body, tyres, actuator } = self;
        (&VehicleData::in_gentle_driving(body, tyres, actuator)).into()
    }

    /// Checks that this can be a vehicle.
    ///
    /// # Errors
    /// Names the value that is wrong.
    pub fn check(&self) -> Result<(), Error> {
        self.bicycle().check()?;
        // Lower and upper ends keep the equations defined: friction and stiffness above zero at
        // every load, forces that saturate, panels that are not absurdly short.
        for (name, value, min, max) in [
            ("the friction coefficient", self.tyres.friction_coefficient, 0.01, 10.0),
            ("the friction balance", self.tyres.friction_balance_rear, 0.01, 100.0),
            ("the tyres' shape factor", self.tyres.shape_factor, 1.0, 1.99),
            ("the tyres' curvature factor", self.tyres.curvature_factor, -1.5, 1.0),
            ("the load sensitivity of friction", self.tyres.friction_load_sensitivity, 0.0, 0.9),
            ("the load sensitivity of stiffness", self.tyres.stiffness_load_sensitivity, 0.0, 0.9),
            (
                "the height of the centre of gravity",
                self.body.centre_of_gravity_height_m,
                0.0,
                10.0,
            ),
            ("the track width", self.body.track_width_m, 0.01, 100.0),
            ("the front share of the roll stiffness", self.body.roll_stiffness_front, 0.0, 1.0),
            ("the roll's time constant", self.body.roll_time_constant_s, 1e-3, 100.0),
            ("the front share of the driving force", self.body.drive_share_front, 0.0, 1.0),
            ("the front share of the braking force", self.body.brake_share_front, 0.0, 1.0),
            ("the area in a crosswind", self.body.side_force_area_m2, 0.0, 1e4),
            ("the arm of the crosswind", self.body.side_force_arm_m, -100.0, 100.0),
            ("the play of the steering", self.actuator.play_rad, 0.0, 0.5),
            ("the combined slip", self.tyres.combined_slip, 0.0, 1.0),
            ("the actuator's time constant", self.actuator.time_constant_s, 1e-4, 100.0),
            ("the actuator's delay", self.actuator.delay_s, 0.0, 10.0),
            ("the largest road-wheel rate", self.actuator.road_wheel_rate_max_radps, 1e-6, 1e6),
            ("the largest road-wheel angle", self.actuator.road_wheel_angle_max_rad, 1e-6, 1.5),
        ] {
            within(name, value, min, max)?;
        }
        Ok(())
    }
}

/// The value must lie in [min, max], which NaN does not.
pub(super) fn within(name: &'static str, value: f64, min: f64, max: f64) -> Result<(), Error> {
    if (min..=max).contains(&value) { Ok(()) } else { Err(Error::Range { name, value, min, max }) }
}
