//! One channel on its own clock: SI values, missing samples dropped, the impossible refused.

use super::Role;
use super::intersample::{self, Updates};
use super::mapping::{Source, time_column};
use super::resample::{Becomes, Grid, resample};
use super::spikes::SpikeFilter;
use super::table::Table;
use super::units::{Quantity, Unit};
use super::{LogOptions, repeated, signal_words};
use crate::validation::resolution;
use crate::{Error, Place};
use formats::{ChannelSummary, Intersample, SourceFile};
use std::rc::Rc;

/// Samples of one channel in time order.
#[derive(Debug, Clone)]
pub(crate) struct Series {
    pub(crate) role: Role,
    pub(crate) file: String,
    pub(crate) column: String,
    pub(crate) unit: Unit,
    /// Instants, s; shared by the channels of a file where none of its cells is blank.
    pub(crate) time: Rc<Vec<f64>>,
    /// SI values.
    pub(crate) value: Vec<f64>,
    /// Lines in the file.
    pub(crate) line: Rc<Vec<u64>>,
    /// Median period of the clock, s; of a sensor that is slower than the rows, that of its updates.
    pub(crate) period: f64,
    /// What it does between its samples.
    pub(crate) intersample: Intersample,
    /// Instants of single spikes and dropouts, which are left out, s.
    pub(crate) spikes: Vec<f64>,
    /// First and last instants of frozen runs, which are left out, s.
    pub(crate) frozen: Vec<[f64; 2]>,
}

/// Reads the channels of `sources`, in that order, and each file once.
pub(crate) fn read(
    tables: Vec<Table<'_>>,
    sources: &[(Role, Source)],
    options: &LogOptions,
    warnings: &mut Vec<String>,
) -> Result<(Vec<Series>, Vec<SourceFile>), Error> {
    let mut channels: Vec<(usize, Series)> = Vec::new();
    let mut files = Vec::new();
    for (t, table) in tables.into_iter().enumerate() {
        let own = || sources.iter().enumerate().filter(|(_, (_, source))| source.table == t);
        let clock = if own().next().is_some() { time_column(&table, options)? } else { None };
        let wanted: Vec<usize> =
            clock.iter().map(|(c, _)| *c).chain(own().map(|(_, (_, s))| s.column)).collect();
        let (file, header) = (table.file.clone(), table.header.clone());
        let (columns, source) = table.columns(&wanted)?;
        files.push(source);
        let mut values = columns.values.into_iter();
        let time: Vec<f64> = match (clock, options.row_period_s) {
            (Some((_, unit)), _) => {
                let mut time = values.next().unwrap_or_default();
                time.iter_mut().for_each(|t| *t *= unit.to_si);
                time
            }
            (None, period) => {
                (0..columns.lines.len()).map(|i| i as f64 * period.unwrap_or(1.0)).collect()
            }
        };
        if let Some((c, _)) = clock {
            check_clock(&file, &header[c], &time, &columns.lines, f64::NEG_INFINITY)?;
        }
        let time = Rc::new(time);
        for ((place, (role, source)), value) in own().zip(values) {
            let raw = Series {
                role: *role,
                file: file.clone(),
                column: header[source.column].clone(),
                unit: source.unit,
                time: Rc::clone(&time),
                value,
                line: Rc::clone(&columns.lines),
                period: 0.0,
                intersample: Intersample::Bl,
                spikes: Vec::new(),
                frozen: Vec::new(),
            };
            channels.push((place, finished(raw, source.sign, options, warnings)?));
        }
    }
    channels.sort_by_key(|(place, _)| *place);
    Ok((channels.into_iter().map(|(_, series)| series).collect(), files))
}

/// SI values, missing samples dropped, yaw differenced.
fn finished(
    mut series: Series,
    sign: f64,
    options: &LogOptions,
    warnings: &mut Vec<String>,
) -> Result<Series, Error> {
    let (role, unit) = (series.role, series.unit);
    series.bring_to_si(sign)?;
    let mut unsaid = Vec::new();
    drop_missing(&mut series, if role.is_place() { &mut unsaid } else { warnings });
    let repeated = repeated::average(&mut series)?;
    if role.is_place() {
        // Drop-outs of a receiver are its own affair, and so is a drive without a fix.
        return Ok(series);
    }
    warnings.extend(repeated.map(|r| r.warning(&series.file)));
    if role.has_spikes() {
        SpikeFilter::default().take(&mut series, true);
    }
    if series.time.len() < 3 {
        return Err(Error::TooFewRows {
            got: series.time.len(),
            need: super::LEAST_SAMPLES,
            file: series.file,
            column: series.column,
        });
    }
    if role == Role::Steering {
        series.intersample = intersample::of_steering(&series, options);
    }
    let mut rows_per_update = None;
    if series.is_sensor()
        && let Some(mut updates) = Updates::of(&series)
    {
        updates.take(&mut series);
        // A bad sample of a slow sensor is many equal rows.
        if role.has_spikes() {
            SpikeFilter::default().take(&mut series, true);
            series.spikes.sort_by(f64::total_cmp);
        }
        rows_per_update = Some(updates.rows());
    }
    series.period = median_period(&series.time);
    warnings.extend(series.spikes_in_words());
    warnings.extend(rows_per_update.map(|rows| intersample::told(&series, rows)));
    if role == Role::YawRate && unit.quantity == Quantity::Angle {
        let limit = series.gap_limit(options.max_gap_s);
        difference(&mut series, limit);
        if series.time.len() < 3 {
            return Err(Error::TooFewRows {
                got: series.time.len(),
                need: super::LEAST_SAMPLES,
                file: series.file,
                column: series.column,
            });
        }
        warnings.push(format!(
            "{}: column `{}` is an angle ({}): taken for yaw, unwrapped and differenced to yaw rate",
            series.file, series.column, series.unit.name
        ));
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
            series.file, series.column
        ));
        series.leave_out_missing();
    }
}

