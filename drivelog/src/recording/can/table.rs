//! Frames in tables with a row for each, as cabana, SavvyCAN and GVRET, python-can, Kvaser, Vehicle Spy, the converter of the
//! CANedge and the CL2000 write them, and as other tools do whose header states time, identifier, length and data.

use super::candump::bytes;
use super::frame::{Frame, Line};
use super::trc::LONG;
use crate::recording::base64::base64;
use crate::recording::csv::instants::instant;
use crate::recording::csv::stamps::Stamps;

/// How the bytes of a frame are written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Data {
    /// In one cell.
    Hex,
    Base64,
    /// In a cell each, as many as another cell states, or else those that are not blank.
    Cells,
}

/// How the instants are written.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Clock {
    /// Numbers of this unit, s.
    Number(f64),
    /// Whole microseconds, or seconds with a fraction.
    Microseconds,
    /// `01T022231683`: day, or month and day, or year, month and day; hours, minutes, seconds and milliseconds.
    Digits,
    Stamps(Stamps),
    /// To be determined from the rows.
    Open,
}

/// The base of identifiers, and of bytes in a cell each, without `0x`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Base {
    Hex,
    Decimal,
    /// Left to the user by the program and not stated: letters or leading zeros in the rows make it hexadecimal.
    HexByRows,
    /// Of an unknown program: letters in the rows make it hexadecimal, without them it stays open.
    Open,
}

/// The columns of a table of frames.
#[derive(Debug, PartialEq)]
pub(super) struct Table {
    delimiter: char,
    time: usize,
    clock: Clock,
    id: usize,
    base: Base,
    is_extended: Option<usize>,
    /// Flags of Kvaser in one number.
    flags: Option<usize>,
    /// Kinds of frames of the CL2000 in one number, of which odd ones are extended.
    kind_of_frame: Option<usize>,
    bus: Option<usize>,
    data: usize,
    kind: Data,
    length: Option<usize>,
    /// The column after the bytes of cells without a length.
    end: usize,
    /// Flags of frames without data: requests and errors.
    others: Vec<usize>,
}

/// Names of the columns without blanks, in small letters.
const TIMES: [&str; 7] =
    ["timestampepoch", "time", "timestamp", "timeoffset", "systemtime", "timeabs", "abstime"];
const IDS: [&str; 8] =
    ["id", "canid", "arbid", "arbitrationid", "frameid", "identifier", "msgid", "messageid"];
const LENGTHS: [&str; 5] = ["len", "dlc", "length", "datalength", "datalen"];
const EXTENDED: [&str; 5] = ["extended", "ide", "xtd", "format", "frameformat"];
const BUSES: [&str; 6] = ["bus", "channel", "chn", "buschannel", "network", "canchannel"];
const DATA: [&str; 3] = ["data", "databytes", "payload"];
const CELLS: [&str; 9] = ["d0", "d1", "b0", "b1", "data0", "data1", "byte0", "byte1", "databyte0"];
const OTHERS: [&str; 4] = ["remote", "error", "rtr", "er"];

/// Whether the line is one of those that Vehicle Spy writes above its header.
pub(super) fn is_above(line: &str) -> bool {
    line.starts_with("Network Description,Hardware,Network,")
}

impl Table {
    /// By the names of the columns; `None` of another table.
    pub(super) fn from_header(header: &str) -> Option<Self> {
        let delimiter = match header {
            _ if header.contains(';') => ';',
            _ if header.contains('\t') => '\t',
            _ => ',',
        };
        let header = header.trim_start_matches('\u{feff}');
        // Name, and what stands in brackets behind it.
        let plain = |cell: &str| {
            let cell = cell.trim().trim_matches('"').replace([' ', '_'], "").to_lowercase();
            let (name, rest) = cell.split_at(cell.find(['(', '[', '/']).unwrap_or(cell.len()));
            (name.to_owned(), rest.trim_matches(&['(', ')', '[', ']'][..]).to_owned())
        };
        let columns: Vec<(String, String)> = header.split(delimiter).map(plain).collect();
        let names: Vec<&str> = columns.iter().map(|(name, _)| name.as_str()).collect();
        let find = |name: &str| names.iter().position(|own| *own == name);
        let any = |all: &[&str]| names.iter().position(|own| all.contains(own));
        let mut table = Self {
            delimiter,
            time: any(&TIMES)?,
            clock: Clock::Number(1.0),
            id: any(&IDS).or_else(|| find("addr"))?,
            base: Base::Hex,
            is_extended: any(&EXTENDED),
            flags: None,
            kind_of_frame: None,
            bus: any(&BUSES),
            data: any(&DATA).or_else(|| any(&CELLS))?,
            kind: if any(&DATA).is_some() { Data::Hex } else { Data::Cells },
            length: any(&LENGTHS),
            end: find("value").unwrap_or(names.len()),
            others: OTHERS.into_iter().filter_map(find).collect(),
        };
        match names[0] {
            "time" if names == ["time", "addr", "bus", "data"] => table.base = Base::Decimal,
            "timestamp" if names == ["timestamp", "type", "id", "data"] || is_cl2000(&names) => {
                (table.clock, table.kind_of_frame) = (Clock::Digits, find("type"));
            }
            "timestamp" if find("d1").is_some() && find("extended").is_some() => {
                table.clock = Clock::Microseconds;
            }
            // Kvaser.
            "time" if find("data0").is_some() && find("flags").is_some() => {
                (table.base, table.flags) = (Base::HexByRows, find("flags"));
            }
            "timestamp" if find("arbitrationid").is_some() && find("extended").is_some() => {
                (table.kind, table.bus) = (Data::Base64, None);
            }
            "timestampepoch" => table.length = find("datalength"),
            "line" if find("arbid").is_some() && find("b1").is_some() => {
                table.length = None;
            }
            // An unknown program, whose table has more than three numbers with such names.
            _ => {
                let has_more = table.length.or(table.is_extended).or(table.bus).is_some();
                if find("addr").is_some() || !has_more {
                    return None;
                }
                table.clock = match columns[table.time].1.as_str() {
                    "ms" => Clock::Number(1e-3),
                    "us" | "µs" => Clock::Number(1e-6),
                    "s" | "sec" => Clock::Number(1.0),
                    _ => Clock::Open,
                };
                table.base = match columns[table.id].1.as_str() {
                    "hex" => Base::Hex,
                    "dec" => Base::Decimal,
                    _ => Base::Open,
                };
                if table.kind == Data::Cells && table.length.is_none() {
                    return None;
                }
            }
        }
        Some(table)
    }

