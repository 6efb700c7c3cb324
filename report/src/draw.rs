//! Draws a [`Figure`]: grid, marks, curves and labels on the places that `layout` gives.

use crate::Error;
use crate::axis::{Axis, Tick, drawable};
use crate::canvas::{Anchor, Canvas, Font, Stroke};
use crate::decimate::{Pixel, clipped, decimate, segments};
use crate::figure::{Figure, Mark, MarkPlace, Panel, Series};
use crate::layout::{self, Frame, TITLE_HEIGHT};
use crate::legend::shortened;
use crate::palette::{BAND_OPACITY, FINE_GRID, FRAME, GRID};

/// Points a figure may hold: at about 11 bytes each they keep it below 150 kB.
const POINTS: usize = 9000;
const LABEL_SIZE: f64 = 13.0;
const TITLE_SIZE: f64 = 15.0;
/// Least distance of two numbers along x and along y, px.
const X_SPACING: f64 = 80.0;
const Y_SPACING: f64 = 30.0;

const PLAIN: Font = Font { size: layout::TICK_SIZE, bold: false, upwards: false };

impl Figure {
    /// The figure as a stand-alone SVG document of that size in pixels, below about 150 kB.
    ///
    /// # Errors
    /// [`Error::NoData`] where a panel has nothing to draw, [`Error::Size`] where there is no room.
    pub fn to_svg(&self, width: u32, height: u32) -> Result<String, Error> {
        let frames = layout::frames(self, width, height)?;
        let curves: usize = self.panels.iter().map(|p| p.series.len()).sum();
        let budget = (POINTS / curves.max(1)).max(50);
        let name = format!("{}. {}", self.title, self.result);
        let mut canvas = Canvas::new(name.trim_end_matches([' ', '.']), width, height);
        let w = f64::from(width);
        let font = Font { size: TITLE_SIZE, bold: true, upwards: false };
        let title = shortened(&self.title, (w - 20.0) * 0.75);
        canvas.text(&title, (0.5 * w, 0.55 * TITLE_HEIGHT), Anchor::Middle, font);
        for (panel, frame) in self.panels.iter().zip(&frames) {
            draw_panel(&mut canvas, panel, frame, budget);
        }
        Ok(canvas.finish())
    }
}

fn draw_panel(canvas: &mut Canvas, panel: &Panel, frame: &Frame, budget: usize) {
    let (a, cell) = (frame.area, frame.cell);
    draw_bands(canvas, panel, frame);
    draw_grid(canvas, frame);
    let lines = panel.marks.iter().filter_map(|m| line_of(m, frame).map(|line| (m, line)));
    for (mark, line) in lines {
        canvas.line(&line, Stroke { color: mark.color, width: 1.2, dashed: true });
    }
    for series in &panel.series {
        draw_series(canvas, series, frame, budget);
    }
    let frame_stroke = Stroke { color: FRAME, width: 1.0, dashed: false };
    let (left, top, right, bottom) = (a.left, a.top, a.right, a.bottom);
    let corners = [(left, top), (right, top), (right, bottom), (left, bottom), (left, top)];
    canvas.line(&corners, frame_stroke);
    let font = Font { size: LABEL_SIZE, ..PLAIN };
    let middle = 0.5 * (a.left + a.right);
    if frame.x_labelled {
        canvas.text(&panel.x_label, (middle, a.bottom + 32.0), Anchor::Middle, font);
    }
    let font = Font { upwards: true, ..font };
    let middle = 0.5 * (a.top + a.bottom);
    canvas.text(&panel.y_label, (cell.left + 14.0, middle), Anchor::Middle, font);
    frame.legend.draw(canvas, a.left, cell.top + layout::TOP - 2.0);
}

