//! What the vehicle is made of.

use crate::Error;
use crate::bicycle::BicycleParameters;
use serde::{Deserialize, Serialize};

/// A vehicle with saturating tyres, load transfer and a steering actuator.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct NonlinearParameters {
    /// Mass m, kg.
    pub mass: f64,
    /// Yaw inertia J, kg·m².
    pub yaw_inertia: f64,
    /// Centre of gravity to front axle L_f, m.
    pub distance_front: f64,
    /// Centre of gravity to rear axle L_r, m.
    pub distance_rear: f64,
    /// Cornering stiffness of the front axle at the static load, N/rad.
    pub cornering_stiffness_front: f64,
    /// Cornering stiffness of the rear axle at the static load, N/rad.
    pub cornering_stiffness_rear: f64,
    /// Peak lateral force over load at the static wheel load, μ.
    pub friction_coefficient: f64,
    /// C of the magic formula, in [1, 1.99].
    pub tyre_shape_factor: f64,
    /// E of the magic formula, in [−1.5, 1].
    pub tyre_curvature_factor: f64,
    /// By how much μ falls from the static wheel load to twice that, relative; in [0, 0.9].
    pub friction_load_sensitivity: f64,
    /// By how much cornering stiffness over load falls likewise; in [0, 0.9].
    pub stiffness_load_sensitivity: f64,
    /// Height of the centre of gravity h, m.
    pub centre_of_gravity_height: f64,
    /// Left to right wheel, m.
    pub track_width: f64,
    /// Share of the front axle in the roll stiffness, in [0, 1].
    pub roll_stiffness_front: f64,
    /// Time constant of the load transfer T_φ, s.
    pub roll_time_constant: f64,
    /// Steering angle over road-wheel angle, 1/n.
    pub steering_ratio: f64,
    /// Time constant of the steering actuator T_n, s.
    pub actuator_time_constant: f64,
    /// Delay before the actuator, s.
    pub actuator_delay: f64,
    /// Largest rate of the road-wheel angle, rad/s.
    pub road_wheel_rate_max: f64,
    /// Largest road-wheel angle to either side, rad: the end stops.
    pub road_wheel_angle_max: f64,
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
            mass: 1093.2952,
            yaw_inertia: 1791.5995,
            distance_front: 1.156_195_7,
            distance_rear: 1.422_717_1,
            cornering_stiffness_front: 129_696.69,
            cornering_stiffness_rear: 105_400.27,
            friction_coefficient: 1.0489,
            tyre_shape_factor: 1.3507,
            tyre_curvature_factor: -0.007_472_2,
            friction_load_sensitivity: 0.095,
            stiffness_load_sensitivity: 0.142,
            centre_of_gravity_height: 0.575,
            track_width: 1.375,
            roll_stiffness_front: 0.515,
            roll_time_constant: 0.123,
            steering_ratio: 1.0,
            actuator_time_constant: 0.05,
            actuator_delay: 0.0,
            road_wheel_rate_max: 0.4,
            road_wheel_angle_max: 1.066,
        }
    }
}

impl NonlinearParameters {
    /// The bicycle that this vehicle is at small slip.
    #[must_use]
    pub fn bicycle(&self) -> BicycleParameters {
        BicycleParameters {
            mass: self.mass,
            yaw_inertia: self.yaw_inertia,
            distance_front: self.distance_front,
            distance_rear: self.distance_rear,
            cornering_stiffness_front: self.cornering_stiffness_front,
            cornering_stiffness_rear: self.cornering_stiffness_rear,
            actuator_time_constant: self.actuator_time_constant,
            actuator_delay: self.actuator_delay,
            steering_ratio: self.steering_ratio,
        }
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
            ("the friction coefficient", self.friction_coefficient, 0.01, 10.0),
            ("the tyres' shape factor", self.tyre_shape_factor, 1.0, 1.99),
            ("the tyres' curvature factor", self.tyre_curvature_factor, -1.5, 1.0),
            ("the load sensitivity of friction", self.friction_load_sensitivity, 0.0, 0.9),
            ("the load sensitivity of stiffness", self.stiffness_load_sensitivity, 0.0, 0.9),
            ("the height of the centre of gravity", self.centre_of_gravity_height, 0.0, 10.0),
            ("the track width", self.track_width, 0.01, 100.0),
            ("the front share of the roll stiffness", self.roll_stiffness_front, 0.0, 1.0),
            ("the roll's time constant", self.roll_time_constant, 1e-3, 100.0),
            ("the actuator's time constant", self.actuator_time_constant, 1e-4, 100.0),
            ("the actuator's delay", self.actuator_delay, 0.0, 10.0),
            ("the largest road-wheel rate", self.road_wheel_rate_max, 1e-6, 1e6),
            ("the largest road-wheel angle", self.road_wheel_angle_max, 1e-6, 1.5),
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
