//! Frames of a bus in text: candump of SocketCAN, and Vector's ASC.

use std::io::{BufRead, BufReader, Read};

/// A frame with data.
#[derive(Debug, Clone, PartialEq, Default)]
pub(super) struct Frame {
    /// Instant, s.
    pub(super) time: f64,
    pub(super) bus: String,
    pub(super) id: u32,
    pub(super) is_extended: bool,
    pub(super) data: Vec<u8>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Form {
    Candump,
    Asc,
}

impl Form {
    /// The form of a text that starts like this.
    pub(super) fn of(start: &[u8]) -> Option<Self> {
        let start = String::from_utf8_lossy(start);
        // The last line may be cut.
        let mut lines = start.lines().map(str::trim).filter(|l| !l.is_empty()).take(30);
        let first = lines.next()?;
        if first.starts_with("date ")
            || first.starts_with("base hex")
            || first.starts_with("base dec")
        {
            return Some(Self::Asc);
        }
        let is_frame = |line: &str| matches!(candump(line), Line::Frame(_));
        (is_frame(first) || lines.next().is_some_and(is_frame)).then_some(Self::Candump)
    }
}

/// What a line is.
#[derive(Debug, PartialEq)]
enum Line {
    Frame(Frame),
    /// A remote frame, an error frame, a comment or the like.
    Other,
    Fault,
}

/// The frames of a text, line by line.
pub(super) struct Frames<R> {
    reader: BufReader<R>,
    form: Form,
    /// Number of lines read.
    pub(super) line: u64,
    /// Number of bytes read.
    pub(super) byte: u64,
    /// Lines that are no frame and nothing else known, and the first of them.
    pub(super) faults: u64,
    pub(super) first_fault: Option<(u64, u64)>,
    text: Vec<u8>,
    asc: Asc,
}

/// The number bases and the clock of an ASC file.
struct Asc {
    is_hex: bool,
    is_relative: bool,
    time: f64,
}

/// No line of a bus log is longer.
const LONGEST: u64 = 4096;

impl<R: Read> Frames<R> {
    pub(super) fn new(reader: R, form: Form) -> Self {
        Self {
            reader: BufReader::with_capacity(1 << 16, reader),
            form,
            line: 0,
            byte: 0,
            faults: 0,
            first_fault: None,
            text: Vec::new(),
            asc: Asc { is_hex: true, is_relative: false, time: 0.0 },
        }
    }

    /// The next frame, or `None` at the end.
    pub(super) fn next(&mut self) -> std::io::Result<Option<Frame>> {
        loop {
            self.text.clear();
            let count = self.reader.by_ref().take(LONGEST).read_until(b'\n', &mut self.text)?;
            if count == 0 {
                return Ok(None);
            }
            let at = self.byte;
            self.line += 1;
            self.byte += count as u64;
            let read = match (std::str::from_utf8(&self.text), self.form) {
                (Ok(text), Form::Candump) => candump(text.trim()),
                (Ok(text), Form::Asc) => self.asc.line(text.trim()),
                (Err(_), _) => Line::Fault,
            };
            match read {
                Line::Frame(frame) => return Ok(Some(frame)),
                Line::Other => {}
                Line::Fault => {
                    self.faults += 1;
                    self.first_fault.get_or_insert((self.line, at));
                }
            }
        }
    }

