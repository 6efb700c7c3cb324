//! Ticks of a sampled system, at `t0 + k·Ts`, inside a communication step of any size.
//!
//! Counting from absolute time fails: an importer that accumulates `t += h` is 1.4e-5 s off after 1e7
//! steps of 0.01 s, and one that computes `k·h` changes `h` by an ulp from step to step. So only a phase
//! is kept, `phase += h/Ts`, snapped to the integer when it is within [`SNAP`] of it.

use crate::Error;
use serde::{Deserialize, Serialize};

/// How near to a tick the phase is taken to be on it, in periods.
pub const SNAP: f64 = 1e-6;

/// The time since the last tick, in periods.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct Ticks {
    phase: f64,
}

impl Ticks {
    /// A counter that stands exactly on a tick.
    #[must_use]
    pub const fn new() -> Self {
        Self { phase: 0.0 }
    }

    /// Time since the last tick, in periods: 0 on a tick, below 1.
    #[must_use]
    pub const fn phase(&self) -> f64 {
        self.phase
    }

    /// Moves on by a step of `h_over_ts` periods; returns how many ticks lie in (t, t+h].
    #[inline]
    pub fn advance(&mut self, h_over_ts: f64) -> u64 {
        let phase = self.phase + h_over_ts;
        let nearest = nearest_integer(phase);
        // Never snapped back to 0: steps far below a period still get somewhere.
        let phase = if nearest >= 1.0 && (phase - nearest).abs() <= SNAP { nearest } else { phase };
        let ticks = if nearest > phase { nearest - 1.0 } else { nearest };
        self.phase = phase - ticks;
        ticks as u64
    }

    /// Refuses a phase that no counter can have.
    ///
    /// # Errors
    /// Where the phase is not in [0, 1).
    pub fn check(&self) -> Result<(), Error> {
        if (0.0..1.0).contains(&self.phase) {
            return Ok(());
        }
        let name = "the phase of the ticks";
        Err(Error::SavedState { name, value: self.phase, expected: "0 or more and less than 1" })
    }
}

/// The integer nearest to a number that is not negative.
#[inline]
fn nearest_integer(x: f64) -> f64 {
    // Without the instruction for it, `round` is a call for each tick of a controller.
    const UNIT_STEPS: f64 = 4_503_599_627_370_496.0;
    if x < 0.5 * UNIT_STEPS { (x + UNIT_STEPS) - UNIT_STEPS } else { x.round() }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn ten_million_steps_lose_no_tick() {
        for rate in [100.0, 60.0] {
            let ts: f64 = 1.0 / rate;
            let mut ticks = Ticks::new();
            for k in 0..10_000_000_u64 {
                assert_eq!(ticks.advance(ts / ts), 1, "step {k} at {rate} Hz");
            }
        }
    }

    /// h taken from differences of absolute times, as importers do it.
    #[test]
    fn importers_by_product_and_by_sum() {
        for (rate, per_tick) in [(100.0, 1_u64), (60.0, 1), (100.0, 4), (60.0, 7)] {
            let ts: f64 = 1.0 / rate;
            let h = ts / per_tick as f64;
            let (mut by_product, mut by_sum) = (Ticks::new(), Ticks::new());
            let mut t = 0.0;
            for k in 0..10_000_000_u64 {
                let product = (k + 1) as f64 * h - k as f64 * h;
                let next = t + h;
                let due = u64::from((k + 1).is_multiple_of(per_tick));
                assert_eq!(by_product.advance(product / ts), due, "step {k}, h = {h}");
                assert_eq!(by_sum.advance((next - t) / ts), due, "step {k}, h = {h}");
                t = next;
            }
        }
    }

    /// Whatever side of the period an importer's steps round to, and however often it changes.
    #[test]
    fn steps_an_ulp_apart() {
        for rate in [100.0, 60.0] {
            let ts: f64 = 1.0 / rate;
            let steps = [ts, ts.next_up(), ts.next_down(), ts.next_up().next_up()];
            let (mut ticks, mut random) = (Ticks::new(), 1_u64);
            for k in 0..10_000_000_u64 {
                random = random.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
                let h = steps[(random >> 62) as usize];
                assert_eq!(ticks.advance(h / ts), 1, "step {k} at {rate} Hz");
            }
        }
    }

    #[test]
    fn phases_that_cannot_be_are_refused() {
        for phase in [-0.1, 1.0, f64::NAN, f64::INFINITY] {
            assert!(Ticks { phase }.check().is_err(), "{phase}");
        }
        assert!(Ticks { phase: 0.999 }.check().is_ok());
    }

    /// 60 Hz in integer nanoseconds, which cannot hold 1/60 s.
    #[test]
    fn nanosecond_clock() {
        let mut ticks = Ticks::new();
        for _ in 0..1_000_000 {
            assert_eq!(ticks.advance(0.016_666_667 * 60.0), 1);
        }
    }

    #[test]
    fn long_and_tiny_steps() {
        let mut ticks = Ticks::new();
        assert_eq!(ticks.advance(2.5), 2);
        assert_eq!(ticks.phase(), 0.5);
        assert_eq!(ticks.advance(2.5), 3);
        assert_eq!(ticks.phase(), 0.0);
        let mut seen = 0;
        for _ in 0..20_000_000 {
            seen += ticks.advance(1e-7);
        }
        assert_eq!(seen, 2);
    }

    proptest! {
        #[test]
        fn ticks_are_the_floor_of_the_time(steps in prop::collection::vec(0.001..7.0_f64, 1..200)) {
            let mut ticks = Ticks::new();
            let (mut counted, mut time) = (0, 0.0);
            for step in steps {
                counted += ticks.advance(step);
                time += step;
            }
            prop_assert!((counted as f64 + ticks.phase() - time).abs() < 1e-3);
            prop_assert!(ticks.phase() >= 0.0 && ticks.phase() < 1.0);
        }
    }
}