/// Time must not decrease from row to row, from the instant `before` them; the last instant.
pub(super) fn check_clock(
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

/// Yaw to yaw rate: unwrapped increments over time, placed at the middle of each interval, so
/// that no delay arises. How far the vehicle turned in a gap is not known: it stays one.
pub(super) fn difference(series: &mut Series, limit: f64) {
    let yaw = crate::signal::unwrap(&series.value);
    let time = Rc::clone(&series.time);
    let near: Vec<usize> = (0..yaw.len() - 1).filter(|&i| time[i + 1] - time[i] <= limit).collect();
    series.value = near.iter().map(|&i| (yaw[i + 1] - yaw[i]) / (time[i + 1] - time[i])).collect();
    series.time = Rc::new(near.iter().map(|&i| 0.5 * (time[i] + time[i + 1])).collect());
    series.line = Rc::new(near.iter().map(|&i| series.line[i]).collect());
}

/// Median step of a clock.
pub(crate) fn median_period(time: &[f64]) -> f64 {
    let mut steps: Vec<f64> = time.windows(2).map(|w| w[1] - w[0]).collect();
    let middle = steps.len() / 2;
    if steps.is_empty() { 0.0 } else { *steps.select_nth_unstable_by(middle, f64::total_cmp).1 }
}

impl Series {
    /// SI values; what no vehicle has is refused.
    pub(super) fn bring_to_si(&mut self, sign: f64) -> Result<(), Error> {
        let (role, unit) = (self.role, self.unit);
        let factor = sign * unit.to_si;
        if let Some((least, most, si)) = role.limits(unit.quantity) {
            let outside = |x: f64| x < least || x > most;
            if let Some(i) = (0..self.value.len())
                .find(|&i| outside(factor * self.value[i]) && !self.time[i].is_nan())
            {
                let value = factor * self.value[i];
                return Err(Error::Impossible {
                    at: Place::new(&self.file, self.line[i], &self.column),
                    role: role.name(),
                    value,
                    si,
                    unit: unit.name,
                    limit: if value < least { least } else { most },
                    alternatives: role.alternatives(sign * self.value[i], unit.name),
                });
            }
        }
        self.value.iter_mut().for_each(|x| *x *= factor);
        Ok(())
    }

    /// The channel on a grid: the steering as it drives a model whose input is held, the others by their
    /// values.
    pub(crate) fn on(&self, grid: &Grid) -> Vec<f64> {
        let becomes = match self.role {
            Role::Steering => Becomes::Held(self.intersample),
            _ => Becomes::Samples,
        };
        resample(&self.time, &self.value, self.period, grid, becomes)
    }

    /// Takes the rows over that follow.
    pub(super) fn append(&mut self, later: &mut Self) {
        Rc::make_mut(&mut self.time).append(Rc::make_mut(&mut later.time));
        Rc::make_mut(&mut self.line).append(Rc::make_mut(&mut later.line));
        self.value.append(&mut later.value);
    }

    /// The rows from that one, which are taken off.
    pub(super) fn split_off(&mut self, row: usize) -> Self {
        Self {
            time: Rc::new(Rc::make_mut(&mut self.time).split_off(row)),
            line: Rc::new(Rc::make_mut(&mut self.line).split_off(row)),
            value: self.value.split_off(row),
            file: self.file.clone(),
            column: self.column.clone(),
            spikes: Vec::new(),
            frozen: Vec::new(),
            ..*self
        }
    }

    /// Keeps the rows that are wanted.
    pub(super) fn retain(&mut self, wanted: impl Fn(usize) -> bool) {
        let kept: Vec<usize> = (0..self.value.len()).filter(|&i| wanted(i)).collect();
        if kept.len() < self.value.len() {
            self.time = Rc::new(kept.iter().map(|&i| self.time[i]).collect());
            self.line = Rc::new(kept.iter().map(|&i| self.line[i]).collect());
            self.value = kept.iter().map(|&i| self.value[i]).collect();
        }
    }

    fn is_missing(&self, i: usize) -> bool {
        self.time[i].is_nan() || self.value[i].is_nan()
    }

    /// Leaves rows without an instant or without a value out; how many they are.
    pub(super) fn leave_out_missing(&mut self) -> usize {
        let rows = self.value.len();
        let there: Vec<bool> = (0..rows).map(|i| !self.is_missing(i)).collect();
        self.retain(|i| there[i]);
        rows - self.value.len()
    }

    /// The spikes with their instants, for a warning; `None` where there are none.
    pub(super) fn spikes_in_words(&self) -> Option<String> {
        const SHOWN: usize = 5;
        if self.spikes.is_empty() {
            return None;
        }
        let mut at: Vec<String> =
            self.spikes.iter().take(SHOWN).map(|t| format!("{t:.3} s")).collect();
        if self.spikes.len() > SHOWN {
            at.push("…".into());
        }
        Some(format!(
            "{}: column `{}`: {} at {} (one to three samples that jump away and back), handled as missing samples",
            self.file,
            self.column,
            signal_words(self.spikes.len(), "spike"),
            at.join(", ")
        ))
    }

    /// The runs in which the channel was frozen, for a warning; `None` where there are none.
    pub(super) fn frozen_in_words(&self) -> Option<String> {
        let at: Vec<String> =
            self.frozen.iter().map(|[a, b]| format!("{a:.2} to {b:.2} s")).collect();
        (!at.is_empty()).then(|| {
            format!(
                "{}: column `{}` is frozen while the vehicle is steered ({}): handled as missing samples",
                self.file,
                self.column,
                at.join(", ")
            )
        })
    }

    /// Leaves out the samples within the runs `from..=to`, in s.
    pub(super) fn leave_out(&mut self, runs: &[[f64; 2]]) {
        if runs.is_empty() {
            return;
        }
        let time = Rc::clone(&self.time);
        self.retain(|i| !runs.iter().any(|[from, to]| (*from..=*to).contains(&time[i])));
    }

    pub(crate) fn start(&self) -> f64 {
        self.time.first().copied().unwrap_or(f64::NAN)
    }

    pub(crate) fn end(&self) -> f64 {
        self.time.last().copied().unwrap_or(f64::NAN)
    }

    /// Gaps above this are not bridged, s.
    pub(crate) fn gap_limit(&self, limit: f64) -> f64 {
        limit.max(1.5 * self.period)
    }

    /// Gaps above the limit within `from..to`, as the row before each.
    pub(crate) fn gaps(&self, from: f64, to: f64, limit: f64) -> Vec<usize> {
        let limit = self.gap_limit(limit);
        let time = &self.time;
        (0..time.len().saturating_sub(1))
            .filter(|&i| time[i + 1] > from && time[i] < to && time[i + 1] - time[i] > limit)
            .collect()
    }

    /// Line of the row after `i`.
    pub(crate) fn line_after(&self, i: usize) -> u64 {
        self.line[(i + 1).min(self.line.len() - 1)]
    }

    /// Tells of the gaps within `from..to` that are bridged.
    pub(crate) fn tell_bridged(&self, from: f64, to: f64, limit: f64, warnings: &mut Vec<String>) {
        let limit = self.gap_limit(limit);
        let gap = |i: usize| self.time[i + 1] - self.time[i];
        let small: Vec<usize> = (0..self.time.len() - 1)
            .filter(|&i| self.time[i + 1] > from && self.time[i] < to)
            .filter(|&i| gap(i) > 3.0 * self.period && gap(i) <= limit)
            .collect();
        if let Some(worst) = small.iter().copied().max_by(|a, b| gap(*a).total_cmp(&gap(*b))) {
            warnings.push(format!(
                "{}: column `{}`: {} bridged by straight lines, the longest {:.3} s before line {}",
                self.file,
                self.column,
                signal_words(small.len(), "gap"),
                gap(worst),
                self.line_after(worst),
            ));
        }
    }

    pub(crate) fn summary(&self) -> ChannelSummary {
        let n = self.value.len() as f64;
        ChannelSummary {
            role: self.role.key().into(),
            column: self.column.clone(),
            unit: self.unit.name.into(),
            rows: self.value.len(),
            // The clock's digits are coarser than 1e-3 Hz.
            rate_hz: (1e3 / self.period).round() / 1e3,
            intersample: Some(self.intersample),
            min: self.value.iter().copied().fold(f64::INFINITY, f64::min),
            mean: self.value.iter().sum::<f64>() / n,
            max: self.value.iter().copied().fold(f64::NEG_INFINITY, f64::max),
            resolution: resolution(&self.value),
            spikes_s: self.spikes.clone(),
            frozen_s: self.frozen.clone(),
        }
    }
}

/// Runs of lines without a sample.
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
        if self.count == 0 {
            return None;
        }
        let mut lines: Vec<String> = self
            .runs
            .iter()
            .take(5)
            .map(|(a, b)| if a == b { a.to_string() } else { format!("{a}-{b}") })
            .collect();
        if self.runs.len() > 5 {
            lines.push("…".into());
        }
        Some(format!("{} (lines {})", signal_words(self.count, "sample"), lines.join(", ")))
    }
}
