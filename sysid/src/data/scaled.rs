//! Estimation and validation data, offsets and trends removed, scaled to unit spread. The means
//! removed are those of the estimation data of all drives together, since the mean of a single
//! drive depends on its bends as much as on the zeros of its sensors; where these drift or differ,
//! [`Detrend::Linear`] takes out a line for each. The [`split`](crate::data::split) is at the end
//! of the log where it is excited.

use crate::Error;
use crate::data::dataset::{DataSet, Segment, without};
use crate::data::recording::samples_in;
use crate::data::split::{Selection, Split, ValidationData};
use crate::error::check_yaw_rate;
use std::ops::Range;
use steerwright_drivelog::signal::{mean, standard_deviation};
use steerwright_drivelog::{self as drivelog, DriveLog};
use steerwright_formats::InputKind;

/// Offsets and trends that are no dynamics.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Detrend {
    /// The means of the estimation data, all drives together, from estimation and validation data. That
    /// of the output is the one about which the model moves: it is found with the model.
    Mean,
    /// A line over time for the estimation and one for the validation data of each clock, for
    /// sensors whose zero drifts or differs between drives. Fits are relative to these lines.
    Linear,
    /// Nothing: the model passes through the origin.
    None,
}

steerwright_formats::words!(Detrend { Mean = "mean", Linear = "linear", None = "none" });

/// How a log becomes estimation and validation data.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Preparation {
    pub(crate) input_kind: InputKind,
    pub(crate) detrend: Detrend,
    pub(crate) validation: ValidationData,
    /// Most samples that estimate.
    pub(crate) max_samples: Option<usize>,
}

/// Signals of one input and one output, `(signal − mean)/scale` of the estimation part.
#[derive(Clone)]
pub(crate) struct Data {
    pub(crate) sample_time: f64,
    pub(crate) estimation: Part,
    pub(crate) validation: Part,
    pub(crate) input_mean: f64,
    pub(crate) output_mean: f64,
    pub(crate) input_scale: f64,
    pub(crate) output_scale: f64,
    pub(crate) selection: Selection,
    /// All samples of the log, in its segments; where lines over time were taken out, in as many as there are lines.
    pub(crate) whole: Part,
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

    fn through(time: &[f64], x: &[f64]) -> Self {
        let (middle, offset) = (mean(time), mean(x));
        let square: f64 = time.iter().map(|t| (t - middle).powi(2)).sum();
        let along: f64 = time.iter().zip(x).map(|(t, x)| (t - middle) * (x - offset)).sum();
        Self { offset, slope: if square > 0.0 { along / square } else { 0.0 }, middle }
    }

    fn value_at(self, t: f64) -> f64 {
        self.offset + self.slope * (t - self.middle)
    }
}

/// Estimation or validation data, in as many segments as the log has there.
#[derive(Clone)]
pub(crate) struct Part {
    pub(crate) data: DataSet,
    /// Which of the log's samples each segment is.
    pub(crate) ranges: Vec<Range<usize>>,
    /// The output of all segments, one after the other, for fits.
    pub(crate) output: Vec<f64>,
}

impl Part {
    fn new(
        sample_time_s: f64,
        ranges: Vec<Range<usize>>,
        u: &[f64],
        y: &[f64],
    ) -> Result<Self, Error> {
        let segments = ranges
            .iter()
            .map(|r| Segment::new(u[r.clone()].to_vec(), y[r.clone()].to_vec()))
            .collect();
        let data = DataSet::new(sample_time_s, segments)?;
        let output = samples_in(y, &ranges);
        Ok(Self { data, ranges, output })
    }

    /// The part's samples of a signal of the whole log, one after the other.
    pub(crate) fn samples(&self, signal: &[f64]) -> Vec<f64> {
        samples_in(signal, &self.ranges)
    }

    /// Puts one number for each sample of the part into a signal of the whole log.
    pub(crate) fn put(&self, values: &[f64], into: &mut [f64]) {
        let at = self.ranges.iter().flat_map(|r| r.clone());
        at.zip(values).for_each(|(k, value)| into[k] = *value);
    }

