//! The channels of a drive: SI values, missing samples dropped, impossible values rejected.

use crate::Error;
use crate::error::{Place, counted, shortened};
use crate::expression::Term;
use crate::faults::{SpikeFilter, average};
use crate::intersample::{self, Updates};
use crate::mapping::{Source, time_column};
use crate::options::LogOptions;
use crate::recording::{Columns, Dates, Group, Recording, Request, Wanted, file_name};
use crate::role::Role;
use crate::series::{MOST_SAMPLES, Series};
use crate::signal::{median_period, unwrap};
use crate::units::Unit;
use std::rc::Rc;
use steerwright_formats::{SampleHash, SourceFile};

/// Rows of a piece.
const PIECE: usize = 1 << 16;
/// Data before and after a window that its samples depend on, s.
const AROUND_WINDOW: f64 = 5.0;

/// A file with those of its groups that are in use, and where they are among the groups of the drive.
pub(crate) struct Opened<'a> {
    pub(crate) recording: Box<dyn Recording + 'a>,
    /// Place in the file of each group in use.
    pub(crate) places: Vec<usize>,
}

impl Opened<'_> {
    pub(crate) fn groups(&self) -> impl Iterator<Item = &Group> + Clone {
        let all = self.recording.groups();
        self.places.iter().map(|&place| &all[place])
    }
}

/// The clock of a group and the channels of it that are read.
pub(crate) struct Selected {
    /// The clock's channel and its unit.
    pub(crate) clock: Option<(String, Unit)>,
    pub(crate) wanted: Wanted,
    /// How often each of the channels is used.
    uses: Vec<usize>,
    /// Which of the sources are in the group.
    pub(crate) sources: Vec<usize>,
}

/// That a group has a clock of its own, where a row period is stated; that of named channels is their sample time.
pub(crate) fn unused_row_period(
    group: &Group,
    clock: &str,
    options: &LogOptions,
) -> Option<String> {
    let period = options.row_period_s?;
    if options.sample_time_s == Some(period) {
        return None;
    }
    Some(format!(
        "{}: the stated row period of {period} s is not used, since column `{clock}` is the clock",
        group.place()
    ))
}

impl Selected {
    /// The group at `place` of its file, as the `index`-th of the drive; `None` if nothing of it is wanted.
    pub(crate) fn new(
        group: &Group,
        place: usize,
        index: usize,
        sources: &[(Role, Source)],
        options: &LogOptions,
    ) -> Result<Option<Self>, Error> {
        let own = sources.iter().enumerate().filter(|(_, (_, source))| source.group == index);
        let own: Vec<usize> = own.map(|(i, _)| i).collect();
        if own.is_empty() {
            return Ok(None);
        }
        let clock = time_column(group, options)?;
        let mut channels: Vec<usize> = clock.iter().map(|(c, _)| *c).collect();
        let mut uses = vec![1; channels.len()];
        for source in own.iter().map(|&i| &sources[i].1) {
            for &c in source.terms.iter().flat_map(|term| &term.channels) {
                match channels.iter().position(|own| *own == c) {
                    Some(place) => uses[place] += 1,
                    None => {
                        channels.push(c);
                        uses.push(1);
                    }
                }
            }
        }
        Ok(Some(Self {
            clock: clock.map(|(c, unit)| (group.channels[c].name.clone(), unit)),
            wanted: Wanted { group: place, channels },
            uses,
            sources: own,
        }))
    }

    /// The channel that is the clock.
    pub(crate) fn clock_channel(&self) -> Option<usize> {
        self.clock.as_ref().map(|_| self.wanted.channels[0])
    }

    /// The channels of optional roles alone.
    fn optional(&self, sources: &[(Role, Source)], options: &LogOptions) -> Vec<usize> {
        let own = || self.sources.iter().map(|&i| &sources[i]);
        let is_of = |source: &Source, c| source.terms.iter().any(|term| term.channels.contains(&c));
        let is_needed =
            |c| own().any(|(role, source)| is_of(source, c) && !options.is_optional(*role));
        let channels = self.wanted.channels.iter().skip(usize::from(self.clock.is_some()));
        channels.copied().filter(|&c| !is_needed(c)).collect()
    }

    /// The instants of the rows, s; `before` is the number of rows before them.
    pub(crate) fn time(&self, columns: &Columns, before: usize, options: &LogOptions) -> Vec<f64> {
        match &self.clock {
            Some((_, unit)) => columns.values[0].iter().map(|t| t * unit.to_si).collect(),
            None => {
                let period = options.row_period_s.unwrap_or(1.0);
                (0..columns.lines.len()).map(|i| (before + i) as f64 * period).collect()
            }
        }
    }

