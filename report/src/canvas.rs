//! The sheet a figure is drawn on: plotters' SVG backend, made finer.
//!
//! plotters draws at whole pixels, which makes smooth curves ragged. The sheet is therefore
//! [`FINE`] times larger inside, and its head says the size asked for. The head also carries what
//! plotters cannot say: round joins (a noisy line would have spikes), a role and a name for screen
//! readers. Dashes are drawn one by one, since plotters' backend has none.

use crate::Error;
use crate::decimate::Pixel;
use crate::palette::{Color, TEXT};
use plotters::coord::Shift;
use plotters::prelude::*;
use plotters::style::Color as _;
use plotters::style::text_anchor::{HPos, Pos, VPos};

/// Units of the drawing in a pixel.
const FINE: f64 = 10.0;
/// plotters divides a font's size by this.
const FONT_FACTOR: f64 = 1.24;
/// No more dashes than this in a line: a long one gets longer dashes.
const MOST_DASHES: f64 = 160.0;

/// The end of a text that its position names.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Anchor {
    Start,
    Middle,
    End,
}

/// Stroke of a line.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Stroke {
    pub(crate) color: Color,
    pub(crate) width: f64,
    pub(crate) dashed: bool,
}

/// Texts: size in pixels.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Font {
    pub(crate) size: f64,
    pub(crate) bold: bool,
    /// Turned to read upwards.
    pub(crate) upwards: bool,
}

pub(crate) struct Canvas<'a> {
    area: DrawingArea<SVGBackend<'a>, Shift>,
    figure: &'a str,
}

fn at(p: Pixel) -> (i32, i32) {
    ((p.0 * FINE).round() as i32, (p.1 * FINE).round() as i32)
}

fn paint(color: Color, opacity: f64) -> RGBAColor {
    RGBColor(color.0, color.1, color.2).mix(opacity)
}

/// Draws on a sheet of that size, in pixels, and gives the SVG.
pub(crate) fn draw(
    figure: &str,
    (width, height): (u32, u32),
    content: impl FnOnce(&Canvas<'_>) -> Result<(), Error>,
) -> Result<String, Error> {
    let mut svg = String::new();
    let fine = |length: u32| length * FINE as u32;
    let area = SVGBackend::with_string(&mut svg, (fine(width), fine(height))).into_drawing_area();
    let canvas = Canvas { area, figure };
    canvas.done(canvas.area.fill(&WHITE))?;
    content(&canvas)?;
    canvas.done(canvas.area.present())?;
    drop(canvas);
    let body = svg.find('>').map_or("", |end| &svg[end + 1..]);
    Ok(format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" data-generator=\"{}\" width=\"{width}\" height=\"{height}\" \
         viewBox=\"0 0 {} {}\" role=\"img\" aria-label=\"{}\" stroke-linejoin=\"round\">{}",
        crate::GENERATOR,
        fine(width),
        fine(height),
        crate::html::escape(figure),
        // plotters states the opacity of everything.
        body.replace(" opacity=\"1\"", "").replace(" \"/>", "\"/>"),
    ))
}

impl Canvas<'_> {
    fn done<T, E: std::fmt::Display>(&self, result: Result<T, E>) -> Result<T, Error> {
        result.map_err(|e| Error::Drawing { figure: self.figure.into(), problem: e.to_string() })
    }

    pub(crate) fn line(&self, points: &[Pixel], stroke: Stroke) -> Result<(), Error> {
        if stroke.dashed {
            for dash in dashes(points, stroke.width) {
                self.solid(&dash, stroke)?;
            }
            return Ok(());
        }
        self.solid(points, stroke)
    }

    fn solid(&self, points: &[Pixel], stroke: Stroke) -> Result<(), Error> {
        let style = ShapeStyle {
            color: paint(stroke.color, 1.0),
            filled: false,
            stroke_width: (stroke.width * FINE).round() as u32,
        };
        let fine: Vec<_> = points.iter().map(|p| at(*p)).collect();
        self.done(self.area.draw(&PathElement::new(fine, style)))
    }

    /// A filled rectangle between two corners.
    pub(crate) fn fill(&self, a: Pixel, b: Pixel, color: Color, opacity: f64) -> Result<(), Error> {
        let style = paint(color, opacity).filled();
        self.done(self.area.draw(&Rectangle::new([at(a), at(b)], style)))
    }

    /// A filled circle.
    pub(crate) fn dot(&self, middle: Pixel, radius: f64, color: Color) -> Result<(), Error> {
        let style = paint(color, 1.0).filled();
        self.done(self.area.draw(&Circle::new(at(middle), (radius * FINE).round() as i32, style)))
    }

    /// A text with its middle at the height of the position.
    pub(crate) fn text(
        &self,
        text: &str,
        position: Pixel,
        anchor: Anchor,
        font: Font,
    ) -> Result<(), Error> {
        let horizontal = match anchor {
            Anchor::Start => HPos::Left,
            Anchor::Middle => HPos::Center,
            Anchor::End => HPos::Right,
        };
        let mut style = FontDesc::new(
            FontFamily::Name("Helvetica, Arial, sans-serif"),
            font.size * FINE * FONT_FACTOR,
            if font.bold { FontStyle::Bold } else { FontStyle::Normal },
        )
        .color(&paint(TEXT, 1.0))
        .pos(Pos::new(horizontal, VPos::Center));
        if font.upwards {
            style = style.transform(FontTransform::Rotate270);
        }
        self.done(self.area.draw_text(&crate::html::printable(text), &style, at(position)))
    }
}

