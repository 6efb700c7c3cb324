//! Samples of one channel on its own clock, in SI units.

use crate::Error;
use crate::error::{Place, counted, shortened};
use crate::resample::{Becomes, Grid, resample};
use crate::role::Role;
use crate::signal::resolution;
use crate::units::{Quantity, Unit};
use std::rc::Rc;
use steerwright_formats::{ChannelSummary, Intersample};

/// Slower on average, a vehicle is at rest, m/s: steered, it need not yaw.
pub(crate) const MOVING_MPS: f64 = 0.5;
/// Fewest samples of the merged recording.
pub(crate) const LEAST_SAMPLES: usize = 100;
/// Most samples of the merged recording, and of the fine grid it is filtered on.
pub(crate) const MOST_SAMPLES: usize = 20_000_000;

#[derive(Debug, Clone)]
pub(crate) struct Series {
    pub(crate) role: Role,
    pub(crate) file: String,
    pub(crate) column: String,
    pub(crate) unit: Unit,
    /// Unit that the values keep; `None` of values that are brought to SI.
    pub(crate) own_unit: Option<String>,
    /// Instants, s; shared by the channels of a file where none of its cells is blank.
    pub(crate) time: Rc<Vec<f64>>,
    /// SI values.
    pub(crate) value: Vec<f64>,
    /// Lines in the file.
    pub(crate) line: Rc<Vec<u64>>,
    /// Median period of the clock, s; of a sensor that is slower than the rows, that of its updates.
    pub(crate) period: f64,
    pub(crate) intersample: Intersample,
    /// Instants of single spikes and dropouts, which are left out, s.
    pub(crate) spikes: Vec<f64>,
    /// First and last instants of frozen runs, which are left out, s.
    pub(crate) frozen: Vec<[f64; 2]>,
}

impl Series {
    pub(crate) fn new(role: Role, file: &str, column: &str, unit: Unit) -> Self {
        Self {
            role,
            file: file.into(),
            column: column.into(),
            unit,
            own_unit: None,
            time: Rc::default(),
            value: Vec::new(),
            line: Rc::default(),
            period: 0.0,
            intersample: Intersample::Bl,
            spikes: Vec::new(),
            frozen: Vec::new(),
        }
    }

    pub(super) fn without_rows(&self) -> Self {
        let (period, intersample) = (self.period, self.intersample);
        let own_unit = self.own_unit.clone();
        Self {
            period,
            intersample,
            own_unit,
            ..Self::new(self.role, &self.file, &self.column, self.unit)
        }
    }

    pub(crate) fn is_yaw(&self) -> bool {
        self.role == Role::YawRate && self.unit.quantity == Quantity::Angle
    }

    /// The error of a channel that has this value, SI, throughout.
    pub(super) fn constant(&self, value: f64) -> Error {
        Error::Constant {
            file: self.file.clone(),
            column: self.column.clone(),
            role: self.role.name(),
            value: value / self.unit.to_si,
            unit: self.unit_name().into(),
        }
    }

    /// The name of the unit in which it is logged.
    pub(super) fn unit_name(&self) -> &str {
        self.own_unit.as_deref().unwrap_or(self.unit.name)
    }

    /// The value, SI, that it has throughout; `None` if it changes.
    pub(super) fn constant_value(&self) -> Option<f64> {
        let first = self.value.first().copied()?;
        let moves = |x: &f64| (x - first).abs() > 1e-12 * (1.0 + first.abs());
        if self.value.iter().any(moves) { None } else { Some(first) }
    }

    /// Rejects a mean speed that is that of a standstill.
    pub(super) fn check_moves(&self, mean_mps: f64) -> Result<(), Error> {
        if mean_mps.abs() < MOVING_MPS {
            let (file, column) = (self.file.clone(), self.column.clone());
            return Err(Error::Standstill { file, column, mean_mps });
        }
        Ok(())
    }

    /// The warning of a yaw; `file` is how it names the file.
    pub(super) fn yaw_in_words(&self, file: &str) -> String {
        format!(
            "{file}: column `{}` is an angle ({}): taken for yaw, unwrapped and differenced to yaw rate",
            shortened(&self.column),
            self.unit.name
        )
    }

    /// Rejects a channel with too few rows to determine a clock.
    pub(crate) fn check_rows(&self) -> Result<(), Error> {
        if self.time.len() >= 3 {
            return Ok(());
        }
        Err(Error::TooFewRows {
            file: self.file.clone(),
            column: self.column.clone(),
            got: self.time.len(),
            need: LEAST_SAMPLES,
        })
    }

    /// SI values; what no vehicle has is refused.
    pub(super) fn bring_to_si(&mut self) -> Result<(), Error> {
        let (role, unit) = (self.role, self.unit);
        let factor = unit.to_si;
        if let Some((least, most, si)) = role.limits(unit.quantity) {
            let outside = |x: f64| x < least || x > most;
            if let Some(i) = (0..self.value.len())
                .find(|&i| outside(factor * self.value[i]) && !self.time[i].is_nan())
            {
                let value = factor * self.value[i];
                return Err(self.impossible(
                    i,
                    value,
                    (if value < least { least } else { most }, si),
                ));
            }
        }
        self.value.iter_mut().for_each(|x| *x *= factor);
        Ok(())
    }

