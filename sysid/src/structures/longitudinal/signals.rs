//! The signals of a log on its grid, and which samples estimate and validate.
//!
//! Samples are used where the vehicle drives faster than the lowest speed: standstill, creeping and reversing end a piece.
//! The first seconds of each segment of the log only fill delays and lags. The pieces that estimate and those that
//! validate alternate, so that both have the speeds and roads of the whole log.

use crate::Error;
use crate::structures::longitudinal::options::LongitudinalOptions;
use std::ops::Range;
use steerwright_drivelog::{DriveLog, Role};

pub(super) const GRAVITY: f64 = 9.806_65;
/// Time at the start of a segment of the log whose inputs only fill delays and lags, s.
const SETTLED_S: f64 = 2.0;
/// Estimation and validation data alternate within this time, s.
const CYCLE_S: f64 = 60.0;
/// Shortest piece, s.
const LEAST_PIECE_S: f64 = 4.0;
/// Estimation data without which no model is estimated, s.
const LEAST_ESTIMATION_S: f64 = 20.0;
/// Samples on either side of one over which the speed that schedules gain and drag is averaged, s.
const HALF_AVERAGE_S: f64 = 0.25;
/// The same of the altitude, whose slope over the distance is the grade, s.
const HALF_SLOPE_S: f64 = 2.5;
/// Time around a change of the gear that is not used, s: the clutch is open.
const SHIFT_S: f64 = 0.7;
/// Least time in a gear whose gain is estimated, s.
const LEAST_GEAR_S: f64 = 15.0;

/// Samples that follow each other.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Piece {
    /// Place of the segment of the log.
    pub(super) segment: usize,
    pub(super) range: Range<usize>,
}

/// Where the grade comes from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum GradeSource {
    Grade,
    Pitch,
    Altitude,
    None,
}

impl GradeSource {
    pub(super) fn name(self) -> &'static str {
        match self {
            Self::Grade => "grade",
            Self::Pitch => "pitch",
            Self::Altitude => "altitude",
            Self::None => "none",
        }
    }
}

/// Signals of a log, one number for each of its samples.
#[derive(Debug)]
pub(super) struct Signals<'a> {
    pub(super) log: &'a DriveLog,
    /// Whether the command is an acceleration, otherwise an accelerator.
    pub(super) is_acceleration: bool,
    /// The brake from 0 to 1, where the log has one that is used.
    pub(super) brake: Option<&'a [f64]>,
    /// Mean speed around each sample, m/s.
    pub(super) mean_speed: Vec<f64>,
    /// g·sin(grade) in the step from each sample to the next, m/s².
    pub(super) gravity: Option<Vec<f64>>,
    pub(super) grade_source: GradeSource,
    /// Number of the gear.
    pub(super) gear: Option<Vec<i64>>,
    /// Gears that are used long enough.
    pub(super) gears: Vec<i64>,
}

impl<'a> Signals<'a> {
    pub(super) fn new(log: &'a DriveLog) -> Self {
        let unit = |role: Role| log.channels.iter().find(|channel| channel.role == role.key());
        let is_dimensionless =
            |role: Role| unit(role).is_some_and(|c| matches!(c.unit.as_str(), "1" | "%"));
        let brake = log.others.get(&Role::Brake).map(Vec::as_slice);
        let half = samples(HALF_AVERAGE_S, log);
        let mean_speed = by_segment(log, |own| mean_around(&log.output[own], half));
        let (grade_source, grade) = grade(log, is_dimensionless(Role::Grade));
        let gear: Option<Vec<i64>> = log
            .others
            .get(&Role::Gear)
            .map(|gear| gear.iter().map(|number| number.round() as i64).collect());
        Self {
            log,
            is_acceleration: !is_dimensionless(Role::LongitudinalCommand),
            brake: brake.filter(|brake| brake.iter().any(|x| (x - brake[0]).abs() > 1e-9)),
            mean_speed,
            gravity: grade.map(|grade| gravity(log, &grade)),
            grade_source,
            gears: match gear.as_deref() {
                Some(gear) => gears(log, gear),
                None => Vec::new(),
            },
            gear,
        }
    }

    /// The pieces that estimate and those that validate.
    pub(super) fn split(&self, options: &LongitudinalOptions) -> Result<[Vec<Piece>; 2], Error> {
        let log = self.log;
        let least = samples(LEAST_PIECE_S, log);
        let runs = self.runs(options.least_speed_mps, least);
        let all: usize = runs.iter().map(|run| run.range.len()).sum();
        let cycle = samples(CYCLE_S, log).min(all.max(1));
        let estimated = ((1.0 - options.validation_fraction) * cycle as f64).round() as usize;
        let mut split = [Vec::new(), Vec::new()];
        let mut place = 0;
        for run in runs {
            let (mut from, to) = (run.range.start, run.range.end);
            while from < to {
                let is_validation = place >= estimated;
                let left = if is_validation { cycle - place } else { estimated - place };
                let end = (from + left.max(1)).min(to);
                if end - from >= least {
                    let piece = Piece { segment: run.segment, range: from..end };
                    split[usize::from(is_validation)].push(piece);
                }
                place = (place + end - from) % cycle;
                from = end;
            }
        }
        let got: usize = split[0].iter().map(|piece| piece.range.len()).sum();
        let need = samples(LEAST_ESTIMATION_S, log);
        if got < need {
            return Err(Error::TooFewSamples { got, need, sample_time_s: log.sample_time_s });
        }
        Ok(split)
    }

