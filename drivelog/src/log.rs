//! A drive on one uniform grid.

use crate::gnss::Gnss;
use crate::options::{Response, VehicleClass};
use crate::role::Role;
use crate::segments::within_speeds;
use crate::signal::integrate;
use crate::units::{Quantity, parse_unit};
use std::borrow::Cow;
use std::collections::BTreeMap;
use std::ops::Range;
use steerwright_formats::{ChannelSummary, Intersample, SourceFile};

/// A drive on one uniform grid, SI and radians, ISO 8855 signs.
#[derive(Debug, Clone, PartialEq)]
pub struct DriveLog {
    /// The first file's name without its ending.
    pub name: String,
    /// Sample time T, s.
    pub sample_time_s: f64,
    /// The segments without a gap, in order; together they are all samples.
    pub segments: Vec<Segment>,
    /// What responds to what.
    pub response: Response,
    /// Steering angle, rad, in the log's coordinates, held over each sample: of an angle that moves on
    /// between its samples, the held one that does the same to a vehicle. Of the response of the lateral
    /// acceleration, samples of the torque, Nm, or of its normalised command; of the response of the speed, the
    /// acceleration command, m/s², or the accelerator from 0 to 1, held over each sample.
    pub input: Vec<f64>,
    /// Yaw rate, rad/s, lateral acceleration, m/s², or speed, m/s.
    pub output: Vec<f64>,
    /// Speed, m/s.
    pub speed: Option<Vec<f64>>,
    /// Samples of further channels, SI; of the motion also those of the steering angle.
    pub others: BTreeMap<Role, Vec<f64>>,
    /// Steering angle over road-wheel angle.
    pub steering_ratio: f64,
    /// Class of the vehicle, where it is stated.
    pub vehicle_class: Option<VehicleClass>,
    /// A receiver's fixes, where the log has them.
    pub gnss: Option<Gnss>,
    /// What was read from each column.
    pub channels: Vec<ChannelSummary>,
    /// Warnings of the reader.
    pub warnings: Vec<String>,
    /// The files, by name and hash.
    pub sources: Vec<SourceFile>,
    /// The options in force, by name.
    pub options: BTreeMap<String, String>,
}

/// Samples of a log that follow each other without a gap.
#[derive(Debug, Clone, PartialEq)]
pub struct Segment {
    /// Time of the first sample, s from the first sample of its drive; the option `log_start_s` states that
    /// instant on the clock of the log.
    pub time0_s: f64,
    /// Which of the log's samples they are.
    pub range: Range<usize>,
}

impl DriveLog {
    /// How fast the steering moved, rad/s in steering coordinates.
    #[must_use]
    pub fn fastest_steering(&self) -> f64 {
        self.segments
            .iter()
            .map(|s| {
                steerwright_formats::Excitation::largest_rate(
                    &self.input[s.range.clone()],
                    self.sample_time_s,
                )
            })
            .fold(0.0, f64::max)
    }

    /// Time of each sample, s from the first sample of its drive.
    #[must_use]
    pub fn time_s(&self) -> Vec<f64> {
        let times = |s: &Segment| {
            let (from, step) = (s.time0_s, self.sample_time_s);
            (0..s.range.len()).map(move |k| from + k as f64 * step)
        };
        self.segments.iter().flat_map(times).collect()
    }

    /// Integral of a yaw rate on the log's samples, rad; the yaw across a gap is unknown, so each
    /// segment starts where the last one ended.
    #[must_use]
    pub fn yaw(&self, rate: &[f64]) -> Vec<f64> {
        let mut all: Vec<f64> = Vec::with_capacity(rate.len());
        for segment in &self.segments {
            let from = all.last().copied().unwrap_or(0.0);
            let yaw = integrate(&rate[segment.range.clone()], self.sample_time_s);
            all.extend(yaw.iter().map(|yaw| from + yaw));
        }
        all
    }

