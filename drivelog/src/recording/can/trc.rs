//! Lines of PEAK's traces (`.trc`), versions 1.0 to 2.1.

use super::candump::bytes;
use super::frame::{Frame, Line};

/// The columns of a trace, by PEAK's letters: N number, O time in ms, T type, B bus, I identifier, d direction,
/// R reserved, l length in bytes, L data length code, D data.
#[derive(Debug)]
pub(super) struct Trc {
    columns: String,
}

/// Version 1.0, which has no line with its version.
impl Default for Trc {
    fn default() -> Self {
        Self { columns: "NOIlD".into() }
    }
}

pub(super) const VERSION: &str = ";$FILEVERSION=";
const COLUMNS: &str = ";$COLUMNS=";
/// Bytes of a frame by data length codes from 9.
pub(super) const LONG: [usize; 7] = [12, 16, 20, 24, 32, 48, 64];

impl Trc {
    pub(super) fn line(&mut self, line: &str) -> Line {
        if let Some(version) = line.strip_prefix(VERSION) {
            let columns = match version.trim() {
                "1.1" => "NOdIlD",
                "1.2" => "NOBdIlD",
                "1.3" => "NOBdIRlD",
                "2.0" => "NOTIdlD",
                "2.1" => "NOTBIdRLD",
                _ => return Line::Other,
            };
            self.columns = columns.into();
        } else if let Some(columns) = line.strip_prefix(COLUMNS) {
            self.columns = columns.replace([',', ' '], "");
        }
        if line.is_empty() || line.starts_with(';') {
            return Line::Other;
        }
        self.frame(line).unwrap_or(Line::Fault)
    }

    fn frame(&self, line: &str) -> Option<Line> {
        let mut words = line.split_whitespace();
        let mut frame = Frame { bus: "1".into(), ..Frame::default() };
        let mut count = 0;
        for column in self.columns.chars().filter(|column| *column != 'D') {
            let word = words.next()?;
            match column {
                'N' => _ = word.trim_end_matches(')').parse::<u64>().ok()?,
                'O' => frame.time = word.parse::<f64>().ok().filter(|ms| ms.is_finite())? * 1e-3,
                // Remote frames, errors, statistics, events.
                'T' if !matches!(word, "DT" | "FD" | "FB" | "FE" | "BI") => {
                    return Some(Line::Other);
                }
                'd' if !matches!(word, "Rx" | "Tx") => return Some(Line::Other),
                'B' => frame.bus = word.into(),
                'I' => {
                    frame.id = u32::from_str_radix(word, 16).ok()?;
                    frame.is_extended = word.len() > 4 || frame.id > 0x7FF;
                }
                'l' => count = word.parse().ok()?,
                'L' => {
                    let code: usize = word.parse().ok()?;
                    count = code.checked_sub(9).map_or(Some(code), |at| LONG.get(at).copied())?;
                }
                _ => {}
            }
        }
        let data: Vec<&str> = words.collect();
        if data.first() == Some(&"RTR") {
            return Some(Line::Other);
        }
        let data = data.get(..count)?;
        if data.iter().any(|byte| byte.len() != 2) {
            return None;
        }
        frame.data = bytes(&data.concat())?;
        Some(Line::Frame(frame))
    }
}
