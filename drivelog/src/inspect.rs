//! What is in a log: the channels of each group with unit, rate, range and gaps, and what they may be.

use crate::Error;
use crate::channel_units::{check_quantity, check_units_are_used, unit_of, unused_databases};
use crate::channels::unused_row_period;
use crate::error::counted;
use crate::mapping::time_column;
use crate::options::LogOptions;
use crate::read::opened;
use crate::recording::{self, Columns, Group, LogFile, Request, Wanted};
use crate::role::Role;
use crate::signal::median_period;
use serde::Serialize;
use std::collections::BTreeMap;

/// Rows of a piece.
const PIECE: usize = 1 << 14;
/// Most points of the outline of a channel.
const POINTS: usize = 1 << 11;
/// A step of the clock that is that many times its period is a gap.
const GAP: f64 = 1.5;

/// The content of a log.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Inspection {
    /// The file as the caller names it.
    pub file: String,
    /// The first instant on the clocks of the log, s; all other instants count from it.
    pub log_start_s: f64,
    /// Its groups: topics, messages, channel groups, or the one table.
    pub groups: Vec<InspectedGroup>,
    /// What could not be read, and at which byte or line; stated units of no channel.
    pub losses: Vec<String>,
}

/// Channels on one clock.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct InspectedGroup {
    /// Its name in the file; empty for a table.
    pub name: String,
    /// Its kind, such as the type of the messages; may be empty.
    pub kind: String,
    /// The channel that is the clock.
    pub clock: Option<String>,
    /// What to do where it has no clock.
    pub no_clock: Option<String>,
    /// Number of rows.
    pub rows: usize,
    /// First and last instant, s.
    pub span_s: Option<[f64; 2]>,
    /// Rate by the median step of the clock, Hz.
    pub rate_hz: Option<f64>,
    /// Number of gaps.
    pub gaps: usize,
    /// Start and end of the longest gap, s.
    pub longest_gap_s: Option<[f64; 2]>,
    /// The channels.
    pub channels: Vec<InspectedChannel>,
}

/// A channel.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct InspectedChannel {
    /// Its name, as options name it where no other group has the same.
    pub name: String,
    /// Its unit as it is understood, or else as the file states it.
    pub unit: Option<String>,
    /// Number of values; `rows` less the missing ones.
    pub values: usize,
    /// Smallest value, in its unit.
    pub min: Option<f64>,
    /// Largest value, in its unit.
    pub max: Option<f64>,
    /// What it may be by name and unit, such as `yaw rate`.
    pub candidate_for: Vec<&'static str>,
    /// Instant in s (number of the row without a clock), smallest and largest value of successive parts.
    #[serde(skip)]
    pub outline: Vec<[f64; 3]>,
}

/// Reads a whole log in bounded memory, and describes its content.
///
/// # Errors
/// [`Error`] where the file cannot be opened as a log. Damage further on is one of the
/// [losses](Inspection::losses).
pub fn inspect(file: LogFile<'_>, options: &LogOptions) -> Result<Inspection, Error> {
    let name = file.name.clone();
    let mut file = opened(recording::open(file, options)?, options)?;
    let groups: Vec<Group> = file.groups().cloned().collect();
    check_stated(&groups, options)?;
    let mut states: Vec<State> = groups.iter().map(|group| State::new(group, options)).collect();
    let wanted = file.places.iter().zip(&states);
    let wanted: Vec<Wanted> =
        wanted.map(|(&group, s)| Wanted { group, channels: s.read.clone() }).collect();
    let request = Request { wanted: &wanted, window_s: None, most: PIECE };
    let clock = states.first().and_then(|state| state.clock);
    file.recording.tolerate(clock.map(|(channel, _)| channel), Vec::new());
    let mut losses = Vec::new();
    for rows in file.recording.rows(request)? {
        match rows {
            Ok(rows) => states[rows.wanted].take(&rows.columns, options),
            // What was read until then remains.
            Err(error) => losses.push(error.to_string()),
        }
    }
    losses.extend(file.recording.losses());
    losses.extend(groups.iter().zip(&states).filter_map(|(group, state)| state.falls(group)));
    // A mapping file may state those of other files.
    losses.extend(check_units_are_used(groups.iter(), options).err().map(|e| e.to_string()));
    losses.extend(unused_databases(groups.iter(), options));
    for (group, state) in groups.iter().zip(&states) {
        if let Some((clock, _)) = state.clock {
            let clock = &group.channels[clock].name;
            losses.extend(unused_row_period(group, clock, options));
        }
    }
    let firsts = states.iter().filter(|s| s.clock.is_some()).map(|s| s.first);
    let log_start_s = firsts.filter(|t| !t.is_nan()).reduce(f64::min).unwrap_or(0.0);
    let finish = |(group, state): (&Group, State)| state.finish(group, options, log_start_s);
    let groups = groups.iter().zip(states).map(finish).collect();
    Ok(Inspection { file: name, log_start_s, groups, losses })
}

