//! The structure `bicycle`: the two-wheel model of eq 13 from a drive whose speed varies.
//!
//! ```text
//! v̇_y = A1/v·v_y + (A2/v − v)·r + B1·δ        yaw rate = r + yaw-rate offset
//! ṙ   = A3/v·v_y +  A4/v·r      + B2·δ
//! δ̇   = (steering(t − τ)/ratio − offset − δ)/Tn
//! ```
//!
//! The coefficients are those of eq 13, the speed v of each sample schedules them, and the result is a
//! `bicycle.json` for the BicyclePlant. What yaw rate identifies and what it does not is derived in
//! `parameters`, the simulation and its derivatives are in `simulate`, the estimation and its priors
//! in `estimate`, the standard errors in `uncertainty`.
//!
//! The focus is simulation: the sum of squared simulation errors, unweighted. A model this small is
//! wrong somewhere on every drive (tyres saturate, load shifts), and its errors are slow; whitening them would
//! fit what remains at high frequency, at the expense of the turns.

mod document;
mod dual;
mod estimate;
mod evidence;
mod judge;
mod options;
mod parameters;
mod quality;
mod simulate;
mod uncertainty;

use crate::Error;
use crate::bicycle::estimate::{Estimate, Problem};
use crate::bicycle::parameters::DELAY;
use crate::bicycle::simulate::{Stretch, within};
use crate::data::split::Split;
use crate::identify::plant::Traces;
use crate::validation::fit::{FitWithError, fit_with_error};
use crate::validation::prediction::BLOCK_S;
use drivelog::DriveLog;
use drivelog::signal::standard_deviation;
use formats::{Bicycle, Document, Provenance, WithDelay};
use std::ops::Range;

pub use crate::bicycle::judge::judge_bicycle;
pub use crate::bicycle::options::BicycleOptions;

/// Fewest samples of the recording, and of each part of it.
const LEAST_SAMPLES: usize = 100;

/// A bicycle with the signals behind its plots.
#[derive(Debug, Clone, PartialEq)]
pub struct IdentifiedBicycle {
    /// What goes into `bicycle.json`; its evidence is there.
    pub bicycle: Bicycle,
    /// Measured and simulated signals.
    pub traces: Traces,
}

/// The recording as the model sees it.
struct Recording {
    steering: Vec<f64>,
    speed: Vec<f64>,
    /// What estimates and what validates.
    split: Split,
}

/// Identifies the bicycle in `log`, which must have a speed.
///
/// The end of the log is held out, or blocks of it where its end is not excited; they judge the model and
/// choose nothing.
///
/// # Errors
/// [`Error`] where the log or the options allow no model. A poor model is no error: the evidence and
/// the quality report it.
pub fn identify_bicycle(
    log: &DriveLog,
    options: &BicycleOptions,
) -> Result<IdentifiedBicycle, Error> {
    options.check()?;
    let recording =
        Recording::new(log, &|turned| Split::new(log, turned, options.validation_fraction))?;
    let stretches = recording.stretches(log);
    let problem = |ranges: &[Range<usize>], delay: bool| {
        Problem::new(within(&stretches, ranges), options.front_share(), options.wheelbase_m, delay)
    };
    let folded = problem(&recording.split.estimation, false);
    let found = folded.solve()?;
    let delayed = problem(&recording.split.estimation, true);
    let with_delay = delayed.solve_with_delay(&found)?;
    let held_out = problem(&recording.split.validation, false);
    let judge = |e: &Estimate| -> Result<Judged, Error> {
        let estimation = folded.errors(&e.parameters, &e.starts);
        let starts = held_out.starts(&e.parameters)?;
        let validation = starts.and_then(|starts| held_out.errors(&e.parameters, &starts));
        Ok(Judged::new(log, &recording, estimation, validation))
    };
    let judged = judge(&found)?;
    let judged_with_delay = judge(&with_delay)?;

    let covariance = uncertainty::covariance(&folded, &found)?;
    let with_delay = WithDelay {
        input_delay_s: with_delay.parameters[DELAY],
        standard_error_s: uncertainty::covariance(&delayed, &with_delay)?[DELAY][DELAY]
            .max(0.0)
            .sqrt(),
        actuator_time_constant_s: with_delay.parameters[parameters::LAG].exp(),
        estimation_fit: judged_with_delay.estimation_fit,
        validation_fit: judged_with_delay.validation_fit.fit,
    };
    let known = evidence::Known {
        log,
        options,
        recording: &recording,
        estimate: &found,
        covariance: &covariance,
        judged: &judged,
        with_delay,
    };
    let evidence = known.evidence()?;
    let quality = known.quality(&evidence);
    let mut used = log.options.clone();
    used.extend(options.to_map());
    let vehicle = parameters::vehicle(
        &found.parameters,
        options,
        &log.name,
        log.steering_ratio,
        evidence.speed.mean_mps,
    );
    let provenance = Provenance {
        version: env!("CARGO_PKG_VERSION").into(),
        sources: log.sources.clone(),
        options: used,
    };
    let bicycle = document::document(vehicle, evidence, quality, provenance);
    bicycle.checked("bicycle.json").map_err(|e| Error::NoModel { problem: e.to_string() })?;
    Ok(IdentifiedBicycle { bicycle, traces: traces(log, &recording, &judged) })
}

