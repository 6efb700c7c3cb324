//! A vehicle as plain data, to be kept and read again, perhaps in another process.

use super::dynamics::Constants;
use super::parameters::NonlinearParameters;
use super::vehicle::{NonlinearVehicle, within_play};
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
    /// Steering angle, its slope, speed, crosswind.
    inputs: [f64; 4],
    initial_pose: Pose,
    initial_states: [f64; 4],
    pose: Pose,
    /// (v_y, r, δ, a_φ).
    states: [f64; 4],
    /// δ behind the play.
    wheel: f64,
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
            inputs: [self.steering_angle, self.steering_slope, self.speed, self.crosswind],
            initial_pose: Pose { x: self.initial_x, y: self.initial_y, yaw: self.initial_yaw },
            initial_states: self.initial_states,
            pose: self.pose,
            states: self.states(),
            wheel: self.wheel,
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
        let [steering_angle, steering_slope, speed, crosswind] = saved.inputs;
        let Pose { x: initial_x, y: initial_y, yaw: initial_yaw } = saved.initial_pose;
        let [lateral_velocity, yaw_rate, angle, roll] = saved.states;
        if angle.abs() > saved.started.actuator.road_wheel_angle_max_rad {
            let expected = "between the end stops";
            return Err(Error::SavedState { name: "the road-wheel angle", value: angle, expected });
        }
        let half_gap = 0.5 * saved.started.actuator.play_rad;
        if within_play(saved.wheel, angle, half_gap) != saved.wheel {
            let expected = "within the play about the actuator's angle";
            let name = "the road-wheel angle behind the play";
            return Err(Error::SavedState { name, value: saved.wheel, expected });
        }
        let mut delay = DelayLine::new(saved.started.actuator.delay_s, 0.0);
        delay.restore(saved.history)?;
        Ok(Self {
            parameters: saved.parameters,
            steering_angle,
            steering_slope,
            speed,
            crosswind,
            initial_x,
            initial_y,
            initial_yaw,
            initial_states: saved.initial_states,
            started: saved.started,
            constants: Constants::new(&saved.started),
            pose: saved.pose,
            lateral: [lateral_velocity, yaw_rate, roll],
            angle,
            wheel: saved.wheel,
            followed_speed: saved.followed_speed,
            delay,
        })
    }
}
