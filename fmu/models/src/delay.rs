//! A pure delay, in seconds, of an input that is held over steps of any size.
//!
//! The input's history is a belt of segments (how long, which value), oldest first, whose length
//! is always the delay: a step puts its own segment on one end and takes as much time off the
//! other. All times are durations, so nothing is lost however long the simulation runs. The belt
//! is bounded: segments shorter than the delay over [`RESOLUTION`] are merged into their
//! neighbour, value averaged over time, so that the input's integral is kept.

use std::collections::VecDeque;

/// Least number of segments the delay can hold before they are merged.
pub const RESOLUTION: f64 = 4096.0;

/// How far a breakpoint may be from the end of a step to be taken as on it, relative to the step.
/// Without this, rounding would leave slivers of 1e-18 s, each an exponential of its own.
const SLIVER: f64 = 1e-9;

#[derive(Debug, Clone, Copy, PartialEq)]
struct Segment {
    duration: f64,
    value: f64,
}

/// The input's recent history.
#[derive(Debug, Clone, PartialEq)]
pub struct DelayLine {
    delay: f64,
    segments: VecDeque<Segment>,
    latest: f64,
}

impl DelayLine {
    /// A line whose input has been `value` for ever.
    #[must_use]
    pub fn new(delay: f64, value: f64) -> Self {
        let mut line = Self { delay, segments: VecDeque::new(), latest: value };
        line.reset(value);
        line
    }

    /// Forgets: the input has been `value` for ever.
    pub fn reset(&mut self, value: f64) {
        self.segments.clear();
        self.latest = value;
        if self.delay > 0.0 {
            self.segments.push_back(Segment { duration: self.delay, value });
        }
    }

    /// The delayed input as of now, if the input at this moment is `present`.
    #[must_use]
    pub fn output(&self, present: f64) -> f64 {
        self.segments.front().map_or(present, |s| s.value)
    }

    /// The input is `value` for the `step` seconds to come, which [`Self::next`] then walks.
    pub fn push(&mut self, step: f64, value: f64) {
        self.latest = value;
        if self.delay <= 0.0 {
            return;
        }
        let resolution = self.delay / RESOLUTION;
        match self.segments.back_mut() {
            Some(back) if back.value == value => back.duration += step,
            Some(back) if back.duration + step <= resolution => {
                let duration = back.duration + step;
                back.value = (back.value * back.duration + value * step) / duration;
                back.duration = duration;
            }
            _ => self.segments.push_back(Segment { duration: step, value }),
        }
    }

    /// Walks on by at most `limit` seconds over which the delayed input is constant; returns how
    /// far (exactly `limit` where no breakpoint comes before) and the delayed input there.
    pub fn next(&mut self, limit: f64) -> (f64, f64) {
        loop {
            let last = self.segments.len() <= 1;
            let Some(front) = self.segments.front_mut() else { return (limit, self.latest) };
            let value = front.value;
            let rest = front.duration - limit;
            if rest.abs() <= SLIVER * limit && !last {
                self.segments.pop_front();
                if let Some(next) = self.segments.front_mut() {
                    next.duration += rest;
                }
                return (limit, value);
            }
            if rest > 0.0 {
                front.duration = rest;
                return (limit, value);
            }
            let duration = front.duration;
            self.segments.pop_front();
            if duration > 0.0 {
                return (duration.min(limit), value);
            }
        }
    }

    /// Segments held.
    #[cfg(test)]
    fn len(&self) -> usize {
        self.segments.len()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// Integral of the delayed input over each step, by walking.
    fn walk(line: &mut DelayLine, step: f64, value: f64) -> Vec<(f64, f64)> {
        line.push(step, value);
        let (mut left, mut pieces) = (step, Vec::new());
        while left > 0.0 {
            let (piece, u) = line.next(left);
            pieces.push((piece, u));
            left -= piece;
        }
        pieces
    }

    proptest! {
        /// Against the definition: the value that was set `delay` ago.
        #[test]
        fn is_the_input_of_a_while_ago(
            delay in 0.001..0.5_f64,
            steps in prop::collection::vec((0.001..0.1_f64, -3..3_i32), 1..200),
        ) {
            let mut line = DelayLine::new(delay, 9.0);
            let mut history = vec![(-delay, 9.0)];
            let mut time = 0.0;
            for (step, value) in steps {
                let value = f64::from(value);
                history.push((time, value));
                for (piece, u) in walk(&mut line, step, value) {
                    let middle = time + piece / 2.0 - delay;
                    let expected = history.iter().rev().find(|(t, _)| *t <= middle).unwrap().1;
                    if piece > 1e-9 {
                        prop_assert_eq!(u, expected);
                    }
                    time += piece;
                }
            }
        }
    }

    #[test]
    fn steps_on_the_grid_leave_no_slivers() {
        let mut line = DelayLine::new(0.05, 0.0);
        for k in 0..100_000 {
            let value = f64::from(k % 97);
            let pieces = walk(&mut line, 0.01, value);
            assert_eq!(pieces.len(), 1);
            assert_eq!(pieces[0].0, 0.01);
            if k >= 5 {
                assert_eq!(pieces[0].1, f64::from((k - 5) % 97));
            }
        }
    }

    #[test]
    fn bounded_and_keeps_the_integral() {
        let mut line = DelayLine::new(1.0, 0.0);
        let (mut into, mut out) = (0.0, 0.0);
        for k in 0..300_000 {
            let value = f64::from(k % 7);
            into += value * 1e-5;
            out += walk(&mut line, 1e-5, value).iter().map(|(t, u)| t * u).sum::<f64>();
            assert!(line.len() <= 2 * RESOLUTION as usize + 2);
        }
        out += walk(&mut line, 1.0, 0.0).iter().map(|(t, u)| t * u).sum::<f64>();
        assert!((into - out).abs() < 1e-9, "{into} {out}");
    }

    #[test]
    fn without_delay_the_input_passes() {
        let mut line = DelayLine::new(0.0, 0.0);
        assert_eq!(walk(&mut line, 0.01, 3.0), [(0.01, 3.0)]);
        assert_eq!(line.output(4.0), 4.0);
    }
}
