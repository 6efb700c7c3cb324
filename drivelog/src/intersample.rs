//! The behaviour of a channel between its samples, and the rows on which it was updated.
//!
//! Of a sensor, a repeated value is old. The rows on which it was updated show as changes that are several
//! rows apart, at multiples of one number of rows; a quantised signal that moves changes from row to row.
//! Of a command the rows are what acts, repetitions included (zero-order hold).

use crate::error::shortened;
use crate::options::LogOptions;
use crate::role::Role;
use crate::series::Series;
use crate::units::Quantity;
use std::rc::Rc;
use steerwright_formats::Intersample;

/// Rows that are looked at: those that a log read in chunks begins with.
const ROWS: usize = 1 << 14;
/// Changes from which the clock of the updates is read.
const LEAST_CHANGES: usize = 30;
/// Share of the changes that lie on that clock.
const ON_CLOCK: f64 = 0.9;
/// Share of the squared increments that lone jumps make up in a command.
const IN_JUMPS: f64 = 0.5;
/// Parts of names that commands have.
const COMMAND_NAMES: [&str; 9] =
    ["command", "cmd", "target", "setpoint", "request", "desired", "demand", "reference", "_ref"];

/// The behaviour of an input between its samples: as stated, or as name, unit and values indicate.
pub(crate) fn of_input(series: &Series, options: &LogOptions) -> Intersample {
    if series.role == Role::SteeringCommand {
        // What is stated is the angle's.
        return Intersample::Zoh;
    }
    if series.role.is_named_channel() {
        // An input of any system is a command, as in the toolboxes of the field.
        return options.intersample.unwrap_or(Intersample::Zoh);
    }
    let name = series.column.to_lowercase();
    options.intersample.unwrap_or_else(|| {
        let is_command = COMMAND_NAMES.iter().any(|word| name.contains(word))
            || series.role == Role::Steering && options.steering_full_scale_rad.is_some()
            || is_unit_of_command(series)
            || (rows_per_update(&series.value).is_none() && jumps(&series.value));
        if is_command { Intersample::Zoh } else { Intersample::Bl }
    })
}

/// A pedal, in 1 or %, is measured as an angle is.
fn is_unit_of_command(series: &Series) -> bool {
    match series.role {
        Role::LongitudinalCommand => series.unit.quantity == Quantity::Acceleration,
        Role::Brake => false,
        _ => series.unit.quantity != Quantity::Angle,
    }
}

/// Whether most of the movement is in jumps from one row to the next with rest before and after.
fn jumps(value: &[f64]) -> bool {
    let value = &value[..value.len().min(ROWS)];
    let steps: Vec<f64> = value.windows(2).map(|w| (w[1] - w[0]).abs()).collect();
    let least = steps.iter().copied().filter(|s| *s > 0.0).fold(f64::INFINITY, f64::min);
    let all: f64 = steps.iter().map(|s| s * s).sum();
    let lone: f64 = steps
        .windows(3)
        .filter(|s| s[1] > 3.0 * least && s[0].max(s[2]) <= 0.05 * s[1])
        .map(|s| s[1] * s[1])
        .sum();
    all > 0.0 && lone > IN_JUMPS * all
}

/// Rows from one update to the next, where it is more than one.
pub(crate) fn rows_per_update(value: &[f64]) -> Option<f64> {
    let value = &value[..value.len().min(ROWS)];
    let changes: Vec<usize> = (1..value.len()).filter(|&i| value[i] != value[i - 1]).collect();
    let gaps: Vec<f64> = changes.windows(2).map(|w| (w[1] - w[0]) as f64).collect();
    if gaps.len() < LEAST_CHANGES {
        return None;
    }
    let mut sorted = gaps.clone();
    sorted.sort_by(f64::total_cmp);
    let shortest = sorted[sorted.len() / 20];
    let near: Vec<f64> =
        gaps.iter().copied().filter(|g| (g / shortest - 1.0).abs() < 0.4).collect();
    let rows = near.iter().sum::<f64>() / near.len() as f64;
    // An update comes with the row after it: one row early or late where the rows are many.
    let tolerance = if rows < 4.0 { 0.3 } else { 1.2_f64.max(0.15 * rows) };
    let on_clock = |g: &&f64| {
        let updates = (**g / rows).round().max(1.0);
        (**g - updates * rows).abs() <= tolerance
    };
    let regular = gaps.iter().filter(on_clock).count() as f64;
    let single = gaps.iter().filter(|g| (**g / rows).round() <= 1.0).count() as f64;
    let count = gaps.len() as f64;
    if rows >= 1.9 && regular >= ON_CLOCK * count && single >= 0.3 * count {
        Some(rows)
    } else {
        None
    }
}