    /// What could not be read, for people.
    pub(super) fn loss(&self, file: &str) -> Option<String> {
        let (line, byte) = self.first_fault?;
        let count = self.faults;
        let lines = if count == 1 { "1 line is" } else { &format!("{count} lines are") };
        Some(format!(
            "{file}: {lines} no frame and not read, the first at line {line}, byte {byte}"
        ))
    }
}

/// `(1436509052.249713) can0 044#2A366C2B7F`, with `##` and flags for CAN FD, or in columns
/// `(1436509052.249713)  can0  044   [5]  2A 36 6C 2B 7F`.
fn candump(line: &str) -> Line {
    if line.is_empty() || line.starts_with('#') {
        return Line::Other;
    }
    let mut words = line.split_whitespace();
    let parsed = (|| {
        let time = words.next()?.strip_prefix('(')?.strip_suffix(')')?.parse::<f64>().ok()?;
        let bus = words.next()?;
        let word = words.next()?;
        let (id, data) = match word.split_once('#') {
            Some((_, data)) if data.starts_with('R') => return Some(Line::Other),
            Some((id, data)) => {
                let data = data.strip_prefix('#').map_or(Some(data), |fd| fd.get(1..))?;
                // A length of 9 to 15 with 8 bytes.
                (id, data.split('_').next().unwrap_or_default().replace('.', ""))
            }
            None => {
                words.next()?.strip_prefix('[')?.strip_suffix(']')?;
                let rest: Vec<&str> = words.clone().collect();
                if rest.first() == Some(&"remote") {
                    return Some(Line::Other);
                }
                let data = rest.into_iter().take_while(|w| w.len() == 2).collect::<String>();
                (word, data)
            }
        };
        let number = u32::from_str_radix(id, 16).ok()?;
        if number & 0x2000_0000 != 0 && id.len() > 3 {
            // An error of the bus.
            return Some(Line::Other);
        }
        let data = bytes(&data)?;
        let is_extended = id.len() > 3;
        time.is_finite()
            .then(|| Line::Frame(Frame { time, bus: bus.into(), id: number, is_extended, data }))
    })();
    parsed.unwrap_or(Line::Fault)
}

fn bytes(hex: &str) -> Option<Vec<u8>> {
    let digits = hex.as_bytes();
    if !digits.len().is_multiple_of(2) || digits.len() > 128 {
        return None;
    }
    let digit = |d: u8| char::from(d).to_digit(16);
    let byte = |pair: &[u8]| Some((16 * digit(pair[0])? + digit(pair[1])?) as u8);
    digits.chunks(2).map(byte).collect()
}

impl Asc {
    fn line(&mut self, line: &str) -> Line {
        let words: Vec<&str> = line.split_whitespace().collect();
        if let ["base", base, rest @ ..] = &words[..] {
            self.is_hex = *base == "hex";
            self.is_relative = rest.contains(&"relative");
            return Line::Other;
        }
        let Some(time) = words.first().and_then(|t| t.parse::<f64>().ok()) else {
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
                self.frame(bus, id, length, data)
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
        self.made(bus, id, count, data)
    }

    fn frame(&self, bus: &str, id: &str, length: &str, data: &[&str]) -> Line {
        match usize::from_str_radix(length, 16) {
            Ok(count) => self.made(bus, id, count.min(8), data),
            Err(_) => Line::Fault,
        }
    }

    fn made(&self, bus: &str, id: &str, count: usize, data: &[&str]) -> Line {
        let radix = if self.is_hex { 16 } else { 10 };
        let (number, is_extended) =
            id.strip_suffix('x').or(id.strip_suffix('X')).map_or((id, false), |id| (id, true));
        let id = u32::from_str_radix(number, radix).ok();
        let byte = |text: &&str| u8::from_str_radix(text, radix).ok();
        let data = data.get(..count).and_then(|data| data.iter().map(byte).collect());
        match (id, data) {
            (Some(id), Some(data)) => {
                let (time, bus) = (self.time, bus.to_owned());
                Line::Frame(Frame { time, bus, id, is_extended, data })
            }
            _ => Line::Fault,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn all(text: &str) -> (Vec<Frame>, u64) {
        let form = Form::of(text.as_bytes()).unwrap();
        let mut frames = Frames::new(text.as_bytes(), form);
        let mut read = Vec::new();
        while let Some(frame) = frames.next().unwrap() {
            read.push(frame);
        }
        (read, frames.faults)
    }

    fn frame(time: f64, bus: &str, id: u32, is_extended: bool, data: &[u8]) -> Frame {
        Frame { time, bus: bus.into(), id, is_extended, data: data.into() }
    }

    #[test]
    fn candump_of_both_forms() {
        let text = "(1436509052.249713) vcan0 044#2A366C\n\
             (1436509052.3) vcan0 00000044#\n\
             (1436509052.4) vcan0 123##1AABB\n\
             (1436509052.4) vcan0 123#R\n\
             (1436509052.4) vcan0 20000080#0000000000000000\n\
             (1436509052.5)  can1  1F334455   [2]  11 22\n\
             (1436509052.5)  can1  123   [8]  remote request\n\
             (1436509052.5) vcan0 044#2A3\n";
        let expected = [
            frame(1_436_509_052.249_713, "vcan0", 0x44, false, &[0x2A, 0x36, 0x6C]),
            frame(1_436_509_052.3, "vcan0", 0x44, true, &[]),
            frame(1_436_509_052.4, "vcan0", 0x123, false, &[0xAA, 0xBB]),
            frame(1_436_509_052.5, "can1", 0x1F33_4455, true, &[0x11, 0x22]),
        ];
        assert_eq!(all(text), (expected.to_vec(), 1));
    }

    #[test]
    fn asc_of_both_bases_and_clocks() {
        let text = "date Sam Sep 30 15:06:13.191 2017\nbase hex  timestamps absolute\n\
             internal events logged\nBegin Triggerblock\n 0.000000 Start of measurement\n\
             2.501 1  C8              Rx   d 8 09 08 07 06 05 04 03 02\n\
             3.2 2 18EBFF00x  Tx   d 2 01 A0  Length = 0\n\
             3.3 1 ErrorFrame\n\
             3.4 1  123 Rx r 8\n\
             30.0 CANFD   1 Rx  300   1 0 8 8 01 02 03 04 05 06 07 08 102203 133 303000\n\
             30.1 CANFD   1 Rx  300 Name  1 0 2 2 01 02 1 1\n\
             3.5 1  zz Rx d 1 00\n";
        let expected = [
            frame(2.501, "1", 0xC8, false, &[9, 8, 7, 6, 5, 4, 3, 2]),
            frame(3.2, "2", 0x18EB_FF00, true, &[1, 0xA0]),
            frame(30.0, "1", 0x300, false, &[1, 2, 3, 4, 5, 6, 7, 8]),
            frame(30.1, "1", 0x300, false, &[1, 2]),
        ];
        assert_eq!(all(text), (expected.to_vec(), 1));
        let relative = "base dec  timestamps relative\n0.5 1 200 Rx d 1 10\n0.25 1 200 Rx d 1 11\n";
        let (frames, _) = all(relative);
        assert_eq!(frames[1], frame(0.75, "1", 200, false, &[11]));
    }
}