    /// The runs of samples that can be used.
    fn runs(&self, least_speed: f64, least: usize) -> Vec<Piece> {
        let log = self.log;
        let (settled, shift) = (samples(SETTLED_S, log), samples(SHIFT_S, log));
        let mut runs = Vec::new();
        for (segment, own) in log.segments.iter().enumerate() {
            let mut begun = None;
            for k in own.range.start + settled..=own.range.end {
                let is_used = k < own.range.end
                    && self.mean_speed[k] >= least_speed
                    && self.is_in_gear(k, shift, &own.range);
                match (begun, is_used) {
                    (None, true) => begun = Some(k),
                    (Some(start), false) => {
                        begun = None;
                        if k - start >= least {
                            runs.push(Piece { segment, range: start..k });
                        }
                    }
                    _ => {}
                }
            }
        }
        runs
    }

    /// Whether a gear that is used is engaged, and stays so.
    fn is_in_gear(&self, k: usize, shift: usize, segment: &Range<usize>) -> bool {
        let Some(gear) = &self.gear else { return true };
        if self.gears.len() < 2 {
            return true;
        }
        let from = k.saturating_sub(shift).max(segment.start);
        let to = (k + shift + 1).min(segment.end);
        self.gears.contains(&gear[k]) && gear[from..to].iter().all(|other| *other == gear[k])
    }
}

/// Samples in a time.
pub(super) fn samples(time_s: f64, log: &DriveLog) -> usize {
    (time_s / log.sample_time_s).round().max(1.0) as usize
}

fn by_segment(log: &DriveLog, of: impl Fn(Range<usize>) -> Vec<f64>) -> Vec<f64> {
    let mut all = Vec::with_capacity(log.len());
    for segment in &log.segments {
        all.extend(of(segment.range.clone()));
    }
    all
}

/// Mean over `half` samples on either side.
fn mean_around(signal: &[f64], half: usize) -> Vec<f64> {
    let mut sums = vec![0.0];
    for x in signal {
        sums.push(sums.last().copied().unwrap_or_default() + x);
    }
    let mean = |k: usize| {
        let (from, to) = (k.saturating_sub(half), (k + half + 1).min(signal.len()));
        (sums[to] - sums[from]) / (to - from) as f64
    };
    (0..signal.len()).map(mean).collect()
}

/// The grade of the road, rad, from the best channel that the log has.
fn grade(log: &DriveLog, is_tangent: bool) -> (GradeSource, Option<Vec<f64>>) {
    if let Some(grade) = log.others.get(&Role::Grade) {
        let angle = |x: &f64| if is_tangent { x.atan() } else { *x };
        return (GradeSource::Grade, Some(grade.iter().map(angle).collect()));
    }
    if let Some(pitch) = log.others.get(&Role::Pitch) {
        // By ISO 8855 the nose is down where the pitch is positive.
        return (GradeSource::Pitch, Some(pitch.iter().map(|pitch| -pitch).collect()));
    }
    if let Some(altitude) = log.others.get(&Role::Altitude) {
        let half = samples(HALF_SLOPE_S, log);
        let slopes =
            by_segment(log, |own| slopes(&altitude[own.clone()], &log.output[own], log, half));
        return (GradeSource::Altitude, Some(slopes.iter().map(|slope| slope.atan()).collect()));
    }
    (GradeSource::None, None)
}

/// Slope of the altitude over the distance: that of the straight line through the samples around each.
fn slopes(altitude: &[f64], speed: &[f64], log: &DriveLog, half: usize) -> Vec<f64> {
    let mut distance = vec![0.0];
    for speed in speed {
        distance.push(distance.last().copied().unwrap_or_default() + speed * log.sample_time_s);
    }
    let slope = |k: usize| {
        let (from, to) = (k.saturating_sub(half), (k + half + 1).min(altitude.len()));
        let count = (to - from) as f64;
        let middle = distance[from..to].iter().sum::<f64>() / count;
        let height = altitude[from..to].iter().sum::<f64>() / count;
        let (mut square, mut product) = (0.0, 0.0);
        for (x, y) in distance[from..to].iter().zip(&altitude[from..to]) {
            square += (x - middle).powi(2);
            product += (x - middle) * (y - height);
        }
        // At a standstill there is no distance.
        if square > count { product / square } else { 0.0 }
    };
    (0..altitude.len()).map(slope).collect()
}

fn gravity(log: &DriveLog, grade: &[f64]) -> Vec<f64> {
    by_segment(log, |own| {
        let own = &grade[own];
        let next = |k: usize| own[(k + 1).min(own.len() - 1)];
        (0..own.len()).map(|k| GRAVITY * (0.5 * (own[k] + next(k))).sin()).collect()
    })
}

fn gears(log: &DriveLog, gear: &[i64]) -> Vec<i64> {
    let mut counts = std::collections::BTreeMap::new();
    for (number, command) in gear.iter().zip(&log.input) {
        if *number > 0 && command.abs() > 0.01 {
            *counts.entry(*number).or_insert(0_usize) += 1;
        }
    }
    let least = samples(LEAST_GEAR_S, log);
    counts.into_iter().filter(|(_, count)| *count >= least).map(|(number, _)| number).collect()
}
