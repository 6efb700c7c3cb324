//! The options of a speed controller's design.

use crate::Error;
use crate::error::{positive, require};
use steerwright_formats::{Longitudinal, Requirement, SpeedSpecification};

/// Requirements and limits. The limits are those of ISO 15622 for adaptive cruise control: 2 m/s² of acceleration,
/// 3.5 m/s² of deceleration and 2.5 m/s³ of jerk.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SpeedDesignOptions {
    /// Largest overshoot of a step, percent; `None` for any.
    pub overshoot_percent: Option<f64>,
    /// Longest settling time, s; `None` for any.
    pub settling_time_s: Option<f64>,
    /// Largest steady-state error of a step and on the grade, percent of the step; `None` for any.
    pub steady_state_error_percent: Option<f64>,
    /// Band of the settling time, percent of the step.
    pub settling_band_percent: f64,
    /// Grade, percent.
    pub grade_percent: f64,
    /// Lowest and highest speed, m/s; by default those of the model's drive.
    pub speeds_mps: Option<[f64; 2]>,
    /// Largest acceleration, m/s².
    pub max_acceleration_mps2: f64,
    /// Largest deceleration, m/s².
    pub max_deceleration_mps2: f64,
    /// Largest jerk, m/s³.
    pub max_jerk_mps3: f64,
    /// Time between ticks, s.
    pub sample_time_s: f64,
    /// Vehicles drawn from the covariance of the model; 0 for the nominal one alone.
    pub members: usize,
    /// Seed of the vehicles drawn.
    pub seed: u64,
}

impl Default for SpeedDesignOptions {
    fn default() -> Self {
        Self {
            overshoot_percent: Some(5.0),
            settling_time_s: Some(4.0),
            steady_state_error_percent: Some(2.0),
            settling_band_percent: 2.0,
            grade_percent: 6.0,
            speeds_mps: None,
            max_acceleration_mps2: 2.0,
            max_deceleration_mps2: 3.5,
            max_jerk_mps3: 2.5,
            sample_time_s: 0.01,
            members: 100,
            seed: 1,
        }
    }
}

/// Height of the step, m/s.
pub(crate) const STEP: f64 = 2.0;

/// Shortest time at which the steady state is read, s, and its multiple of the settling time.
const STEADY_STATE: f64 = 20.0;
const STEADY_STATE_SETTLINGS: f64 = 5.0;

impl SpeedDesignOptions {
    /// Checks the values.
    ///
    /// # Errors
    /// [`Error::Option`].
    pub fn check(&self) -> Result<(), Error> {
        positive([
            ("largest acceleration", self.max_acceleration_mps2, " m/s²"),
            ("largest deceleration", self.max_deceleration_mps2, " m/s²"),
            ("largest jerk", self.max_jerk_mps3, " m/s³"),
            ("settling band", self.settling_band_percent, " %"),
        ])?;
        for (requirement, stated) in [
            (Requirement::Overshoot, self.overshoot_percent),
            (Requirement::Settling, self.settling_time_s),
            (Requirement::SteadyState, self.steady_state_error_percent),
        ] {
            let Some(value) = stated else { continue };
            let (must, is_within) = requirement.bounds();
            require(is_within(value), requirement.label(), (value, requirement.unit()), must)?;
        }
        let grade = self.grade_percent;
        let is_grade = (0.0..=30.0).contains(&grade);
        require(is_grade, "grade", (grade, " %"), "at least 0 and at most 30 %")?;
        let sample = self.sample_time_s;
        let is_sample = (0.001..=0.1).contains(&sample);
        require(is_sample, "sample time", (sample, " s"), "at least 0.001 s and at most 0.1 s")?;
        let members = (self.members as f64, " vehicles");
        require(self.members <= 10_000, "ensemble", members, "at most 10000")
    }

    /// The specification of the file.
    pub(crate) fn specification(&self, model: &Longitudinal) -> Result<SpeedSpecification, Error> {
        let [low, _, high] = model.evidence.speed_mps;
        let [low, high] = self.speeds_mps.unwrap_or([low, high]);
        let must = "above 0, and 2 m/s or more below the highest";
        require(low > 0.0 && high - low >= STEP, "lowest speed", (low, " m/s"), must)?;
        require(high <= 100.0, "highest speed", (high, " m/s"), "at most 100 m/s")?;
        let settling = self.settling_time_s.unwrap_or(0.0);
        Ok(SpeedSpecification {
            overshoot_percent: self.overshoot_percent,
            settling_time_s: self.settling_time_s,
            steady_state_error_percent: self.steady_state_error_percent,
            settling_band_percent: self.settling_band_percent,
            step_mps: STEP,
            grade_percent: self.grade_percent,
            steady_state_time_s: STEADY_STATE.max(STEADY_STATE_SETTLINGS * settling),
            speeds_mps: [low, high],
        })
    }
}

/// The requirements that a specification may have.
pub(crate) const REQUIREMENTS: [Requirement; 3] =
    [Requirement::Overshoot, Requirement::Settling, Requirement::SteadyState];

/// The bound of a requirement.
pub(crate) fn required(requirement: Requirement, s: &SpeedSpecification) -> Option<f64> {
    match requirement {
        Requirement::Overshoot => s.overshoot_percent,
        Requirement::Settling => s.settling_time_s,
        Requirement::SteadyState => s.steady_state_error_percent,
        _ => None,
    }
}
