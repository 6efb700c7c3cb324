//! The readings between the time at which an arriving fix was valid and now, oldest first.
//!
//! All times are durations, so nothing is lost however long the drive. The history is bounded:
//! intervals shorter than the latency over [`RESOLUTION`] are merged into their neighbour, their
//! readings averaged over time.

use crate::Error;
use crate::error::finite;
use serde::{Deserialize, Serialize};
use std::collections::VecDeque;

/// Least number of intervals that the latency can hold before they are merged.
pub const RESOLUTION: f64 = 1024.0;

/// How near to the end of an interval a cut may be to be taken as on it, relative to the interval.
const SLIVER: f64 = 1e-9;

/// An interval of time over which the readings are constant.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Interval {
    /// How long, s.
    pub duration: f64,
    /// The gyro's reading, rad/s.
    pub yaw_rate: f64,
    /// Its derivative, rad/s².
    pub yaw_acceleration: f64,
    /// The speed, m/s.
    pub speed: f64,
}

impl Interval {
    fn merge(&mut self, other: &Self) {
        let duration = self.duration + other.duration;
        let mean = |a: f64, b: f64| (a * self.duration + b * other.duration) / duration;
        *self = Self {
            duration,
            yaw_rate: mean(self.yaw_rate, other.yaw_rate),
            yaw_acceleration: mean(self.yaw_acceleration, other.yaw_acceleration),
            speed: mean(self.speed, other.speed),
        };
    }
}

/// The latest intervals, as long together as the latency once that time has passed.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct History {
    intervals: VecDeque<Interval>,
    length: f64,
}

impl History {
    /// Puts the latest interval in.
    pub fn push(&mut self, interval: Interval, latency: f64) {
        self.length += interval.duration;
        match self.intervals.back_mut() {
            Some(back) if back.duration + interval.duration <= latency / RESOLUTION => {
                back.merge(&interval);
            }
            _ => self.intervals.push_back(interval),
        }
    }

    /// Takes the oldest interval out, or its older part, as far as it lies before the latency.
    pub fn pop(&mut self, latency: f64) -> Option<Interval> {
        let before = self.length - latency;
        let front = self.intervals.front_mut()?;
        if before <= SLIVER * front.duration {
            return None;
        }
        if before >= (1.0 - SLIVER) * front.duration {
            self.length -= front.duration;
            let taken = self.intervals.pop_front();
            if self.intervals.is_empty() {
                self.length = 0.0;
            }
            return taken;
        }
        front.duration -= before;
        self.length -= before;
        Some(Interval { duration: before, ..*front })
    }

    /// Whether it reaches back as far as the latency.
    #[must_use]
    pub fn reaches(&self, latency: f64) -> bool {
        self.length >= latency * (1.0 - SLIVER) - f64::EPSILON
    }

    /// The intervals, oldest first.
    pub fn iter(&self) -> impl Iterator<Item = &Interval> {
        self.intervals.iter()
    }

    /// Refuses a history that cannot be one of this latency.
    ///
    /// # Errors
    /// Names an invalid value.
    pub fn check(&self, latency: f64) -> Result<(), Error> {
        let bad = |name, value, expected| Err(Error::SavedState { name, value, expected });
        let count = self.intervals.len() as f64;
        if count > 2.0 * RESOLUTION + 2.0 {
            return bad("the number of intervals in the history", count, "at most 2050");
        }
        let mut sum = 0.0;
        for s in &self.intervals {
            if !(s.duration > 0.0 && s.duration <= latency * (1.0 + 1e-6)) {
                return bad("a duration in the history", s.duration, "more than 0, to the latency");
            }
            finite("a reading in the history", &[s.yaw_rate, s.yaw_acceleration, s.speed])?;
            sum += s.duration;
        }
        if !((self.length - sum).abs() <= 1e-6 * latency && sum <= latency * (1.0 + 1e-6)) {
            return bad("the length of the history", self.length, "at most the latency");
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn interval(duration: f64) -> Interval {
        Interval { duration, yaw_rate: 0.1, yaw_acceleration: 0.3, speed: 2.0 }
    }

    #[test]
    fn what_comes_out_went_in_and_the_rest_is_the_latency() {
        let latency = 0.1;
        for steps in [vec![0.01; 500], vec![0.003, 0.25, 0.04, 1e-5, 0.1], vec![1e-7; 20_000]] {
            let mut history = History::default();
            let (mut given, mut taken) = (0.0, 0.0);
            for step in steps {
                history.push(interval(step), latency);
                given += step;
                while let Some(old) = history.pop(latency) {
                    assert!(old.duration > 0.0);
                    taken += old.duration;
                }
                let rest: f64 = history.iter().map(|s| s.duration).sum();
                assert!((rest + taken - given).abs() < 1e-12);
                assert!((rest - given.min(latency)).abs() < 1e-9);
                assert_eq!(history.reaches(latency), given > latency * (1.0 - 1e-8));
                history.check(latency).unwrap();
            }
        }
    }

    #[test]
    fn without_latency_nothing_is_kept() {
        let mut history = History::default();
        for _ in 0..10 {
            assert!(history.reaches(0.0));
            history.push(interval(0.01), 0.0);
            assert_eq!(history.pop(0.0), Some(interval(0.01)));
            assert_eq!(history.pop(0.0), None);
            assert_eq!(history, History::default());
        }
    }
}
