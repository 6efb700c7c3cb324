//! A log read in chunks: what [`read_drives`](super::read_drives) makes of a file, piece by piece, in
//! memory that does not grow with the file.
//!
//! A file is a drive of its own. Its sample time and whether its clock is uniform are those of its
//! first rows; a clock that changes later is refused, since the filters are made for the first. Gaps,
//! filters and grids are those of the whole reading: a stretch has the same samples however long the
//! chunks are.

mod channel;
mod gate;
mod span;
#[cfg(test)]
mod tests;

use super::drive::{Drive, brings, leave_out_frozen, steering_ratio};
use super::intersample;
use super::mapping::{self, Source, time_column};
use super::role::Role;
use super::series::{Series, check_clock};
use super::stretches::{self, Clock};
use super::table::{Columns, Table};
use super::{LogFile, LogOptions, check_options, last_part, signal_words, stem};
use crate::Error;
use channel::Channel;
use formats::{ChannelSummary, SourceFile};
use span::Spans;

/// Rows read at once.
const CHUNK: usize = 1 << 14;
/// Slower on average, a vehicle stands, m/s.
const LEAST_MEAN_SPEED: f64 = 0.5;

/// What comes out of a log, in order.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Piece<'a> {
    /// Samples that continue the stretch.
    Samples {
        /// Steering angle, rad.
        steering: &'a [f64],
        /// Yaw rate, rad/s.
        yaw_rate: &'a [f64],
        /// Speed, m/s.
        speed: Option<&'a [f64]>,
    },
    /// The stretch ends.
    End,
}

/// What a log has told about itself.
pub(crate) struct Streamed {
    pub(crate) name: String,
    pub(crate) steering_ratio: f64,
    pub(crate) channels: Vec<ChannelSummary>,
    pub(crate) source: SourceFile,
    pub(crate) warnings: Vec<String>,
}

/// Where the pieces go, with their sample time in s.
pub(crate) type Sink<'a> = dyn FnMut(f64, Piece<'_>) -> Result<(), Error> + 'a;

/// Reads one file to its end.
pub(crate) fn stream(
    file: LogFile<'_>,
    options: &LogOptions,
    sink: &mut Sink<'_>,
) -> Result<Streamed, Error> {
    in_chunks(file, options, CHUNK, sink)
}

fn in_chunks(
    file: LogFile<'_>,
    options: &LogOptions,
    chunk: usize,
    sink: &mut Sink<'_>,
) -> Result<Streamed, Error> {
    check_options(options)?;
    if !options.windows.is_empty() {
        let value = format!("{} of them", options.windows.len());
        let expected = "none where logs are read in chunks".into();
        return Err(Error::Option { option: "--window", value, expected });
    }
    let mut table = Table::open(file, options.decimal)?;
    for role in [Role::Steering, Role::YawRate] {
        if !brings(&table, role, options) {
            return Err(Error::NotADrive { file: table.file, role: role.name() });
        }
    }
    mapping::check_units_are_used(std::iter::once(&table), options)?;
    let mut warnings = Vec::new();
    let mut sources = Vec::new();
    let tables = [table];
    for role in [Role::Steering, Role::YawRate, Role::Speed] {
        if let Some(source) = mapping::find(&tables, options, role, &mut warnings)? {
            sources.push((role, source));
        }
    }
    let [read] = tables;
    table = read;
    let has_speed = sources.iter().any(|(role, _)| *role == Role::Speed);
    if options.speed_window.is_some() && !has_speed {
        return Err(Error::NoSpeedForWindow { drive: last_part(&table.file).into() });
    }
    let mut reading = Reading::new(&table, &sources, options)?;
    let mut spans: Option<Spans> = None;
    loop {
        let rows = table.rows(&reading.wanted, chunk)?;
        let is_last = rows.lines.len() < chunk;
        reading.take(rows, is_last)?;
        if spans.is_none() {
            let ratio = reading.begin(options, &mut warnings)?;
            let clock = Clock::of(&reading.drive);
            let step = stretches::sample_time(&[&clock], options)?;
            reading.drive.steering_ratio = ratio;
            spans = Some(Spans::new(clock, step, options.speed_window));
        } else {
            // A later angle may be more than a road wheel can turn.
            steering_ratio(&reading.drive.channels[0], options, &mut Vec::new())?;
        }
        if let Some(spans) = &mut spans {
            spans.advance(&mut reading.drive, options, is_last, sink)?;
        }
        if is_last {
            break;
        }
    }
    reading.check_at_the_end()?;
    let repeated = reading.channels.iter().filter_map(|c| c.repeated);
    warnings.extend(repeated.map(|r| r.warning(&reading.drive.channels[0].file)));
    if let Some(spans) = &spans {
        warnings.extend(spans.told(&reading.drive.name));
    }
    warnings.extend(reading.drive.channels.iter().filter_map(Series::spikes_in_words));
    warnings.extend(reading.drive.channels.iter().filter_map(Series::frozen_in_words));
    for channel in &reading.channels {
        if channel.missing > 0 {
            warnings.push(format!(
                "{}: column `{}`: {} missing; short runs are bridged by straight lines",
                last_part(&table.file),
                channel.column,
                signal_words(channel.missing, "sample")
            ));
        }
    }
    let summaries = reading.channels.iter().zip(&reading.drive.channels);
    Ok(Streamed {
        name: stem(&table.file),
        steering_ratio: reading.drive.steering_ratio,
        channels: summaries.map(|(c, series)| c.summary(series)).collect(),
        warnings,
        source: table.finish(),
    })
}

