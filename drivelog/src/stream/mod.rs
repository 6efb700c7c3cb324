//! A log read in chunks: what [`read_drives`](crate::read_drives) makes of a file, piece by piece, in
//! memory that does not grow with the file.
//!
//! Sample time and clock are those of the first rows; a clock that changes later is refused. A segment has
//! the same samples however long the chunks are: the last rows wait for those after them, a run of equal yaw
//! rates for its end, but no longer than a chunk.

mod aligned;
mod channel;
mod gate;
mod span;
#[cfg(test)]
mod tests;

use crate::channel_units::{check_units_are_used, unused_databases};
use crate::channels::{Selected, check_clock, count_from, first_instant, source_file};
use crate::drive::{Drive, brings, sources, steering_ratio};
use crate::error::{counted, last_part, shortened, stem};
use crate::faults::{Freezes, Moving, Sampled};
use crate::mapping::Source;
use crate::options::{LogOptions, Response};
use crate::read::{check_options, opened};
use crate::recording::{Columns, Group, Recording, Request, Wanted};
use crate::role::Role;
use crate::segments::{self, Clock};
use crate::series::Series;
use crate::units::Quantity;
use crate::{Error, intersample};
use aligned::Aligned;
use channel::Channel;
use span::Spans;
use steerwright_formats::{ChannelSummary, SampleHash, SourceFile};

pub use gate::{Gate, Piece, Sink, StreamStart};

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

/// Reads one recording to its end, piece by piece.
///
/// # Errors
/// [`Error`] with file, line and column, and what the sink returns.
pub fn stream<E: From<Error>>(
    recording: Box<dyn Recording + '_>,
    options: &LogOptions,
    sink: &mut Sink<'_, E>,
) -> Result<Streamed, E> {
    in_chunks(recording, options, CHUNK, sink)
}

fn in_chunks<E: From<Error>>(
    recording: Box<dyn Recording + '_>,
    options: &LogOptions,
    chunk: usize,
    sink: &mut Sink<'_, E>,
) -> Result<Streamed, E> {
    check_options(options)?;
    if !options.windows.is_empty() {
        return Err(Error::InPieces { option: "window" }.into());
    }
    if options.inputs.len().max(options.outputs.len()) > 1 {
        return Err(Error::InPieces { option: "several inputs or outputs" }.into());
    }
    let mut file = opened(recording, options)?;
    let groups: Vec<Group> = file.groups().cloned().collect();
    let name = groups[0].file.clone();
    if options.response != Response::YawRate {
        return Err(Error::InPieces { option: "response" }.into());
    }
    if options.stated_channel(Role::SteeringCommand).is_some() {
        return Err(Error::InPieces { option: "channel steering_command" }.into());
    }
    for role in [Role::Steering, Role::YawRate] {
        if !groups.iter().any(|group| brings(group, role, options)) {
            return Err(Error::NotADrive { file: name, role: role.name() }.into());
        }
    }
    check_units_are_used(groups.iter(), options)?;
    let mut warnings = Vec::from_iter(unused_databases(groups.iter(), options));
    let roles = [Role::Steering, Role::YawRate, Role::Speed];
    let sources = sources(&groups, roles, options, &mut warnings)?;
    let has_speed = sources.iter().any(|(role, _)| *role == Role::Speed);
    if options.speed_window.is_some() && !has_speed {
        return Err(Error::NoSpeedForWindow { drive: last_part(&name).into() }.into());
    }
    let mut clocks = Vec::new();
    for (index, (group, &place)) in groups.iter().zip(&file.places).enumerate() {
        let selected = Selected::new(group, place, index, &sources, options)?;
        clocks.extend(selected.map(|selected| OfClock::new(group, selected)));
    }
    let wanted: Vec<Wanted> = clocks.iter().map(|own| own.selected.wanted.clone()).collect();
    if let Some(own) = clocks.first() {
        file.recording.tolerate(own.selected.clock_channel(), Vec::new());
    }
    let mut reading = Reading::new(&groups, clocks, sources, options);
    reading.hash = if file.recording.hashes_bytes() { None } else { Some(SampleHash::default()) };
    let mut spans: Option<Spans> = None;
    let request = Request { wanted: &wanted, window_s: None, most: chunk };
    let scales = reading.clocks.iter().map(OfClock::seconds).collect();
    let mut rows = Aligned::new(file.recording.rows(request)?, scales);
    loop {
        let is_last = reading.take(rows.next()?)?;
        reading.leave_out_frozen(if is_last { None } else { Some(chunk) });
        match spans {
            Some(_) => {
                // A later angle may be more than a road wheel can turn.
                steering_ratio(&reading.drive.channels[STEERING], options, &mut Vec::new())?;
            }
            None if is_last || reading.is_known() => {
                let ratio = reading.begin(options, &mut warnings)?;
                let clock = Clock::from_drive(&reading.drive);
                let step = segments::sample_time(&[&clock], options)?;
                reading.drive.steering_ratio = ratio;
                let unit = reading.drive.channels[STEERING].unit;
                let start = StreamStart {
                    sample_time_s: step,
                    steering_ratio: ratio,
                    has_steering_angle: options.steering_full_scale_rad.is_some()
                        || unit.quantity != Quantity::Dimensionless,
                };
                spans = Some(Spans::new(clock, start, options.speed_window));
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
    if let Some(spans) = &spans {
        spans.check_forward(&reading.drive)?;
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
                last_part(&name),
                shortened(&series.column),
                counted(channel.missing, "sample")
            ));
        }
    }
    drop(rows);
    warnings.extend(file.recording.losses());
    let samples = reading.hash.take().unwrap_or_default();
    let summaries = reading.channels.iter().zip(&reading.drive.channels);
    Ok(Streamed {
        name: stem(&name),
        steering_ratio: reading.drive.steering_ratio,
        channels: summaries.map(|(c, series)| c.summary(series)).collect(),
        warnings,
        source: source_file(file.recording.as_mut(), &name, samples),
    })
}

