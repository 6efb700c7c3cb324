//! Estimation and held-out data, offsets and trends removed, scaled to unit spread.
//!
//! *One offset for all drives.* The operating point is the vehicle's, and the mean of a single drive
//! tells its bends as much as the zeros of its sensors; so the means removed are those of the
//! estimation data of all drives together. Where a sensor's zero drifts, or differs from drive to
//! drive, [`Detrend::Linear`] takes out a line of its own for each.
//!
//! *The split* counts samples over all stretches; it is moved to the nearest end of a stretch where it
//! would leave a crumb of one.

use super::conditions::without;
use super::level::level;
use super::{Detrend, IdentifyOptions};
use crate::signal::{mean, standard_deviation};
use crate::{DataSet, DriveLog, Error, Segment};
use formats::InputKind;
use std::ops::Range;

/// Signals of one input and one output, `(signal − mean)/scale` of the estimation part.
pub(crate) struct Data {
    pub(crate) sample_time: f64,
    pub(crate) estimation: Part,
    pub(crate) validation: Part,
    pub(crate) input_mean: f64,
    pub(crate) output_mean: f64,
    pub(crate) input_scale: f64,
    pub(crate) output_scale: f64,
    /// What was taken from the output, for each run of samples.
    output_lines: Vec<(Range<usize>, Line)>,
}

/// `offset + slope·(t − middle)`, t in s on the clock.
#[derive(Clone, Copy)]
struct Line {
    offset: f64,
    slope: f64,
    middle: f64,
}

impl Line {
    fn flat(offset: f64) -> Self {
        Self { offset, slope: 0.0, middle: 0.0 }
    }

    /// The least-squares line.
    fn through(time: &[f64], x: &[f64]) -> Self {
        let (middle, offset) = (mean(time), mean(x));
        let square: f64 = time.iter().map(|t| (t - middle).powi(2)).sum();
        let along: f64 = time.iter().zip(x).map(|(t, x)| (t - middle) * (x - offset)).sum();
        Self { offset, slope: if square > 0.0 { along / square } else { 0.0 }, middle }
    }

    fn at(self, t: f64) -> f64 {
        self.offset + self.slope * (t - self.middle)
    }
}

/// One stretch of time, in as many segments as the log has there.
pub(crate) struct Part {
    pub(crate) data: DataSet,
    /// The output of all segments, one after the other, for fits.
    pub(crate) output: Vec<f64>,
}

impl Part {
    /// The part of the log's segments within `range`.
    fn new(log: &DriveLog, range: &Range<usize>, u: &[f64], y: &[f64]) -> Result<Self, Error> {
        let within = |s: &Range<usize>| s.start.max(range.start)..s.end.min(range.end);
        let segments = log
            .segments
            .iter()
            .map(|s| within(&s.range))
            .filter(|s| !s.is_empty())
            .map(|s| Segment::new(u[s.clone()].to_vec(), y[s].to_vec()))
            .collect();
        let data = DataSet::new(log.sample_time_s, segments)?;
        Ok(Self { data, output: y[range.clone()].to_vec() })
    }

    pub(crate) fn len(&self) -> usize {
        self.output.len()
    }

    /// One number for each sample of the part, segment by segment.
    pub(crate) fn stretches<'a>(&self, values: &'a [f64]) -> Vec<&'a [f64]> {
        let mut rest = values;
        let lengths = self.data.segments().iter().map(Segment::len);
        lengths
            .map(|n| {
                let (head, tail) = rest.split_at(n.min(rest.len()));
                rest = tail;
                head
            })
            .collect()
    }
}

/// The signal that drives the model: steering, or steering times speed.
pub(crate) fn driving_input(log: &DriveLog, kind: InputKind) -> Result<Vec<f64>, Error> {
    match (kind, &log.speed) {
        (InputKind::Steering, _) => Ok(log.input.clone()),
        (InputKind::SteeringTimesSpeed, Some(speed)) => {
            Ok(log.input.iter().zip(speed).map(|(u, v)| u * v).collect())
        }
        (InputKind::SteeringTimesSpeed, None) => Err(Error::NoSpeed),
    }
}

