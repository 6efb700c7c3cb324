//! Lines of the CSV files of openpilot's cabana.

use super::candump::bytes;
use super::frame::{Frame, Line};

const HEADER: &str = "time,addr,bus,data";

pub(super) fn is_header(line: &str) -> bool {
    line.replace([' ', '"'], "").eq_ignore_ascii_case(HEADER)
}

/// `0.01,0x25,0,0x4903204120422000`: seconds, identifier, bus and bytes. An identifier without `0x` is decimal. The
/// format does not state its length: one beyond 11 bits is extended.
pub(super) fn cabana(line: &str) -> Line {
    if line.is_empty() || is_header(line) {
        return Line::Other;
    }
    let parsed = (|| {
        let cells: Vec<&str> = line.split(',').map(|c| c.trim().trim_matches('"')).collect();
        let &[time, id, bus, data] = &cells[..] else { return None };
        let time = time.parse::<f64>().ok().filter(|time| time.is_finite())?;
        let hex = id.strip_prefix("0x");
        let id = hex.map_or_else(|| id.parse(), |hex| u32::from_str_radix(hex, 16)).ok()?;
        let data = bytes(data.strip_prefix("0x").unwrap_or(data))?;
        let is_extended = id > 0x7FF;
        Some(Line::Frame(Frame { time, bus: bus.into(), id, is_extended, data, is_request: false }))
    })();
    parsed.unwrap_or(Line::Fault)
}
