//! The figures of a page as JSON, for the scripts in `page`: the description that also gives the SVG, with
//! the axes of `layout`.
//!
//! Columns of numbers are stored once, however many series use them, as differences of integers: a
//! value is the sum so far over 10 to the power of `e`, `null` is a gap. Six digits stay. Columns of
//! logarithmic axes are stored as they are, with six digits each.

use crate::axis::drawable;
use crate::figure::{Figure, Mark, MarkPlace, Panel, Series, Symbol};
use crate::layout::{self, Frame};
use crate::{Error, WIDTH};
use serde_json::{Value, json};
use std::collections::HashMap;

/// The figures of a page in at most about `bytes`: series are thinned out until that is enough, and
/// keep the least and the largest value of each interval. Also how many points of how many each figure
/// keeps.
pub(crate) fn encode(
    figures: &[(&Figure, u32)],
    bytes: usize,
) -> Result<(String, Vec<(usize, usize)>), Error> {
    let longest =
        |f: &Figure| f.panels.iter().flat_map(|p| &p.series).map(|s| s.points.len()).max();
    let mut most = figures.iter().filter_map(|(f, _)| longest(f)).max().unwrap_or(0);
    loop {
        let mut pool = Pool { most, ..Pool::default() };
        let all: Vec<Value> =
            figures.iter().map(|(f, height)| pool.figure(f, *height)).collect::<Result<_, _>>()?;
        let size: usize = pool.columns.iter().map(String::len).sum();
        if size <= bytes || most < 200 {
            let text = Value::from(all).to_string();
            let json = format!("{{\"columns\":[{}],\"figures\":{text}}}", pool.columns.join(","));
            // Names may hold what HTML or XML takes for markup; within JSON that is only in strings.
            let escaped =
                json.replace('<', "\\u003c").replace('>', "\\u003e").replace('&', "\\u0026");
            return Ok((escaped, pool.kept));
        }
        // Somewhat less than its share: columns that series have in common are thinned out apart.
        most = (most * 2 / 3).min((0.8 * most as f64 * bytes as f64 / size as f64) as usize);
    }
}

/// The columns of a page.
#[derive(Default)]
struct Pool {
    /// Points that a series may keep.
    most: usize,
    columns: Vec<String>,
    places: HashMap<String, usize>,
    kept: Vec<(usize, usize)>,
}

impl Pool {
    fn figure(&mut self, figure: &Figure, height: u32) -> Result<Value, Error> {
        let frames = layout::frames(figure, WIDTH, height)?;
        self.kept.push((0, 0));
        let panels: Vec<Value> =
            figure.panels.iter().zip(&frames).map(|(p, f)| self.panel(p, f)).collect();
        Ok(json!({ "title": figure.title, "columns": figure.columns, "panels": panels }))
    }

    fn panel(&mut self, panel: &Panel, frame: &Frame) -> Value {
        let series: Vec<Value> = panel.series.iter().map(|s| self.series(s, panel)).collect();
        let (a, x, y) = (frame.area, frame.x, frame.y);
        json!({
            "x": {"label": panel.x_label, "log": x.log, "range": [x.low, x.high]},
            "y": {"label": panel.y_label, "log": y.log, "range": [y.low, y.high]},
            "link": panel.link,
            "labelled": frame.x_labelled,
            "equal": panel.equal_aspect,
            "size": [(a.right - a.left).round(), (a.bottom - a.top).round()],
            "series": series,
            "marks": panel.marks.iter().map(mark).collect::<Vec<_>>(),
        })
    }

