//! A vehicle as plain data, to be kept and read again, perhaps in another process.

use super::dynamics::Constants;
use super::parameters::NonlinearParameters;
use super::vehicle::NonlinearVehicle;
use crate::Error;
use crate::delay::{DelayLine, History};
use crate::error::finite;
use crate::quadrature::Pose;
use serde::{Deserialize, Serialize};

/// All that a [`NonlinearVehicle`] is.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct SavedVehicle {
    parameters: NonlinearParameters,
    started: NonlinearParameters,
    /// Steering angle, its slope, speed.
    inputs: [f64; 3],
    initial_pose: Pose,
    initial_states: [f64; 4],
    pose: Pose,
    /// (v_y, r, δ, a_φ).
    states: [f64; 4],
    followed_speed: Option<f64>,
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
            initial_pose: Pose { x: self.initial_x, y: self.initial_y, yaw: self.initial_yaw },
            initial_states: self.initial_states,
            pose: self.pose,
            states: self.states(),
            followed_speed: self.followed_speed,
            history: self.delay.save(),
        }
    }

    /// The vehicle that was saved. The data may come from anywhere.
    ///
    /// # Errors
    /// Names what cannot be.
    pub fn restore(saved: SavedVehicle) -> Result<Self, Error> {
        // What is started was checked at the start; what is set since is checked at the next.
        saved.started.check()?;
        finite("an input", &saved.inputs)?;
        finite("an initial state", &saved.initial_states)?;
        finite("a state", &saved.states)?;
        finite("the speed that the load has followed", saved.followed_speed.as_slice())?;
        saved.initial_pose.check()?;
        saved.pose.check()?;
        let [steering_angle, steering_slope, speed] = saved.inputs;
        let Pose { x: initial_x, y: initial_y, yaw: initial_yaw } = saved.initial_pose;
        let [lateral_velocity, yaw_rate, angle, roll] = saved.states;
        if angle.abs() > saved.started.actuator.road_wheel_angle_max_rad {
            let expected = "between the end stops";
            return Err(Error::SavedState { name: "the road-wheel angle", value: angle, expected });
        }
        let mut delay = DelayLine::new(saved.started.actuator.delay_s, 0.0);
        delay.restore(saved.history)?;
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
            pose: saved.pose,
            lateral: [lateral_velocity, yaw_rate, roll],
            angle,
            followed_speed: saved.followed_speed,
            delay,
        })
    }
}
