//! The sheet that a figure is drawn on: the text of an SVG document.
//!
//! Coordinates are written in tenths of a pixel, so that smooth curves stay smooth and numbers short.

use crate::decimate::Pixel;
use crate::figure::{Style, Symbol};
use crate::markup::{escape, push};
use crate::palette::{Color, TEXT};

/// Units of the drawing in a pixel.
const FINE: f64 = 10.0;

/// The end of a text that its position names.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Anchor {
    Start,
    Middle,
    End,
}

#[derive(Debug, Clone, Copy)]
pub(crate) struct Stroke {
    pub(crate) color: Color,
    pub(crate) width: f64,
    pub(crate) dashed: bool,
}

impl From<&Style> for Stroke {
    fn from(style: &Style) -> Self {
        Self { color: style.color, width: style.width, dashed: style.dashed }
    }
}

/// Texts: size in pixels.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Font {
    pub(crate) size: f64,
    pub(crate) bold: bool,
    /// Turned to read upwards.
    pub(crate) upwards: bool,
}

pub(crate) struct Canvas {
    svg: String,
}

fn fine(length: f64) -> i64 {
    (length * FINE).round() as i64
}

impl Canvas {
    /// A white sheet of that size in pixels; `name` is what screen readers read.
    pub(crate) fn new(name: &str, width: u32, height: u32) -> Self {
        let (w, h) = (fine(width.into()), fine(height.into()));
        // Round joins: a noisy line would have spikes.
        let svg = format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" data-generator=\"{}\" width=\"{width}\" \
             height=\"{height}\" viewBox=\"0 0 {w} {h}\" role=\"img\" aria-label=\"{}\" \
             stroke-linejoin=\"round\" font-family=\"Helvetica, Arial, sans-serif\">\n\
             <rect width=\"{w}\" height=\"{h}\" fill=\"#ffffff\"/>\n",
            crate::GENERATOR,
            escape(name),
        );
        Self { svg }
    }

    pub(crate) fn finish(mut self) -> String {
        self.svg.push_str("</svg>\n");
        self.svg
    }

    pub(crate) fn line(&mut self, points: &[Pixel], stroke: Stroke) {
        let (color, width) = (stroke.color.hex(), fine(stroke.width));
        push!(self.svg, "<polyline fill=\"none\" stroke=\"{color}\" stroke-width=\"{width}\"");
        if stroke.dashed {
            let dash = 3.5 * stroke.width;
            push!(self.svg, " stroke-dasharray=\"{} {}\"", fine(dash), fine(0.56 * dash));
        }
        for (k, p) in points.iter().enumerate() {
            let before = if k == 0 { " points=\"" } else { " " };
            push!(self.svg, "{before}{},{}", fine(p.0), fine(p.1));
        }
        self.svg.push_str("\"/>\n");
    }

    /// A filled rectangle between two corners.
    pub(crate) fn fill(&mut self, a: Pixel, b: Pixel, color: Color, opacity: f64) {
        let (left, top) = (fine(a.0.min(b.0)), fine(a.1.min(b.1)));
        let (w, h) = (fine(a.0.max(b.0)) - left, fine(a.1.max(b.1)) - top);
        push!(
            self.svg,
            "<rect x=\"{left}\" y=\"{top}\" width=\"{w}\" height=\"{h}\" fill=\"{}\" \
                 opacity=\"{opacity:.3}\"/>\n",
            color.hex()
        );
    }

    pub(crate) fn symbol(&mut self, at: Pixel, radius: f64, symbol: Symbol, color: Color) {
        if symbol == Symbol::Cross {
            let stroke = Stroke { color, width: 2.0, dashed: false };
            for side in [-1.0, 1.0] {
                let (x, y) = (radius, side * radius);
                self.line(&[(at.0 - x, at.1 - y), (at.0 + x, at.1 + y)], stroke);
            }
            return;
        }
        let (x, y, r, color) = (fine(at.0), fine(at.1), fine(radius), color.hex());
        let paint = if symbol == Symbol::Ring {
            format!("fill=\"none\" stroke=\"{color}\" stroke-width=\"{}\"", fine(2.0))
        } else {
            format!("fill=\"{color}\"")
        };
        push!(self.svg, "<circle cx=\"{x}\" cy=\"{y}\" r=\"{r}\" {paint}/>\n");
    }

    /// A text with its middle at the height of the position.
    pub(crate) fn text(&mut self, text: &str, position: Pixel, anchor: Anchor, font: Font) {
        let (x, y, size) = (fine(position.0), fine(position.1), fine(font.size));
        let anchor = match anchor {
            Anchor::Start => "start",
            Anchor::Middle => "middle",
            Anchor::End => "end",
        };
        push!(
            self.svg,
            "<text x=\"{x}\" y=\"{y}\" dy=\"0.5ex\" text-anchor=\"{anchor}\" \
                 font-size=\"{size}\" fill=\"{}\"",
            TEXT.hex()
        );
        if font.bold {
            self.svg.push_str(" font-weight=\"bold\"");
        }
        if font.upwards {
            push!(self.svg, " transform=\"rotate(270, {x}, {y})\"");
        }
        push!(self.svg, ">{}</text>\n", escape(text));
    }
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
