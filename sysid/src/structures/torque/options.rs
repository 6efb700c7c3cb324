//! The options of the structure `torque`.

use crate::Error;
use std::collections::BTreeMap;

/// Options of [`identify_torque`](crate::structures::torque::identify_torque).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TorqueOptions {
    /// Lowest speed of a sample, m/s: at lower speeds, the tyres' friction on the road is a large part of the torque.
    pub least_speed_mps: f64,
    /// ω0, rate of the steering angle at which friction reaches 76 %, rad/s.
    pub friction_rate_radps: f64,
    /// Share of the samples that are validation data, from the end.
    pub validation_fraction: f64,
}

impl Default for TorqueOptions {
    fn default() -> Self {
        Self { least_speed_mps: 15.0, friction_rate_radps: 0.05, validation_fraction: 0.5 }
    }
}

impl TorqueOptions {
    pub(super) fn check(&self) -> Result<(), Error> {
        let Self { least_speed_mps, friction_rate_radps, validation_fraction } = self;
        if !(*least_speed_mps >= 0.0 && least_speed_mps.is_finite()) {
            return Err(Error::option("lowest speed", least_speed_mps, "0 m/s or more"));
        }
        if !(*friction_rate_radps > 0.0 && friction_rate_radps.is_finite()) {
            return Err(Error::option("friction rate", friction_rate_radps, "above 0 rad/s"));
        }
        if !(0.0..=0.9).contains(validation_fraction) {
            return Err(Error::option("validation fraction", validation_fraction, "0 to 0.9"));
        }
        Ok(())
    }

    pub(super) fn to_map(self) -> BTreeMap<String, String> {
        BTreeMap::from([
            ("structure".into(), "torque".into()),
            ("least_speed_mps".into(), self.least_speed_mps.to_string()),
            ("friction_rate_radps".into(), self.friction_rate_radps.to_string()),
            ("validation_fraction".into(), self.validation_fraction.to_string()),
        ])
    }
}
