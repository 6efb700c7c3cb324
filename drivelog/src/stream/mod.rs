//! A log read in chunks: what [`read_drives`](crate::read_drives) makes of a file, piece by piece, in
//! memory that does not grow with the file.
//!
//! Sample time and clock are those of the first rows; a clock that changes later is refused. A segment has
//! the same samples however long the chunks are: the last rows wait for those after them, a run of equal yaw
//! rates for its end, but no longer than a chunk.

mod channel;
mod gate;
mod span;
#[cfg(test)]
mod tests;

use crate::channels::check_clock;
use crate::drive::{Drive, brings, steering_ratio};
use crate::error::{Error, counted, last_part, stem};
use crate::faults::{Freezes, Moving, Sampled};
use crate::intersample;
use crate::mapping::{self, Source, time_column};
use crate::options::LogOptions;
use crate::read::check_options;
use crate::role::Role;
use crate::segments::{self, Clock};
use crate::series::Series;
use crate::table::{Columns, LogFile, Table};
use channel::Channel;
use span::Spans;
use steerwright_formats::{ChannelSummary, SourceFile};

pub use gate::{Piece, Sink};

/// Rows read at once.
const CHUNK: usize = 1 << 14;

/// The places of the channels.
const STEERING: usize = 0;
const YAW_RATE: usize = 1;
const SPEED: usize = 2;

/// What was read in addition to the samples.
#[derive(Debug, Clone, PartialEq)]
pub struct Streamed {
    /// The file's name without its ending.
    pub name: String,
    /// Steering angle over road-wheel angle.
    pub steering_ratio: f64,
    /// What was read from each column.
    pub channels: Vec<ChannelSummary>,
    /// The file, by name and hash.
    pub source: SourceFile,
    /// Warnings of the reader.
    pub warnings: Vec<String>,
}

/// Reads one file to its end, piece by piece.
///
/// # Errors
/// [`Error`] with file, line and column, and what the sink returns.
pub fn stream<E: From<Error>>(
    file: LogFile<'_>,
    options: &LogOptions,
    sink: &mut Sink<'_, E>,
) -> Result<Streamed, E> {
    in_chunks(file, options, CHUNK, sink)
}

