//! Lines of candump of SocketCAN.

use super::frame::{Frame, Line};
use crate::recording::csv::instants::instant;

/// `(1436509052.249713) can0 044#2A366C2B7F`, with `##` and flags for CAN FD, or in columns
/// `(1436509052.249713)  can0  044   [5]  2A 36 6C 2B 7F`. The time may be a date (`-t A`); flags of the direction
/// (`-x`) and a column of text (`-a`) are no data.
pub(super) fn candump(line: &str) -> Line {
    if line.is_empty() || line.starts_with('#') {
        return Line::Other;
    }
    if line.contains('\x1b') {
        return candump(without_colours(line).trim());
    }
    let parsed = (|| {
        let (stamp, rest) = line.strip_prefix('(')?.split_once(')')?;
        let time = stamp.trim().parse::<f64>().ok().or_else(|| instant(stamp.trim()))?;
        let mut words = rest.split_whitespace();
        let bus = words.next()?;
        let mut word = words.next()?;
        if matches!(word, "RX" | "TX") {
            word = words.nth(2)?;
        }
        let (id, data) = match word.split_once('#') {
            Some((_, data)) if data.starts_with('R') => return Some(Line::Other),
            Some((id, data)) => {
                let data = data.strip_prefix('#').map_or(Some(data), |fd| fd.get(1..))?;
                // A length of 9 to 15 with 8 bytes.
                (id, data.split('_').next().unwrap_or_default().replace('.', ""))
            }
            None => {
                let count = words.next()?.strip_prefix('[')?.strip_suffix(']')?;
                let count = count.trim().parse::<usize>().ok()?;
                let rest: Vec<&str> = words.clone().collect();
                if rest.first() == Some(&"remote") {
                    return Some(Line::Other);
                }
                (word, digits(&rest, count)?)
            }
        };
        let number = u32::from_str_radix(id, 16).ok()?;
        if number & 0x2000_0000 != 0 && id.len() > 3 {
            // An error of the bus.
            return Some(Line::Other);
        }
        let (id, is_extended, data) = (number, id.len() > 3, bytes(&data)?);
        let frame = Frame { time, bus: bus.into(), id, is_extended, data, is_request: false };
        if time.is_finite() { Some(Line::Frame(frame)) } else { None }
    })();
    parsed.unwrap_or(Line::Fault)
}

/// A line of `candump -c` without the sequences that colour it on a terminal: ESC, `[`, numbers and a letter.
fn without_colours(line: &str) -> String {
    let mut parts = line.split('\x1b');
    let mut plain = parts.next().unwrap_or_default().to_owned();
    for part in parts {
        let end = part.find(|c: char| c.is_ascii_alphabetic()).map_or(part.len(), |at| at + 1);
        plain += &part[end..];
    }
    plain
}

/// The hexadecimal digits of so many bytes in columns, which may be binary (`-i`) or in reverse with marks between them
/// (`-S`).
fn digits(words: &[&str], count: usize) -> Option<String> {
    if let [swapped, ..] = words
        && swapped.contains('`')
    {
        let bytes: Vec<&str> = swapped.split('`').rev().collect();
        return digits(&bytes, count);
    }
    let hex = |byte: &&str| match byte.len() {
        2 => Some((*byte).to_owned()),
        8 => Some(format!("{:02X}", u8::from_str_radix(byte, 2).ok()?)),
        _ => None,
    };
    words.get(..count)?.iter().map(hex).collect()
}

/// Whether the line is one of candump without `-t`.
pub(super) fn has_no_time(line: &str) -> bool {
    !line.starts_with('(') && matches!(candump(&format!("(0) {line}")), Line::Frame(_))
}

/// The bytes that digits state, of which CAN FD has at most 64.
pub(super) fn bytes(hex: &str) -> Option<Vec<u8>> {
    let digits = hex.as_bytes();
    if !digits.len().is_multiple_of(2) || digits.len() > 128 {
        return None;
    }
    let digit = |d: u8| char::from(d).to_digit(16);
    let byte = |pair: &[u8]| Some((16 * digit(pair[0])? + digit(pair[1])?) as u8);
    digits.chunks(2).map(byte).collect()
}
