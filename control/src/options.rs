//! What a design is asked for.

use crate::{Error, plant::DesignPlant};
use formats::{Limits, Specification};
use std::f64::consts::PI;

/// Requirements, limits and loop of a design. The defaults are the paper's.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DesignOptions {
    /// Largest overshoot of a yaw step, percent; 0 allows none.
    pub overshoot_percent: f64,
    /// Longest settling time, s.
    pub settling_time_s: f64,
    /// Largest steady-state error, percent; also the settling band.
    pub steady_state_error_percent: f64,
    /// Largest steering angle, rad, in steering coordinates; 22° at the road wheel by default.
    pub max_angle_rad: Option<f64>,
    /// Largest change in a sample, rad, in steering coordinates; 15° at the road wheel by default.
    pub max_increment_rad: Option<f64>,
    /// Largest rate, rad/s, in steering coordinates; what the increment allows by default.
    pub max_rate_radps: Option<f64>,
    /// Time between the controller's ticks, s.
    pub sample_time_s: f64,
    /// Delay of the loop beyond the plant's own, s.
    pub loop_delay_s: f64,
    /// Smallest modulus margin.
    pub modulus_margin: f64,
    /// Names the sequence of starting points; the same seed gives the same design.
    pub seed: u64,
}

impl Default for DesignOptions {
    fn default() -> Self {
        Self {
            overshoot_percent: 1.0,
            settling_time_s: 1.0,
            steady_state_error_percent: 2.0,
            max_angle_rad: None,
            max_increment_rad: None,
            max_rate_radps: None,
            sample_time_s: 0.01,
            loop_delay_s: 0.0,
            modulus_margin: 0.5,
            seed: 1,
        }
    }
}

/// Height of the step, rad.
pub(crate) const STEP: f64 = 5.0 / 180.0 * PI;
/// Steering offset of the second step, rad at the road wheel.
pub(crate) const OFFSET: f64 = 1.0 / 180.0 * PI;
/// Samples that a settling time must hold.
const LEAST_SAMPLES: usize = 4;

impl DesignOptions {
    /// Checks the values against each other.
    ///
    /// # Errors
    /// [`Error::Option`], [`Error::SampleTimeTooLong`].
    pub fn check(&self) -> Result<(), Error> {
        let optional = |v: Option<f64>| v.unwrap_or(1.0);
        for (option, value) in [
            ("overshoot", self.overshoot_percent),
            ("settling time", self.settling_time_s),
            ("steady-state error", self.steady_state_error_percent),
            ("largest angle", optional(self.max_angle_rad)),
            ("largest increment", optional(self.max_increment_rad)),
            ("largest rate", optional(self.max_rate_radps)),
            ("sample time", self.sample_time_s),
        ] {
            // An overshoot of exactly 0 may be asked for.
            let (least, must) = if option == "overshoot" {
                (value >= 0.0, "0 or more")
            } else {
                (value > 0.0, "greater than 0")
            };
            if !(value.is_finite() && least) {
                return Err(Error::Option { option, value, must });
            }
        }
        if !(self.loop_delay_s.is_finite() && self.loop_delay_s >= 0.0) {
            let (option, value) = ("loop delay", self.loop_delay_s);
            return Err(Error::Option { option, value, must: "0 or more" });
        }
        if !(0.0..1.0).contains(&self.modulus_margin) {
            let (option, value) = ("modulus margin", self.modulus_margin);
            return Err(Error::Option { option, value, must: "at least 0 and below 1" });
        }
        if self.settling_time_s > 60.0 {
            let (option, value) = ("settling time", self.settling_time_s);
            return Err(Error::Option { option, value, must: "at most 60 s" });
        }
        // One step simulation stays below a million ticks.
        if self.sample_time_s < 1e-4 {
            let (option, value) = ("sample time", self.sample_time_s);
            return Err(Error::Option { option, value, must: "at least 0.0001 s" });
        }
        if self.settling_time_s < LEAST_SAMPLES as f64 * self.sample_time_s {
            return Err(Error::SampleTimeTooLong {
                sample_time_s: self.sample_time_s,
                settling_time_s: self.settling_time_s,
                need: LEAST_SAMPLES,
            });
        }
        Ok(())
    }

    /// The specification of the file.
    #[must_use]
    pub fn specification(&self) -> Specification {
        Specification {
            overshoot_percent: self.overshoot_percent,
            settling_time_s: self.settling_time_s,
            steady_state_error_percent: self.steady_state_error_percent,
            step_rad: STEP,
            steering_offset_rad: OFFSET,
            // 5 s, unless settling itself may take longer than half of that.
            steady_state_time_s: f64::max(5.0, 2.0 * self.settling_time_s),
            modulus_margin: self.modulus_margin,
        }
    }

    /// The limits of the file, in the plant's steering coordinates.
    #[must_use]
    pub fn limits(&self, plant: &DesignPlant) -> Limits {
        let road_wheel = |degrees: f64| degrees.to_radians() * plant.steering_ratio;
        let max_increment_rad = self.max_increment_rad.unwrap_or(road_wheel(15.0));
        Limits {
            max_angle_rad: self.max_angle_rad.unwrap_or(road_wheel(22.0)),
            max_increment_rad,
            max_rate_radps: self.max_rate_radps.unwrap_or(max_increment_rad / self.sample_time_s),
        }
    }
}
