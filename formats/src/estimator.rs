//! `estimator.json`: the sensors of a pose estimator.
//!
//! Written by hand; the example in this repository is `examples/drives/multibody/estimator.json`. The README
//! of `PoseEstimator` documents the numbers.

use crate::document::{Checker, Document};
use crate::facts::{Described, Fact, Facts};
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
    #[serde(default, skip_serializing_if = "is_zero")]
    pub std_m: f64,
    /// Time between fixes that are taken from the inputs without a changed count, s; by default
    /// there are none.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub period_s: f64,
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
    /// Of what the sideslip per yaw rate walks by, s/√s; 0 or omitted if it is constant.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub sideslip_per_yaw_rate_density: f64,
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
    /// Of the sideslip per yaw rate, s; 0 or omitted if it is known exactly.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub sideslip_per_yaw_rate_std_s: f64,
}

/// A number with its range: key, name in words, value, least and largest value.
pub type Ranged = (&'static str, &'static str, f64, f64, f64);

impl Gnss {
    /// Longest time between fixes, s.
    pub const LONGEST_PERIOD_S: f64 = 3600.0;

    /// The ranges of its numbers.
    #[must_use]
    pub fn ranges(&self) -> [Ranged; 5] {
        [
            ("latency_s", "the GNSS latency", self.latency_s, 0.0, 10.0),
            ("antenna_x_m", "the antenna's x", self.antenna_x_m, -100.0, 100.0),
            ("antenna_y_m", "the antenna's y", self.antenna_y_m, -100.0, 100.0),
            ("std_m", "the standard deviation of a fix", self.std_m, 0.0, 1e6),
            ("period_s", "the period of the fixes", self.period_s, 0.0, Self::LONGEST_PERIOD_S),
        ]
    }
}

impl SensorNoise {
    /// The ranges of its numbers.
    #[must_use]
    pub fn ranges(&self) -> [Ranged; 5] {
        let Self { yaw_rate_density, yaw_rate_bias_density, speed_density, .. } = *self;
        let (across, sideslip) =
            (self.lateral_velocity_density, self.sideslip_per_yaw_rate_density);
        [
            (
                "yaw_rate_density",
                "the density of the yaw rate's noise",
                yaw_rate_density,
                0.0,
                100.0,
            ),
            (
                "yaw_rate_bias_density",
                "the density of the bias's walk",
                yaw_rate_bias_density,
                0.0,
                100.0,
            ),
            ("speed_density", "the density of the speed's noise", speed_density, 0.0, 1e3),
            (
                "lateral_velocity_density",
                "the density of the lateral velocity's noise",
                across,
                0.0,
                1e3,
            ),
            (
                "sideslip_per_yaw_rate_density",
                "the density of the sideslip's walk",
                sideslip,
                0.0,
                10.0,
            ),
        ]
    }
}

impl InitialUncertainty {
    /// The ranges of its numbers.
    #[must_use]
    pub fn ranges(&self) -> [Ranged; 4] {
        let (position, yaw, bias) =
            (self.position_std_m, self.yaw_std_rad, self.yaw_rate_bias_std_radps);
        let sideslip = self.sideslip_per_yaw_rate_std_s;
        [
            ("position_std_m", "the position's initial deviation", position, 0.0, 1e6),
            ("yaw_std_rad", "the yaw's initial deviation", yaw, 0.0, std::f64::consts::PI),
            ("yaw_rate_bias_std_radps", "the bias's initial deviation", bias, 0.0, 10.0),
            (
                "sideslip_per_yaw_rate_std_s",
                "the initial deviation of the sideslip per yaw rate",
                sideslip,
                0.0,
                10.0,
            ),
        ]
    }
}

impl Estimator {
    /// The ranges of its sideslip: of per yaw rate, growth, per yaw acceleration, and distance to the rear axle.
    #[must_use]
    pub fn sideslip_ranges([s, q, c, b]: [f64; 4]) -> [Ranged; 4] {
        [
            ("sideslip_per_yaw_rate_s", "the sideslip per yaw rate", s, -10.0, 10.0),
            ("sideslip_growth_s5pm2", "the sideslip's growth", q, -1.0, 1.0),
            ("sideslip_per_yaw_acceleration_s2", "the sideslip per yaw acceleration", c, -1.0, 1.0),
            ("distance_rear_m", "the distance to the rear axle", b, 0.0, 100.0),
        ]
    }
}

impl Document for Estimator {
    const SCHEMA: &'static str = "steerwright/estimator/1";

    fn check(&self, c: &mut Checker) {
        let sideslip = [
            self.sideslip_per_yaw_rate_s,
            self.sideslip_growth_s5pm2,
            self.sideslip_per_yaw_acceleration_s2,
            self.distance_rear_m,
        ];
        for (at, ranges) in [
            ("gnss.", self.gnss.ranges().as_slice()),
            ("", Self::sideslip_ranges(sideslip).as_slice()),
            ("noise.", self.noise.ranges().as_slice()),
            ("initial.", self.initial.ranges().as_slice()),
        ] {
            for (key, _, value, min, max) in ranges {
                c.within(*value, *min, *max, &format!("{at}{key}"));
            }
        }
        c.not_negative(self.speed_mps, "speed_mps");
    }
}

impl Described for Estimator {
    fn facts(self) -> Facts {
        let facts = vec![
            Fact::new("gnss_latency", self.gnss.latency_s, "s"),
            Fact::new("sideslip_per_yaw_rate", self.sideslip_per_yaw_rate_s, "s"),
            Fact::new("speed", self.speed_mps, "m/s"),
        ];
        Facts { name: self.name, provenance: None, evidence: facts }
    }
}
