//! The command's recent history: a pure delay, in seconds, of an input that is held or ramped.
//!
//! Like [`crate::delay`] a belt of pieces, oldest first, whose length is always the delay, but each
//! piece is a line, since the input may grow within a step. Pieces shorter than the delay over
//! [`RESOLUTION`] are merged into their neighbour, which keeps the
//! input's integral and bounds the belt.

use super::actuator::Line;
use super::parameters::within;
use crate::delay::RESOLUTION;
use crate::error::Error;
use serde::{Deserialize, Serialize};
use std::collections::VecDeque;

/// How far a breakpoint may be from the end of a step to be taken as on it, relative to the step.
const SLIVER: f64 = 1e-9;

/// More pieces than a belt ever holds: one of every two neighbours is longer than the delay over
/// [`RESOLUTION`].
const MOST_PIECES: usize = 2 * RESOLUTION as usize + 8;

/// What the command was within the delay.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct History {
    delay: f64,
    /// Duration, start, slope.
    pieces: VecDeque<(f64, f64, f64)>,
}

impl History {
    /// The input has been `value` for ever.
    #[must_use]
    pub fn new(delay: f64, value: f64) -> Self {
        let mut pieces = VecDeque::new();
        if delay > 0.0 {
            pieces.push_back((delay, value, 0.0));
        }
        Self { delay, pieces }
    }

    /// Forgets: the input has been `value` for ever.
    pub fn reset(&mut self, delay: f64, value: f64) {
        self.delay = delay;
        self.pieces.clear();
        if delay > 0.0 {
            self.pieces.push_back((delay, value, 0.0));
        }
    }

    /// The delayed input as of now, if the input at this moment is `present`.
    #[must_use]
    pub fn output(&self, present: f64) -> f64 {
        self.pieces.front().map_or(present, |piece| piece.1)
    }

    /// The input is that line for its duration to come, which [`Self::next`] then walks.
    pub fn push(&mut self, line: Line) {
        let Line { duration: step, start, slope } = line;
        let resolution = self.delay / RESOLUTION;
        match self.pieces.back_mut() {
            Some((duration, value, 0.0)) if *value == start && slope == 0.0 => *duration += step,
            Some((duration, value, back_slope)) if *duration + step <= resolution => {
                let sum = *duration * (*value + 0.5 * *back_slope * *duration)
                    + step * (start + 0.5 * slope * step);
                *duration += step;
                (*value, *back_slope) = (sum / *duration, 0.0);
            }
            _ => self.pieces.push_back((step, start, slope)),
        }
    }

    /// Walks on by at most `limit` seconds over which the delayed input is one line.
    pub fn next(&mut self, limit: f64) -> Option<Line> {
        loop {
            let last = self.pieces.len() <= 1;
            let front = self.pieces.front_mut()?;
            let (duration, start, slope) = *front;
            let rest = duration - limit;
            if rest.abs() <= SLIVER * limit && !last {
                self.pieces.pop_front();
                if let Some(next) = self.pieces.front_mut() {
                    // A hair is put on the next piece, or taken off it.
                    next.0 += rest;
                    next.1 -= next.2 * rest;
                }
                return Some(Line { duration: limit, start, slope });
            }
            if rest > 0.0 {
                (front.0, front.1) = (rest, start + slope * limit);
                return Some(Line { duration: limit, start, slope });
            }
            self.pieces.pop_front();
            if duration > 0.0 {
                return Some(Line { duration: duration.min(limit), start, slope });
            }
        }
    }

    /// Checks what was read from outside.
    pub(super) fn check(&self, delay: f64) -> Result<(), Error> {
        let name = "the delay of the saved command";
        within(name, self.delay, delay, delay)?;
        let count = self.pieces.len();
        if count > MOST_PIECES || (delay > 0.0) != (count > 0) {
            let need = if delay > 0.0 { MOST_PIECES } else { 0 };
            return Err(Error::Shape { name: "the saved command", got: count, need });
        }
        let mut total = 0.0;
        for &(duration, start, slope) in &self.pieces {
            // A hair below 0 is left where a breakpoint was taken as on the end of a step.
            within("a duration of the saved command", duration, -SLIVER * 3600.0, f64::MAX)?;
            for value in [start, slope] {
                within("a value of the saved command", value, f64::MIN, f64::MAX)?;
            }
            total += duration;
        }
        within("the length of the saved command", total, delay - 1e-3, delay + 1e-3)
    }
}
