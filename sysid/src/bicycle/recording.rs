//! The recording as the model sees it, and how a model follows it.

use crate::Error;
use crate::bicycle::simulate::SpeedSegment;
use crate::data::split::Split;
use crate::error::check_yaw_rate;
use crate::validation::fit::{FitWithError, fit_with_error};
use crate::validation::prediction::BLOCK_S;
use std::ops::Range;
use steerwright_drivelog::DriveLog;
use steerwright_drivelog::signal::standard_deviation;

/// Fewest samples of the recording, and of each part of it.
const LEAST_SAMPLES: usize = 100;

pub(super) struct Recording {
    pub(super) steering: Vec<f64>,
    pub(super) speed: Vec<f64>,
    /// What estimates and what validates.
    pub(super) split: Split,
}

impl Recording {
    /// Checks the log, and splits it by its steering times speed.
    pub(super) fn new(log: &DriveLog, split: &dyn Fn(&[f64]) -> Split) -> Result<Self, Error> {
        check_yaw_rate(log)?;
        let speed = log.speed.clone().ok_or(Error::SpeedNeeded)?;
        let n = log.len();
        let no_model = |problem: &str| Err(Error::no_model(problem));
        if log.output.len() != n || speed.len() != n {
            return no_model("steering, yaw rate and speed are not equally long");
        }
        let turned: Vec<f64> = log.input.iter().zip(&speed).map(|(u, v)| u * v).collect();
        let split = split(&turned);
        let least = count(&split.estimation).min(count(&split.validation));
        if least < LEAST_SAMPLES {
            let need = (n * LEAST_SAMPLES).div_ceil(least.max(1)).max(2 * LEAST_SAMPLES);
            return Err(Error::too_few(n, need, log.sample_time_s));
        }
        if !log.input.iter().chain(&log.output).chain(&speed).all(|x| x.is_finite()) {
            return no_model("the recording is not finite");
        }
        if !(log.sample_time_s > 0.0 && log.steering_ratio > 0.0) {
            return no_model("sample time and steering ratio must be positive");
        }
        if let Some(v) = speed.iter().find(|v| **v < 0.0) {
            return no_model(&format!("the speed is {v} m/s somewhere"));
        }
        for (signal, role) in [(&log.input, "steering"), (&log.output, "yaw rate")] {
            let estimation = of(signal, &split.estimation);
            let size = estimation.iter().fold(0.0_f64, |a, x| a.max(x.abs()));
            if standard_deviation(&estimation) <= 1e-12 * size {
                return no_model(&format!("the {role} does not move in the estimation data"));
            }
        }
        let steering = log.input.iter().map(|u| u / log.steering_ratio).collect();
        Ok(Self { steering, speed, split })
    }

    /// The log's segments, each with its place.
    pub(super) fn segments<'a>(
        &'a self,
        log: &'a DriveLog,
    ) -> Vec<(Range<usize>, SpeedSegment<'a>)> {
        let of = |range: &Range<usize>| SpeedSegment {
            sample_time: log.sample_time_s,
            before: &[],
            steering: &self.steering[range.clone()],
            speed: &self.speed[range.clone()],
            yaw_rate: &log.output[range.clone()],
        };
        log.segments.iter().map(|s| (s.range.clone(), of(&s.range))).collect()
    }
}

pub(super) fn count(ranges: &[Range<usize>]) -> usize {
    ranges.iter().map(Range::len).sum()
}

/// The samples of a signal that `ranges` hold.
pub(super) fn of(signal: &[f64], ranges: &[Range<usize>]) -> Vec<f64> {
    ranges.iter().flat_map(|r| &signal[r.clone()]).copied().collect()
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
                return FitWithError { fit: Self::LOST, standard_error: None, blocks: 0 };
            };
            for (range, errors) in ranges.iter().zip(errors) {
                simulated[range.clone()].iter_mut().zip(errors).for_each(|(y, e)| *y -= e);
            }
            let pairs: Vec<(&[f64], &[f64])> =
                ranges.iter().map(|r| (&log.output[r.clone()], &simulated[r.clone()])).collect();
            let found = fit_with_error(&pairs, log.sample_time_s, BLOCK_S);
            FitWithError { fit: found.fit.max(Self::LOST), ..found }
        };
        let estimation_fit = fit(estimation, &recording.split.estimation).fit;
        let validation_fit = fit(validation, &recording.split.validation);
        Self { estimation_fit, validation_fit, simulated, bounded }
    }
}
