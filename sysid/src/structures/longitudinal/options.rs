//! The options of the structure `longitudinal`.

use crate::Error;
use std::collections::BTreeMap;

/// Options of [`identify_longitudinal`](crate::structures::longitudinal::identify_longitudinal).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LongitudinalOptions {
    /// Lowest speed of a sample, m/s: more slowly, a car with an automatic gearbox creeps without a pedal, and its clutch
    /// and torque converter slip.
    pub least_speed_mps: f64,
    /// Share of the samples that are validation data, in blocks over the whole log.
    pub validation_fraction: f64,
    /// Whether the drive has one gear, as most electric ones: the accelerator's effect depends on no gear.
    pub single_gear: bool,
}

impl Default for LongitudinalOptions {
    fn default() -> Self {
        Self { least_speed_mps: 3.0, validation_fraction: 0.5, single_gear: false }
    }
}

impl LongitudinalOptions {
    pub(super) fn check(&self) -> Result<(), Error> {
        let Self { least_speed_mps, validation_fraction, single_gear: _ } = self;
        if !(*least_speed_mps >= 0.5 && least_speed_mps.is_finite()) {
            return Err(Error::option("lowest speed", least_speed_mps, "0.5 m/s or more"));
        }
        if !(0.1..=0.9).contains(validation_fraction) {
            return Err(Error::option("validation fraction", validation_fraction, "0.1 to 0.9"));
        }
        Ok(())
    }

    pub(super) fn to_map(self) -> BTreeMap<String, String> {
        BTreeMap::from([
            ("structure".into(), "longitudinal".into()),
            ("least_speed_mps".into(), self.least_speed_mps.to_string()),
            ("validation_fraction".into(), self.validation_fraction.to_string()),
            ("single_gear".into(), self.single_gear.to_string()),
        ])
    }
}
