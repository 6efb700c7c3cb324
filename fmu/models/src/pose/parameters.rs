//! The parameters of the filter.

use crate::Error;
use crate::sideslip::Sideslip;
use serde::{Deserialize, Serialize};
use std::f64::consts::PI;

/// Where the sensors are, how noisy they are, and where the vehicle may be at the start.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct PoseParameters {
    /// Age of a fix when it arrives, s.
    pub gnss_latency: f64,
    /// Time between fixes that are taken from the inputs without a changed count, s; 0 for none.
    pub gnss_period: f64,
    /// The antenna ahead of the centre of gravity, m.
    pub antenna_x: f64,
    /// The antenna to the left of the centre of gravity, m.
    pub antenna_y: f64,
    /// The sideslip of the vehicle.
    pub sideslip: Sideslip,
    /// Density of the gyro's white noise, (rad/s)/√Hz.
    pub yaw_rate_noise_density: f64,
    /// Density of the random walk of the gyro's bias, (rad/s²)/√Hz.
    pub yaw_rate_bias_density: f64,
    /// Density of the speed's white noise, (m/s)/√Hz.
    pub speed_noise_density: f64,
    /// Density of the lateral velocity beyond the sideslip, (m/s)/√Hz.
    pub lateral_velocity_noise_density: f64,
    /// Position at the start, m.
    pub initial_x: f64,
    /// Position at the start, m.
    pub initial_y: f64,
    /// Yaw at the start, rad.
    pub initial_yaw: f64,
    /// Standard deviation of each coordinate at the start, m.
    pub initial_position_std: f64,
    /// Standard deviation of the yaw at the start, rad.
    pub initial_yaw_std: f64,
    /// Standard deviation of the gyro's bias at the start, rad/s.
    pub initial_yaw_rate_bias_std: f64,
}

impl Default for PoseParameters {
    /// An automotive gyro and wheel speeds; a start known to a metre and six degrees.
    fn default() -> Self {
        Self {
            gnss_latency: 0.0,
            gnss_period: 0.0,
            antenna_x: 0.0,
            antenna_y: 0.0,
            sideslip: Sideslip::default(),
            yaw_rate_noise_density: 1e-3,
            yaw_rate_bias_density: 5e-5,
            speed_noise_density: 0.05,
            lateral_velocity_noise_density: 0.05,
            initial_x: 0.0,
            initial_y: 0.0,
            initial_yaw: 0.0,
            initial_position_std: 1.0,
            initial_yaw_std: 0.1,
            initial_yaw_rate_bias_std: 0.01,
        }
    }
}

impl PoseParameters {
    /// Largest latency, s: the length of the history.
    pub const LONGEST_LATENCY: f64 = 10.0;

    /// The shortest and the longest period of fixes, s.
    pub const PERIODS: [f64; 2] = [1e-6, 3600.0];

    /// Checks the ranges of the parameters.
    ///
    /// # Errors
    /// Names the value that is wrong.
    pub fn check(&self) -> Result<(), Error> {
        // None at all, or one whose ends a step can count.
        let [shortest, longest] = if self.gnss_period == 0.0 { [0.0; 2] } else { Self::PERIODS };
        for (name, value, min, max) in [
            ("the GNSS latency", self.gnss_latency, 0.0, Self::LONGEST_LATENCY),
            ("the period of the fixes", self.gnss_period, shortest, longest),
            ("the antenna's x", self.antenna_x, -100.0, 100.0),
            ("the antenna's y", self.antenna_y, -100.0, 100.0),
            ("the sideslip per yaw rate", self.sideslip.per_yaw_rate, -10.0, 10.0),
            ("the sideslip's growth", self.sideslip.growth, -1.0, 1.0),
            ("the sideslip per yaw acceleration", self.sideslip.per_yaw_acceleration, -1.0, 1.0),
            ("the sideslip's reference speed", self.sideslip.reference_speed, 0.0, 1e3),
            ("the distance to the rear axle", self.sideslip.distance_rear, 0.0, 100.0),
            ("the density of the yaw rate's noise", self.yaw_rate_noise_density, 0.0, 100.0),
            ("the density of the bias's walk", self.yaw_rate_bias_density, 0.0, 100.0),
            ("the density of the speed's noise", self.speed_noise_density, 0.0, 1e3),
            (
                "the density of the lateral velocity's noise",
                self.lateral_velocity_noise_density,
                0.0,
                1e3,
            ),
            ("the initial x", self.initial_x, f64::MIN, f64::MAX),
            ("the initial y", self.initial_y, f64::MIN, f64::MAX),
            ("the initial yaw", self.initial_yaw, f64::MIN, f64::MAX),
            ("the position's initial deviation", self.initial_position_std, 0.0, 1e6),
            ("the yaw's initial deviation", self.initial_yaw_std, 0.0, PI),
            ("the bias's initial deviation", self.initial_yaw_rate_bias_std, 0.0, 10.0),
        ] {
            if !(min..=max).contains(&value) {
                return Err(Error::Range { name, value, min, max });
            }
        }
        Ok(())
    }
}