    pub(crate) fn len(&self) -> usize {
        self.output.len()
    }

    /// One number for each sample of the part, segment by segment.
    pub(crate) fn segments_of<'a>(&self, values: &'a [f64]) -> Vec<&'a [f64]> {
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
pub(crate) fn driving_input(
    steering: &[f64],
    speed: Option<&[f64]>,
    kind: InputKind,
) -> Result<Vec<f64>, Error> {
    match (kind, speed) {
        (InputKind::Steering, _) => Ok(steering.to_vec()),
        (InputKind::SteeringTimesSpeed, Some(speed)) => {
            Ok(steering.iter().zip(speed).map(|(u, v)| u * v).collect())
        }
        (InputKind::SteeringTimesSpeed, None) => Err(Error::NoSpeed),
    }
}

impl Data {
    /// Splits and scales by [`Split::new`]; lines over time need the end.
    pub(crate) fn new(log: &DriveLog, options: &Preparation) -> Result<Self, Error> {
        if options.detrend == Detrend::Linear {
            return Self::of_end(log, options);
        }
        Self::split(log, options, &|input| {
            Split::new(log, input, options.validation)
                .thinned(options.max_samples, log.sample_time_s)
        })
    }

    /// The same, where the end of the log validates whatever was driven there.
    pub(crate) fn of_end(log: &DriveLog, options: &Preparation) -> Result<Self, Error> {
        Self::split(log, options, &|u| Split::end(log, u.len(), options.validation.fraction))
    }

    fn split(
        log: &DriveLog,
        options: &Preparation,
        split: &dyn Fn(&[f64]) -> Split,
    ) -> Result<Self, Error> {
        const LEAST: usize = 100;
        check_yaw_rate(log)?;
        let input = driving_input(&log.input, log.speed.as_deref(), options.input_kind)?;
        let n = input.len().min(log.output.len());
        if n < LEAST {
            return Err(Error::too_few(n, LEAST, log.sample_time_s));
        }
        if input.iter().chain(&log.output).any(|x| !x.is_finite()) {
            return Err(Error::no_model("the recording is not finite"));
        }
        let Split { estimation, validation, selection } = split(&input[..n]);
        let mean = |x: &[f64]| match options.detrend {
            Detrend::None => 0.0,
            _ => tapered_mean(estimation.iter().map(|r| &x[r.clone()])),
        };
        let (input_mean, output_mean) = (mean(&input), mean(&log.output));
        let time = log.time_s();
        let first_validation = validation.first().map_or(n, |r| r.start);
        let lines = |x: &[f64], mean: f64| -> Vec<(Range<usize>, Line)> {
            if options.detrend != Detrend::Linear {
                return vec![(0..n, Line::flat(mean))];
            }
            let line = |run: Range<usize>| Line::through(&time[run.clone()], &x[run]);
            let runs = clock_runs(&time, first_validation).into_iter();
            runs.map(|run| (run.clone(), line(run))).collect()
        };
        // A drift is no motion: the spread is that about the lines.
        let scaled = |x: &[f64], lines: &[(Range<usize>, Line)], role: &str| {
            let runs = lines.iter().flat_map(|(run, line)| run.clone().map(move |k| (k, *line)));
            let mut all: Vec<f64> = runs.map(|(k, line)| x[k] - line.value_at(time[k])).collect();
            let part = || estimation.iter().flat_map(|r| r.clone());
            let scale = standard_deviation(&part().map(|k| all[k]).collect::<Vec<_>>());
            let size = part().map(|k| x[k].abs()).fold(0.0, f64::max);
            if scale <= 1e-13 * size {
                let problem = format!("the {role} does not move in the estimation data");
                return Err(Error::no_model(problem));
            }
            all.iter_mut().for_each(|x| *x /= scale);
            Ok((all, scale))
        };
        let output_lines = lines(&log.output, output_mean);
        let (u, input_scale) = scaled(&input, &lines(&input, input_mean), "steering")?;
        let (y, output_scale) = scaled(&log.output, &output_lines, "yaw rate")?;
        let segments = output_lines.iter().flat_map(|(run, _)| {
            let within =
                |s: &drivelog::Segment| s.range.start.max(run.start)..s.range.end.min(run.end);
            log.segments.iter().map(within).filter(|r| !r.is_empty())
        });
        let whole = Part::new(log.sample_time_s, segments.collect(), &u, &y)?;
        Ok(Self {
            sample_time: log.sample_time_s,
            estimation: Part::new(log.sample_time_s, estimation, &u, &y)?,
            validation: Part::new(log.sample_time_s, validation, &u, &y)?,
            selection,
            whole,
            input_mean,
            output_mean,
            input_scale,
            output_scale,
            output_lines,
        })
    }

