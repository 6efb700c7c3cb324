//! Estimation and held-out data, means removed and scaled to unit spread.

use super::IdentifyOptions;
use crate::dense::row;
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
            .map(|s| Segment { u: row(&u[s.clone()]), y: row(&y[s]) })
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
        let split = n - (options.validation_fraction * n as f64).round() as usize;
        let (u, y) = (&input[..split], &log.output[..split]);
        let means = if options.remove_means { (mean(u), mean(y)) } else { (0.0, 0.0) };
        let scales = (standard_deviation(u), standard_deviation(y));
        for (scale, role) in [(scales.0, "steering"), (scales.1, "yaw rate")] {
            if scale <= 0.0 {
                return Err(Error::NoModel {
                    problem: format!("the {role} does not move in the estimation data"),
                });
            }
        }
        let scaled =
            |x: &[f64], m: f64, s: f64| -> Vec<f64> { x.iter().map(|v| (v - m) / s).collect() };
        let (u, y) =
            (scaled(&input[..n], means.0, scales.0), scaled(&log.output[..n], means.1, scales.1));
        Ok(Self {
            sample_time: log.sample_time_s,
            estimation: Part::new(log, &(0..split), &u, &y)?,
            validation: Part::new(log, &(split..n), &u, &y)?,
            input_mean: means.0,
            output_mean: means.1,
            input_scale: scales.0,
            output_scale: scales.1,
        })
    }
}
