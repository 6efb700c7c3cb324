//! The figures of a report, each a function from plain data to a [`Figure`](crate::Figure).
//!
//! Angles are shown in degrees; everything handed over is SI and radians.

mod design;
mod drive;
mod evidence;
mod identification;
mod tracking;

pub use design::yaw_step;
pub use drive::drive;
pub use evidence::{frequency_response, poles_and_zeros, prediction, residuals};
pub use identification::{coherence, comparison, order_table};
pub use tracking::{reference_road, road_height, tracking_errors};

pub(crate) const DEG: f64 = 180.0 / std::f64::consts::PI;

/// A number with a proper minus sign.
pub(crate) fn text(value: f64, digits: usize) -> String {
    if !value.is_finite() {
        return "–".into();
    }
    let text = format!("{value:.digits$}");
    let zero = text.trim_start_matches('-').chars().all(|c| matches!(c, '0' | '.'));
    if zero { text.trim_start_matches('-').into() } else { text.replace('-', "−") }
}