/// Rejects a stated clock that no group has, and a stated unit that is unknown.
fn check_stated(groups: &[Group], options: &LogOptions) -> Result<(), Error> {
    if options.time.is_some() {
        let mut clocks = groups.iter().map(|group| time_column(group, options));
        if let Some(Err(error)) = clocks.next()
            && clocks.all(|clock| clock.is_err())
        {
            return Err(error);
        }
    }
    for group in groups {
        for (c, channel) in group.channels.iter().enumerate() {
            if options.units.contains_key(&channel.name) {
                unit_of(group, c, options)?;
            }
        }
    }
    Ok(())
}

/// A group that is being read.
struct State {
    /// Channel of the clock and its unit, s.
    clock: Option<(usize, f64)>,
    no_clock: Option<String>,
    /// The channels that are read, the clock first.
    read: Vec<usize>,
    channels: Vec<Outline>,
    rows: usize,
    first: f64,
    last: f64,
    period: f64,
    gaps: usize,
    longest: Option<[f64; 2]>,
    /// Instants before the one above them, and the first two of these.
    falls: usize,
    first_fall: Option<[f64; 2]>,
}

impl State {
    fn new(group: &Group, options: &LogOptions) -> Self {
        let (clock, no_clock) = match time_column(group, options) {
            Ok(clock) => (clock.map(|(c, unit)| (c, unit.to_si)), None),
            Err(error @ Error::UnknownUnit { .. }) => {
                (None, Some(format!("{error}; {}", error.hint())))
            }
            Err(error) => (None, Some(error.hint())),
        };
        let is_clock = |c: usize| clock.is_some_and(|(own, _)| own == c);
        let others =
            (0..group.channels.len()).filter(|&c| !is_clock(c) && !group.channels[c].is_text);
        let read: Vec<usize> = clock.iter().map(|(c, _)| *c).chain(others).collect();
        Self {
            clock,
            no_clock,
            channels: vec![Outline::default(); read.len()],
            read,
            rows: 0,
            first: f64::NAN,
            last: f64::NAN,
            period: f64::NAN,
            gaps: 0,
            longest: None,
            falls: 0,
            first_fall: None,
        }
    }

    fn take(&mut self, columns: &Columns, options: &LogOptions) {
        let rows = columns.lines.len();
        let time: Vec<f64> = match self.clock {
            Some((_, seconds)) => columns.values[0].iter().map(|t| t * seconds).collect(),
            None => {
                let period = options.row_period_s.unwrap_or(1.0);
                (self.rows..self.rows + rows).map(|row| row as f64 * period).collect()
            }
        };
        self.rows += rows;
        if self.period.is_nan() && rows > 1 {
            self.period = median_period(&time);
        }
        // Ten missing rows, but no more than what is bridged; of a slow channel one missing row.
        let limit = options.max_gap_s.min(10.0 * self.period).max(GAP * self.period);
        for &t in time.iter().filter(|t| !t.is_nan()) {
            if self.first.is_nan() {
                self.first = t;
            }
            if t - self.last > limit {
                self.gaps += 1;
                if self.longest.is_none_or(|[a, b]| t - self.last > b - a) {
                    self.longest = Some([self.last, t]);
                }
            }
            if t < self.last {
                self.falls += 1;
                self.first_fall.get_or_insert([self.last, t]);
            }
            self.last = t;
        }
        for (channel, values) in self.channels.iter_mut().zip(&columns.values) {
            time.iter().zip(values).for_each(|(t, x)| channel.take(*t, *x));
        }
    }