    /// The same with what its rows show: the base of the numbers, and how the instants are written.
    pub(super) fn based_on(mut self, rows: &str) -> Self {
        let rows: Vec<Vec<&str>> = rows.lines().map(|row| self.cells(row)).collect();
        let has_letters = |cell: &str| {
            cell.bytes().all(|b| b.is_ascii_hexdigit())
                && cell.bytes().any(|b| b.is_ascii_alphabetic())
        };
        let has_zero = |cell: &str| cell.len() == 2 && cell.starts_with('0');
        let id = self.id;
        let mut ids = rows.iter().filter_map(|cells| cells.get(id).copied());
        match self.base {
            Base::HexByRows => {
                let data = self.data;
                let numbers = rows.iter().flat_map(|cells| {
                    let data = cells.get(data..data + 8).unwrap_or_default();
                    cells.get(id).into_iter().chain(data)
                });
                let is_hex = numbers.into_iter().any(|cell| has_letters(cell) || has_zero(cell));
                self.base = if is_hex { Base::Hex } else { Base::Decimal };
            }
            Base::Open if ids.any(|id| has_letters(id) || stated_hex(id).is_some()) => {
                self.base = Base::Hex;
            }
            _ => {}
        }
        if self.clock == Clock::Open {
            let first =
                rows.iter().find_map(|cells| cells.get(self.time).filter(|c| !c.is_empty()));
            let first = first.copied().unwrap_or_default();
            if let Some(stamps) = Stamps::like(first) {
                self.clock = Clock::Stamps(stamps);
            } else if first.contains('.') && first.parse::<f64>().is_ok() {
                self.clock = Clock::Number(1.0);
            }
        }
        self
    }

