//! The parameters of the response of the speed, and what follows from them alone.

use crate::Error;
use crate::numbers::as_numbers;
use crate::trigonometry::sin_cos;

/// Standard gravity, m/s².
const GRAVITY: f64 = 9.806_65;

/// Least and largest time constant of a lag, s.
const TIME_CONSTANTS: [f64; 2] = [1e-4, 100.0];

/// Curvatures of a pedal between which more of it drives more.
const CURVATURES: [f64; 2] = [-1.0, 1.0];

/// Longest delay of an input, s.
const LONGEST_DELAY: f64 = 10.0;

/// The parameters that can be set; the gains are those of the document.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct LongitudinalParameters {
    /// κ, curvature of the accelerator.
    pub pedal_curvature: f64,
    /// τ, lag of the drive, s.
    pub time_constant: f64,
    /// d, delay of the drive, s.
    pub delay: f64,
    /// B, deceleration at a brake of 1, m/s²; 0 without a brake.
    pub brake_gain: f64,
    /// σ, lag of the brake, s.
    pub brake_time_constant: f64,
    /// e, delay of the brake, s.
    pub brake_delay: f64,
    /// c0, m/s².
    pub resistance: f64,
    /// c1, 1/s.
    pub resistance_per_speed: f64,
    /// c2, 1/m.
    pub drag: f64,
    /// ρ, share of the gravity along the road.
    pub grade_coefficient: f64,
}

as_numbers!(LongitudinalParameters: pedal_curvature time_constant delay brake_gain brake_time_constant brake_delay resistance
    resistance_per_speed drag grade_coefficient);

impl LongitudinalParameters {
    /// Share of the gain that acts at an accelerator; beyond 0 and 1 as without curvature.
    #[must_use]
    pub fn share_of_gain(&self, accelerator: f64) -> f64 {
        let within = accelerator.clamp(0.0, 1.0);
        accelerator + self.pedal_curvature * (within * (1.0 - within))
    }

    /// The accelerator from 0 to 1 at which a share of the gain acts, as far as one does.
    #[must_use]
    pub fn accelerator(&self, share_of_gain: f64) -> f64 {
        let share = share_of_gain.clamp(0.0, 1.0);
        let rise = 1.0 + self.pedal_curvature;
        // Root of κ·a² − (1 + κ)·a + share without a difference of large numbers; where κ = −1, it is that of the share.
        let root = (rise * rise - 4.0 * self.pedal_curvature * share).max(0.0).sqrt();
        if rise + root > 0.0 { (2.0 * share / (rise + root)).min(1.0) } else { 0.0 }
    }

    /// Resistances at a speed, m/s, and gravity on a grade, rad: m/s².
    #[must_use]
    pub fn slowing(&self, speed: f64, grade: f64) -> f64 {
        self.resistance
            + self.resistance_per_speed * speed
            + self.drag * (speed * speed)
            + self.gravity(grade)
    }

    /// Gravity along the road on a grade, rad, as far as it acts: m/s².
    #[must_use]
    pub fn gravity(&self, grade: f64) -> f64 {
        let (sin, _) = sin_cos(grade);
        self.grade_coefficient * (GRAVITY * sin)
    }

    /// Refuses parameters that no vehicle has.
    ///
    /// # Errors
    /// Where a number is not finite, or a lag or delay is out of its bounds.
    pub fn check(&self) -> Result<(), Error> {
        let [min, max] = TIME_CONSTANTS;
        let longest = LONGEST_DELAY;
        for (name, value, min, max) in [
            ("the time constant", self.time_constant, min, max),
            ("the time constant of the brake", self.brake_time_constant, min, max),
            ("the curvature of the pedal", self.pedal_curvature, CURVATURES[0], CURVATURES[1]),
            ("the delay", self.delay, 0.0, longest),
            ("the delay of the brake", self.brake_delay, 0.0, longest),
        ] {
            if !(min..=max).contains(&value) {
                return Err(Error::Range { name, value, min, max });
            }
        }
        for value in self.numbers() {
            if !value.is_finite() {
                return Err(Error::NotFinite { name: "a parameter", value });
            }
        }
        Ok(())
    }
}
