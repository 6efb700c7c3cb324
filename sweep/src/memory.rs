//! Metrics, computed during a run: a few numbers each, no trajectory.

use crate::metric::{Metric, MetricKind, Target};

/// The state of a metric in a run.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Memory {
    count: f64,
    /// Of values, of squares, or of points that count.
    sum: f64,
    /// The extreme, the last value or the time found.
    value: f64,
    first: f64,
    first_time: f64,
    inside: bool,
    target: f64,
}

impl Memory {
    pub(crate) fn new(metric: &Metric, draws: &[f64]) -> Self {
        let value = match metric.kind {
            MetricKind::Minimum | MetricKind::FirstTime | MetricKind::SettlingTime => f64::INFINITY,
            MetricKind::Maximum => f64::NEG_INFINITY,
            _ => 0.0,
        };
        let target = match metric.target {
            Target::Number(number) => number.evaluate(draws),
            _ => 0.0,
        };
        Self { count: 0.0, sum: 0.0, value, first: 0.0, first_time: 0.0, inside: false, target }
    }

    /// Takes the values at a communication point.
    #[inline]
    pub(crate) fn see(&mut self, metric: &Metric, values: &[f64], time: f64, step: f64) {
        // k·step may differ by an ulp from the stated times.
        let slack = 1e-6 * step;
        if time < metric.from - slack || time > metric.to + slack {
            return;
        }
        let target = match metric.target {
            Target::Variable(slot, convert) => convert.apply(values[slot]),
            _ => self.target,
        };
        let mut x = metric.convert.apply(values[metric.slot]) - target;
        if metric.absolute {
            x = x.abs();
        }
        if self.count == 0.0 {
            self.first = x;
            self.first_time = time;
        }
        self.count += 1.0;
        match metric.kind {
            MetricKind::Rms => self.sum += x * x,
            MetricKind::Mean => self.sum += x,
            MetricKind::Minimum => self.value = self.value.min(x),
            MetricKind::Maximum => self.value = self.value.max(x),
            MetricKind::MaxAbs => self.value = self.value.max(x.abs()),
            MetricKind::Final => self.value = x,
            MetricKind::Time => {
                // The value at a point holds until the next.
                if self.inside {
                    self.sum += 1.0;
                }
                // Counted, so that no rounding adds up.
                self.value = self.sum * step;
                self.inside = passes(metric, x);
            }
            MetricKind::FirstTime => {
                if self.value == f64::INFINITY && passes(metric, x) {
                    self.value = time;
                }
            }
            MetricKind::SettlingTime => {
                let scale = if metric.band_is_relative { self.first.abs() / 100.0 } else { 1.0 };
                if x.abs() > metric.band * scale {
                    (self.inside, self.value) = (false, f64::INFINITY);
                } else if !self.inside {
                    (self.inside, self.value) = (true, time - self.first_time);
                }
            }
            MetricKind::Overshoot => self.value = self.value.max(-100.0 * x / self.first),
        }
    }

    /// The result; NaN where the window had no point, or an overshoot had no distance to go.
    pub(crate) fn result(&self, kind: MetricKind) -> f64 {
        if self.count == 0.0 {
            return f64::NAN;
        }
        match kind {
            MetricKind::Rms => (self.sum / self.count).sqrt(),
            MetricKind::Mean => self.sum / self.count,
            MetricKind::Overshoot if self.first == 0.0 => f64::NAN,
            _ => self.value,
        }
    }
}