/// The rows at hand and what is known of those before.
struct Reading {
    /// The rows not yet done with.
    drive: Drive,
    channels: Vec<Channel>,
    /// Columns of the file: the clock, if it has one, and the channels.
    wanted: Vec<usize>,
    /// The clock's column and its unit in s.
    clock: Option<(String, f64)>,
    row_period_s: f64,
    options: LogOptions,
    rows: usize,
    before: f64,
    /// Rows of the last instant read, which the next may repeat.
    open: Columns,
}

impl Reading {
    fn new(
        table: &Table<'_>,
        sources: &[(Role, Source)],
        options: &LogOptions,
    ) -> Result<Self, Error> {
        let clock = time_column(table, options)?;
        let channels: Vec<Channel> =
            sources.iter().map(|(_, source)| Channel::new(table, source)).collect();
        let series = sources.iter().map(|(role, s)| channel::empty(table, *role, s)).collect();
        Ok(Self {
            drive: Drive {
                name: last_part(&table.file).into(),
                channels: series,
                places: Vec::new(),
                files: Vec::new(),
                steering_ratio: 1.0,
            },
            wanted: clock
                .iter()
                .map(|(c, _)| *c)
                .chain(sources.iter().map(|(_, s)| s.column))
                .collect(),
            clock: clock.map(|(c, unit)| (table.header[c].clone(), unit.to_si)),
            channels,
            row_period_s: options.row_period_s.unwrap_or(1.0),
            options: options.clone(),
            rows: 0,
            before: f64::NEG_INFINITY,
            open: Columns::default(),
        })
    }

    /// Adds rows to every channel.
    fn take(&mut self, rows: Columns, is_last: bool) -> Result<(), Error> {
        let mut rows = std::mem::take(&mut self.open).and(rows);
        if self.clock.is_some() && !is_last {
            let time = &rows.values[0];
            let last = time.iter().rev().copied().find(|t| !t.is_nan());
            let first = last.and_then(|last| time.iter().position(|t| *t == last));
            // A clock that stands still is refused below, not held back.
            if let Some(first) = first.filter(|first| 2 * first > time.len()) {
                self.open = rows.split_off(first);
            }
        }
        let file = &self.drive.channels[0].file;
        let mut values = rows.values.into_iter();
        let time: Vec<f64> = match &self.clock {
            Some((column, to_si)) => {
                let mut time = values.next().unwrap_or_default();
                time.iter_mut().for_each(|t| *t *= to_si);
                self.before = check_clock(file, column, &time, &rows.lines, self.before)?;
                time
            }
            None => {
                let period = self.row_period_s;
                (0..rows.lines.len()).map(|i| (self.rows + i) as f64 * period).collect()
            }
        };
        self.rows += rows.lines.len();
        let from: Vec<usize> = self.drive.channels.iter().map(|c| c.value.len()).collect();
        let both = self.channels.iter_mut().zip(&mut self.drive.channels);
        for ((channel, series), value) in both.zip(values) {
            channel.take(series, &time, value, &rows.lines, &self.options)?;
        }
        leave_out_frozen(&mut self.drive.channels, &from);
        Ok(())
    }

    /// What the first rows tell: the steering ratio.
    fn begin(&mut self, options: &LogOptions, warnings: &mut Vec<String>) -> Result<f64, Error> {
        for (channel, series) in self.channels.iter().zip(&self.drive.channels) {
            if series.time.len() < 3 {
                return Err(Error::TooFewRows {
                    file: series.file.clone(),
                    column: series.column.clone(),
                    got: series.time.len(),
                    need: super::LEAST_SAMPLES,
                });
            }
            if let Some(updates) = &channel.updates {
                warnings.push(intersample::told(series, updates.rows()));
            }
            if channel.is_angle && series.role == Role::YawRate {
                warnings.push(format!(
                    "{}: column `{}` is an angle ({}): taken for yaw, unwrapped and differenced to yaw rate",
                    self.drive.name, series.column, series.unit.name
                ));
            }
        }
        steering_ratio(&self.drive.channels[0], options, warnings)
    }

    /// What only the whole file can tell.
    fn check_at_the_end(&self) -> Result<(), Error> {
        for (channel, series) in self.channels.iter().zip(&self.drive.channels) {
            if series.role != Role::Speed && channel.is_constant() {
                return Err(Error::Constant {
                    file: series.file.clone(),
                    column: series.column.clone(),
                    role: series.role.name(),
                    value: channel.least / series.unit.to_si,
                    unit: series.unit.name,
                });
            }
            if series.role == Role::Speed && channel.mean() < LEAST_MEAN_SPEED {
                return Err(Error::Standstill {
                    file: series.file.clone(),
                    column: series.column.clone(),
                    mean_mps: channel.mean(),
                });
            }
        }
        Ok(())
    }
}
