//! Frames in tables with a row for each, as cabana, SavvyCAN and GVRET, python-can and the CANedge's converter write them.

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
    /// Whether an identifier without `0x` is of hexadecimal digits.
    is_hex: bool,
    is_extended: Option<usize>,
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
            Data::Cells => find("len"),
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
            bus,
            data,
            kind,
            length,
            others,
        })
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
        let id = *cells.get(self.id)?;
        let id = match id.strip_prefix("0x") {
            Some(hex) => u32::from_str_radix(hex, 16),
            None if self.is_hex => u32::from_str_radix(id, 16),
            None => id.parse(),
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
                if is_cut && cells.last().is_some_and(|cell| cell.len() < 2) {
                    return None;
                }
                cells.iter().map(|cell| u8::from_str_radix(cell, 16).ok()).collect::<Option<_>>()?
            }
        };
        if length.is_some_and(|length| length != Some(data.len())) {
            return None;
        }
        // Where the table does not state it, an identifier beyond 11 bits is extended.
        let is_extended = self.is_extended.map_or(id > 0x7FF, is_set);
        let bus = self.bus.and_then(|at| cells.get(at)).map_or("1", |bus| bus).to_owned();
        let time = time * second;
        Some(Line::Frame(Frame { time, bus, id, is_extended, data, is_request: false }))
    }
}
