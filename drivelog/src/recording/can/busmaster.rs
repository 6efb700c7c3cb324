//! Lines of BUSMASTER's logs.

use super::frame::{Frame, Line};

/// What a log begins with.
pub(super) const MARK: &str = "***BUSMASTER";
const DAY_S: f64 = 86_400.0;

/// The number base and the clock of a log.
#[derive(Debug, Default)]
pub(super) struct Busmaster {
    is_decimal: bool,
    is_relative: bool,
    time: f64,
}

impl Busmaster {
    /// `14:53:01:9680 Rx 1 0x19F s 8 01 02 03 04 05 06 07 08`, the clock with tenths of a millisecond; `x` is an
    /// identifier of 29 bits.
    pub(super) fn line(&mut self, line: &str) -> Line {
        match line {
            "***DEC***" => self.is_decimal = true,
            "***HEX***" => self.is_decimal = false,
            "***RELATIVE MODE***" => self.is_relative = true,
            "***ABSOLUTE MODE***" | "***SYSTEM MODE***" => self.is_relative = false,
            _ => {}
        }
        if line.is_empty() || line.starts_with("***") {
            return Line::Other;
        }
        self.frame(line).unwrap_or(Line::Fault)
    }

    fn frame(&mut self, line: &str) -> Option<Line> {
        let words: Vec<&str> = line.split_whitespace().collect();
        let [clock, direction, bus, id, kind, count, data @ ..] = &words[..] else { return None };
        let parts = clock.split(':').map(|part| part.parse::<u32>().ok());
        let parts = parts.collect::<Option<Vec<u32>>>()?;
        let &[hours, minutes, seconds, tenths] = &parts[..] else { return None };
        let whole = 3600.0 * f64::from(hours) + 60.0 * f64::from(minutes) + f64::from(seconds);
        let time = whole + 1e-4 * f64::from(tenths);
        if !matches!(*direction, "Rx" | "Tx") {
            return None;
        }
        self.time = if self.is_relative {
            self.time + time
        } else {
            // The clock goes on after midnight.
            time + DAY_S * ((self.time - time) / DAY_S).round().max(0.0)
        };
        let radix = if self.is_decimal { 10 } else { 16 };
        let number =
            |text: &str| u32::from_str_radix(text.strip_prefix("0x").unwrap_or(text), radix).ok();
        let is_extended = match *kind {
            "s" => false,
            "x" => true,
            // Requests and errors.
            _ => return Some(Line::Other),
        };
        let data = data.get(..count.parse::<usize>().ok()?)?;
        let data = data.iter().map(|byte| u8::try_from(number(byte)?).ok());
        let (time, bus, id) = (self.time, (*bus).to_owned(), number(id)?);
        let data = data.collect::<Option<_>>()?;
        Some(Line::Frame(Frame { time, bus, id, is_extended, data, is_request: false }))
    }
}
