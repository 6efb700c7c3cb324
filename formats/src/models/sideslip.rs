//! The sideslip that a drive with GNSS fixes determines, in the model's document whatever its structure.

use crate::document::Checker;
use serde::{Deserialize, Serialize};

/// The sideslip of the centre of gravity, from the course of GNSS fixes: with the yaw rate r and the
/// lateral acceleration `a = v·r`, course minus yaw is `(S + Q·a²)·r + C·dr/dt` at a speed. With the distance b to the
/// rear axle, `S = b/v − κ·v` at all speeds v.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Sideslip {
    /// The speed at which it is stated, m/s; absent in plants of former versions, which state it at their operating
    /// point.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub speed_mps: Option<f64>,
    /// S, sideslip angle per yaw rate, s: in gentle turns if the growth is stated, else the mean over
    /// the drive's turns.
    pub sideslip_per_yaw_rate_s: f64,
    /// Its standard error, s, from the noise of the fixes and the gyro, and from the age of the fixes if
    /// that is estimated.
    pub standard_error_s: f64,
    /// Q, the growth of S per squared lateral acceleration, s⁵/m²; absent if the drive does not
    /// determine it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub sideslip_growth_s5pm2: Option<SideslipTerm>,
    /// C, sideslip angle per yaw acceleration, s²; absent if the drive does not determine it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub sideslip_per_yaw_acceleration_s2: Option<SideslipTerm>,
    /// b, distance from centre of gravity to rear axle, m; absent if the drive does not determine it, by too
    /// little change of its speed.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub distance_rear_m: Option<SideslipTerm>,
    /// The assumed age of a fix, s: an error of it is an error of the sideslip.
    pub gnss_latency_s: f64,
    /// The standard error of that age, s; absent if the age was stated.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub gnss_latency_standard_error_s: Option<f64>,
    /// The assumed position of the antenna ahead of the centre of gravity, m.
    pub antenna_x_m: f64,
}

/// A term of the sideslip, in the unit of its name.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SideslipTerm {
    /// The estimate.
    pub value: f64,
    /// Its standard error, from the noise of the fixes and the gyro only.
    pub standard_error: f64,
}

impl Sideslip {
    /// Q, s⁵/m²; 0 if unknown.
    #[must_use]
    pub fn growth(&self) -> f64 {
        self.sideslip_growth_s5pm2.map_or(0.0, |term| term.value)
    }

    /// C, s²; 0 if unknown.
    #[must_use]
    pub fn per_yaw_acceleration(&self) -> f64 {
        self.sideslip_per_yaw_acceleration_s2.map_or(0.0, |term| term.value)
    }

    /// b, m; 0 if unknown.
    #[must_use]
    pub fn distance_rear(&self) -> f64 {
        self.distance_rear_m.map_or(0.0, |term| term.value)
    }

    pub(crate) fn check(&self, c: &mut Checker) {
        c.within(self.sideslip_per_yaw_rate_s, -10.0, 10.0, "sideslip.sideslip_per_yaw_rate_s");
        for (term, min, max, name) in [
            (self.sideslip_growth_s5pm2, -1.0, 1.0, "sideslip_growth_s5pm2"),
            (
                self.sideslip_per_yaw_acceleration_s2,
                -10.0,
                10.0,
                "sideslip_per_yaw_acceleration_s2",
            ),
            (self.distance_rear_m, 0.0, 100.0, "distance_rear_m"),
        ] {
            if let Some(SideslipTerm { value, standard_error }) = term {
                c.within(value, min, max, &format!("sideslip.{name}.value"));
                c.not_negative(standard_error, &format!("sideslip.{name}.standard_error"));
            }
        }
        if let Some(speed) = self.speed_mps {
            c.not_negative(speed, "sideslip.speed_mps");
        }
        c.not_negative(self.standard_error_s, "sideslip.standard_error_s");
        c.not_negative(self.gnss_latency_s, "sideslip.gnss_latency_s");
        let age_error = self.gnss_latency_standard_error_s.unwrap_or(0.0);
        c.not_negative(age_error, "sideslip.gnss_latency_standard_error_s");
        c.finite(self.antenna_x_m, "sideslip.antenna_x_m");
    }
}
