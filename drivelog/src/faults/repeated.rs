//! Rows with the same time: a clock with few digits, or a logger that writes an instant twice.

use crate::Error;
use crate::error::{counted, short};
use crate::series::Series;
use crate::units::Quantity;
use std::f64::consts::{PI, TAU};
use std::ops::Range;
use std::rc::Rc;

/// Samples of a channel that repeat an instant, and the first of them.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Repeated {
    pub(crate) count: usize,
    pub(crate) time: f64,
    pub(crate) line: u64,
}

/// One sample for each instant: the mean of its values, of angles that wrap the mean around the first.
pub(crate) fn average(series: &mut Series) -> Result<Option<Repeated>, Error> {
    let time = Rc::clone(&series.time);
    let Some(first) = (1..time.len()).find(|&i| time[i] == time[i - 1]) else { return Ok(None) };
    let starts: Vec<usize> =
        (0..time.len()).filter(|&i| i == 0 || time[i] != time[i - 1]).collect();
    let count = time.len() - starts.len();
    if count > starts.len() {
        return Err(Error::CoarseClock {
            file: series.file.clone(),
            column: series.column.clone(),
            values: time.len(),
            instants: starts.len(),
        });
    }
    let line = Rc::clone(&series.line);
    let is_angle = series.unit.quantity == Quantity::Angle;
    let wraps = series.is_yaw() || (series.role.is_place() && is_angle);
    let mean = |range: Range<usize>| {
        let values = &series.value[range];
        let sum: f64 = values
            .iter()
            .map(|x| x - values[0])
            .map(|x| if wraps { (x + PI).rem_euclid(TAU) - PI } else { x })
            .sum();
        values[0] + sum / values.len() as f64
    };
    let ends = starts.iter().skip(1).copied().chain([time.len()]);
    series.value = starts.iter().zip(ends).map(|(from, to)| mean(*from..to)).collect();
    series.time = Rc::new(starts.iter().map(|&i| time[i]).collect());
    series.line = Rc::new(starts.iter().map(|&i| line[i]).collect());
    Ok(Some(Repeated { count, time: time[first], line: line[first] }))
}

impl Repeated {
    pub(crate) fn and(earlier: Option<Self>, later: Option<Self>) -> Option<Self> {
        match (earlier, later) {
            (Some(a), Some(b)) => Some(Self { count: a.count + b.count, ..a }),
            (a, b) => a.or(b),
        }
    }

    pub(crate) fn warning(&self, file: &str) -> String {
        format!(
            "{file}: {} with the time of the sample before, averaged with it; the first is in line {} at {} s",
            counted(self.count, "sample"),
            self.line,
            short(self.time)
        )
    }
}