    /// The values of a source as its unit counts them.
    pub(crate) fn values(&self, source: &Source, columns: &Columns) -> Vec<f64> {
        let place = |c| self.wanted.channels.iter().position(|own| *own == c).unwrap_or_default();
        Term::sum(&source.terms, &columns.values, place)
    }

    /// The same; a channel that is in no other source is not copied.
    fn take_values(&self, source: &Source, columns: &mut Columns) -> Vec<f64> {
        let place = |c| self.wanted.channels.iter().position(|own| *own == c);
        match &source.terms[..] {
            [Term { factor: 1.0, channels }] if channels.len() == 1 => {
                let place = place(channels[0]).filter(|p| self.uses[*p] == 1);
                let taken = place.map(|p| std::mem::take(&mut columns.values[p]));
                taken.unwrap_or_else(|| self.values(source, columns))
            }
            _ => self.values(source, columns),
        }
    }

    /// Adds the rows to the hash of the samples.
    pub(crate) fn hash(&self, group: &Group, columns: &Columns, hash: &mut SampleHash) {
        for (&c, values) in self.wanted.channels.iter().zip(&columns.values) {
            hash.update(&group.label(&group.channels[c].name), values);
        }
    }
}

/// The file by its name and hash.
pub(crate) fn source_file(
    recording: &mut dyn Recording,
    file: &str,
    samples: SampleHash,
) -> SourceFile {
    let of_bytes = recording.sha256();
    SourceFile {
        name: file_name(file),
        of_samples: of_bytes.is_none(),
        sha256: of_bytes.unwrap_or_else(|| samples.sha256_hex()),
    }
}

/// The channels of a drive.
pub(crate) struct Channels {
    pub(crate) series: Vec<Series>,
    pub(crate) files: Vec<SourceFile>,
    /// The first instant of the clocks, s: time is counted from there.
    pub(crate) start_s: f64,
}

/// The rows of a group.
struct RowsOfGroup {
    group: Group,
    selected: Selected,
    columns: Columns,
    /// Instants on the clock of the log, s.
    time: Vec<f64>,
}

