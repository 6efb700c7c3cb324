//! One axis: its range, where its ticks are and how they are written.
//!
//! Ticks stand at 1, 2 or 5 times a power of ten (logarithmic: at powers of ten, and at 2 and 5
//! between them where there is room).

/// A range of finite numbers, `low < high`, mapped linearly or by the logarithm to 0…1.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Axis {
    pub(crate) low: f64,
    pub(crate) high: f64,
    pub(crate) log: bool,
}

/// A tick; `text` is empty for a line of the grid without a number.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Tick {
    pub(crate) at: f64,
    pub(crate) text: String,
}

/// Larger numbers are left out: their differences overflow.
const LARGEST: f64 = 1e150;

/// Whether a value can stand on an axis of this kind.
pub(crate) fn drawable(value: f64, log: bool) -> bool {
    value.is_finite() && value.abs() <= LARGEST && (!log || value > 1e-150)
}

impl Axis {
    /// The range of the values, a little wider by `padding` of its length; equal values get a range
    /// about them. `None` where no value can be drawn.
    pub(crate) fn around(
        values: impl Iterator<Item = f64>,
        padding: f64,
        log: bool,
    ) -> Option<Self> {
        let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
        for value in values.filter(|v| drawable(*v, log)) {
            low = low.min(value);
            high = high.max(value);
        }
        if low > high {
            return None;
        }
        let (mut a, mut b) = if log { (low.ln(), high.ln()) } else { (low, high) };
        // A difference in the last digits only is noise of the arithmetic, not a range.
        if b - a <= 1e-9 * a.abs().max(b.abs()) {
            let about = if log { 1.0 } else { (0.1 * a.abs()).max(1e-3) };
            (a, b) = (a - about, b + about);
        } else {
            let more = padding * (b - a);
            (a, b) = (a - more, b + more);
        }
        let (low, high) = if log { (a.exp(), b.exp()) } else { (a, b) };
        Some(Self { low, high, log })
    }

    /// The position of a value: 0 at the low end, 1 at the high one.
    pub(crate) fn fraction(&self, value: f64) -> f64 {
        if self.log {
            (value / self.low).ln() / (self.high / self.low).ln()
        } else {
            (value - self.low) / (self.high - self.low)
        }
    }

    /// Widens a linear axis about its middle to `length`.
    pub(crate) fn widened(&self, length: f64) -> Self {
        let middle = 0.5 * (self.low + self.high);
        Self { low: middle - 0.5 * length, high: middle + 0.5 * length, log: self.log }
    }

    /// About `count` ticks within the range.
    pub(crate) fn ticks(&self, count: usize) -> Vec<Tick> {
        if self.log { self.log_ticks(count) } else { self.linear_ticks(count) }
    }

    fn linear_ticks(&self, count: usize) -> Vec<Tick> {
        let step = nice_step((self.high - self.low) / count.max(2) as f64);
        let first = (self.low / step - 1e-9).ceil();
        let last = (self.high / step + 1e-9).floor();
        (0..=((last - first).max(0.0) as usize).min(50))
            .map(|k| {
                let at = (first + k as f64) * step;
                Tick { at, text: number(at, step) }
            })
            .collect()
    }

    fn log_ticks(&self, count: usize) -> Vec<Tick> {
        let (first, last) = (self.low.log10().floor() as i32, self.high.log10().ceil() as i32);
        let decades = (self.high / self.low).log10();
        let every = ((decades / count.max(2) as f64).ceil() as i32).max(1);
        let mut ticks = Vec::new();
        for exponent in first..=last {
            if (exponent - first) % every != 0 {
                continue;
            }
            let minor: &[u8] = if every == 1 { &[1, 2, 3, 4, 5, 6, 7, 8, 9] } else { &[1] };
            for digit in minor {
                let unit = 10f64.powi(exponent);
                let at = f64::from(*digit) * unit;
                let named =
                    *digit == 1 || (3.0 * decades <= count as f64 && matches!(digit, 2 | 5));
                if at >= self.low * (1.0 - 1e-9) && at <= self.high * (1.0 + 1e-9) {
                    let text = if named { number(at, unit) } else { String::new() };
                    ticks.push(Tick { at, text });
                }
            }
        }
        ticks
    }
}

/// The next of 1, 2, 5 times a power of ten.
fn nice_step(rough: f64) -> f64 {
    let unit = 10f64.powf(rough.log10().floor());
    let nice = [1.0, 2.0, 5.0].into_iter().find(|m| m * unit >= rough * (1.0 - 1e-9));
    nice.unwrap_or(10.0) * unit
}

/// A number with the digits that a multiple of `step` needs, and a proper minus sign.
fn number(value: f64, step: f64) -> String {
    let value = if value.abs() < 1e-9 * step { 0.0 } else { value };
    let text = if value != 0.0 && (value.abs() >= 1e6 || step < 0.99e-4) {
        let digits = (value.abs().log10().floor() - step.log10().floor()).clamp(0.0, 9.0) as usize;
        format!("{value:.digits$e}")
    } else {
        let digits = (-(step * 1.000_001).log10().floor()).clamp(0.0, 9.0) as usize;
        format!("{value:.digits$}")
    };
    text.replace('-', "−")
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn texts(low: f64, high: f64, log: bool) -> Vec<String> {
        Axis { low, high, log }.ticks(5).into_iter().map(|t| t.text).collect()
    }

    #[test]
    fn ticks_are_round_numbers() {
        assert_eq!(texts(-0.31, 0.42, false), ["−0.2", "0.0", "0.2", "0.4"]);
        assert_eq!(texts(0.0, 300.0, false), ["0", "100", "200", "300"]);
        assert_eq!(texts(149.99, 449.99, false), ["200", "300", "400"]);
        let decades: Vec<_> =
            texts(0.05, 20.0, true).into_iter().filter(|t| !t.is_empty()).collect();
        assert_eq!(decades, ["0.1", "1", "10"]);
        let within: Vec<_> = texts(0.9, 6.0, true).into_iter().filter(|t| !t.is_empty()).collect();
        assert_eq!(within, ["1", "2", "5"]);
    }

    #[test]
    fn equal_values_get_a_range() {
        let axis = Axis::around([3.0, 3.0].into_iter(), 0.05, false).unwrap();
        assert!(axis.low < 3.0 && axis.high > 3.0);
        let axis = Axis::around([0.0].into_iter(), 0.05, false).unwrap();
        assert!(axis.low < 0.0 && axis.high > 0.0);
        assert_eq!(Axis::around([f64::NAN].into_iter(), 0.05, false), None);
        assert_eq!(Axis::around([-1.0, 0.0].into_iter(), 0.05, true), None);
    }

    proptest! {
        #[test]
        fn every_range_has_few_ticks_inside_it(
            a in -1e12..1e12f64, scale in -12..12i32, log: bool
        ) {
            let width = 10f64.powi(scale);
            let (low, high) = if log { (width, width * 37.0) } else { (a, a + width) };
            let Some(axis) = Axis::around([low, high].into_iter(), 0.04, log) else {
                return Ok(());
            };
            let ticks = axis.ticks(6);
            prop_assert!(ticks.len() <= 51);
            prop_assert!(!ticks.is_empty());
            for tick in ticks {
                let f = axis.fraction(tick.at);
                prop_assert!((-1e-3..=1.001).contains(&f), "{tick:?} at {f}");
            }
        }
    }
}