    /// Why none of its rows can be read.
    pub(super) fn problem(&self) -> Option<&'static str> {
        if self.base == Base::Open {
            return Some(
                "the base of the identifiers is open: none has a letter or 0x, and the header does not state (hex) or (dec)",
            );
        }
        if self.clock == Clock::Open {
            return Some("the unit of the times is open: state it in the header, as in Time (ms)");
        }
        None
    }

    /// The cells of a row; delimiters in quotes are none.
    fn cells<'l>(&self, line: &'l str) -> Vec<&'l str> {
        let mut is_quoted = false;
        let is_end = |c: char| {
            is_quoted ^= c == '"';
            c == self.delimiter && !is_quoted
        };
        line.split(is_end).map(|cell| cell.trim().trim_matches('"')).collect()
    }

    /// A line; `is_cut` where the file ends within it.
    pub(super) fn line(&mut self, line: &str, is_cut: bool) -> Line {
        if line.is_empty() || Self::from_header(line).is_some() {
            return Line::Other;
        }
        self.frame(line, is_cut).unwrap_or(Line::Fault)
    }

    fn frame(&mut self, line: &str, is_cut: bool) -> Option<Line> {
        if self.problem().is_some() {
            return None;
        }
        let cells = self.cells(line);
        let is_one_of = |at: usize, words: &[&str]| {
            cells.get(at).is_some_and(|c| words.iter().any(|word| c.eq_ignore_ascii_case(word)))
        };
        if self.others.iter().any(|at| is_one_of(*at, &["1", "true", "t"])) {
            return Some(Line::Other);
        }
        let time = seconds(&mut self.clock, cells.get(self.time)?)?;
        let flags = match self.flags {
            Some(at) if !cells.get(at)?.is_empty() => cells[at].parse().ok()?,
            _ => 0,
        };
        const REQUEST: u32 = 1;
        const EXTENDED: u32 = 4;
        const FAULT: u32 = 32;
        if flags & (REQUEST | FAULT) != 0 {
            return Some(Line::Other);
        }
        let base = if self.base == Base::Hex { 16 } else { 10 };
        let id = cells.get(self.id)?;
        let id = match stated_hex(id) {
            Some(hex) => u32::from_str_radix(hex, 16),
            None => u32::from_str_radix(id, base),
        };
        let id = id.ok()?;
        let length = match self.length.map(|at| cells.get(at)?.parse::<usize>().ok()) {
            // A length in digits that begin with `0x`, or none.
            Some(None) => {
                Some(usize::from_str_radix(cells.get(self.length?)?.strip_prefix("0x")?, 16).ok()?)
            }
            Some(length) => length,
            None => None,
        };
        let data = match self.kind {
            Data::Hex => {
                let data = cells.get(self.data)?.trim_start_matches("x|").trim_start();
                bytes(&data.replace("0x", "").replace(' ', ""))?
            }
            Data::Base64 => base64(cells.get(self.data)?),
            Data::Cells => {
                let count = match length {
                    Some(length) => length,
                    // The rest of the row is missing where it is cut.
                    None if cells.len() <= self.end => return None,
                    None => {
                        let data = &cells[self.data..self.end];
                        data.iter().position(|cell| cell.is_empty()).unwrap_or(data.len())
                    }
                };
                let cells = cells.get(self.data..)?.get(..count)?;
                // The byte at which the file was cut off may lack a digit.
                if is_cut && base == 16 && cells.last().is_some_and(|cell| cell.len() < 2) {
                    return None;
                }
                cells
                    .iter()
                    .map(|cell| u8::from_str_radix(cell, base).ok())
                    .collect::<Option<_>>()?
            }
        };
        let is_of_code =
            |length: usize| length.checked_sub(9).and_then(|at| LONG.get(at)) == Some(&data.len());
        if length.is_some_and(|length| length != data.len() && !is_of_code(length)) {
            return None;
        }
        // Where the table does not state it, an identifier beyond 11 bits is extended.
        let is_extended = match (self.is_extended, self.kind_of_frame) {
            (Some(at), _) => is_one_of(at, &["1", "true", "t", "ext", "extended", "x"]),
            (None, Some(at)) => cells.get(at)?.parse::<u32>().ok()? % 2 == 1,
            (None, None) => id > 0x7FF || flags & EXTENDED != 0,
        };
        let bus = self.bus.and_then(|at| cells.get(at)).map_or("1", |bus| bus).to_owned();
        Some(Line::Frame(Frame { time, bus, id, is_extended, data, is_request: false }))
    }
}

/// The CL2000 with its optional columns.
fn is_cl2000(names: &[&str]) -> bool {
    names.starts_with(&["timestamp", "type", "id"]) && names.last() == Some(&"data")
}

/// The digits of an identifier that states its base: `0x1F`, `1Fh`.
fn stated_hex(id: &str) -> Option<&str> {
    let hex = id.strip_prefix("0x").or_else(|| id.strip_prefix("0X"));
    hex.or_else(|| id.strip_suffix(['h', 'H']))
}

/// The instant of a cell, s.
fn seconds(clock: &mut Clock, cell: &str) -> Option<f64> {
    let number = || cell.parse::<f64>().ok().filter(|time| time.is_finite());
    match clock {
        Clock::Number(second) => Some(number()? * *second),
        Clock::Microseconds => Some(number()? * if cell.contains('.') { 1.0 } else { 1e-6 }),
        Clock::Digits => of_digits(cell),
        Clock::Stamps(stamps) => stamps.seconds(cell),
        Clock::Open => None,
    }
}

fn of_digits(cell: &str) -> Option<f64> {
    let (date, time) = cell.split_once(['T', ' ']).unwrap_or(("", cell));
    let digits = |text: &str| text.chars().filter(char::is_ascii_digit).collect::<String>();
    let (date, time) = (digits(date), digits(time));
    let part = |text: &str, from: usize, to: usize| text.get(from..to)?.parse::<u32>().ok();
    if time.len() != 9 {
        return None;
    }
    let minutes = 60 * part(&time, 0, 2)? + part(&time, 2, 4)?;
    let of_day = f64::from(60 * minutes) + 1e-3 * f64::from(part(&time, 4, 9)?);
    let [year, month, day] = match date.len() {
        0 => [1970, 1, 1],
        // Days of a month and months of a year without those above them.
        2 => [1970, 1, part(&date, 0, 2)?],
        4 => [1970, part(&date, 0, 2)?, part(&date, 2, 4)?],
        8 => [part(&date, 0, 4)?, part(&date, 4, 6)?, part(&date, 6, 8)?],
        _ => return None,
    };
    let midnight = instant(&format!("{year:04}-{month:02}-{day:02} 00:00:00"))?;
    Some(midnight + of_day)
}