/// Reads the channels of `sources`, in that order, and each file once.
pub(crate) fn read(
    files: Vec<Opened<'_>>,
    sources: &[(Role, Source)],
    options: &LogOptions,
    warnings: &mut Vec<String>,
) -> Result<Channels, Error> {
    let mut opened = Vec::new();
    let mut index = 0;
    for file in files {
        let groups: Vec<Group> = file.groups().cloned().collect();
        let mut selected = Vec::new();
        for (group, &place) in groups.into_iter().zip(&file.places) {
            let own = Selected::new(&group, place, index, sources, options)?;
            selected.extend(own.map(|own| (group, own)));
            index += 1;
        }
        opened.push((file, selected));
    }
    let stated = if options.windows.is_empty() { None } else { stated_start(&opened, options) };
    let mut all: Vec<RowsOfGroup> = Vec::new();
    let mut hashes = Vec::new();
    let (mut dated, mut dates) = (Vec::new(), Vec::new());
    for (mut file, selected) in opened {
        let name = file.recording.groups().first().map(|g| g.file.clone()).unwrap_or_default();
        let wanted: Vec<Wanted> = selected.iter().map(|(_, own)| own.wanted.clone()).collect();
        let mut columns = vec![Columns::default(); wanted.len()];
        let window_s = stated.map(|start| hull(options, start));
        let request = Request { wanted: &wanted, window_s, most: PIECE };
        if let Some((_, own)) = selected.first() {
            file.recording.tolerate(own.clock_channel(), own.optional(sources, options));
        }
        if wanted.is_empty() {
            // The hash of a file that brings no channel.
            let all = [Wanted { group: 0, channels: Vec::new() }];
            let request = Request { wanted: &all, ..request };
            file.recording.rows(request)?.try_for_each(|rows| rows.map(drop))?;
        }
        let too_many = || Error::TooManyRows { file: name.clone(), limit: MOST_SAMPLES };
        // Some formats state it; rows outside a window may be left out.
        let stated = selected.iter().filter_map(|(group, _)| group.rows).max().unwrap_or_default();
        if request.window_s.is_none() && stated > MOST_SAMPLES as u64 {
            return Err(too_many());
        }
        for rows in file.recording.rows(request)? {
            let rows = rows?;
            let all = &mut columns[rows.wanted];
            all.append(rows.columns);
            if all.lines.len() > MOST_SAMPLES {
                return Err(too_many());
            }
        }
        columns.iter_mut().flat_map(|c| &mut c.values).for_each(Vec::shrink_to_fit);
        let mut hash = SampleHash::default();
        for ((group, own), mut columns) in selected.into_iter().zip(columns) {
            if !file.recording.hashes_bytes() {
                own.hash(&group, &columns, &mut hash);
            }
            columns.values.resize(own.wanted.channels.len(), Vec::new());
            let time = own.time(&columns, 0, options);
            if let Some((column, _)) = &own.clock {
                check_clock(&group.place(), column, &time, &columns.lines, f64::NEG_INFINITY)?;
                warnings.extend(unused_row_period(&group, column, options));
            }
            let clock = own.clock_channel();
            if let Some(own) = clock.and_then(|clock| file.recording.dates(clock)) {
                dated.push(all.len());
                dates.push(own);
            }
            all.push(RowsOfGroup { group, selected: own, columns, time });
        }
        warnings.extend(file.recording.losses());
        hashes.push(source_file(file.recording.as_mut(), &name, hash));
    }
    if dates.len() > 1 {
        let shifts = Dates::shifts(&dates).map_err(|open| Error::OpenDates {
            file: all.first().map(|rows| rows.group.file.clone()).unwrap_or_default(),
            dates: open,
        })?;
        for (at, shift) in dated.into_iter().zip(shifts) {
            all[at].time.iter_mut().for_each(|t| *t += shift);
        }
    }
    let start_s = stated.or_else(|| first_instant(all.iter().map(|rows| &rows.time[..])));
    let start_s = start_s.unwrap_or(0.0);
    let mut channels: Vec<(usize, Series)> = Vec::new();
    for RowsOfGroup { group, selected, mut columns, mut time } in all {
        count_from(&mut time, start_s);
        let (time, place) = (Rc::new(time), group.place());
        for &i in &selected.sources {
            let (role, source) = &sources[i];
            let empty = Series::new(*role, &place, &source.name, source.unit);
            let empty = Series { own_unit: source.own_unit.clone(), ..empty };
            let (time, line) = (Rc::clone(&time), Rc::clone(&columns.lines));
            let value = selected.take_values(source, &mut columns);
            let raw = Series { time, value, line, ..empty };
            let mut own_warnings = Vec::new();
            match finished(raw, options, &mut own_warnings) {
                Ok(series) => channels.push((i, series)),
                Err(error) if options.is_optional(*role) => {
                    own_warnings = vec![format!("{error}: not used as the {}", role.name())];
                }
                Err(error) => return Err(error),
            }
            warnings.extend(own_warnings);
        }
    }
    channels.sort_by_key(|(place, _)| *place);
    let series = channels.into_iter().map(|(_, series)| series).collect();
    Ok(Channels { series, files: hashes, start_s })
}

/// The earliest of the first instants of clocks.
pub(crate) fn first_instant<'t>(clocks: impl Iterator<Item = &'t [f64]>) -> Option<f64> {
    let first = |time: &[f64]| time.iter().copied().find(|t| !t.is_nan());
    clocks.filter_map(first).reduce(f64::min)
}

/// Counts instants from `start_s`. Seconds since 1970 have a resolution of 0.2 µs, which shows in the difference.
pub(crate) fn count_from(time: &mut [f64], start_s: f64) {
    const LARGE: f64 = 1e6;
    for t in time {
        *t -= start_s;
        if start_s.abs() > LARGE {
            *t = (*t * 1e6).round() / 1e6;
        }
    }
}

