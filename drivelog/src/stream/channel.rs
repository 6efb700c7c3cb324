//! One channel of a file that is read in chunks.

use crate::Error;
use crate::channels::difference;
use crate::faults::{Repeated, SpikeFilter, average};
use crate::intersample::{self, Updates};
use crate::options::LogOptions;
use crate::role::Role;
use crate::series::Series;
use crate::signal::{median_period, resolution};
use std::rc::Rc;
use steerwright_formats::ChannelSummary;

/// A clock whose median period differs by that share from what it was is another clock.
const SAME_PERIOD: f64 = 0.1;
/// Fewest values from which a period is determined.
const ENOUGH: usize = 100;

pub(super) struct Channel {
    pub(super) missing: usize,
    pub(super) least: f64,
    most: f64,
    sum: f64,
    count: usize,
    pub(super) repeated: Option<Repeated>,
    /// The last row of a yaw: instant, angle and line.
    last: Option<(f64, f64, u64)>,
    /// Of a sensor that is slower than the rows.
    pub(super) updates: Option<Updates>,
    /// That of the first rows that show one.
    pub(super) resolution: Option<f64>,
    /// Whether rows have shown what kind of channel it is.
    begun: bool,
    /// Spikes among the rows, and among the updates of a sensor that is slower.
    spikes: [SpikeFilter; 2],
}

impl Default for Channel {
    fn default() -> Self {
        Self {
            missing: 0,
            least: f64::INFINITY,
            most: f64::NEG_INFINITY,
            sum: 0.0,
            count: 0,
            repeated: None,
            last: None,
            updates: None,
            resolution: None,
            begun: false,
            spikes: Default::default(),
        }
    }
}

impl Channel {
    /// Adds rows, as written in the file, to those at hand.
    pub(super) fn take(
        &mut self,
        to: &mut Series,
        time: &[f64],
        value: Vec<f64>,
        line: &[u64],
        options: &LogOptions,
        are_last: bool,
    ) -> Result<(), Error> {
        let (time, line) = (Rc::new(time.to_vec()), Rc::new(line.to_vec()));
        let mut new = Series { time, value, line, ..to.without_rows() };
        new.bring_to_si()?;
        self.missing += new.leave_out_missing();
        self.repeated = Repeated::and(self.repeated, average(&mut new)?);
        let [of_rows, of_updates] = &mut self.spikes;
        if to.role.has_spikes() {
            of_rows.take(&mut new, are_last);
        }
        if !self.begun {
            self.begun = true;
            if to.role == Role::Steering {
                to.intersample = intersample::of_input(&new, options);
                new.intersample = to.intersample;
            }
            self.updates = if new.is_sensor() { Updates::from_series(&new) } else { None };
        }
        if let Some(updates) = &mut self.updates {
            updates.take(&mut new);
            // A bad sample of a slow sensor is many equal rows.
            if to.role.has_spikes() {
                of_updates.take(&mut new, are_last);
            }
        }
        to.spikes.append(&mut new.spikes);
        to.spikes.sort_by(f64::total_cmp);
        let of_yaw = to.is_yaw();
        let last = self.last.filter(|_| of_yaw);
        if let Some((time, value, line)) = last {
            Rc::make_mut(&mut new.time).insert(0, time);
            new.value.insert(0, value);
            Rc::make_mut(&mut new.line).insert(0, line);
        }
        self.check_period(to, &new)?;
        if of_yaw && let Some(i) = new.value.len().checked_sub(1) {
            self.last = Some((new.time[i], new.value[i], new.line[i]));
            difference(&mut new, to.gap_limit(options.max_gap_s));
        }
        self.resolution = self.resolution.or_else(|| resolution(&new.value));
        for x in &new.value {
            (self.least, self.most) = (self.least.min(*x), self.most.max(*x));
            self.sum += x;
        }
        self.count += new.value.len();
        to.append(&mut new);
        Ok(())
    }

    /// Takes the first rows' period, and holds those of later rows against it.
    fn check_period(&self, to: &mut Series, new: &Series) -> Result<(), Error> {
        let period = median_period(&new.time);
        if self.count == 0 {
            to.period = period;
        } else if new.time.len() >= ENOUGH && (period / to.period - 1.0).abs() > SAME_PERIOD {
            return Err(Error::ClockChanged {
                file: to.file.clone(),
                line: new.line[0],
                column: to.column.clone(),
                before_s: to.period,
                period_s: period,
            });
        }
        Ok(())
    }

    pub(super) fn mean(&self) -> f64 {
        self.sum / self.count.max(1) as f64
    }

    pub(super) fn is_constant(&self) -> bool {
        self.most - self.least <= 1e-12 * (1.0 + self.least.abs())
    }

    pub(super) fn summary(&self, series: &Series) -> ChannelSummary {
        ChannelSummary {
            rows: self.count,
            min: self.least,
            mean: self.mean(),
            max: self.most,
            resolution: self.resolution,
            ..series.summary()
        }
    }
}
