//! Lines of Kvaser's logs in text: those of CanKing, and those of the Memorator converter.

use super::frame::{Frame, Line};

/// The header of a log of CanKing, and that of the Memorator converter.
const CAN_KING: [&str; 3] = ["Chn", "Identifier", "Flg"];
const MEMORATOR: [&str; 4] = ["Time", "Chan", "Identifier", "Flags"];

/// Which of the two logs it is, and its number bases.
#[derive(Debug)]
pub(super) struct Kvaser {
    is_memorator: bool,
    /// Whether identifiers and bytes are hexadecimal, which the Memorator converter states.
    is_hex: [bool; 2],
}

impl Default for Kvaser {
    fn default() -> Self {
        Self { is_memorator: false, is_hex: [true; 2] }
    }
}

/// Whether the line is the header of the frames, or the first line of a log of the Memorator converter.
pub(super) fn is_header(line: &str) -> bool {
    let words: Vec<&str> = line.split_whitespace().collect();
    words.starts_with(&CAN_KING) || words.starts_with(&MEMORATOR) || line == "Kvaser Memorator Log"
}

impl Kvaser {
    pub(super) fn line(&mut self, line: &str) -> Line {
        let words: Vec<&str> = line.split_whitespace().collect();
        match &words[..] {
            ["Format", "of", what, "field:", base] => {
                self.is_hex[usize::from(*what == "data")] = *base == "HEX";
                return Line::Other;
            }
            _ if words.starts_with(&MEMORATOR) => {
                self.is_memorator = true;
                return Line::Other;
            }
            // Text around the frames, such as `Logging stopped.`, and triggers.
            [first, ..] if first.parse::<f64>().is_err() => return Line::Other,
            [] | [_, "Trigger", ..] => return Line::Other,
            _ => {}
        }
        let read = if self.is_memorator { self.of_memorator(&words) } else { of_can_king(&words) };
        read.unwrap_or(Line::Fault)
    }

    /// `1.059900  1  123 Rx  2 AB 01  17`: time, channel, identifier, flags, length, data, counter.
    fn of_memorator(&self, words: &[&str]) -> Option<Line> {
        let [time, channel, id, rest @ ..] = words else { return None };
        let radix = self.is_hex.map(|is_hex| if is_hex { 16 } else { 10 });
        frame(time, channel, (id, radix[0]), rest, radix[1])
    }
}

/// ` 0  0000014B X  1  00  1675.570498 T`: channel, identifier, flags, length, data, time, direction. Identifiers of eight
/// digits are hexadecimal, and so are the bytes then; the program states no base.
fn of_can_king(words: &[&str]) -> Option<Line> {
    let [channel, id, rest @ .., time, direction] = words else { return None };
    if !matches!(*direction, "R" | "T") {
        return None;
    }
    let radix = if id.len() == 8 { 16 } else { 10 };
    frame(time, channel, (id, radix), rest, radix)
}

fn frame(time: &str, bus: &str, id: (&str, u32), rest: &[&str], radix: u32) -> Option<Line> {
    let time = time.parse::<f64>().ok().filter(|time| time.is_finite())?;
    bus.parse::<u32>().ok()?;
    let (id, base) = id;
    let length = rest.iter().position(|word| word.bytes().all(|b| b.is_ascii_digit()));
    let flags = &rest[..length.unwrap_or(rest.len())];
    let has = |flag: &str| flags.iter().any(|own| own.eq_ignore_ascii_case(flag));
    if has("R")
        || id.eq_ignore_ascii_case("ErrorFrame")
        || flags.iter().any(|f| f.to_ascii_lowercase().contains("error"))
    {
        return Some(Line::Other);
    }
    let length = length?;
    let number = id.trim_end_matches(['x', 'X']);
    let is_extended = has("X") || number.len() < id.len();
    let id = u32::from_str_radix(number, base).ok()?;
    let count = rest[length].parse::<usize>().ok()?;
    let data = rest.get(length + 1..length + 1 + count)?;
    let data = data.iter().map(|byte| u8::from_str_radix(byte, radix).ok());
    let is_extended = is_extended || id > 0x7FF;
    let (bus, data) = (bus.to_owned(), data.collect::<Option<_>>()?);
    Some(Line::Frame(Frame { time, bus, id, is_extended, data, is_request: false }))
}
