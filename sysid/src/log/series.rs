//! One channel on its own clock: SI values, missing samples dropped, the impossible refused.

use super::Role;
use super::mapping::{Source, time_column};
use super::table::Table;
use super::units::{Quantity, Unit};
use super::{LogOptions, signal_words};
use crate::{Error, Place};
use formats::ChannelSummary;

/// Samples of one channel in time order.
#[derive(Debug, Clone)]
pub(crate) struct Series {
    pub(crate) role: Role,
    pub(crate) file: String,
    pub(crate) column: String,
    pub(crate) unit: Unit,
    /// Instants, s.
    pub(crate) time: Vec<f64>,
    /// SI values.
    pub(crate) value: Vec<f64>,
    /// Lines in the file.
    pub(crate) line: Vec<u64>,
    /// Median period of the clock, s.
    pub(crate) period: f64,
}

/// Reads the channel of `source`.
pub(crate) fn read(
    tables: &[Table<'_>],
    source: Source,
    role: Role,
    options: &LogOptions,
    warnings: &mut Vec<String>,
) -> Result<Series, Error> {
    let table = &tables[source.table];
    let clock = time_column(table, options)?;
    let wanted: Vec<usize> =
        clock.iter().map(|(c, _)| *c).chain(std::iter::once(source.column)).collect();
    let columns = table.columns(&wanted)?;
    let raw = columns.values.last().map_or(&[][..], Vec::as_slice);
    let file = table.file.to_owned();
    let column = table.header[source.column].clone();
    let time: Vec<f64> = match (clock, options.row_period_s) {
        (Some((_, unit)), _) => columns.values[0].iter().map(|t| t * unit.to_si).collect(),
        (None, period) => (0..raw.len()).map(|i| i as f64 * period.unwrap_or(1.0)).collect(),
    };
    if let Some((c, _)) = clock {
        check_clock(&file, &table.header[c], &time, &columns.lines)?;
    }
    let mut series = Series {
        role,
        file,
        column,
        unit: source.unit,
        time: Vec::with_capacity(raw.len()),
        value: Vec::with_capacity(raw.len()),
        line: Vec::with_capacity(raw.len()),
        period: 0.0,
    };
    let limits = role.limits(source.unit.quantity);
    let mut missing = MissingRuns::default();
    for ((&t, &x), &line) in time.iter().zip(raw).zip(&columns.lines) {
        if t.is_nan() || x.is_nan() {
            missing.note(line);
            continue;
        }
        let value = source.sign * x * source.unit.to_si;
        if let Some((least, most, si)) = limits
            && !(least..=most).contains(&value)
        {
            return Err(Error::Impossible {
                at: Place::new(&series.file, line, &series.column),
                role: role.name(),
                value,
                si,
                unit: source.unit.name,
                limit: if value < least { least } else { most },
                alternatives: role.alternatives(source.sign * x, source.unit.name),
            });
        }
        series.time.push(t);
        series.value.push(value);
        series.line.push(line);
    }
    if let Some(text) = missing.finish() {
        warnings.push(format!(
            "{}: column `{}`: {text} missing, bridged by straight lines",
            series.file, series.column
        ));
    }
    if series.time.len() < 3 {
        return Err(Error::TooFewRows {
            got: series.time.len(),
            need: super::LEAST_SAMPLES,
            file: series.file,
            column: series.column,
        });
    }
    if role == Role::YawRate && source.unit.quantity == Quantity::Angle {
        difference(&mut series);
        warnings.push(format!(
            "{}: column `{}` is an angle ({}): taken for yaw, unwrapped and differenced to yaw rate",
            series.file, series.column, series.unit.name
        ));
    }
    series.period = median_period(&series.time);
    Ok(series)
}

/// Time must increase from row to row.
fn check_clock(file: &str, column: &str, time: &[f64], lines: &[u64]) -> Result<(), Error> {
    let mut before = f64::NEG_INFINITY;
    for (&t, &line) in time.iter().zip(lines) {
        if t <= before {
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
    Ok(())
}

/// Yaw to yaw rate: unwrapped increments over time, placed at the middle of each interval, so
/// that no delay arises.
fn difference(series: &mut Series) {
    let yaw = crate::signal::unwrap(&series.value);
    let n = yaw.len() - 1;
    let time = &series.time;
    series.value = (0..n).map(|i| (yaw[i + 1] - yaw[i]) / (time[i + 1] - time[i])).collect();
    series.time = (0..n).map(|i| 0.5 * (time[i] + time[i + 1])).collect();
    series.line.truncate(n);
}

fn median_period(time: &[f64]) -> f64 {
    let mut steps: Vec<f64> = time.windows(2).map(|w| w[1] - w[0]).collect();
    let middle = steps.len() / 2;
    if steps.is_empty() { 0.0 } else { *steps.select_nth_unstable_by(middle, f64::total_cmp).1 }
}

impl Series {
    pub(crate) fn start(&self) -> f64 {
        self.time.first().copied().unwrap_or(f64::NAN)
    }

    pub(crate) fn end(&self) -> f64 {
        self.time.last().copied().unwrap_or(f64::NAN)
    }

    /// Refuses gaps above the limit between `from` and `to`, and warns of the smaller ones.
    pub(crate) fn check_gaps(
        &self,
        from: f64,
        to: f64,
        limit: f64,
        warnings: &mut Vec<String>,
    ) -> Result<(), Error> {
        let inside = |i: usize| self.time[i + 1] > from && self.time[i] < to;
        let gap = |i: usize| self.time[i + 1] - self.time[i];
        let limit = limit.max(1.5 * self.period);
        let count = self.time.len() - 1;
        if let Some(i) = (0..count).find(|&i| inside(i) && gap(i) > limit) {
            let (mut longest, mut start) = ((from, from), from);
            for j in (0..count).filter(|&j| inside(j) && gap(j) > limit) {
                longest = longer(longest, (start, self.time[j].min(to)));
                start = self.time[j + 1];
            }
            longest = longer(longest, (start.min(to), to));
            return Err(Error::Gap {
                at: Place::new(
                    &self.file,
                    self.line[(i + 1).min(self.line.len() - 1)],
                    &self.column,
                ),
                from_s: round_ms(self.time[i]),
                to_s: round_ms(self.time[i + 1]),
                gap_s: round_ms(gap(i)),
                limit_s: round_ms(limit),
                longest: (round_ms(longest.0), round_ms(longest.1)),
            });
        }
        let small: Vec<usize> =
            (0..count).filter(|&i| inside(i) && gap(i) > 3.0 * self.period).collect();
        if let Some(worst) = small.iter().copied().max_by(|a, b| gap(*a).total_cmp(&gap(*b))) {
            warnings.push(format!(
                "{}: column `{}`: {} bridged by straight lines, the longest {:.3} s before line {}",
                self.file,
                self.column,
                signal_words(small.len(), "gap"),
                gap(worst),
                self.line[(worst + 1).min(self.line.len() - 1)],
            ));
        }
        Ok(())
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
            min: self.value.iter().copied().fold(f64::INFINITY, f64::min),
            mean: self.value.iter().sum::<f64>() / n,
            max: self.value.iter().copied().fold(f64::NEG_INFINITY, f64::max),
        }
    }
}

fn longer(a: (f64, f64), b: (f64, f64)) -> (f64, f64) {
    if b.1 - b.0 > a.1 - a.0 { b } else { a }
}

fn round_ms(x: f64) -> f64 {
    (x * 1e3).round() / 1e3
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