/// The dashes of a polyline, by arc length.
fn dashes(points: &[Pixel], width: f64) -> Vec<Vec<Pixel>> {
    let length: f64 = points.windows(2).map(|w| (w[1].0 - w[0].0).hypot(w[1].1 - w[0].1)).sum();
    let on = (3.5 * width).max(0.64 * length / MOST_DASHES);
    let off = 0.56 * on;
    let mut out: Vec<Vec<Pixel>> = Vec::new();
    let (mut drawing, mut left) = (true, on);
    if let Some(first) = points.first() {
        out.push(vec![*first]);
    }
    for pair in points.windows(2) {
        let (a, b) = (pair[0], pair[1]);
        let whole = (b.0 - a.0).hypot(b.1 - a.1);
        let mut gone = 0.0;
        while whole - gone > left {
            gone += left;
            let here = (a.0 + gone / whole * (b.0 - a.0), a.1 + gone / whole * (b.1 - a.1));
            if drawing {
                if let Some(dash) = out.last_mut() {
                    dash.push(here);
                }
            } else {
                out.push(vec![here]);
            }
            drawing = !drawing;
            left = if drawing { on } else { off };
        }
        left -= whole - gone;
        if drawing && let Some(dash) = out.last_mut() {
            dash.push(b);
        }
    }
    out
}

/// Width of a text in pixels, about that of Helvetica.
pub(crate) fn text_width(text: &str, size: f64) -> f64 {
    let em: f64 = text
        .chars()
        .map(|c| match c {
            'i' | 'j' | 'l' | '\'' | '|' => 0.23,
            ' ' | '.' | ',' | ':' | ';' | '!' | '/' | 'I' | 't' | 'f' | '(' | ')' | '[' | ']'
            | '-' => 0.3,
            'r' => 0.34,
            'm' | 'M' | '%' | 'W' | '@' => 0.88,
            'w' | 'A'..='Z' | '+' | '−' | '=' | '<' | '>' | '±' => 0.7,
            _ if c.is_ascii() => 0.56,
            '\u{300}'..='\u{36f}' => 0.0,
            '\u{80}'..='\u{24ff}' => 0.6,
            c if is_wide(c) => 1.05,
            _ => 0.9,
        })
        .sum();
    // Other fonts than Helvetica are a little wider.
    1.06 * em * size
}

/// Whether a character is as wide as two (Chinese, Japanese, Korean, emoji), roughly.
pub(crate) fn is_wide(c: char) -> bool {
    matches!(c, '\u{1100}'..='\u{115f}' | '\u{2e80}'..='\u{a4cf}' | '\u{ac00}'..='\u{d7a3}'
        | '\u{f900}'..='\u{faff}' | '\u{fe30}'..='\u{fe6f}' | '\u{ff00}'..='\u{ff60}'
        | '\u{1f300}'..='\u{1faff}' | '\u{20000}'..='\u{3fffd}')
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn dashes_cover_two_thirds_of_the_way_and_are_few() {
        let zigzag: Vec<Pixel> =
            (0..2000).map(|k| (f64::from(k), if k % 2 == 0 { 0.0 } else { 100.0 })).collect();
        let length = |p: &[Pixel]| -> f64 {
            p.windows(2).map(|w| (w[1].0 - w[0].0).hypot(w[1].1 - w[0].1)).sum()
        };
        let parts = dashes(&zigzag, 1.5);
        assert!(parts.len() <= 170, "{}", parts.len());
        let covered: f64 = parts.iter().map(|p| length(p)).sum();
        assert!((covered / length(&zigzag) - 0.64).abs() < 0.02);
    }
}
