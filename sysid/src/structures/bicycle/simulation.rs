//! The segments of a recording as the model sees them, and how a model follows them.

use crate::data::recording::Recording;
use crate::structures::bicycle::simulate::SpeedSegment;
use crate::validation::residuals::fit::{FitWithError, fit_with_error};
use std::ops::Range;
use steerwright_drivelog::DriveLog;

/// The log's segments, each with its place.
pub(super) fn segments<'a>(
    recording: &'a Recording,
    log: &'a DriveLog,
) -> Vec<(Range<usize>, SpeedSegment<'a>)> {
    let of = |range: &Range<usize>| SpeedSegment {
        sample_time: log.sample_time_s,
        before: &[],
        steering: &recording.steering[range.clone()],
        speed: &recording.speed[range.clone()],
        yaw_rate: &log.output[range.clone()],
    };
    log.segments.iter().map(|s| (s.range.clone(), of(&s.range))).collect()
}

pub(super) struct Simulation {
    pub(super) estimation_fit: f64,
    pub(super) validation_fit: FitWithError,
    pub(super) simulated: Vec<f64>,
    /// Whether the simulation of the validation data stayed within all bounds.
    pub(super) bounded: bool,
}

impl Simulation {
    /// Fit of a part that left all bounds, percent: nothing of the drive is reproduced.
    const LOST: f64 = -100.0;

    pub(super) fn new(
        log: &DriveLog,
        recording: &Recording,
        estimation: Option<Vec<Vec<f64>>>,
        validation: Option<Vec<Vec<f64>>>,
    ) -> Self {
        let mut simulated = log.output.clone();
        let bounded = estimation.is_some() && validation.is_some();
        let mut fit = |errors: Option<Vec<Vec<f64>>>, ranges: &[Range<usize>]| {
            let Some(errors) = errors else {
                // No simulated value is that of the model.
                ranges.iter().for_each(|range| simulated[range.clone()].fill(f64::NAN));
                return FitWithError { fit: Self::LOST, standard_error: None, blocks: 0 };
            };
            for (range, errors) in ranges.iter().zip(errors) {
                simulated[range.clone()].iter_mut().zip(errors).for_each(|(y, e)| *y -= e);
            }
            let pairs: Vec<(&[f64], &[f64])> =
                ranges.iter().map(|r| (&log.output[r.clone()], &simulated[r.clone()])).collect();
            let found = fit_with_error(&pairs, log.sample_time_s);
            FitWithError { fit: found.fit.max(Self::LOST), ..found }
        };
        let estimation_fit = fit(estimation, &recording.split.estimation).fit;
        let validation_fit = fit(validation, &recording.split.validation);
        Self { estimation_fit, validation_fit, simulated, bounded }
    }

    /// Of samples that neither estimate nor validate.
    pub(super) fn add(&mut self, log: &DriveLog, ranges: &[Range<usize>], errors: Vec<Vec<f64>>) {
        for (range, errors) in ranges.iter().zip(errors) {
            let measured = log.output[range.clone()].iter().zip(errors);
            let simulated = self.simulated[range.clone()].iter_mut();
            simulated.zip(measured).for_each(|(simulated, (y, e))| *simulated = y - e);
        }
    }
}
