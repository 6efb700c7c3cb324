//! The channels of a drive: SI values, missing samples dropped, impossible values rejected.

use crate::error::{Error, Place, counted};
use crate::faults::{SpikeFilter, average};
use crate::intersample::{self, Updates};
use crate::mapping::{Source, time_column};
use crate::options::LogOptions;
use crate::role::Role;
use crate::series::Series;
use crate::signal::{median_period, unwrap};
use crate::table::Table;
use std::rc::Rc;
use steerwright_formats::SourceFile;

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
            let empty = Series::new(*role, &file, &header[source.column], source.unit);
            let (time, line) = (Rc::clone(&time), Rc::clone(&columns.lines));
            let raw = Series { time, value, line, ..empty };
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
    let role = series.role;
    series.bring_to_si(sign)?;
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
            series.file, series.column
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
        (self.count > 0).then(text)
    }
}
