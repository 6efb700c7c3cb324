//! The layout of the panels of a figure: rows by weight, equal left edges, a common x range.
//!
//! Panels with the same x label share their range of x, and only the lowest of a column shows it.

use crate::Error;
use crate::axis::{Axis, drawable};
use crate::canvas::text_width;
use crate::decimate::Pixel;
use crate::figure::{Figure, MarkPlace, Panel};
use crate::legend::Legend;
use std::collections::HashSet;

pub(crate) const TICK_SIZE: f64 = 12.0;
pub(crate) const TITLE_HEIGHT: f64 = 30.0;
pub(crate) const TOP: f64 = 8.0;
/// Below the axis: its numbers, and its label.
const NUMBERS: f64 = 26.0;
const X_LABEL: f64 = 20.0;
const RIGHT: f64 = 16.0;
/// Between the cell's edge and the numbers: the y label.
const Y_LABEL: f64 = 26.0;
/// A panel must be at least that large inside its labels, px.
const LEAST: (f64, f64) = (200.0, 60.0);

/// A rectangle in pixels.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Area {
    pub(crate) left: f64,
    pub(crate) top: f64,
    pub(crate) right: f64,
    pub(crate) bottom: f64,
}

/// The axes of a panel on their place.
pub(crate) struct Frame {
    pub(crate) x: Axis,
    pub(crate) y: Axis,
    /// Inside the axes.
    pub(crate) area: Area,
    /// With labels and legend.
    pub(crate) cell: Area,
    /// Whether the label of x is shown here.
    pub(crate) x_labelled: bool,
    pub(crate) legend: Legend,
}

impl Frame {
    pub(crate) fn pixel(&self, (x, y): (f64, f64)) -> Option<Pixel> {
        if !drawable(x, self.x.log) || !drawable(y, self.y.log) {
            return None;
        }
        let a = &self.area;
        // Far outside is outside; numbers that large would not survive the arithmetic of pixels.
        let place = |f: f64| f.clamp(-1e4, 1e4);
        Some((
            a.left + place(self.x.fraction(x)) * (a.right - a.left),
            a.bottom - place(self.y.fraction(y)) * (a.bottom - a.top),
        ))
    }
}

pub(crate) fn frames(figure: &Figure, width: u32, height: u32) -> Result<Vec<Frame>, Error> {
    let panels = &figure.panels;
    let columns = figure.columns.clamp(1, panels.len().max(1));
    let cells = cells(panels, columns, f64::from(width), f64::from(height));
    let axes = panels
        .iter()
        .enumerate()
        .map(|(k, panel)| {
            let no_data = || Error::NoData { figure: figure.title.clone(), panel: k + 1 };
            let x = x_axis(panels, panel).ok_or_else(no_data)?;
            let y = y_axis(panel).ok_or_else(no_data)?;
            Ok((x, y))
        })
        .collect::<Result<Vec<_>, Error>>()?;
    let numbers =
        |y: &Axis| y.ticks(5).iter().map(|t| text_width(&t.text, TICK_SIZE)).fold(20.0, f64::max);
    let mut shown = HashSet::new();
    let mut out = Vec::new();
    for (k, (panel, cell)) in panels.iter().zip(cells).enumerate() {
        let (mut x, mut y) = axes[k];
        let column = axes.iter().skip(k % columns).step_by(columns);
        let left = cell.left + Y_LABEL + column.map(|(_, y)| numbers(y)).fold(0.0, f64::max) + 8.0;
        let right = cell.right - RIGHT;
        let x_labelled = panels.get(k + columns).is_none_or(|below| below.x_label != panel.x_label);
        let bottom = cell.bottom - NUMBERS - if x_labelled { X_LABEL } else { 0.0 };
        let legend = Legend::new(panel, right - left, &mut shown, k % columns);
        let area = Area { left, top: cell.top + TOP + legend.height(), right, bottom };
        let (w, h) = (area.right - area.left, area.bottom - area.top);
        if !(w >= LEAST.0 && h >= LEAST.1) || width.max(height) > 10_000 {
            let (title, panels) = (figure.title.clone(), panels.len());
            return Err(Error::Size { figure: title, width, height, panels });
        }
        if panel.equal_aspect && !panel.x_log && !panel.y_log {
            let unit = ((x.high - x.low) / w).max((y.high - y.low) / h);
            x = x.widened(unit * w);
            y = y.widened(unit * h);
        }
        out.push(Frame { x, y, area, cell, x_labelled, legend });
    }
    Ok(out)
}

/// Cells row by row; the height of a row is that of its heaviest panel.
fn cells(panels: &[Panel], columns: usize, width: f64, height: f64) -> Vec<Area> {
    let weight = |row: &[Panel]| row.iter().fold(0.0, |m: f64, p| m.max(p.weight));
    let total: f64 = panels.chunks(columns).map(weight).sum();
    let mut top = TITLE_HEIGHT;
    let mut out = Vec::new();
    for row in panels.chunks(columns) {
        let bottom = top + weight(row) / total * (height - TITLE_HEIGHT);
        let step = width / columns as f64;
        out.extend((0..row.len()).map(|k| {
            let left = k as f64 * step;
            Area { left, top, right: left + step, bottom }
        }));
        top = bottom;
    }
    out
}

/// The range of x of all panels with the same label.
fn x_axis(panels: &[Panel], panel: &Panel) -> Option<Axis> {
    points(panel).next()?;
    let alike = || {
        panels.iter().filter(|p| {
            (&p.x_label, p.x_log, p.equal_aspect)
                == (&panel.x_label, panel.x_log, panel.equal_aspect)
        })
    };
    // Time axes end with their data; curves in the plane and rows of dots need air.
    let dotted = |p: &Panel| p.series.iter().any(|s| s.style.dot > 0.0 && s.style.width > 0.0);
    let air = if panel.equal_aspect || alike().any(dotted) { 0.05 } else { 0.0 };
    let values = alike().flat_map(|p| {
        let marks = p.marks.iter().filter_map(|m| match m.place {
            MarkPlace::XLine(at) => Some(at),
            // A band, such as the validation data, never widens the range of the data.
            _ => None,
        });
        points(p).map(|p| p.0).chain(marks)
    });
    Axis::around(values, air, panel.x_log)
}

fn y_axis(panel: &Panel) -> Option<Axis> {
    if let Some((low, high)) = panel.y_limits
        && low < high
        && [low, high].iter().all(|v| drawable(*v, panel.y_log))
    {
        return Some(Axis { low, high, log: panel.y_log });
    }
    let marks = panel.marks.iter().flat_map(|m| match m.place {
        MarkPlace::YLine(at) => [at, at],
        MarkPlace::YBand(from, to) => [from, to],
        MarkPlace::XBand(..) | MarkPlace::XLine(_) => [f64::NAN; 2],
    });
    let air = if panel.equal_aspect { 0.05 } else { 0.06 };
    Axis::around(points(panel).map(|p| p.1).chain(marks), air, panel.y_log)
}

fn points(panel: &Panel) -> impl Iterator<Item = &(f64, f64)> {
    let seen = |p: &&(f64, f64)| drawable(p.0, panel.x_log) && drawable(p.1, panel.y_log);
    panel.series.iter().flat_map(|s| &s.points).filter(seen)
}
