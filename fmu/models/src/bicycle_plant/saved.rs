//! The bicycle plant's state as it is saved.

use super::BicyclePlant;
use crate::Error;
use crate::bicycle::BicycleParameters;
use crate::delay::{DelayLine, History};
use crate::error::finite;
use crate::quadrature::Pose;
use serde::{Deserialize, Serialize};

/// Inputs, parameters and states of a [`BicyclePlant`].
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct SavedBicyclePlant {
    parameters: BicycleParameters,
    started: BicycleParameters,
    steering_angle: f64,
    steering_rate: f64,
    speed: f64,
    initial_pose: Pose,
    initial_states: [f64; 3],
    pose: Pose,
    w: [f64; 3],
    history: History,
}

impl BicyclePlant {
    /// The whole plant.
    #[must_use]
    pub fn save(&self) -> SavedBicyclePlant {
        SavedBicyclePlant {
            parameters: self.parameters,
            started: self.started,
            steering_angle: self.steering_angle,
            steering_rate: self.steering_rate,
            speed: self.speed,
            initial_pose: Pose { x: self.initial_x, y: self.initial_y, yaw: self.initial_yaw },
            initial_states: self.initial_states,
            pose: self.pose,
            w: self.w,
            history: self.delay.save(),
        }
    }

    /// The plant that was saved.
    ///
    /// # Errors
    /// Where no plant can be in that state.
    pub fn restore(saved: &SavedBicyclePlant) -> Result<Self, Error> {
        // Parameters that were set but not started with may be any numbers.
        finite("a parameter", &saved.parameters.numbers())?;
        saved.started.check()?;
        finite("an input", &[saved.steering_angle, saved.steering_rate, saved.speed])?;
        finite("a state", &saved.w)?;
        finite("an initial state", &saved.initial_states)?;
        saved.initial_pose.check()?;
        saved.pose.check()?;
        let mut delay = DelayLine::new(saved.started.actuator_delay, 0.0);
        delay.restore(saved.history.clone())?;
        let Pose { x, y, yaw } = saved.initial_pose;
        Ok(Self {
            parameters: saved.parameters,
            steering_angle: saved.steering_angle,
            steering_rate: saved.steering_rate,
            speed: saved.speed,
            initial_x: x,
            initial_y: y,
            initial_yaw: yaw,
            initial_states: saved.initial_states,
            started: saved.started,
            coefficients: saved.started.coefficients(),
            delay,
            pose: saved.pose,
            w: saved.w,
        })
    }
}