fn draw_bands(canvas: &mut Canvas, panel: &Panel, frame: &Frame) {
    let a = frame.area;
    let clamp = |axis: &Axis, v: f64| {
        let f = if axis.log && v <= 0.0 { 0.0 } else { axis.fraction(v) };
        // Bands may be open: an end at infinity is the end of the axis.
        if f.is_nan() { 0.0 } else { f.clamp(0.0, 1.0) }
    };
    for mark in &panel.marks {
        let (from, to) = match mark.place {
            MarkPlace::XBand(from, to) => {
                let x = |v| a.left + clamp(&frame.x, v) * (a.right - a.left);
                ((x(from), a.top), (x(to), a.bottom))
            }
            MarkPlace::YBand(from, to) => {
                let y = |v| a.bottom - clamp(&frame.y, v) * (a.bottom - a.top);
                ((a.left, y(to)), (a.right, y(from)))
            }
            MarkPlace::XLine(_) | MarkPlace::YLine(_) => continue,
        };
        canvas.fill(from, to, mark.color, BAND_OPACITY);
    }
}

fn draw_grid(canvas: &mut Canvas, frame: &Frame) {
    let a = frame.area;
    let (w, h) = (a.right - a.left, a.bottom - a.top);
    let line = |canvas: &mut Canvas, from, to, tick: &Tick| {
        let color = if tick.text.is_empty() { FINE_GRID } else { GRID };
        canvas.line(&[from, to], Stroke { color, width: 1.0, dashed: false });
    };
    for tick in frame.x.ticks((w / X_SPACING) as usize) {
        let x = a.left + frame.x.fraction(tick.at).clamp(0.0, 1.0) * w;
        line(canvas, (x, a.top), (x, a.bottom), &tick);
        if !tick.text.is_empty() {
            canvas.text(&tick.text, (x, a.bottom + 13.0), Anchor::Middle, PLAIN);
        }
    }
    for tick in frame.y.ticks((h / Y_SPACING) as usize) {
        let y = a.bottom - frame.y.fraction(tick.at).clamp(0.0, 1.0) * h;
        line(canvas, (a.left, y), (a.right, y), &tick);
        if !tick.text.is_empty() {
            canvas.text(&tick.text, (a.left - 7.0, y), Anchor::End, PLAIN);
        }
    }
}

fn line_of(mark: &Mark, frame: &Frame) -> Option<[Pixel; 2]> {
    let a = frame.area;
    match mark.place {
        MarkPlace::XLine(x) => {
            let f = drawable(x, frame.x.log).then(|| frame.x.fraction(x))?;
            let x = a.left + f * (a.right - a.left);
            if (0.0..=1.0).contains(&f) { Some([(x, a.bottom), (x, a.top)]) } else { None }
        }
        MarkPlace::YLine(y) => {
            let f = drawable(y, frame.y.log).then(|| frame.y.fraction(y))?;
            let y = a.bottom - f * (a.bottom - a.top);
            if (0.0..=1.0).contains(&f) { Some([(a.left, y), (a.right, y)]) } else { None }
        }
        MarkPlace::XBand(..) | MarkPlace::YBand(..) => None,
    }
}

fn draw_series(canvas: &mut Canvas, series: &Series, frame: &Frame, budget: usize) {
    let a = frame.area;
    let window = (a.left, a.top, a.right, a.bottom);
    let inside = |p: &Pixel| {
        (a.left - 0.5..=a.right + 0.5).contains(&p.0)
            && (a.top - 0.5..=a.bottom + 0.5).contains(&p.1)
    };
    let style = &series.style;
    let parts = segments(series.points.iter().map(|p| frame.pixel(*p)));
    let all: usize = parts.iter().map(Vec::len).sum();
    // Each piece costs about ten points of text in addition to its own. A series torn into very many
    // pieces keeps evenly spread ones.
    let every = parts.len().div_ceil((budget / 20).max(1)).max(1);
    for part in parts.iter().step_by(every) {
        let short = decimate(part, (budget * part.len() / all.max(1)).max(4));
        if style.width > 0.0 {
            for line in clipped(&short, window) {
                canvas.line(&line, style.into());
            }
        }
        // A point between two gaps would leave nothing of a line.
        let alone = if part.len() == 1 { 0.5 * style.width.max(2.0) } else { 0.0 };
        if style.dot.max(alone) > 0.0 {
            let dots = if style.dot > 0.0 { part } else { &short };
            for p in dots.iter().filter(|p| inside(p)).take(budget / 8) {
                canvas.symbol(*p, style.dot.max(alone), style.symbol, style.color);
            }
        }
    }
}