    /// The report of a clock that does not rise.
    fn falls(&self, group: &Group) -> Option<String> {
        let [before, after] = self.first_fall?;
        let rows = counted(self.falls, "row");
        Some(format!(
            "{}: {rows} with a time before that of the row above, the first {after} s after {before} s",
            group.place()
        ))
    }

    fn finish(self, group: &Group, options: &LogOptions, log_start_s: f64) -> InspectedGroup {
        let has_clock = self.clock.is_some() || options.row_period_s.is_some();
        // Without a clock of its own a group counts its rows.
        let start = if self.clock.is_some() { log_start_s } else { 0.0 };
        let read: BTreeMap<usize, &Outline> =
            self.read.iter().copied().zip(&self.channels).collect();
        let channel = |c: usize| {
            let outline = match read.get(&c) {
                Some(&own) => own.clone(),
                None => Outline::default(),
            };
            let parts = outline.parts.iter().map(|&[t, least, most]| [t - start, least, most]);
            let own = &group.channels[c];
            let unit = unit_of(group, c, options).ok();
            let unit = unit.filter(|_| !own.is_text);
            let text = if own.is_text { Some("text") } else { own.unit.as_deref() };
            let is_clock = self.clock.is_some_and(|(own, _)| own == c);
            let roles = own.roles().filter(|role| {
                let fits = |unit| check_quantity(group, c, unit, *role).is_ok();
                !is_clock && unit.is_none_or(fits)
            });
            InspectedChannel {
                name: own.name.clone(),
                unit: match unit {
                    Some(unit) => Some(unit.name.into()),
                    None => text.map(Into::into),
                },
                values: outline.values,
                min: if outline.values > 0 { Some(outline.least) } else { None },
                max: if outline.values > 0 { Some(outline.most) } else { None },
                candidate_for: roles.map(Role::name).collect(),
                outline: parts.collect(),
            }
        };
        InspectedGroup {
            name: group.name.clone(),
            kind: group.kind.clone(),
            clock: self.clock.map(|(c, _)| group.channels[c].name.clone()),
            no_clock: self.no_clock.clone(),
            rows: self.rows,
            span_s: if has_clock && !self.first.is_nan() {
                Some([self.first - start, self.last - start])
            } else {
                None
            },
            // The clock's digits are coarser than 1e-3 Hz.
            rate_hz: if has_clock && self.period > 0.0 {
                Some((1e3 / self.period).round() / 1e3)
            } else {
                None
            },
            gaps: if has_clock { self.gaps } else { 0 },
            longest_gap_s: self.longest.filter(|_| has_clock).map(|gap| gap.map(|t| t - start)),
            channels: (0..group.channels.len()).map(channel).collect(),
        }
    }
}

/// Range of a channel, and its smallest and largest values in parts of equally many rows.
#[derive(Debug, Clone)]
struct Outline {
    values: usize,
    least: f64,
    most: f64,
    parts: Vec<[f64; 3]>,
    /// Values of a part, and of the last one so far.
    per_part: usize,
    in_last: usize,
}

impl Default for Outline {
    fn default() -> Self {
        let (least, most) = (f64::INFINITY, f64::NEG_INFINITY);
        Self { values: 0, least, most, parts: Vec::new(), per_part: 1, in_last: 1 }
    }
}

impl Outline {
    fn take(&mut self, time: f64, x: f64) {
        if x.is_nan() {
            return;
        }
        self.values += 1;
        (self.least, self.most) = (self.least.min(x), self.most.max(x));
        match self.parts.last_mut().filter(|_| self.in_last < self.per_part) {
            Some([_, least, most]) => {
                (*least, *most) = (least.min(x), most.max(x));
                self.in_last += 1;
            }
            None => {
                if self.parts.len() == POINTS {
                    let both = |p: &[[f64; 3]]| {
                        let [a, b] = [p[0], p[p.len() - 1]];
                        [a[0], a[1].min(b[1]), a[2].max(b[2])]
                    };
                    self.parts = self.parts.chunks(2).map(both).collect();
                    self.per_part *= 2;
                }
                self.parts.push([time, x, x]);
                self.in_last = 1;
            }
        }
    }
}
