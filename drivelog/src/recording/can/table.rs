//! Frames in tables with a row for each, as cabana, SavvyCAN and GVRET, python-can, Kvaser and the CANedge's converter write them.

use super::candump::bytes;
use super::frame::{Frame, Line};
use crate::recording::base64::base64;

/// How the bytes of a frame are written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Data {
    /// In one cell.
    Hex,
    Base64,
    /// In a cell each, as many as another cell states.
    Cells,
}

/// The columns of a table of frames.
#[derive(Debug, PartialEq)]
pub(super) struct Table {
    delimiter: char,
    time: usize,
    /// Seconds of its unit.
    second: f64,
    id: usize,
    /// Whether an identifier without `0x` is of hexadecimal digits, and where bytes are in a cell each, these, too.
    is_hex: bool,
    is_extended: Option<usize>,
    /// Flags of Kvaser in one number.
    flags: Option<usize>,
    bus: Option<usize>,
    data: usize,
    kind: Data,
    length: Option<usize>,
    /// Flags of frames without data: requests and errors.
    others: Vec<usize>,
}

impl Table {
    /// By the names of the columns; `None` of another table.
    pub(super) fn from_header(header: &str) -> Option<Self> {
        let delimiter = if header.contains(';') { ';' } else { ',' };
        let plain =
            |cell: &str| cell.trim().trim_matches('"').replace([' ', '_'], "").to_lowercase();
        let names: Vec<String> =
            header.trim_start_matches('\u{feff}').split(delimiter).map(plain).collect();
        let find = |name: &str| names.iter().position(|own| own == name);
        let others = ["remote", "error", "rtr"].into_iter().filter_map(find).collect();
        let (time, second, id, is_hex, is_extended, bus, data, kind) = match &*names[0] {
            "time" if names == ["time", "addr", "bus", "data"] => {
                (0, 1.0, 1, false, None, Some(2), 3, Data::Hex)
            }
            "timestamp" if names.iter().any(|name| name == "d1") => (
                0,
                1e-6,
                find("id")?,
                true,
                Some(find("extended")?),
                find("bus"),
                find("d1")?,
                Data::Cells,
            ),
            // Kvaser.
            "time" if find("data0").is_some() => {
                (0, 1.0, find("id")?, false, None, find("channel"), find("data0")?, Data::Cells)
            }
            "timestamp" => (
                0,
                1.0,
                find("arbitrationid")?,
                true,
                Some(find("extended")?),
                None,
                find("data")?,
                Data::Base64,
            ),
            "timestampepoch" => (
                0,
                1.0,
                find("id")?,
                true,
                Some(find("ide")?),
                find("buschannel"),
                find("databytes")?,
                Data::Hex,
            ),
            _ => return None,
        };
        let length = match kind {
            Data::Cells => find("len").or(find("dlc")),
            Data::Base64 => find("dlc"),
            Data::Hex => find("datalength"),
        };
        if kind == Data::Cells && length.is_none() {
            return None;
        }
        Some(Self {
            delimiter,
            time,
            second,
            id,
            is_hex,
            is_extended,
            flags: find("flags"),
            bus,
            data,
            kind,
            length,
            others,
        })
    }

    /// The same with the base of its numbers, which Kvaser leaves to the user and does not state: rows with letters or a
    /// leading zero are hexadecimal.
    pub(super) fn based_on(mut self, rows: &str) -> Self {
        let is_hex = |cell: &str| {
            cell.bytes().all(|b| b.is_ascii_hexdigit())
                && (cell.len() == 2 && cell.starts_with('0')
                    || cell.bytes().any(|b| b.is_ascii_alphabetic()))
        };
        if self.flags.is_some() {
            let cells = rows.lines().flat_map(|row| {
                let cells: Vec<&str> = row.split(self.delimiter).map(str::trim).collect();
                let data = cells.get(self.data..self.data + 8).unwrap_or_default().to_vec();
                cells.get(self.id).copied().into_iter().chain(data).collect::<Vec<_>>()
            });
            self.is_hex = cells.into_iter().any(is_hex);
        }
        self
    }

    /// A line; `is_cut` where the file ends within it.
    pub(super) fn line(&self, line: &str, is_cut: bool) -> Line {
        if line.is_empty() || Self::from_header(line).is_some() {
            return Line::Other;
        }
        self.frame(line, is_cut).unwrap_or(Line::Fault)
    }

    fn frame(&self, line: &str, is_cut: bool) -> Option<Line> {
        let cells: Vec<&str> =
            line.split(self.delimiter).map(|c| c.trim().trim_matches('"')).collect();
        let is_set =
            |at: usize| cells.get(at).is_some_and(|c| *c == "1" || c.eq_ignore_ascii_case("true"));
        if self.others.iter().any(|at| is_set(*at)) {
            return Some(Line::Other);
        }
        let stamp = *cells.get(self.time)?;
        let time = stamp.parse::<f64>().ok().filter(|time| time.is_finite())?;
        // SavvyCAN has whole microseconds, or seconds with a fraction.
        let second = if stamp.contains('.') { 1.0 } else { self.second };
        let flags = match self.flags {
            Some(at) => cells.get(at)?.parse().ok()?,
            None => 0,
        };
        const REQUEST: u32 = 1;
        const EXTENDED: u32 = 4;
        const FAULT: u32 = 32;
        if flags & (REQUEST | FAULT) != 0 {
            return Some(Line::Other);
        }
        let id = *cells.get(self.id)?;
        let base = if self.is_hex { 16 } else { 10 };
        let id = match id.strip_prefix("0x") {
            Some(hex) => u32::from_str_radix(hex, 16),
            None => u32::from_str_radix(id, base),
        };
        let id = id.ok()?;
        let length = self.length.map(|at| cells.get(at)?.parse::<usize>().ok());
        let data = match self.kind {
            Data::Hex => {
                let data = *cells.get(self.data)?;
                bytes(data.strip_prefix("0x").unwrap_or(data))?
            }
            Data::Base64 => base64(cells.get(self.data)?),
            Data::Cells => {
                let cells = cells.get(self.data..)?.get(..length??)?;
                // The byte at which the file was cut off may lack a digit.
                if is_cut && self.is_hex && cells.last().is_some_and(|cell| cell.len() < 2) {
                    return None;
                }
                cells
                    .iter()
                    .map(|cell| u8::from_str_radix(cell, base).ok())
                    .collect::<Option<_>>()?
            }
        };
        if length.is_some_and(|length| length != Some(data.len())) {
            return None;
        }
        // Where the table does not state it, an identifier beyond 11 bits is extended.
        let is_extended = match self.is_extended {
            Some(at) => is_set(at),
            None => id > 0x7FF || flags & EXTENDED != 0,
        };
        let bus = self.bus.and_then(|at| cells.get(at)).map_or("1", |bus| bus).to_owned();
        let time = time * second;
        Some(Line::Frame(Frame { time, bus, id, is_extended, data, is_request: false }))
    }
}