impl Recording {
    /// Checks the log, and splits it by its steering times speed.
    fn new(log: &DriveLog, split: &dyn Fn(&[f64]) -> Split) -> Result<Self, Error> {
        let speed = log.speed.clone().ok_or(Error::SpeedNeeded)?;
        let n = log.len();
        let no_model = |problem: &str| Err(Error::NoModel { problem: problem.into() });
        if log.output.len() != n || speed.len() != n {
            return no_model("steering, yaw rate and speed are not equally long");
        }
        let turned: Vec<f64> = log.input.iter().zip(&speed).map(|(u, v)| u * v).collect();
        let split = split(&turned);
        let least = count(&split.estimation).min(count(&split.validation));
        if least < LEAST_SAMPLES {
            let (got, need) = (n, (n * LEAST_SAMPLES).div_ceil(least.max(1)));
            let sample_time_s = log.sample_time_s;
            return Err(Error::TooFewSamples {
                got,
                need: need.max(2 * LEAST_SAMPLES),
                sample_time_s,
            });
        }
        if !log.input.iter().chain(&log.output).chain(&speed).all(|x| x.is_finite()) {
            return no_model("the recording is not finite");
        }
        if !(log.sample_time_s > 0.0 && log.steering_ratio > 0.0) {
            return no_model("sample time and steering ratio must be positive");
        }
        if let Some(v) = speed.iter().find(|v| **v < 0.0) {
            return Err(Error::NoModel { problem: format!("the speed is {v} m/s somewhere") });
        }
        for (signal, role) in [(&log.input, "steering"), (&log.output, "yaw rate")] {
            let estimation = of(signal, &split.estimation);
            let size = estimation.iter().fold(0.0_f64, |a, x| a.max(x.abs()));
            if standard_deviation(&estimation) <= 1e-12 * size {
                let problem = format!("the {role} does not move in the estimation data");
                return Err(Error::NoModel { problem });
            }
        }
        let steering = log.input.iter().map(|u| u / log.steering_ratio).collect();
        Ok(Self { steering, speed, split })
    }

    /// The log's stretches, each with its place.
    fn stretches<'a>(&'a self, log: &'a DriveLog) -> Vec<(Range<usize>, Stretch<'a>)> {
        let of = |range: &Range<usize>| Stretch {
            sample_time: log.sample_time_s,
            before: &[],
            steering: &self.steering[range.clone()],
            speed: &self.speed[range.clone()],
            yaw_rate: &log.output[range.clone()],
        };
        log.segments.iter().map(|s| (s.range.clone(), of(&s.range))).collect()
    }
}

fn count(ranges: &[Range<usize>]) -> usize {
    ranges.iter().map(Range::len).sum()
}

/// The samples of a signal that `ranges` hold.
fn of(signal: &[f64], ranges: &[Range<usize>]) -> Vec<f64> {
    ranges.iter().flat_map(|r| &signal[r.clone()]).copied().collect()
}

/// A model compared with the drive.
struct Judged {
    estimation_fit: f64,
    validation_fit: FitWithError,
    simulated: Vec<f64>,
    /// Whether the simulation of the held-out part stayed within all bounds.
    bounded: bool,
}

impl Judged {
    /// Fit of a part that left all bounds, percent: nothing of the drive is reproduced.
    const LOST: f64 = -100.0;

    fn new(
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

fn traces(log: &DriveLog, recording: &Recording, judged: &Judged) -> Traces {
    let mut is_validation = vec![false; log.len()];
    recording.split.validation.iter().for_each(|r| is_validation[r.clone()].fill(true));
    Traces {
        time_s: log.time_s(),
        steering_rad: log.input.clone(),
        yaw_rate_radps: log.output.clone(),
        is_validation,
        yaw_rad: log.yaw(&log.output),
        simulated_yaw_rad: log.yaw(&judged.simulated),
        simulated_yaw_rate_radps: judged.simulated.clone(),
    }
}
