//! Figures: panels of series, marks and axes. [`Figure::to_svg`] draws it as SVG; the page of
//! [`crate::report_html`] has the same figure to zoom into.
//!
//! The same figure gives the same bytes. Values that are not finite leave a gap.

use crate::palette::Color;

/// A figure of one or more panels.
#[derive(Debug, Clone, PartialEq)]
#[allow(missing_docs)]
#[must_use]
pub struct Figure {
    pub title: String,
    /// The figure in one or two sentences with numbers, for screen readers.
    pub result: String,
    /// Panels next to each other in one row; 1 stacks them.
    pub columns: usize,
    pub panels: Vec<Panel>,
}

/// One pair of axes. The legend stands above it, where it covers no data.
#[derive(Debug, Clone, PartialEq)]
#[allow(missing_docs)]
#[must_use]
pub struct Panel {
    /// Label of the horizontal axis, with its unit.
    pub x_label: String,
    /// Label of the vertical axis, with its unit.
    pub y_label: String,
    pub series: Vec<Series>,
    /// Bands behind and lines across the curves.
    pub marks: Vec<Mark>,
    /// One unit is equally long on both axes, as on a map.
    pub equal_aspect: bool,
    /// Panels of a page with the same name here show the same range of x when one is zoomed; without
    /// a name, those of the figure with the same x label.
    pub link: &'static str,
    pub x_log: bool,
    pub y_log: bool,
    /// The range of y; the range of series and marks where absent. Curves are cut at it.
    pub y_limits: Option<(f64, f64)>,
    /// Share of the figure's height, relative to the other rows.
    pub weight: f64,
}

/// One curve.
#[derive(Debug, Clone, PartialEq)]
#[allow(missing_docs)]
#[must_use]
pub struct Series {
    /// For the legend; an empty name has no entry. Series of a figure with the same name are shown and
    /// hidden together, and the legend lists them once.
    pub name: String,
    /// Addition of the legend to the name, such as ` (fit 98 %)`.
    pub note: String,
    pub points: Vec<(f64, f64)>,
    /// Whether the points are data, with values under the cursor, and not the outline of a shape.
    pub is_data: bool,
    pub style: Style,
}

/// Style of a curve.
#[derive(Debug, Clone, Copy, PartialEq)]
#[allow(missing_docs)]
#[must_use]
pub struct Style {
    pub color: Color,
    /// Width of the line in pixels; 0 draws no line.
    pub width: f64,
    pub dashed: bool,
    /// Radius of a symbol at each point, in pixels; 0 draws none.
    pub dot: f64,
    pub symbol: Symbol,
}

/// A symbol at a point.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[allow(missing_docs)]
pub enum Symbol {
    #[default]
    Dot,
    Cross,
    Ring,
}

/// A band or line that is not data.
#[derive(Debug, Clone, PartialEq)]
#[must_use]
pub struct Mark {
    /// For the legend; an empty name has no entry.
    pub name: String,
    /// Its place.
    pub place: MarkPlace,
    /// Its colour; bands are drawn faint.
    pub color: Color,
}

/// Place of a mark.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum MarkPlace {
    /// A range of x, over the full height.
    XBand(f64, f64),
    /// A range of y, over the full width.
    YBand(f64, f64),
    /// A dashed upright line.
    XLine(f64),
    /// A dashed level line.
    YLine(f64),
}

impl Style {
    /// A line of usual width.
    pub const fn line(color: Color) -> Self {
        Self { color, width: 1.5, dashed: false, dot: 0.0, symbol: Symbol::Dot }
    }

    /// A dashed line.
    pub const fn dashed(color: Color) -> Self {
        Self { dashed: true, ..Self::line(color) }
    }

    /// Dots joined by a thin line.
    pub const fn dots(color: Color) -> Self {
        Self { dot: 3.5, ..Self::line(color).width(1.0) }
    }

    /// Symbols without a line.
    pub const fn symbols(color: Color, symbol: Symbol, dot: f64) -> Self {
        Self { symbol, dot, ..Self::line(color).width(0.0) }
    }

    /// The same with another width.
    pub const fn width(self, width: f64) -> Self {
        Self { width, ..self }
    }
}

impl Series {
    /// A curve through points.
    pub fn new(name: impl Into<String>, points: Vec<(f64, f64)>, style: Style) -> Self {
        Self { name: name.into(), note: String::new(), points, is_data: true, style }
    }

    /// The same with an addition to its name in the legend.
    pub fn noted(self, note: impl Into<String>) -> Self {
        Self { note: note.into(), ..self }
    }

    /// The outline of a shape.
    pub fn shape(name: impl Into<String>, points: Vec<(f64, f64)>, style: Style) -> Self {
        Self { is_data: false, ..Self::new(name, points, style) }
    }

    /// A curve of `y` over `x`, both of equal length, each times a factor (for units).
    pub fn over(
        name: impl Into<String>,
        x: &[f64],
        (y, factor): (&[f64], f64),
        style: Style,
    ) -> Self {
        Self::new(name, x.iter().zip(y).map(|(x, y)| (*x, factor * y)).collect(), style)
    }
}

impl Mark {
    /// A mark with a name for the legend.
    pub fn new(name: impl Into<String>, place: MarkPlace, color: Color) -> Self {
        Self { name: name.into(), place, color }
    }
}

impl Panel {
    /// Empty axes with their labels.
    pub fn new(x_label: impl Into<String>, y_label: impl Into<String>) -> Self {
        Self {
            x_label: x_label.into(),
            y_label: y_label.into(),
            series: Vec::new(),
            marks: Vec::new(),
            equal_aspect: false,
            link: "",
            x_log: false,
            y_log: false,
            y_limits: None,
            weight: 1.0,
        }
    }

    /// Adds a curve.
    pub fn with(mut self, series: Series) -> Self {
        self.series.push(series);
        self
    }

    /// Adds a band or line.
    pub fn mark(mut self, mark: Mark) -> Self {
        self.marks.push(mark);
        self
    }

    /// Where another series leaves the range of the first by far, that range, half as wide again to
    /// each side: a simulation that runs away should be seen to leave, not flatten the rest.
    pub(crate) fn limits_of_the_first(&self) -> Option<(f64, f64)> {
        let range = |series: &Series| {
            let values = series.points.iter().map(|p| p.1).filter(|v| v.is_finite());
            values.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), v| (a.min(v), b.max(v)))
        };
        let (low, high) = self.series.first().map(range)?;
        let width = high - low;
        let away = |s: &Series| {
            let (a, b) = range(s);
            a < low - 3.0 * width || b > high + 3.0 * width
        };
        if width > 0.0 && self.series.iter().any(away) {
            Some((low - 0.5 * width, high + 0.5 * width))
        } else {
            None
        }
    }
}

impl Figure {
    /// A figure of stacked panels.
    pub fn new(title: impl Into<String>, panels: Vec<Panel>) -> Self {
        Self { title: title.into(), result: String::new(), columns: 1, panels }
    }

    /// The same with what it shows.
    pub fn stating(self, result: impl Into<String>) -> Self {
        Self { result: result.into(), ..self }
    }
}