    /// The segments in which the speed, averaged over a second, is `least_mps` or more, with a warning about what is left
    /// out: an empty log if the speed is below that everywhere, and all of a log that has no speed of all samples.
    #[must_use]
    pub fn above_speed(&self, least_mps: f64) -> Cow<'_, Self> {
        let Some(speed) = &self.speed else { return Cow::Borrowed(self) };
        let is_speed = |v: &f64| v.is_finite() && *v >= 0.0;
        let are_signals = [&self.output, speed].into_iter().chain(self.others.values());
        let is_whole = are_signals.into_iter().all(|signal| signal.len() == self.len());
        let is_fast = speed.iter().all(|v| *v >= least_mps);
        if !is_whole || is_fast || !speed.iter().all(is_speed) {
            return Cow::Borrowed(self);
        }
        let step = self.sample_time_s;
        let mut kept: Vec<(f64, Range<usize>)> = Vec::new();
        for segment in &self.segments {
            let (time0_s, first) = (segment.time0_s, segment.range.start);
            let speed = &speed[segment.range.clone()];
            for run in within_speeds(speed, step, (least_mps, f64::INFINITY)) {
                let from_s = time0_s + run.start as f64 * step;
                kept.push((from_s, first + run.start..first + run.end));
            }
        }
        let count: usize = kept.iter().map(|(_, range)| range.len()).sum();
        if count == self.len() {
            return Cow::Borrowed(self);
        }
        let of = |signal: &[f64]| -> Vec<f64> {
            kept.iter().flat_map(|(_, range)| &signal[range.clone()]).copied().collect()
        };
        let mut end = 0;
        let segments = kept.iter().map(|(time0_s, range)| {
            let start = end;
            end += range.len();
            Segment { time0_s: *time0_s, range: start..end }
        });
        let segments = segments.collect();
        let mut warnings = self.warnings.clone();
        let left_out_s = (self.len() - count) as f64 * step;
        warnings.push(below_speed_in_words(least_mps, left_out_s, self.len() as f64 * step));
        Cow::Owned(Self {
            segments,
            input: of(&self.input),
            output: of(&self.output),
            speed: Some(of(speed)),
            others: self.others.iter().map(|(role, signal)| (*role, of(signal))).collect(),
            warnings,
            ..self.clone()
        })
    }

    /// Whether the steering is an angle, or a command whose angle at 1 is stated; it is one too where that is unknown.
    #[must_use]
    pub fn has_steering_angle(&self) -> bool {
        let is_angle = |unit: &str| {
            parse_unit(unit).is_none_or(|unit| unit.quantity != Quantity::Dimensionless)
        };
        let mut channels = self.channels.iter().filter(|c| c.role == Role::Steering.key());
        self.options.contains_key("steering_full_scale_rad") || channels.all(|c| is_angle(&c.unit))
    }

    /// Period of an input, such as the steering, s, where it is read as held or as moving on between its samples without an
    /// option that states so: its name, its unit and its values are no proof. An angle may be held, and a command set more
    /// often than it is logged.
    #[must_use]
    pub fn assumed_period_s(&self, role: Role, between_samples: Intersample) -> Option<f64> {
        let is_stated = self.options.get("intersample").is_some_and(|stated| stated != "auto");
        let channel = self.channels.iter().find(|c| c.role == role.key())?;
        if is_stated || channel.intersample != Some(between_samples) {
            return None;
        }
        let period_s = 1.0 / channel.rate_hz;
        if period_s.is_finite() && period_s > 0.0 { Some(period_s) } else { None }
    }

    /// What was read from each column of a role by its word in files, such as `output`.
    pub fn channels_of<'l>(&'l self, role: &'l str) -> impl Iterator<Item = &'l ChannelSummary> {
        self.channels.iter().filter(move |channel| channel.role == role)
    }

    /// Number of samples.
    #[must_use]
    pub fn len(&self) -> usize {
        self.input.len()
    }

    /// Whether there is no sample.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.input.is_empty()
    }
}

/// The warning about the time below a least speed.
#[must_use]
pub fn below_speed_in_words(least_mps: f64, left_out_s: f64, all_s: f64) -> String {
    format!(
        "the speed is below {least_mps} m/s in {left_out_s:.1} s of {all_s:.1} s: these segments are left out"
    )
}
