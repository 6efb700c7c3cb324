//! Lines of Vector's ASC.

use super::frame::{Frame, Line};
use std::collections::BTreeMap;
use std::rc::Rc;

/// Identifiers of messages by their names, and whether they are extended.
pub(super) type Names = Rc<BTreeMap<String, (u32, bool)>>;

/// The number bases and the clock of an ASC file.
#[derive(Debug)]
pub(super) struct Asc {
    is_hex: bool,
    is_relative: bool,
    time: f64,
    /// Of the databases, by which symbolic logs are read.
    pub(super) names: Names,
}

impl Default for Asc {
    fn default() -> Self {
        Self { is_hex: true, is_relative: false, time: 0.0, names: Names::default() }
    }
}

impl Asc {
    pub(super) fn line(&mut self, line: &str) -> Line {
        let words: Vec<&str> = line.split_whitespace().collect();
        if let ["base", base, rest @ ..] = &words[..] {
            self.is_hex = *base == "hex";
            self.is_relative = rest.contains(&"relative");
            return Line::Other;
        }
        // Some tools write the clock with a decimal comma.
        let number = |t: &&str| t.parse().or_else(|_| t.replace(',', ".").parse::<f64>()).ok();
        let Some(time) = words.first().and_then(number) else {
            // Header, comments, blocks of triggers.
            return Line::Other;
        };
        if !time.is_finite() {
            return Line::Fault;
        }
        self.time = if self.is_relative { self.time + time } else { time };
        match &words[1..] {
            ["CANFD", rest @ ..] => self.fd(rest),
            [bus, id, direction, "d", length, data @ ..]
                if bus.parse::<u32>().is_ok() && matches!(*direction, "Rx" | "Tx" | "TxRq") =>
            {
                match self.frame(bus, id, length, data) {
                    Line::Frame(frame) => {
                        Line::Frame(Frame { is_request: *direction == "TxRq", ..frame })
                    }
                    other => other,
                }
            }
            // Remote frames, errors, statistics, events.
            _ => Line::Other,
        }
    }

    /// `CANFD BUS Rx ID NAME BRS ESI DLC LENGTH DATA …`; the name may be left out.
    fn fd(&self, words: &[&str]) -> Line {
        let [bus, _, id, rest @ ..] = words else { return Line::Fault };
        // A name is there where the next word is no flag.
        let rest = match rest {
            [flag, other, ..] if matches!(*flag, "0" | "1") && matches!(*other, "0" | "1") => rest,
            [_, rest @ ..] => rest,
            [] => return Line::Fault,
        };
        let [_, _, _, length, data @ ..] = rest else { return Line::Fault };
        let Ok(count) = length.parse::<usize>() else { return Line::Fault };
        self.frame_line(bus, self.identifier(id), count, data)
    }

    /// The identifier of a number, or of the name of a message, which may have the letters of a number.
    fn identifier(&self, text: &str) -> Option<(u32, bool)> {
        self.names.get(text).copied().or_else(|| identifier(text, self.radix()))
    }

    fn frame(&self, bus: &str, id: &str, length: &str, data: &[&str]) -> Line {
        let Ok(count) = usize::from_str_radix(length, 16) else { return Line::Fault };
        // Behind the data the identifier is in decimal digits, also where a name is in its place.
        let stated = data.windows(3).find(|words| words[..2] == ["ID", "="]);
        let id = match stated.and_then(|words| identifier(words[2], 10)) {
            Some(stated) => Some(stated),
            None => self.identifier(id),
        };
        self.frame_line(bus, id, count.min(8), data)
    }

    fn radix(&self) -> u32 {
        if self.is_hex { 16 } else { 10 }
    }

    fn frame_line(&self, bus: &str, id: Option<(u32, bool)>, count: usize, data: &[&str]) -> Line {
        let byte = |text: &&str| u8::from_str_radix(text, self.radix()).ok();
        let data = data.get(..count).and_then(|data| data.iter().map(byte).collect());
        match (id, data) {
            (Some((id, is_extended)), Some(data)) => {
                let (time, bus) = (self.time, bus.to_owned());
                Line::Frame(Frame { time, bus, id, is_extended, data, is_request: false })
            }
            _ => Line::Fault,
        }
    }
}

/// An identifier and whether it is extended, which an `x` behind it states.
fn identifier(text: &str, radix: u32) -> Option<(u32, bool)> {
    let number = text.trim_end_matches(['x', 'X']);
    Some((u32::from_str_radix(number, radix).ok()?, number.len() < text.len()))
}