    fn series(&mut self, series: &Series, panel: &Panel) -> Value {
        let can = |p: &(f64, f64)| drawable(p.0, panel.x_log) && drawable(p.1, panel.y_log);
        let points: Vec<Option<(f64, f64)>> =
            series.points.iter().map(|p| if can(p) { Some(*p) } else { None }).collect();
        let thin = thinned(&points, self.most);
        if let Some(kept) = self.kept.last_mut() {
            *kept = (kept.0 + thin.len(), kept.1 + points.len());
        }
        // Where nothing was left out, a gap of y has its x: then all curves over one time share it.
        let whole = thin.len() == points.len();
        let raw = |k: usize| Some(series.points.get(k)?.0).filter(|x| drawable(*x, panel.x_log));
        let x: Vec<Option<f64>> =
            (0..).zip(&thin).map(|(k, p)| if whole { raw(k) } else { p.map(|p| p.0) }).collect();
        let y: Vec<Option<f64>> = thin.iter().map(|p| p.map(|p| p.1)).collect();
        let style = series.style;
        json!({
            "name": series.name,
            "note": series.note,
            "isData": series.is_data,
            "color": style.color.hex(),
            "width": style.width,
            "dashed": style.dashed,
            "dot": style.dot,
            "symbol": match style.symbol {
                Symbol::Dot => "dot",
                Symbol::Cross => "cross",
                Symbol::Ring => "ring",
            },
            "x": self.column(&x, panel.x_log, true),
            "y": self.column(&y, panel.y_log, false),
        })
    }

    /// The place of a column among those of the page.
    fn column(&mut self, values: &[Option<f64>], log: bool, is_x: bool) -> usize {
        let text = column(values, log, is_x);
        *self.places.entry(text).or_insert_with_key(|text| {
            self.columns.push(text.clone());
            self.columns.len() - 1
        })
    }
}

/// Of each of `most / 2` intervals the least and the largest, and gaps.
fn thinned(points: &[Option<(f64, f64)>], most: usize) -> Vec<Option<(f64, f64)>> {
    if points.len() <= most {
        return points.to_vec();
    }
    let length = points.len().div_ceil((most / 2).max(1));
    let mut out = Vec::with_capacity(most + 2);
    for part in points.chunks(length) {
        let by = |a: &(usize, f64), b: &(usize, f64)| a.1.total_cmp(&b.1);
        let values = || part.iter().enumerate().filter_map(|(k, p)| Some((k, p.as_ref()?.1)));
        let gap = part.iter().position(Option::is_none);
        let mut keep: Vec<usize> = [values().min_by(by), values().max_by(by)]
            .into_iter()
            .flatten()
            .map(|(k, _)| k)
            .chain(gap)
            .collect();
        keep.sort_unstable();
        keep.dedup();
        out.extend(keep.into_iter().map(|k| part[k]));
    }
    out
}

fn column(values: &[Option<f64>], log: bool, is_x: bool) -> String {
    if log {
        let digits = |v: &Option<f64>| {
            v.and_then(|v| format!("{v:.5e}").parse().ok()).map_or(Value::Null, |v: f64| json!(v))
        };
        return json!({ "v": values.iter().map(digits).collect::<Vec<_>>() }).to_string();
    }
    let finite = || values.iter().flatten().copied();
    let largest = finite().fold(0.0, |m: f64, v| m.max(v.abs()));
    let power = |v: f64| if v > 0.0 { v.log10().floor() as i32 } else { 0 };
    let mut decimals = 5 - power(largest);
    if is_x {
        // Steps of time keep three digits however long the drive is.
        let (low, high) =
            finite().fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), v| (a.min(v), b.max(v)));
        if high > low {
            decimals = decimals.max(3 - power((high - low) / values.len() as f64));
        }
    }
    let decimals = decimals.min(14 - power(largest));
    let mut before = 0;
    let mut text = format!("{{\"e\":{decimals},\"d\":[");
    for (k, value) in values.iter().enumerate() {
        if k > 0 {
            text.push(',');
        }
        match value {
            None => text.push_str("null"),
            Some(value) => {
                // Below 2⁵³: `decimals` is at most 14 beyond the largest.
                let scaled = scaled(*value, decimals);
                text.push_str(&(scaled - before).to_string());
                before = scaled;
            }
        }
    }
    text + "]}"
}

