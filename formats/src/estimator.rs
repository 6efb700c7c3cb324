//! `estimator.json`: the sensors of a pose estimator.
//!
//! Written by hand; the example in this repository is `examples/drives/multibody/estimator.json`. The README
//! of `PoseEstimator` documents the numbers.

use crate::document::{Checker, Document};
use crate::is_zero;
use serde::{Deserialize, Serialize};

/// Sensors, their noise, and the initial uncertainty.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Estimator {
    /// `steerwright/estimator/1`.
    pub schema: String,
    /// A name.
    pub name: String,
    /// The receiver and its antenna.
    pub gnss: Gnss,
    /// Sideslip angle per yaw rate in a steady turn, s; at small lateral acceleration if the growth is
    /// stated.
    pub sideslip_per_yaw_rate_s: f64,
    /// Growth of the sideslip per yaw rate, per squared lateral acceleration, s⁵/m²; 0 or omitted if
    /// unknown.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub sideslip_growth_s5pm2: f64,
    /// Sideslip angle per yaw acceleration, s²; 0 may be omitted.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub sideslip_per_yaw_acceleration_s2: f64,
    /// Distance from centre of gravity to rear axle, m, by which the sideslip follows the speed from that at
    /// `speed_mps`; 0 or omitted if unknown, which keeps the sideslip per yaw rate at all speeds.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub distance_rear_m: f64,
    /// Noise of gyro and speed.
    pub noise: SensorNoise,
    /// Uncertainty of the initial state.
    pub initial: InitialUncertainty,
    /// Longitudinal velocity that the `speed` input starts with, and at which the sideslip is stated, m/s.
    pub speed_mps: f64,
}

/// The receiver and its antenna.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Gnss {
    /// Age of a fix when it arrives, s; at most 10.
    pub latency_s: f64,
    /// The antenna ahead of the centre of gravity, m.
    pub antenna_x_m: f64,
    /// The antenna to the left of the centre of gravity, m.
    pub antenna_y_m: f64,
    /// Standard deviation of a fix in each coordinate that the `gnss_std` input starts with, m; by
    /// default 0, with which no fix is used.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub std_m: Option<f64>,
    /// Time between fixes that are taken from the inputs without a changed count, s; by default
    /// there are none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub period_s: Option<f64>,
}

/// Noise densities: a white noise of density q adds up to q·√t in t seconds.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SensorNoise {
    /// Of the gyro, (rad/s)/√Hz.
    pub yaw_rate_density: f64,
    /// Of what the gyro's bias walks by, (rad/s²)/√Hz.
    pub yaw_rate_bias_density: f64,
    /// Of the speed, (m/s)/√Hz.
    pub speed_density: f64,
    /// Of the lateral velocity that the sideslip does not explain, (m/s)/√Hz.
    pub lateral_velocity_density: f64,
}

/// Standard deviations at the start.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct InitialUncertainty {
    /// Of each coordinate, m.
    pub position_std_m: f64,
    /// Of the yaw, rad; above 0.5 it is initialised from the direction of the first fixes.
    pub yaw_std_rad: f64,
    /// Of the gyro's bias, rad/s.
    pub yaw_rate_bias_std_radps: f64,
}

impl Document for Estimator {
    const SCHEMA: &'static str = "steerwright/estimator/1";

    fn check(&self, c: &mut Checker) {
        let (g, n, i) = (&self.gnss, &self.noise, &self.initial);
        for (value, min, max, path) in [
            (g.latency_s, 0.0, 10.0, "gnss.latency_s"),
            (g.antenna_x_m, -100.0, 100.0, "gnss.antenna_x_m"),
            (g.antenna_y_m, -100.0, 100.0, "gnss.antenna_y_m"),
            (g.std_m.unwrap_or(0.0), 0.0, 1e6, "gnss.std_m"),
            (g.period_s.unwrap_or(0.0), 0.0, 3600.0, "gnss.period_s"),
            (self.sideslip_per_yaw_rate_s, -10.0, 10.0, "sideslip_per_yaw_rate_s"),
            (self.sideslip_growth_s5pm2, -1.0, 1.0, "sideslip_growth_s5pm2"),
            (self.sideslip_per_yaw_acceleration_s2, -1.0, 1.0, "sideslip_per_yaw_acceleration_s2"),
            (self.distance_rear_m, 0.0, 100.0, "distance_rear_m"),
            (n.yaw_rate_density, 0.0, 100.0, "noise.yaw_rate_density"),
            (n.yaw_rate_bias_density, 0.0, 100.0, "noise.yaw_rate_bias_density"),
            (n.speed_density, 0.0, 1e3, "noise.speed_density"),
            (n.lateral_velocity_density, 0.0, 1e3, "noise.lateral_velocity_density"),
            (i.position_std_m, 0.0, 1e6, "initial.position_std_m"),
            (i.yaw_std_rad, 0.0, std::f64::consts::PI, "initial.yaw_std_rad"),
            (i.yaw_rate_bias_std_radps, 0.0, 10.0, "initial.yaw_rate_bias_std_radps"),
        ] {
            c.within(value, min, max, path);
        }
        c.not_negative(self.speed_mps, "speed_mps");
    }
}
