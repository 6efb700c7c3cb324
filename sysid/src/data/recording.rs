//! A log whose speed is known, checked and split for a model that is scheduled by it.

use crate::Error;
use crate::data::split::Split;
use crate::error::check_yaw_rate;
use std::ops::Range;
use steerwright_drivelog::DriveLog;
use steerwright_drivelog::signal::{mean, standard_deviation};
use steerwright_formats::SpeedSummary;

/// Fewest samples of the recording, and of each part of it.
const LEAST_SAMPLES: usize = 100;

pub(crate) struct Recording {
    /// Road-wheel angle by the log's steering ratio, rad.
    pub(crate) steering: Vec<f64>,
    pub(crate) speed: Vec<f64>,
    /// What estimates and what validates.
    pub(crate) split: Split,
}

impl Recording {
    /// Checks the log, and splits it by its steering times speed.
    pub(crate) fn new(log: &DriveLog, split: &dyn Fn(&[f64]) -> Split) -> Result<Self, Error> {
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
            let estimation = samples_in(signal, &split.estimation);
            let size = estimation.iter().fold(0.0_f64, |a, x| a.max(x.abs()));
            if standard_deviation(&estimation) <= 1e-12 * size {
                return no_model(&format!("the {role} does not move in the estimation data"));
            }
        }
        let steering = log.input.iter().map(|u| u / log.steering_ratio).collect();
        Ok(Self { steering, speed, split })
    }

    /// The speed over the estimation data.
    pub(crate) fn speed_summary(&self) -> SpeedSummary {
        let v = &samples_in(&self.speed, &self.split.estimation);
        SpeedSummary {
            min_mps: v.iter().copied().fold(f64::INFINITY, f64::min),
            // Of a vehicle that is at rest most of the time too, so that eq 13 can be written.
            mean_mps: mean(v).max(1.0),
            max_mps: v.iter().copied().fold(0.0, f64::max),
            standard_deviation_mps: standard_deviation(v),
        }
    }
}

pub(crate) fn count(ranges: &[Range<usize>]) -> usize {
    ranges.iter().map(Range::len).sum()
}

/// The samples of a signal that `ranges` hold.
pub(crate) fn samples_in(signal: &[f64], ranges: &[Range<usize>]) -> Vec<f64> {
    ranges.iter().flat_map(|r| &signal[r.clone()]).copied().collect()
}
