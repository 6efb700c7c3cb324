//! The legend of a panel: a few rows above it, so that it never covers data.

use crate::canvas::{Anchor, Canvas, Font, Stroke, text_width};
use crate::figure::{MarkPlace, Panel, Symbol};
use crate::palette::{BAND_OPACITY, Color};
use std::collections::HashSet;

/// Size of the text, height of a row and length of the sample of a line, px.
const SIZE: f64 = 12.0;
const ROW: f64 = 18.0;
const SAMPLE: f64 = 24.0;
/// Between sample and text, and between two entries, px.
const SPACE: f64 = 6.0;
const BETWEEN: f64 = 18.0;

enum Sample {
    Line { stroke: Stroke, dot: f64, symbol: Symbol },
    Band,
}

struct Entry {
    text: String,
    color: Color,
    sample: Sample,
    x: f64,
    row: usize,
}

pub(crate) struct Legend {
    entries: Vec<Entry>,
    rows: usize,
}

impl Legend {
    /// The legend of a panel in a column, wrapped to a width. What `shown` holds has no entry: another
    /// panel of the figure has that series, or one of the column that mark.
    pub(crate) fn new(
        panel: &Panel,
        width: f64,
        shown: &mut HashSet<String>,
        column: usize,
    ) -> Self {
        let series = panel.series.iter().map(|s| {
            let Stroke { color, width, dashed } = Stroke::from(&s.style);
            // The colour of a thin line is hard to see.
            let width = if width > 0.0 { width.max(2.0) } else { 0.0 };
            let stroke = Stroke { color, width, dashed };
            let sample = Sample::Line { stroke, dot: s.style.dot, symbol: s.style.symbol };
            (s.name.as_str(), s.note.as_str(), format!("{:?}", s.style), color, sample)
        });
        let marks = panel.marks.iter().map(|m| {
            let sample = match m.place {
                MarkPlace::XBand(..) | MarkPlace::YBand(..) => Sample::Band,
                MarkPlace::XLine(_) | MarkPlace::YLine(_) => {
                    let stroke = Stroke { color: m.color, width: 1.2, dashed: true };
                    Sample::Line { stroke, dot: 0.0, symbol: Symbol::Dot }
                }
            };
            (m.name.as_str(), "", format!("{:?} {column}", m.color), m.color, sample)
        });
        let mut entries = Vec::new();
        let (mut x, mut row) = (0.0, 0);
        for (name, note, look, color, sample) in series.chain(marks).filter(|e| !e.0.is_empty()) {
            if !shown.insert(format!("{name} {look}")) && note.is_empty() {
                continue;
            }
            let text = shortened(&format!("{name}{note}"), width - SAMPLE - SPACE);
            let length = SAMPLE + SPACE + text_width(&text, SIZE);
            if x > 0.0 && x + length > width {
                x = 0.0;
                row += 1;
            }
            entries.push(Entry { text, color, sample, x, row });
            x += length + BETWEEN;
        }
        let rows = if entries.is_empty() { 0 } else { row + 1 };
        Self { entries, rows }
    }

    /// Height it takes, px.
    pub(crate) fn height(&self) -> f64 {
        self.rows as f64 * ROW + if self.rows > 0 { 4.0 } else { 0.0 }
    }

    /// Draws it with its upper left corner at a place.
    pub(crate) fn draw(&self, canvas: &mut Canvas, left: f64, top: f64) {
        for entry in &self.entries {
            let (x, y) = (left + entry.x, top + (entry.row as f64 + 0.5) * ROW);
            match &entry.sample {
                Sample::Line { stroke, dot, symbol } => {
                    if stroke.width > 0.0 {
                        canvas.line(&[(x, y), (x + SAMPLE, y)], *stroke);
                    }
                    if *dot > 0.0 {
                        canvas.symbol((x + 0.5 * SAMPLE, y), *dot, *symbol, entry.color);
                    }
                }
                Sample::Band => canvas.fill(
                    (x, y - 5.0),
                    (x + SAMPLE, y + 5.0),
                    entry.color,
                    1.6 * BAND_OPACITY,
                ),
            }
            let font = Font { size: SIZE, bold: false, upwards: false };
            canvas.text(&entry.text, (x + SAMPLE + SPACE, y), Anchor::Start, font);
        }
    }
}

/// The text, cut to a width with an ellipsis.
pub(crate) fn shortened(text: &str, width: f64) -> String {
    if text_width(text, SIZE) <= width {
        return text.to_owned();
    }
    let mut out = String::new();
    for c in text.chars() {
        out.push(c);
        if text_width(&out, SIZE) + SIZE > width {
            break;
        }
    }
    out.push('…');
    out
}
