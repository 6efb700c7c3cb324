//! The recorded drive: steering, yaw rate and its integral (the paper's Fig. 1 and 2).

use super::{DEG, text};
use crate::palette::{BLACK, BLUE, GREY};
use crate::{Figure, Mark, Panel, Place, Series, Style, Traces};

/// Steering angle, yaw rate and yaw of the drive over time.
#[must_use]
pub fn drive(traces: &Traces) -> Figure {
    let t = &traces.time_s;
    let thin = |color| Style::line(color).width(1.1);
    let panel = |label: &str, y: &[f64], color| {
        let mut panel =
            Panel::new("Time (s)", label).with(Series::over("", t, (y, DEG), thin(color)));
        for (k, (from, to)) in traces.validation_ranges().into_iter().enumerate() {
            let name = if k == 0 { "validation data" } else { "" };
            panel = panel.mark(Mark::new(name, Place::XBand(from, to), GREY));
        }
        Panel { link: "drive", ..panel }
    };
    let panels = vec![
        panel("Steering angle (deg)", &traces.steering_rad, BLUE),
        panel("Yaw rate (deg/s)", &traces.yaw_rate_radps, BLACK),
        panel("Yaw (deg)", &traces.yaw_rad, BLACK),
    ];
    let length = |(from, to): (f64, f64)| to - from;
    let most = |values: &[f64]| {
        let finite = values.iter().filter(|v| v.is_finite());
        text(DEG * finite.fold(0.0, |m: f64, v| m.max(v.abs())), 1)
    };
    let result = format!(
        "{} s, of which {} s are validation data; steering up to {} deg, yaw rate up to {} deg/s.",
        text(length((t.first().copied().unwrap_or(0.0), t.last().copied().unwrap_or(0.0))), 1),
        text(traces.validation_ranges().into_iter().map(length).sum(), 1),
        most(&traces.steering_rad),
        most(&traces.yaw_rate_radps),
    );
    Figure::new("The drive: steering, yaw rate and its integral", panels).stating(result)
}
