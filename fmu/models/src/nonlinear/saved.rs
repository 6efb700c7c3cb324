//! A vehicle as plain data, to be kept and read again, perhaps in another process.

use super::dynamics::Constants;
use super::history::History;
use super::parameters::{NonlinearParameters, within};
use super::vehicle::NonlinearVehicle;
use crate::error::Error;
use crate::quadrature::Pose;
use serde::{Deserialize, Serialize};

/// All that a [`NonlinearVehicle`] is.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct SavedVehicle {
    parameters: NonlinearParameters,
    started: NonlinearParameters,
    /// Steering angle, its slope, speed.
    inputs: [f64; 3],
    /// X, Y, ψ at the start.
    initial_pose: [f64; 3],
    initial_states: [f64; 4],
    /// X, Y, ψ.
    pose: [f64; 3],
    /// (v_y, r, δ, a_φ).
    states: [f64; 4],
    history: History,
}

impl NonlinearVehicle {
    /// The vehicle as plain data.
    #[must_use]
    pub fn save(&self) -> SavedVehicle {
        SavedVehicle {
            parameters: self.parameters,
            started: self.started,
            inputs: [self.steering_angle, self.steering_slope, self.speed],
            initial_pose: [self.initial_x, self.initial_y, self.initial_yaw],
            initial_states: self.initial_states,
            pose: [self.pose.x, self.pose.y, self.pose.yaw],
            states: self.states(),
            history: self.history.clone(),
        }
    }

    /// The vehicle that was saved. The data may come from anywhere.
    ///
    /// # Errors
    /// Names what cannot be.
    pub fn restore(saved: SavedVehicle) -> Result<Self, Error> {
        // What is started was checked at the start; what is set since is checked at the next.
        saved.started.check()?;
        let [x, y, yaw] = saved.pose;
        let numbers = [
            &saved.inputs[..],
            &saved.initial_pose,
            &saved.initial_states,
            &saved.pose,
            &saved.states,
        ];
        for value in numbers.into_iter().flatten() {
            within("a number of the saved vehicle", *value, f64::MIN, f64::MAX)?;
        }
        within("the saved speed", saved.inputs[2], 0.0, f64::MAX)?;
        let stop = saved.started.road_wheel_angle_max;
        within("the saved road-wheel angle", saved.states[2], -stop, stop)?;
        saved.history.check(saved.started.actuator_delay)?;
        let [steering_angle, steering_slope, speed] = saved.inputs;
        let [initial_x, initial_y, initial_yaw] = saved.initial_pose;
        let [lateral_velocity, yaw_rate, angle, roll] = saved.states;
        Ok(Self {
            parameters: saved.parameters,
            steering_angle,
            steering_slope,
            speed,
            initial_x,
            initial_y,
            initial_yaw,
            initial_states: saved.initial_states,
            started: saved.started,
            constants: Constants::new(&saved.started),
            pose: Pose { x, y, yaw },
            lateral: [lateral_velocity, yaw_rate, roll],
            angle,
            history: saved.history,
        })
    }
}
