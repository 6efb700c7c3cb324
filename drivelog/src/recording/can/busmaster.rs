//! Lines of BUSMASTER's logs.

use super::frame::{Frame, Line};
use crate::recording::csv::instants::instant;

/// What a log begins with.
pub(super) const MARK: &str = "***BUSMASTER";
/// What a session begins with, before `30:9:2013 14:53:0:968***`.
const START: &str = "***START DATE AND TIME ";
const DAY_S: f64 = 86_400.0;

/// The number base and the clock of a log.
#[derive(Debug, Default)]
pub(super) struct Busmaster {
    is_decimal: bool,
    mode: Mode,
    time: f64,
    /// The start of the first session and of this one, s since 1970.
    starts: Option<[f64; 2]>,
}

/// What the clock counts from.
#[derive(Debug, Default, Clone, Copy)]
enum Mode {
    #[default]
    Midnight,
    Start,
    LastFrame,
}

impl Busmaster {
    /// `14:53:01:9680 Rx 1 0x19F s 8 01 02 03 04 05 06 07 08`, the clock with tenths of a millisecond; `x` is an
    /// identifier of 29 bits.
    pub(super) fn line(&mut self, line: &str) -> Line {
        match line {
            "***DEC***" => self.is_decimal = true,
            "***HEX***" => self.is_decimal = false,
            "***RELATIVE MODE***" => self.mode = Mode::LastFrame,
            "***ABSOLUTE MODE***" => self.mode = Mode::Start,
            "***SYSTEM MODE***" => self.mode = Mode::Midnight,
            _ => {}
        }
        if let Some(start) = line.strip_prefix(START).and_then(start) {
            let [first, _] = *self.starts.get_or_insert([start; 2]);
            self.starts = Some([first, start]);
            self.time = self.time.max(start - first);
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
        let [first, start] = self.starts.unwrap_or_default();
        self.time = match self.mode {
            Mode::LastFrame => self.time + time,
            Mode::Start => start - first + time,
            Mode::Midnight => {
                let days = (start / DAY_S).floor() - (first / DAY_S).floor();
                let time = time + DAY_S * days;
                // The clock goes on after midnight.
                time + DAY_S * ((self.time - time) / DAY_S).round().max(0.0)
            }
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

/// The instant of `30:9:2013 14:53:0:968***`, s since 1970.
fn start(text: &str) -> Option<f64> {
    let number = |text: &str| text.trim().parse::<u32>().ok();
    let (date, clock) = text.trim_end_matches('*').split_once(' ')?;
    let date = date.split(':').map(number).collect::<Option<Vec<u32>>>()?;
    let clock = clock.split(':').map(number).collect::<Option<Vec<u32>>>()?;
    let (&[day, month, year], &[hours, minutes, seconds, millis]) = (&date[..], &clock[..]) else {
        return None;
    };
    let clock = format!("{hours:02}:{minutes:02}:{seconds:02}.{millis:03}");
    let month = instant(&format!("{year:04}-{month:02}-01 {clock}"))?;
    Some(month + DAY_S * (f64::from(day) - 1.0))
}
