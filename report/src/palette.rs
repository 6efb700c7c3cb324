//! Colours that people with the common colour blindnesses can distinguish (Okabe and Ito 2008), and
//! the greys of the drawing itself.
#![allow(missing_docs)]

/// Red, green, blue, 0 to 255.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Color(pub u8, pub u8, pub u8);

impl Color {
    /// As `#rrggbb`.
    pub(crate) fn hex(self) -> String {
        format!("#{:02x}{:02x}{:02x}", self.0, self.1, self.2)
    }
}

/// Black: what was measured.
pub const BLACK: Color = Color(0, 0, 0);
pub const BLUE: Color = Color(0, 114, 178);
pub const VERMILION: Color = Color(213, 94, 0);
pub const GREEN: Color = Color(0, 158, 115);
pub const ORANGE: Color = Color(230, 159, 0);
pub const PURPLE: Color = Color(204, 121, 167);
pub const SKY: Color = Color(86, 180, 233);
/// Grey, for limits and marks.
pub const GREY: Color = Color(110, 110, 110);

/// Opacity of a band that marks a range.
pub(crate) const BAND_OPACITY: f64 = 0.14;
pub(crate) const TEXT: Color = Color(34, 34, 34);
pub(crate) const FRAME: Color = Color(130, 130, 130);
pub(crate) const GRID: Color = Color(225, 225, 225);
pub(crate) const FINE_GRID: Color = Color(241, 241, 241);

/// The colour of the n-th of several things of equal rank.
#[must_use]
pub fn nth(n: usize) -> Color {
    [BLUE, VERMILION, GREEN, ORANGE, PURPLE, SKY][n % 6]
}
