//! The limits of a controller.

use crate::Error;
use crate::closed_loop::scenario::{Step, simulated_step};
use crate::closed_loop::simulate::Simulator;
use crate::design::options::DesignOptions;
use crate::design::search::significant;
use crate::plants::design_plant::DesignPlant;
use crate::plants::sampled::Sampled;
use nalgebra::Complex;
use std::f64::consts::{FRAC_PI_2, PI};
use steerwright_formats::{LargeErrors, LateralAcceleration, Limits, Specification};
use steerwright_models::{PidParameters, time_at_largest_rate};

/// The rate that an actuator is assumed to follow, as a multiple of the fastest steering of the drive.
pub(crate) const TIMES_DRIVEN: f64 = 2.0;
/// The largest error acted on at once, over the specification's step.
const BEYOND_STEP: f64 = 1.04;
/// Sustained rate over the largest. The multi-body cars of `evaluation/experiment/engagement.py` return to the
/// road with an actuator of 3/8 of the rate stated.
const SUSTAINED: f64 = 0.35;
/// Reserve of time at the largest rate over the time that the specification's step takes, and the shortest, s.
const RESERVE: f64 = 1.3;
const LEAST_RESERVE_S: f64 = 0.15;
/// Frequency at which the lag of the yaw rate is read, rad/s: half a turn of the steering a second. The lag is
/// between a sample and the longest, s.
const LAG_READ_AT_RADPS: f64 = PI;
const LONGEST_LAG_S: f64 = 1.0;

/// The largest steering angle where none is stated, the paper's 22° at the road wheel, in steering coordinates.
#[must_use]
pub fn usual_max_angle_rad(steering_ratio: f64) -> f64 {
    PidParameters::default().max_angle * steering_ratio
}

impl DesignOptions {
    /// The limits of the file in the plant's steering coordinates, without those of large errors, which depend
    /// on the gains.
    ///
    /// # Errors
    /// [`Error::NoSteeringRate`] where no rate is stated and the plant comes from no drive.
    pub fn limits(&self, plant: &DesignPlant) -> Result<Limits, Error> {
        // The paper's limits are those of the controller without a file, at the road wheel.
        let usual = PidParameters::default();
        let driven = plant.fastest_steering().or(self.driven_rate_radps);
        let max_rate_radps = self
            .max_rate_radps
            .or(driven.map(|rate| TIMES_DRIVEN * rate))
            .ok_or_else(|| Error::NoSteeringRate { model: plant.name.clone() })?;
        let turn = plant.steady_turn();
        Ok(Limits {
            max_angle_rad: self
                .max_angle_rad
                .unwrap_or_else(|| usual_max_angle_rad(plant.steering_ratio)),
            max_increment_rad: self
                .max_increment_rad
                .unwrap_or(usual.max_increment * plant.steering_ratio),
            max_rate_radps,
            large_errors: None,
            lateral_acceleration: Some(LateralAcceleration {
                max_mps2: self.max_lateral_acceleration_mps2,
                steering_per_curvature_radm: turn.slow,
                understeer_gradient_rads2pm: turn.understeer,
            }),
        })
    }
}

/// How the controller treats errors beyond the step of the specification, which do not depend on it.
pub(crate) fn large_errors(
    plant: &Sampled,
    pid: &PidParameters,
    spec: &Specification,
) -> LargeErrors {
    let mut simulator = Simulator::default();
    simulated_step(&mut simulator, plant, pid, spec, Step::from_specification(spec));
    let trace = &simulator.trace;
    let taken = time_at_largest_rate(pid, trace.steering_before, &trace.steering);
    LargeErrors {
        max_yaw_error_rad: significant(BEYOND_STEP * spec.step_rad, 5),
        yaw_rate_lag_s: significant(yaw_rate_lag(plant), 3),
        sustained_rate_radps: significant(SUSTAINED * pid.largest_increment() / pid.sample_time, 5),
        rate_reserve_time_s: significant((RESERVE * taken).max(LEAST_RESERVE_S), 3),
    }
}

/// Of the first-order lag with the phase of the plant's yaw rate, delays included, s.
fn yaw_rate_lag(plant: &Sampled) -> f64 {
    let z = Complex::from_polar(1.0, LAG_READ_AT_RADPS * plant.sample_time);
    let behind = -(plant.response(z) * (z - 1.0)).arg();
    let lag = if behind < FRAC_PI_2 { behind.tan() / LAG_READ_AT_RADPS } else { LONGEST_LAG_S };
    lag.max(plant.sample_time).min(LONGEST_LAG_S)
}