fn in_chunks<E: From<Error>>(
    file: LogFile<'_>,
    options: &LogOptions,
    chunk: usize,
    sink: &mut Sink<'_, E>,
) -> Result<Streamed, E> {
    check_options(options)?;
    if !options.windows.is_empty() {
        let value = format!("{} of them", options.windows.len());
        let expected = "none where logs are read in chunks".into();
        return Err(Error::Option { option: "window", value, expected }.into());
    }
    let mut table = Table::open(file, options.decimal)?;
    for role in [Role::Steering, Role::YawRate] {
        if !brings(&table, role, options) {
            return Err(Error::NotADrive { file: table.file, role: role.name() }.into());
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
        return Err(Error::NoSpeedForWindow { drive: last_part(&table.file).into() }.into());
    }
    let mut reading = Reading::new(&table, &sources, options)?;
    let mut spans: Option<Spans> = None;
    loop {
        let rows = table.rows(&reading.wanted, chunk)?;
        let is_last = rows.lines.len() < chunk;
        reading.take(rows, is_last)?;
        reading.leave_out_frozen(if is_last { None } else { Some(chunk) });
        match spans {
            Some(_) => {
                // A later angle may be more than a road wheel can turn.
                steering_ratio(&reading.drive.channels[STEERING], options, &mut Vec::new())?;
            }
            None if is_last || reading.is_known() => {
                let ratio = reading.begin(options, &mut warnings)?;
                let clock = Clock::of(&reading.drive);
                let step = segments::sample_time(&[&clock], options)?;
                reading.drive.steering_ratio = ratio;
                spans = Some(Spans::new(clock, step, options.speed_window));
            }
            None => {}
        }
        let frozen_to = reading.frozen_to();
        match &mut spans {
            Some(spans) => spans.advance(&mut reading.drive, options, frozen_to, is_last, sink)?,
            None => span::drop_before(&mut reading.drive, frozen_to.unwrap_or(f64::NEG_INFINITY)),
        }
        if is_last {
            break;
        }
    }
    reading.check_at_the_end()?;
    let repeated = reading.channels.iter().filter_map(|c| c.repeated);
    warnings.extend(repeated.map(|r| r.warning(&reading.drive.channels[0].file)));
    if let Some(spans) = &spans {
        warnings.extend(spans.warnings(&reading.drive.name));
    }
    warnings.extend(reading.drive.channels.iter().filter_map(Series::spikes_in_words));
    warnings.extend(reading.drive.channels.iter().filter_map(Series::frozen_in_words));
    for (channel, series) in reading.channels.iter().zip(&reading.drive.channels) {
        if channel.missing > 0 {
            warnings.push(format!(
                "{}: column `{}`: {} missing; short runs are bridged by straight lines",
                last_part(&table.file),
                series.column,
                counted(channel.missing, "sample")
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

/// The rows at hand and the state of those before.
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
    freezes: Freezes,
    /// Rows of the yaw rate that are decided upon: the rest may be frozen.
    alive: usize,
    /// Rows of the yaw rate that are not decided upon.
    doubtful: Series,
}

impl Reading {
    fn new(
        table: &Table<'_>,
        sources: &[(Role, Source)],
        options: &LogOptions,
    ) -> Result<Self, Error> {
        let clock = time_column(table, options)?;
        let channels = sources.iter().map(|(_, source)| Channel::new(source)).collect();
        let series = |(role, source): &(Role, Source)| {
            Series::new(*role, &table.file, &table.header[source.column], source.unit)
        };
        let series: Vec<Series> = sources.iter().map(series).collect();
        Ok(Self {
            doubtful: series[YAW_RATE].clone(),
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
            freezes: Freezes::default(),
            alive: 0,
        })
    }

    /// Adds rows to every channel.
    fn take(&mut self, rows: Columns, is_last: bool) -> Result<(), Error> {
        let mut rows = std::mem::take(&mut self.open).and(rows);
        if self.clock.is_some() && !is_last {
            let time = &rows.values[0];
            let last = time.iter().rev().copied().find(|t| !t.is_nan());
            let first = last.and_then(|last| time.iter().position(|t| *t == last));
            // A clock that stops is rejected below, not held back.
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
        let yaw_rate = &mut self.drive.channels[YAW_RATE];
        self.alive = yaw_rate.value.len();
        yaw_rate.append(&mut self.doubtful);
        let from: Vec<usize> = self.drive.channels.iter().map(|c| c.value.len()).collect();
        let both = self.channels.iter_mut().zip(&mut self.drive.channels);
        for ((channel, series), value) in both.zip(values) {
            channel.take(series, &time, value, &rows.lines, &self.options, is_last)?;
        }
        let new = |c: usize| &self.drive.channels[c].value[from[c]..];
        self.freezes.note(new(YAW_RATE), new(STEERING));
        Ok(())
    }

    /// Leaves out the samples of a gyro that is frozen while the vehicle moves and is steered, and
    /// holds back up to `most` rows that may be frozen.
    fn leave_out_frozen(&mut self, most: Option<usize>) {
        let mut tail = self.drive.channels[YAW_RATE].split_off(self.alive);
        let rows = Moving {
            yaw_rate: Sampled::of(&tail),
            steering: Sampled::of(&self.drive.channels[STEERING]),
            speed: self.drive.channels.get(SPEED).map(Sampled::of),
            resolution: self.channels[YAW_RATE].resolution,
        };
        let (decided, runs) = self.freezes.find(rows, most);
        self.doubtful = tail.split_off(decided);
        tail.leave_out(&runs);
        let yaw_rate = &mut self.drive.channels[YAW_RATE];
        yaw_rate.append(&mut tail);
        // A frozen run that continues keeps its start.
        yaw_rate.frozen.retain(|old| runs.iter().all(|new| new[0] != old[0]));
        yaw_rate.frozen.extend(runs);
    }

    /// Until when the yaw rate is frozen, where that may go on.
    fn frozen_to(&self) -> Option<f64> {
        let last = self.drive.channels[YAW_RATE].frozen.last().filter(|_| self.freezes.goes_on());
        last.map(|[_, to]| *to)
    }

    /// Whether the clock can be read: most rows of the yaw rate are no file's frozen start.
    fn is_known(&self) -> bool {
        self.drive.channels[YAW_RATE].value.len() > self.doubtful.value.len()
    }

    /// The steering ratio, which the first rows determine.
    fn begin(&mut self, options: &LogOptions, warnings: &mut Vec<String>) -> Result<f64, Error> {
        let yaw_rate = &self.drive.channels[YAW_RATE];
        if yaw_rate.value.is_empty() && !yaw_rate.frozen.is_empty() {
            self.check_at_the_end()?;
        }
        for (channel, series) in self.channels.iter().zip(&self.drive.channels) {
            series.check_rows()?;
            if let Some(updates) = &channel.updates {
                warnings.push(intersample::held_steps_warning(series, updates.rows));
            }
            if series.is_yaw() {
                warnings.push(series.yaw_in_words(&self.drive.name));
            }
        }
        steering_ratio(&self.drive.channels[0], options, warnings)
    }

    /// Rejects a constant channel and a standstill, which only the whole file shows.
    fn check_at_the_end(&self) -> Result<(), Error> {
        for (channel, series) in self.channels.iter().zip(&self.drive.channels) {
            if series.role == Role::Speed {
                series.check_moves(channel.mean())?;
            } else if channel.is_constant() {
                return Err(series.constant(channel.least));
            }
        }
        Ok(())
    }
}