fn passes(metric: &Metric, x: f64) -> bool {
    metric.above.is_some_and(|bound| x > bound) || metric.below.is_some_and(|bound| x < bound)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::draws::Number;
    use steerwright_host::Linear;

    const STEP: f64 = 0.01;

    fn metric(kind: MetricKind) -> Metric {
        Metric {
            name: "m".into(),
            kind,
            unit: None,
            slot: 1,
            convert: Linear::IDENTITY,
            target: Target::Nothing,
            absolute: false,
            from: 0.0,
            to: 10.0,
            above: None,
            below: None,
            band: 2.0,
            band_is_relative: true,
            at_most: None,
            at_least: None,
            shows: None,
        }
    }

    /// Over 0 s to 10 s.
    fn result(metric: &Metric, signal: impl Fn(f64) -> f64) -> f64 {
        let mut memory = Memory::new(metric, &[1.0]);
        for k in 0..=1000 {
            let time = f64::from(k) * STEP;
            memory.see(metric, &[f64::NAN, signal(time)], time, STEP);
        }
        memory.result(metric.kind)
    }

    fn turn(t: f64) -> f64 {
        2.0 * std::f64::consts::PI * t
    }

    #[test]
    fn of_a_sine_the_values_are_those_of_the_books() {
        let sine = |t: f64| 3.0 * turn(t).sin();
        // The last point is the first of another turn: 1000 of 1001 squares average to a half.
        assert!((result(&metric(MetricKind::Rms), sine) - 3.0 / 2f64.sqrt()).abs() < 2e-3);
        assert!(result(&metric(MetricKind::Mean), sine).abs() < 1e-12);
        assert!((result(&metric(MetricKind::Maximum), sine) - 3.0).abs() < 1e-12);
        assert!((result(&metric(MetricKind::Minimum), sine) + 3.0).abs() < 1e-12);
        let lowered = |t: f64| sine(t) - 1.0;
        assert!((result(&metric(MetricKind::MaxAbs), lowered) - 4.0).abs() < 1e-12);
        assert!((result(&metric(MetricKind::Final), lowered) + 1.0).abs() < 1e-9);
        let time = Metric { above: Some(1.5), ..metric(MetricKind::Time) };
        // A sine is above half its amplitude for a third of the time.
        assert!((result(&time, sine) - 10.0 / 3.0).abs() < 0.1);
        let both = Metric { absolute: true, ..time.clone() };
        assert!((result(&both, sine) - 20.0 / 3.0).abs() < 0.2);
        let first = Metric { kind: MetricKind::FirstTime, ..time };
        assert!((result(&first, sine) - 1.0 / 12.0).abs() < STEP);
        let never = Metric { above: Some(3.5), ..first };
        assert_eq!(result(&never, sine), f64::INFINITY);
    }

    #[test]
    fn a_step_of_second_order_overshoots_and_settles_as_in_the_books() {
        // Damping 0.5 at 2 rad/s.
        let (zeta, omega) = (0.5f64, 2.0f64);
        let damped = omega * (1.0 - zeta * zeta).sqrt();
        let answer = |t: f64| {
            let phase = damped * t;
            1.0 - (-zeta * omega * t).exp() * (phase.cos() + zeta * omega / damped * phase.sin())
        };
        let target = Target::Number(Number::Drawn(0));
        let overshoot = Metric { target, ..metric(MetricKind::Overshoot) };
        let expected = 100.0 * (-std::f64::consts::PI * zeta / (1.0 - zeta * zeta).sqrt()).exp();
        assert!((result(&overshoot, answer) - expected).abs() < 0.01);
        let settling = Metric { target, ..metric(MetricKind::SettlingTime) };
        let last_outside =
            (0..=1000).rev().map(|k| f64::from(k) * STEP).find(|t| (answer(*t) - 1.0).abs() > 0.02);
        assert!((result(&settling, answer) - last_outside.unwrap() - STEP).abs() < 1e-9);
        let narrow = Metric { band: 1e-6, band_is_relative: false, ..settling };
        assert_eq!(result(&narrow, answer), f64::INFINITY);
        assert!(result(&overshoot, |_| 1.0).is_nan(), "no distance to go");
    }

    #[test]
    fn a_window_counts_its_points_alone() {
        let ramp = |t: f64| t;
        let window = Metric { from: 2.0, to: 3.0, ..metric(MetricKind::Mean) };
        assert!((result(&window, ramp) - 2.5).abs() < 1e-12);
        let last = Metric { kind: MetricKind::Final, ..window };
        assert!((result(&last, ramp) - 3.0).abs() < 1e-12);
    }

    #[test]
    fn a_requirement_is_not_met_by_nothing() {
        let required = Metric { at_most: Some(1.0), ..metric(MetricKind::Rms) };
        assert!(required.is_required() && required.is_met(1.0));
        assert!(!required.is_met(1.1) && !required.is_met(f64::NAN));
    }
}
