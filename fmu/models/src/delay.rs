//! A pure delay, in seconds, of an input that is held or ramped over steps of any size.
//!
//! The input's history is a belt of segments, oldest first, whose length is always the delay: a step puts
//! its own segment on one end and takes as much time off the other. All times are durations, so nothing
//! is lost however long the simulation runs. Segments shorter than the delay over [`RESOLUTION`] are
//! merged into their neighbour such that the input's integral is kept, and a ramp in pieces stays the ramp.

use crate::Error;
use crate::error::finite;
use serde::{Deserialize, Serialize};
use std::collections::VecDeque;

/// Least number of segments the delay can hold before they are merged.
pub const RESOLUTION: f64 = 4096.0;

/// How far a breakpoint may be from the end of a step to be taken as on it, relative to the step.
/// Without this, rounding would leave slivers of 1e-18 s, each an exponential of its own.
const SLIVER: f64 = 1e-9;

/// How far the segments of a saved history may be from the delay in sum, relative to it.
const SAVED_LENGTH: f64 = 1e-6;

/// A time interval over which the input is `value + slope·t`, t from the interval's beginning.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct Segment {
    /// How long, s.
    pub duration: f64,
    /// Input at its beginning.
    pub value: f64,
    /// Derivative of the input, 1/s.
    pub slope: f64,
}

impl Segment {
    /// Takes time off the beginning.
    #[inline]
    fn cut(&mut self, time: f64) {
        self.duration -= time;
        self.value += self.slope * time;
    }

    /// Puts another behind it, with the integral of both.
    fn merge(&mut self, other: &Self) {
        let duration = self.duration + other.duration;
        let mean = |s: &Self| s.value + 0.5 * s.slope * s.duration;
        let over = |a: f64, b: f64| (a * self.duration + b * other.duration) / duration;
        let slope = over(self.slope, other.slope);
        let middle = over(mean(self), mean(other));
        *self = Self { duration, value: middle - 0.5 * slope * duration, slope };
    }
}

/// The saved state of a [`DelayLine`].
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct History {
    segments: VecDeque<Segment>,
    latest: Segment,
}

/// The input's recent history.
#[derive(Debug, Clone, PartialEq)]
pub struct DelayLine {
    delay: f64,
    segments: VecDeque<Segment>,
    /// The last input; without delay, the rest of it.
    latest: Segment,
}

impl DelayLine {
    /// A line whose input has been `value` for ever.
    #[must_use]
    pub fn new(delay: f64, value: f64) -> Self {
        let mut line = Self { delay, segments: VecDeque::new(), latest: Segment::default() };
        line.reset(value);
        line
    }

    /// Forgets: the input has been `value` for ever.
    pub fn reset(&mut self, value: f64) {
        self.segments.clear();
        self.latest = Segment { value, ..Segment::default() };
        if self.delay > 0.0 {
            self.segments.push_back(Segment { duration: self.delay, value, slope: 0.0 });
        }
    }

    /// The delayed input as of now and its derivative, if the input is `present` and grows by `slope`.
    #[inline]
    #[must_use]
    pub fn output(&self, present: f64, slope: f64) -> (f64, f64) {
        self.segments.front().map_or((present, slope), |s| (s.value, s.slope))
    }

    /// The delayed input as far as [`Self::next`] has walked.
    #[inline]
    #[must_use]
    pub fn here(&self) -> f64 {
        self.segments.front().unwrap_or(&self.latest).value
    }

    /// The input is `value + slope·t` for the `step` seconds that [`Self::next`] then walks.
    ///
    /// # Errors
    /// Where the input grows beyond all numbers; it is then as if nothing had been put in.
    #[inline]
    pub fn push(&mut self, step: f64, value: f64, slope: f64) -> Result<(), Error> {
        let end = value + slope * step;
        if !end.is_finite() {
            return Err(Error::Diverged { name: "the input", value: end });
        }
        let segment = Segment { duration: step, value, slope };
        self.latest = segment;
        if self.delay <= 0.0 {
            return Ok(());
        }
        self.end_rounding();
        match self.segments.back_mut() {
            Some(back) if back.value == value && back.slope == 0.0 && slope == 0.0 => {
                back.duration += step;
            }
            Some(back) if back.duration + step <= self.delay / RESOLUTION => back.merge(&segment),
            _ => self.segments.push_back(segment),
        }
        Ok(())
    }

    /// Walks on by at most `limit` seconds over which the delayed input is one ramp; returns that
    /// ramp, as long as it was walked: exactly `limit` where no breakpoint comes before.
    #[inline]
    pub fn next(&mut self, limit: f64) -> Segment {
        loop {
            let last = self.segments.len() <= 1;
            let Some(front) = self.segments.front_mut() else {
                let walked = Segment { duration: limit, ..self.latest };
                self.latest.cut(limit);
                return walked;
            };
            let walked = Segment { duration: limit, ..*front };
            let rest = front.duration - limit;
            if last || rest > SLIVER * limit {
                front.cut(limit);
                // Rounding can make the last one slightly negative.
                front.duration = front.duration.max(0.0);
                return walked;
            }
            let duration = front.duration;
            self.segments.pop_front();
            let on_the_end = rest >= -SLIVER * limit;
            if let Some(next) = self.segments.front_mut()
                && (on_the_end || duration <= 0.0)
            {
                next.cut(if on_the_end { -rest } else { -duration });
            }
            if on_the_end {
                return walked;
            }
            if duration > 0.0 {
                return Segment { duration, ..walked };
            }
        }
    }

    /// Between steps a single segment is as long as the delay, whatever rounding made of it.
    #[inline]
    fn end_rounding(&mut self) {
        if self.segments.len() == 1
            && let Some(only) = self.segments.front_mut()
        {
            only.duration = self.delay;
        }
    }

    /// The state between steps. Saving a restored line returns the same state.
    #[must_use]
    pub fn save(&self) -> History {
        let mut line = self.clone();
        line.end_rounding();
        History { segments: line.segments, latest: line.latest }
    }

    /// Restores the state of a line of the same delay.
    ///
    /// # Errors
    /// Where the history is not one of this delay.
    pub fn restore(&mut self, history: History) -> Result<(), Error> {
        let bad = |name, value, expected| Err(Error::SavedState { name, value, expected });
        for s in history.segments.iter().chain([&history.latest]) {
            finite("a segment of the input's history", &[s.duration, s.value, s.slope])?;
        }
        let number = "the number of segments of the input's history";
        let count = history.segments.len() as f64;
        if count > 2.0 * RESOLUTION + 2.0 {
            return bad(number, count, "at most 8194");
        }
        if history.segments.is_empty() != (self.delay <= 0.0) {
            return bad(number, count, "none without delay and some with one");
        }
        let tolerance = SAVED_LENGTH * self.delay;
        if let Some(s) = history.segments.iter().find(|s| s.duration < -tolerance) {
            return bad("a duration in the input's history", s.duration, "zero or more");
        }
        let length: f64 = history.segments.iter().map(|s| s.duration).sum();
        if history.segments.len() > 1 && (length - self.delay).abs() > tolerance {
            return bad("the length of the input's history", length, "the delay of the input");
        }
        self.segments = history.segments;
        self.latest = history.latest;
        self.end_rounding();
        Ok(())
    }

    /// Segments held.
    #[cfg(test)]
    fn len(&self) -> usize {
        self.segments.len()
    }
}

#[cfg(test)]
mod tests;