    /// The error of a row whose value, SI, is beyond a limit.
    pub(crate) fn impossible(
        &self,
        row: usize,
        value: f64,
        (limit, si): (f64, &'static str),
    ) -> Error {
        Error::Impossible {
            at: Place::new(&self.file, self.line[row], &self.column),
            role: self.role.name(),
            value,
            si,
            unit: self.unit.name,
            limit,
            alternatives: self.role.alternatives(value / self.unit.to_si, self.unit.name),
        }
    }

    /// The channel on a grid: an input as it drives a model whose input is held.
    pub(crate) fn interpolate(&self, grid: &Grid) -> Vec<f64> {
        let becomes = match self.role {
            role if role.is_held() => Becomes::Held(self.intersample),
            _ => return self.samples_on(grid),
        };
        resample(&self.time, &self.value, self.period, grid, becomes)
    }

    /// The values of the channel on a grid.
    pub(crate) fn samples_on(&self, grid: &Grid) -> Vec<f64> {
        resample(&self.time, &self.value, self.period, grid, Becomes::Samples)
    }

    pub(super) fn append(&mut self, later: &mut Self) {
        Rc::make_mut(&mut self.time).append(Rc::make_mut(&mut later.time));
        Rc::make_mut(&mut self.line).append(Rc::make_mut(&mut later.line));
        self.value.append(&mut later.value);
    }

    pub(super) fn split_off(&mut self, row: usize) -> Self {
        Self {
            time: Rc::new(Rc::make_mut(&mut self.time).split_off(row)),
            line: Rc::new(Rc::make_mut(&mut self.line).split_off(row)),
            value: self.value.split_off(row),
            ..self.without_rows()
        }
    }

    pub(super) fn retain(&mut self, wanted: impl Fn(usize) -> bool) {
        let kept: Vec<usize> = (0..self.value.len()).filter(|&i| wanted(i)).collect();
        if kept.len() < self.value.len() {
            self.time = Rc::new(kept.iter().map(|&i| self.time[i]).collect());
            self.line = Rc::new(kept.iter().map(|&i| self.line[i]).collect());
            self.value = kept.iter().map(|&i| self.value[i]).collect();
        }
    }

    pub(crate) fn is_missing(&self, i: usize) -> bool {
        self.time[i].is_nan() || self.value[i].is_nan()
    }

    /// Leaves rows without an instant or without a value out; how many they are.
    pub(super) fn leave_out_missing(&mut self) -> usize {
        let rows = self.value.len();
        let there: Vec<bool> = (0..rows).map(|i| !self.is_missing(i)).collect();
        self.retain(|i| there[i]);
        rows - self.value.len()
    }

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
            shortened(&self.column),
            counted(self.spikes.len(), "spike"),
            at.join(", ")
        ))
    }

    /// The runs in which the channel was frozen, for a warning; `None` where there are none.
    pub(super) fn frozen_in_words(&self) -> Option<String> {
        let at: Vec<String> =
            self.frozen.iter().map(|[a, b]| format!("{a:.2} to {b:.2} s")).collect();
        if at.is_empty() {
            None
        } else {
            Some(format!(
                "{}: column `{}` is frozen while the vehicle is steered ({}): handled as missing samples",
                self.file,
                shortened(&self.column),
                at.join(", ")
            ))
        }
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

    /// The parts of a span between successive values, and those before the first and after the last.
    pub(crate) fn missing_within(&self, (from, to): (f64, f64)) -> Vec<(f64, f64)> {
        let edges = [f64::NEG_INFINITY].into_iter().chain(self.time.iter().copied());
        let ends = self.time.iter().copied().chain([f64::INFINITY]);
        let parts = edges.zip(ends).map(|(a, b)| (a.max(from), b.min(to)));
        parts.filter(|(a, b)| a < b).collect()
    }

    /// Line of the row after `i`.
    pub(crate) fn line_after(&self, i: usize) -> u64 {
        self.line[(i + 1).min(self.line.len() - 1)]
    }

    /// Reports the gaps within `from..to` that are bridged.
    pub(crate) fn warn_bridged(&self, from: f64, to: f64, limit: f64, warnings: &mut Vec<String>) {
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
                shortened(&self.column),
                counted(small.len(), "gap"),
                gap(worst),
                self.line_after(worst),
            ));
        }
    }

    /// The row at an instant, or the one after it.
    pub(crate) fn place_at(&self, instant: f64) -> Box<Place> {
        let row = self.time.partition_point(|t| *t < instant).min(self.line.len() - 1);
        Place::new(&self.file, self.line[row], &self.column)
    }

    pub(crate) fn summary(&self) -> ChannelSummary {
        let n = self.value.len() as f64;
        ChannelSummary {
            role: self.role.key().into(),
            column: self.column.clone(),
            unit: self.unit_name().into(),
            rows: self.value.len(),
            // The clock's digits are coarser than 1e-3 Hz.
            rate_hz: (1e3 / self.period).round() / 1e3,
            intersample: Some(self.intersample),
            along_lines: false,
            min: self.value.iter().copied().fold(f64::INFINITY, f64::min),
            mean: self.value.iter().sum::<f64>() / n,
            max: self.value.iter().copied().fold(f64::NEG_INFINITY, f64::max),
            resolution: resolution(&self.value),
            spikes_s: self.spikes.clone(),
            frozen_s: self.frozen.clone(),
        }
    }
}
