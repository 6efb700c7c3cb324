//! The recorded drive: steering, yaw rate and its integral (the paper's Fig. 1 and 2).

use super::DEG;
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
        for (k, (from, to)) in traces.held_out_ranges().into_iter().enumerate() {
            let name = if k == 0 { "validation data" } else { "" };
            panel = panel.mark(Mark::new(name, Place::XBand(from, to), GREY));
        }
        panel
    };
    let mut panels = vec![
        panel("Steering angle (deg)", &traces.steering_rad, BLUE),
        panel("Yaw rate (deg/s)", &traces.yaw_rate_radps, BLACK),
        panel("Yaw (deg)", &traces.yaw_rad, BLACK),
    ];
    // One legend is enough.
    for panel in panels.iter_mut().skip(1) {
        panel.marks.iter_mut().for_each(|m| m.name.clear());
    }
    Figure::new("The drive: steering, yaw rate and its integral", panels)
}