impl Data {
    /// Splits and scales; the held-out part is the end of the log.
    pub(crate) fn new(log: &DriveLog, options: &IdentifyOptions) -> Result<Self, Error> {
        const LEAST: usize = 100;
        let input = driving_input(log, options.input_kind)?;
        let n = input.len().min(log.output.len());
        if n < LEAST {
            return Err(Error::TooFewSamples {
                got: n,
                need: LEAST,
                sample_time_s: log.sample_time_s,
            });
        }
        if input.iter().chain(&log.output).any(|x| !x.is_finite()) {
            return Err(Error::NoModel { problem: "the recording is not finite".into() });
        }
        let split = split(log, n, options.validation_fraction);
        let (u, y) = (&input[..split], &log.output[..split]);
        let of = |x: &[f64]| {
            let ranges = log.segments.iter().map(|s| s.range.start..s.range.end.min(split));
            level(ranges.filter(|r| !r.is_empty()).map(|r| &x[r]))
        };
        let means = match options.detrend {
            Detrend::None => (0.0, 0.0),
            Detrend::Mean | Detrend::Linear => (of(u), of(y)),
        };
        let time = log.time_s();
        let lines = |x: &[f64], mean: f64| -> Vec<(Range<usize>, Line)> {
            match options.detrend {
                Detrend::Linear => clock_runs(&time, split)
                    .into_iter()
                    .map(|run| (run.clone(), Line::through(&time[run.clone()], &x[run])))
                    .collect(),
                Detrend::Mean | Detrend::None => vec![(0..n, Line::flat(mean))],
            }
        };
        let input_lines = lines(&input, means.0);
        let output_lines = lines(&log.output, means.1);
        // A drift is no motion: the spread is that about the lines.
        let spread = |x: &[f64], lines: &[(Range<usize>, Line)], role: &str| {
            let runs = lines.iter().flat_map(|(run, line)| run.clone().map(move |k| (k, *line)));
            let about: Vec<f64> = runs
                .take_while(|(k, _)| *k < split)
                .map(|(k, line)| x[k] - line.at(time[k]))
                .collect();
            let scale = standard_deviation(&about);
            let size = x[..split].iter().fold(0.0_f64, |most, x| most.max(x.abs()));
            if scale <= 1e-13 * size {
                return Err(Error::NoModel {
                    problem: format!("the {role} does not move in the estimation data"),
                });
            }
            Ok(scale)
        };
        let scales = (
            spread(&input, &input_lines, "steering")?,
            spread(&log.output, &output_lines, "yaw rate")?,
        );
        let scaled = |x: &[f64], lines: &[(Range<usize>, Line)], scale: f64| -> Vec<f64> {
            let runs = lines.iter().flat_map(|(run, line)| run.clone().map(move |k| (k, *line)));
            runs.map(|(k, line)| (x[k] - line.at(time[k])) / scale).collect()
        };
        let u = scaled(&input, &input_lines, scales.0);
        let y = scaled(&log.output, &output_lines, scales.1);
        Ok(Self {
            sample_time: log.sample_time_s,
            estimation: Part::new(log, &(0..split), &u, &y)?,
            validation: Part::new(log, &(split..n), &u, &y)?,
            input_mean: means.0,
            output_mean: means.1,
            input_scale: scales.0,
            output_scale: scales.1,
            output_lines,
        })
    }

    /// The same about another output level, given in scaled units.
    pub(crate) fn about(mut self, level: f64) -> Result<Self, Error> {
        for part in [&mut self.estimation, &mut self.validation] {
            part.data = without(&part.data, &[level])?;
            part.output.iter_mut().for_each(|y| *y -= level);
        }
        let shift = self.output_scale * level;
        self.output_mean += shift;
        self.output_lines.iter_mut().for_each(|(_, line)| line.offset += shift);
        Ok(self)
    }

    /// Yaw rate, rad/s, in place of the scaled one of all samples.
    pub(crate) fn restore(&self, log: &DriveLog, y: &mut [f64]) {
        let time = log.time_s();
        for (run, line) in &self.output_lines {
            for k in run.clone() {
                y[k] = line.at(time[k]) + self.output_scale * y[k];
            }
        }
    }
}

/// The first sample that is held out.
fn split(log: &DriveLog, n: usize, held_out: f64) -> usize {
    /// Shorter pieces of a stretch have no column in a block Hankel matrix of 30 block rows.
    const CRUMB: usize = 60;
    let split = n - (held_out * n as f64).round() as usize;
    let ends = log.segments.iter().map(|s| s.range.end).filter(|end| *end < n);
    ends.min_by_key(|end| end.abs_diff(split))
        .filter(|end| end.abs_diff(split) < CRUMB)
        .unwrap_or(split)
}

/// Runs of samples on one clock, none across the split: a clock that goes back is another drive's.
fn clock_runs(time: &[f64], split: usize) -> Vec<Range<usize>> {
    let mut runs: Vec<Range<usize>> = Vec::new();
    for k in 0..time.len() {
        match runs.last_mut() {
            Some(run) if k != split && time[k] > time[k - 1] => run.end = k + 1,
            _ => runs.push(k..k + 1),
        }
    }
    runs
}
