//! A single-track model: its parameters and its free simulation.

use crate::Error;
use crate::structures::single_track::drive::Drive;
use crate::structures::single_track::dynamics::Constants;
use crate::structures::single_track::parameters::{COUNT, Parameter, values};
use crate::structures::single_track::prepared::prepare;
use crate::structures::single_track::problem::Point;
use crate::structures::single_track::search::result_run;
use crate::structures::single_track::simulate::{SimulationRun, simulate};

/// The model, by the values of its parameters.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SingleTrackModel {
    values: [f64; COUNT],
}

/// What the model does on a segment, a value for each sample; NaN from where it leaves all bounds.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct SimulatedSegment {
    /// Yaw rate with the sensor's offset, rad/s.
    pub yaw_rate_radps: Vec<f64>,
    /// Lateral acceleration with the sensor's offset at its place, m/s².
    pub lateral_acceleration_mps2: Vec<f64>,
    /// Lateral velocity of the centre of gravity, m/s.
    pub lateral_velocity_mps: Vec<f64>,
}

impl Default for SingleTrackModel {
    /// The means of the priors.
    fn default() -> Self {
        Self { values: Parameter::ALL.map(|p| p.default_prior().mean) }
    }
}

impl SingleTrackModel {
    /// Of coordinates.
    pub(super) fn of_point(point: &Point) -> Self {
        Self { values: values(point) }
    }

    /// The value of a parameter in its unit.
    #[must_use]
    pub fn get(&self, parameter: Parameter) -> f64 {
        self.values[parameter.index()]
    }

    /// With another value of a parameter.
    #[must_use]
    pub fn with(mut self, parameter: Parameter, value: f64) -> Self {
        self.values[parameter.index()] = value;
        self
    }

    pub(super) fn point(&self) -> Point {
        std::array::from_fn(|i| Parameter::ALL[i].coordinate(self.values[i]))
    }

    /// The free simulation: each segment from the steady turn at its first yaw rate, from steering
    /// and speed alone.
    ///
    /// # Errors
    /// Those of [`Drive::check`].
    pub fn simulate(&self, drive: &Drive) -> Result<Vec<SimulatedSegment>, Error> {
        drive.check()?;
        let constants = Constants::new(&self.point());
        let run = SimulationRun { stride: 1, ..result_run(drive.sample_time_s) };
        let of_segment =
            |segment: &crate::structures::single_track::prepared::PreparedSegment<'_>| {
                let n = segment.len();
                let mut all = SimulatedSegment::default();
                simulate(&constants, segment, &run, |_, output| {
                    all.yaw_rate_radps.push(output.yaw_rate);
                    all.lateral_acceleration_mps2.push(output.lateral_acceleration);
                    all.lateral_velocity_mps.push(output.lateral_velocity);
                });
                for signal in [
                    &mut all.yaw_rate_radps,
                    &mut all.lateral_acceleration_mps2,
                    &mut all.lateral_velocity_mps,
                ] {
                    signal.resize(n, f64::NAN);
                }
                all
            };
        Ok(prepare(drive).iter().map(of_segment).collect())
    }
}