/// A group of the file, and the state of its clock.
struct OfClock {
    group: Group,
    selected: Selected,
    rows: usize,
    /// Its last instant, s.
    before: f64,
    /// Rows of the last instant read, which the next may repeat.
    open: Columns,
}

impl OfClock {
    fn new(group: &Group, selected: Selected) -> Self {
        let (before, open) = (f64::NEG_INFINITY, Columns::default());
        Self { group: group.clone(), selected, rows: 0, before, open }
    }

    /// The unit of its clock, s; `None` without a clock.
    fn seconds(&self) -> Option<f64> {
        self.selected.clock.as_ref().map(|(_, unit)| unit.to_si)
    }
}

/// The rows at hand and the state of those before.
struct Reading {
    /// The rows not yet done with.
    drive: Drive,
    channels: Vec<Channel>,
    sources: Vec<(Role, Source)>,
    clocks: Vec<OfClock>,
    /// Of the samples, where the bytes are not hashed.
    hash: Option<SampleHash>,
    options: LogOptions,
    freezes: Freezes,
    /// The first instant of the clocks, s: time is counted from there.
    start_s: Option<f64>,
    /// Rows of the yaw rate that are decided upon: the rest may be frozen.
    alive: usize,
    /// Rows of the yaw rate that are not decided upon.
    doubtful: Series,
}

impl Reading {
    fn new(
        groups: &[Group],
        clocks: Vec<OfClock>,
        sources: Vec<(Role, Source)>,
        options: &LogOptions,
    ) -> Self {
        let series = |(role, source): &(Role, Source)| {
            Series::new(*role, &groups[source.group].place(), &source.name, source.unit)
        };
        let series: Vec<Series> = sources.iter().map(series).collect();
        Self {
            doubtful: series[YAW_RATE].clone(),
            drive: Drive {
                name: last_part(&groups[0].file).into(),
                channels: series,
                places: Vec::new(),
                files: Vec::new(),
                steering_ratio: 1.0,
                start_s: 0.0,
            },
            channels: sources.iter().map(|_| Channel::default()).collect(),
            sources,
            clocks,
            hash: None,
            options: options.clone(),
            freezes: Freezes::default(),
            start_s: None,
            alive: 0,
        }
    }

    /// Adds rows to every channel; whether they were the last.
    fn take(&mut self, rows: aligned::Rows) -> Result<bool, Error> {
        let aligned::Rows { of_groups, are_last } = rows;
        let yaw_rate = &mut self.drive.channels[YAW_RATE];
        self.alive = yaw_rate.value.len();
        yaw_rate.append(&mut self.doubtful);
        let from: Vec<usize> = self.drive.channels.iter().map(|c| c.value.len()).collect();
        if self.start_s.is_none() {
            let times = self.clocks.iter().zip(&of_groups).map(|(own, rows)| {
                let empty = rows.values.is_empty();
                if empty { Vec::new() } else { own.selected.time(rows, 0, &self.options) }
            });
            let times: Vec<Vec<f64>> = times.collect();
            self.start_s = first_instant(times.iter().map(Vec::as_slice));
        }
        for (own, rows) in self.clocks.iter_mut().zip(of_groups) {
            if let Some(hash) = &mut self.hash {
                own.selected.hash(&own.group, &rows, hash);
            }
            let mut rows = std::mem::take(&mut own.open).and(rows);
            rows.values.resize(own.selected.wanted.channels.len(), Vec::new());
            if own.selected.clock.is_some() && !are_last {
                let time = &rows.values[0];
                let last = time.iter().rev().copied().find(|t| !t.is_nan());
                let first = last.and_then(|last| time.iter().position(|t| *t == last));
                // A clock that stops is rejected below, not held back.
                if let Some(first) = first.filter(|first| 2 * first > time.len()) {
                    own.open = rows.split_off(first);
                }
            }
            let mut time = own.selected.time(&rows, own.rows, &self.options);
            if let Some((column, _)) = &own.selected.clock {
                let place = own.group.place();
                own.before = check_clock(&place, column, &time, &rows.lines, own.before)?;
            }
            own.rows += rows.lines.len();
            count_from(&mut time, self.start_s.unwrap_or_default());
            for &i in &own.selected.sources {
                let value = own.selected.values(&self.sources[i].1, &rows);
                let (channel, series) = (&mut self.channels[i], &mut self.drive.channels[i]);
                channel.take(series, &time, value, &rows.lines, &self.options, are_last)?;
            }
        }
        let new = |c: usize| &self.drive.channels[c].value[from[c]..];
        self.freezes.note(new(YAW_RATE), new(STEERING));
        Ok(are_last)
    }

    /// Leaves out the samples of a gyro that is frozen while the vehicle moves and is steered, and
    /// holds back up to `most` rows that may be frozen.
    fn leave_out_frozen(&mut self, most: Option<usize>) {
        let mut tail = self.drive.channels[YAW_RATE].split_off(self.alive);
        let rows = Moving {
            yaw_rate: Sampled::from_series(&tail),
            steering: Sampled::from_series(&self.drive.channels[STEERING]),
            speed: self.drive.channels.get(SPEED).map(Sampled::from_series),
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