#[derive(Debug, Clone, Default)]
pub(crate) struct Updates {
    /// Rows from one update to the next.
    pub(crate) rows: f64,
    since: usize,
    last: Option<f64>,
    /// The row on which an update is due that need not change the value.
    due: Option<(f64, f64, u64)>,
}

impl Updates {
    /// Of a sensor that is slower than the rows.
    pub(crate) fn from_series(series: &Series) -> Option<Self> {
        rows_per_update(&series.value).map(|rows| Self { rows, ..Self::default() })
    }

    /// Leaves the rows out on which the sensor was not updated. What repeats for half a period beyond the
    /// next update was updated to the same value.
    pub(crate) fn take(&mut self, series: &mut Series) {
        let (mut time, mut value, mut line) = (Vec::new(), Vec::new(), Vec::new());
        let mut keep = |(t, x, l): (f64, f64, u64)| {
            time.push(t);
            value.push(x);
            line.push(l);
        };
        let period = self.rows.round() as usize;
        for i in 0..series.value.len() {
            let row = (series.time[i], series.value[i], series.line[i]);
            let Some(last) = self.last.replace(row.1) else { continue };
            self.since += 1;
            if row.1 != last {
                (self.since, self.due) = (0, None);
                keep(row);
                continue;
            }
            if self.since == period {
                self.due = Some(row);
            }
            if self.since as f64 >= 1.5 * self.rows
                && let Some(due) = self.due.take()
            {
                self.since -= period;
                keep(due);
            }
        }
        (series.time, series.value, series.line) = (Rc::new(time), value, Rc::new(line));
    }
}

/// The warning of a channel that is slower than its rows.
pub(crate) fn held_steps_warning(series: &Series, rows: f64) -> String {
    format!(
        "{}: column `{}`: each value is repeated over {:.0} rows; it is read as updated at {:.1} Hz",
        series.file,
        shortened(&series.column),
        rows,
        1.0 / series.period
    )
}

impl Series {
    /// Whether its samples are those of a sensor, whose repeated values are old.
    pub(super) fn is_sensor(&self) -> bool {
        // A quantised output of any system rests between its changes.
        !self.role.is_named_channel()
            && (!self.role.is_held() || self.intersample != Intersample::Zoh)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Values at 100 Hz of a slow sine, updated every so many rows, with a quantum.
    fn held(rows: usize, quantum: f64) -> Vec<f64> {
        (0..4000)
            .map(|k| {
                let x = (0.02 * (k / rows * rows) as f64).sin() + 0.3 * (0.0013 * k as f64).sin();
                let x = if rows == 1 { x } else { (0.02 * (k / rows * rows) as f64).sin() };
                if quantum > 0.0 { (x / quantum).round() * quantum } else { x }
            })
            .collect()
    }

    #[test]
    fn updates_are_distinguished_from_quantisation() {
        for rows in [2, 3, 5, 10] {
            let found = rows_per_update(&held(rows, 0.0)).unwrap();
            assert!((found - rows as f64).abs() < 0.01, "{rows}: {found}");
            let coarse = rows_per_update(&held(rows, 0.005)).unwrap();
            assert!((coarse - rows as f64).abs() < 0.2, "{rows}: {coarse}");
        }
        for quantum in [0.0, 0.001, 0.01, 0.05, 0.2] {
            assert_eq!(rows_per_update(&held(1, quantum)), None, "{quantum}");
        }
    }

    #[test]
    fn jumps_are_distinguished_from_movement() {
        let steps: Vec<f64> = (0..4000).map(|k| ((k / 60 * 7919) % 13) as f64).collect();
        assert!(jumps(&steps));
        for quantum in [0.0, 0.001, 0.05, 0.2] {
            assert!(!jumps(&held(1, quantum)), "{quantum}");
        }
    }
}