/// The first instant of the clocks, where all files state it ahead of their rows.
fn stated_start(
    files: &[(Opened<'_>, Vec<(Group, Selected)>)],
    options: &LogOptions,
) -> Option<f64> {
    if options.time.is_some() {
        return None;
    }
    let mut start = f64::INFINITY;
    for (file, selected) in files {
        for (_, own) in selected {
            start = start.min(file.recording.first_s(&own.wanted)?);
        }
    }
    if start.is_finite() { Some(start) } else { None }
}

/// The part of a log from `start_s` on that the windows are in, with what their samples depend on.
fn hull(options: &LogOptions, start_s: f64) -> (f64, f64) {
    let around = AROUND_WINDOW.max(options.max_gap_s);
    let from = options.windows.iter().map(|w| w.0).fold(f64::INFINITY, f64::min);
    let to = options.windows.iter().map(|w| w.1).fold(f64::NEG_INFINITY, f64::max);
    (start_s + from - around, start_s + to + around)
}

/// SI values, missing samples dropped, yaw differenced.
fn finished(
    mut series: Series,
    options: &LogOptions,
    warnings: &mut Vec<String>,
) -> Result<Series, Error> {
    let role = series.role;
    series.bring_to_si()?;
    let mut unreported = Vec::new();
    drop_missing(&mut series, if role.is_place() { &mut unreported } else { warnings });
    let repeated = average(&mut series)?;
    if role.is_place() {
        // Dropouts of a receiver are no fault, and neither is a drive without a fix.
        return Ok(series);
    }
    warnings.extend(repeated.map(|r| r.warning(&series.file)));
    if role.has_spikes() {
        SpikeFilter::default().take(&mut series, true);
    }
    series.check_rows()?;
    if role.is_state() {
        series.period = median_period(&series.time);
        return Ok(series);
    }
    if role.is_held() {
        series.intersample = intersample::of_input(&series, options);
    }
    let mut rows_per_update = None;
    if series.is_sensor()
        && let Some(mut updates) = Updates::from_series(&series)
    {
        updates.take(&mut series);
        // A bad sample of a slow sensor is many equal rows.
        if role.has_spikes() {
            SpikeFilter::default().take(&mut series, true);
            series.spikes.sort_by(f64::total_cmp);
        }
        rows_per_update = Some(updates.rows);
    }
    series.period = median_period(&series.time);
    warnings.extend(series.spikes_in_words());
    warnings.extend(rows_per_update.map(|rows| intersample::held_steps_warning(&series, rows)));
    if series.is_yaw() {
        let limit = series.gap_limit(options.max_gap_s);
        difference(&mut series, limit);
        series.check_rows()?;
        warnings.push(series.yaw_in_words(&series.file));
    }
    Ok(series)
}

/// Leaves rows without an instant or without a value out.
fn drop_missing(series: &mut Series, warnings: &mut Vec<String>) {
    let mut runs = MissingRuns::default();
    for i in (0..series.value.len()).filter(|&i| series.is_missing(i)) {
        runs.note(series.line[i]);
    }
    if let Some(text) = runs.finish() {
        warnings.push(format!(
            "{}: column `{}`: {text} missing; short runs are bridged by straight lines",
            series.file,
            shortened(&series.column)
        ));
        series.leave_out_missing();
    }
}

/// Time must not decrease from row to row, from the instant `before` them; the last instant.
pub(crate) fn check_clock(
    file: &str,
    column: &str,
    time: &[f64],
    lines: &[u64],
    mut before: f64,
) -> Result<f64, Error> {
    for (&t, &line) in time.iter().zip(lines) {
        if t < before {
            return Err(Error::TimeNotIncreasing {
                at: Place::new(file, line, column),
                time: t,
                before,
            });
        }
        if !t.is_nan() {
            before = t;
        }
    }
    Ok(before)
}

/// Yaw to yaw rate, at the middle of each interval, so that no delay arises. A gap stays a gap.
pub(crate) fn difference(series: &mut Series, limit: f64) {
    let yaw = unwrap(&series.value);
    let time = Rc::clone(&series.time);
    let near: Vec<usize> = (0..yaw.len() - 1).filter(|&i| time[i + 1] - time[i] <= limit).collect();
    series.value = near.iter().map(|&i| (yaw[i + 1] - yaw[i]) / (time[i + 1] - time[i])).collect();
    series.time = Rc::new(near.iter().map(|&i| 0.5 * (time[i] + time[i + 1])).collect());
    series.line = Rc::new(near.iter().map(|&i| series.line[i]).collect());
}

#[derive(Default)]
struct MissingRuns {
    runs: Vec<(u64, u64)>,
    count: usize,
}

impl MissingRuns {
    fn note(&mut self, line: u64) {
        self.count += 1;
        match self.runs.last_mut() {
            Some((_, last)) if *last + 1 == line => *last = line,
            _ => self.runs.push((line, line)),
        }
    }

    fn finish(&self) -> Option<String> {
        let run = |(a, b): &(u64, u64)| if a == b { a.to_string() } else { format!("{a}-{b}") };
        let mut lines: Vec<String> = self.runs.iter().take(5).map(run).collect();
        if self.runs.len() > 5 {
            lines.push("…".into());
        }
        let text = || format!("{} (lines {})", counted(self.count, "sample"), lines.join(", "));
        if self.count > 0 { Some(text()) } else { None }
    }
}