    /// The estimation data over the length of the block that a sample of them is in, on the mean, where they are blocks of
    /// the log's segments; 1 where each has the initial state that the log gives it. What a mode slower than a block
    /// leaves from one block to the next is replaced by the initial state of each, so that the data do not show it.
    pub(crate) fn records_of_blocks(&self) -> f64 {
        let blocks = &self.estimation.ranges;
        if blocks.len() <= self.whole.ranges.len() {
            return 1.0;
        }
        let samples = self.estimation.len() as f64;
        let length = blocks.iter().map(|r| (r.len() * r.len()) as f64).sum::<f64>() / samples;
        samples / length
    }

    pub(crate) fn about(mut self, offset: f64) -> Result<Self, Error> {
        for part in [&mut self.estimation, &mut self.validation, &mut self.whole] {
            part.data = without(&part.data, &[offset])?;
            part.output.iter_mut().for_each(|y| *y -= offset);
        }
        let shift = self.output_scale * offset;
        self.output_mean += shift;
        self.output_lines.iter_mut().for_each(|(_, line)| line.offset += shift);
        Ok(self)
    }

    /// Yaw rate, rad/s, in place of the scaled one of all samples.
    pub(crate) fn restore(&self, log: &DriveLog, y: &mut [f64]) {
        let time = log.time_s();
        for (run, line) in &self.output_lines {
            for k in run.clone() {
                y[k] = line.value_at(time[k]) + self.output_scale * y[k];
            }
        }
    }
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

/// Mean of all segments, each weighted by a Hann window of its length, which loses nothing at the
/// ends: what rings there would leave a constant in the simulation errors, which falls with the
/// 1.5th power of the record's length (R. Pintelon, J. Schoukens, *System Identification: A
/// Frequency Domain Method*, 2012, section 2.2.3, on leakage at the frequency 0).
pub(crate) fn tapered_mean<'a>(segments: impl Iterator<Item = &'a [f64]>) -> f64 {
    let (mut sum, mut total) = (0.0, 0.0);
    for segment in segments {
        for (t, x) in segment.iter().enumerate() {
            let phase = std::f64::consts::PI * (t as f64 + 0.5) / segment.len() as f64;
            let weight = phase.sin().powi(2);
            sum += weight * x;
            total += weight;
        }
    }
    if total > 0.0 { sum / total } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn of_a_constant_and_of_a_slow_response() {
        assert!((tapered_mean([[3.0; 10].as_slice(), &[3.0; 5]].into_iter()) - 3.0).abs() < 1e-14);
        // y⁺ = 0.95 y + 0.05 u from a state that the input before the record left.
        let u: Vec<f64> = (0..2000).map(|t| (f64::from(t) * 0.37).sin() + 0.5).collect();
        let mut y = vec![4.0];
        for (t, u) in u.iter().enumerate().skip(1) {
            y.push(0.95 * y[t - 1] + 0.05 * u);
        }
        let off = |mean: fn(&[f64]) -> f64| (mean(&y) - mean(&u)).abs();
        let (plain, tapered) =
            (off(steerwright_drivelog::signal::mean), off(|x| tapered_mean(std::iter::once(x))));
        assert!(plain > 0.02 && tapered < 0.05 * plain, "{plain} {tapered}");
    }
}
