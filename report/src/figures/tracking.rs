//! The reference road and how it was followed (the paper's Fig. 5 to 7).

use super::{DEG, metres, text};
use crate::figure::{Figure, Mark, MarkPlace, Panel, Series, Style, Symbol};
use crate::palette::{BLACK, Color, GREY, nth};
use crate::read::Track;
use steerwright_formats::PathPoint;

/// Light enough for the tracks to be seen on it.
const ROAD: Color = Color(200, 200, 200);

/// The reference road in the plane with the tracks of the controllers, by name.
pub fn reference_road(points: &[PathPoint], closed: bool, tracks: &[(&str, &Track)]) -> Figure {
    let mut road: Vec<_> = points.iter().map(|p| (p.x_m, p.y_m)).collect();
    if closed && let Some(first) = road.first().copied() {
        road.push(first);
    }
    let road = Series::new("reference road", road, Style::line(ROAD).width(5.0));
    let mut panel = Panel::new("x (m)", "y (m)").with(road);
    for (k, (name, track)) in tracks.iter().enumerate() {
        panel = panel.with(Series::new(
            *name,
            track.x_m.iter().copied().zip(track.y_m.iter().copied()).collect(),
            Style { dashed: k > 0, ..Style::line(nth(k)).width(1.6) },
        ));
    }
    let start = points.first().map(|p| (p.x_m, p.y_m)).into_iter().collect();
    panel = panel.with(Series::shape("start", start, Style::symbols(BLACK, Symbol::Dot, 4.5)));
    panel.equal_aspect = true;
    let off = |(name, track): &(&str, &Track)| {
        format!("{name} {} m", metres(track.errors().cross_track_max_m))
    };
    let off: Vec<_> = tracks.iter().map(off).collect();
    let figure = Figure::new("Reference road and tracks", vec![panel]);
    if off.is_empty() {
        figure
    } else {
        figure.stating(format!("Largest cross-track error: {}.", off.join(", ")))
    }
}

/// The height at which [`reference_road`] fills a width, in pixels.
#[must_use]
pub fn road_height(width: u32, points: &[PathPoint], tracks: &[(&str, &Track)]) -> u32 {
    let road = points.iter().map(|p| (p.x_m, p.y_m));
    let driven = tracks.iter().flat_map(|(_, t)| t.x_m.iter().copied().zip(t.y_m.iter().copied()));
    let empty = [f64::INFINITY, f64::NEG_INFINITY];
    let (x, y) = road
        .chain(driven)
        .filter(|p| p.0.is_finite() && p.1.is_finite())
        .fold((empty, empty), |(x, y), p| {
            ([x[0].min(p.0), x[1].max(p.0)], [y[0].min(p.1), y[1].max(p.1)])
        });
    let aspect = (y[1] - y[0]) / (x[1] - x[0]);
    let aspect = if aspect.is_finite() { aspect } else { 1.0 };
    (130.0 + f64::from(width) * aspect).clamp(280.0, 720.0) as u32
}

/// Cross-track error, yaw error and steering along the road, with their RMS in the legend.
///
/// Over distance where every track has it, else over time.
pub fn tracking_errors(tracks: &[(&str, &Track)]) -> Figure {
    let by_distance = tracks.iter().all(|(_, t)| t.distance_m.len() == t.time_s.len());
    let label = if by_distance { "Distance along the road (m)" } else { "Time (s)" };
    let steered = tracks.iter().any(|(_, t)| !t.steering_rad.is_empty());
    let zero = || Mark::new("", MarkPlace::YLine(0.0), GREY);
    let mut cross = Panel::new(label, "Cross-track error (m)").mark(zero());
    let mut yaw = Panel::new(label, "Yaw error (deg)").mark(zero());
    let mut steering = Panel::new(label, "Steering angle (deg)");
    let mut results = Vec::new();
    for (k, (name, track)) in tracks.iter().enumerate() {
        let x = if by_distance { &track.distance_m } else { &track.time_s };
        let style = Style { dashed: k > 0, ..Style::line(nth(k)) };
        let errors = track.errors();
        let off = format!("{} m", metres(errors.cross_track_rms_m));
        let turned = format!("{} deg", text(errors.heading_rms_rad * DEG, 3));
        let over = |y, note: &str| Series::over(*name, x, y, style).noted(note);
        cross = cross.with(over((&track.cross_track_error_m, 1.0), &format!(": RMS {off}")));
        yaw = yaw.with(over((&track.heading_error_rad, DEG), &format!(": RMS {turned}")));
        if !track.steering_rad.is_empty() {
            steering = steering.with(over((&track.steering_rad, DEG), ""));
        }
        results.push(format!("{name} {off} and {turned}"));
    }
    let mut panels = vec![cross, yaw];
    if steered {
        panels.push(steering);
    }
    panels.iter_mut().for_each(|p| p.link = "road");
    let result = format!("RMS of cross-track error and yaw error: {}.", results.join(", "));
    Figure::new("Errors along the road", panels).stating(result)
}