fn scaled(value: f64, decimals: i32) -> i64 {
    // Powers beyond 10³⁰⁸ overflow, so that both halves are multiplied.
    let half = decimals / 2;
    (value * 10f64.powi(half) * 10f64.powi(decimals - half)).round() as i64
}

fn mark(mark: &Mark) -> Value {
    let end = |v: f64| if v.is_finite() { json!(v) } else { Value::Null };
    let (kind, from, to) = match mark.place {
        MarkPlace::XBand(from, to) => ("x", end(from), end(to)),
        MarkPlace::YBand(from, to) => ("y", end(from), end(to)),
        MarkPlace::XLine(at) => ("x", end(at), end(at)),
        MarkPlace::YLine(at) => ("y", end(at), end(at)),
    };
    let is_band = matches!(mark.place, MarkPlace::XBand(..) | MarkPlace::YBand(..));
    json!({
        "name": mark.name, "axis": kind, "from": from, "to": to, "isBand": is_band,
        "color": mark.color.hex(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::WIDTH;
    use crate::figure::Style;
    use crate::palette::BLUE;

    /// What the page reads from a column.
    fn decoded(text: &str) -> Vec<Option<f64>> {
        let column: Value = serde_json::from_str(text).unwrap();
        if let Some(values) = column["v"].as_array() {
            return values.iter().map(Value::as_f64).collect();
        }
        let (mut sum, e) = (0, column["e"].as_i64().unwrap() as i32);
        let value = |d: &Value| {
            sum += d.as_i64()?;
            Some(sum as f64 / 10f64.powi(e))
        };
        column["d"].as_array().unwrap().iter().map(value).collect()
    }

    #[test]
    fn six_digits_and_gaps_stay() {
        for scale in [1e-12, 1.0, 3e3, 1e140] {
            let values: Vec<_> = (0..200)
                .map(|k| (k % 7 > 0).then(|| scale * (f64::from(k) * 0.37).sin()))
                .collect();
            let read = decoded(&column(&values, false, false));
            for (a, b) in values.iter().zip(&read) {
                assert_eq!(a.is_some(), b.is_some());
                let (a, b) = (a.unwrap_or(0.0), b.unwrap_or(0.0));
                assert!((a - b).abs() <= 1e-5 * scale, "{a} {b}");
            }
        }
        // A day at 200 Hz.
        let times: Vec<_> = (0..1000).map(|k| Some(86_400.0 + 0.005 * f64::from(k))).collect();
        let read = decoded(&column(&times, false, true));
        assert!(times.iter().zip(read).all(|(a, b)| (a.unwrap() - b.unwrap()).abs() < 1e-6));
        assert_eq!(decoded(&column(&[Some(1e-9), Some(123.0)], true, false))[0], Some(1e-9));
    }

    #[test]
    fn shared_columns_are_stored_once_and_long_ones_are_thinned_out() {
        let x: Vec<f64> = (0..50_000).map(|k| f64::from(k) * 0.01).collect();
        let noise: Vec<f64> = (0..50_000u32).map(|k| f64::from(k * 7919 % 1009)).collect();
        let series = |name| Series::over(name, &x, (&noise, 1.0), Style::line(BLUE));
        let panel = Panel::new("x", "y").with(series("a")).with(series("b"));
        let figure = Figure::new("f", vec![panel]);
        let all = [(&figure, 400)];
        let (json, kept) = encode(&all, usize::MAX).unwrap();
        assert_eq!(kept, [(100_000, 100_000)]);
        assert!(WIDTH > 0 && json.matches("\"e\":").count() == 2);
        let (json, kept) = encode(&all, 60_000).unwrap();
        assert!(json.len() < 70_000 && kept[0].0 < 20_000, "{} {kept:?}", json.len());
        assert!(json.contains("\"range\":[0.0,499.99]"), "the axes stay: {}", &json[..200]);
    }
}
