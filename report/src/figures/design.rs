//! The yaw step that the controller was designed for.

use super::{DEG, text};
use crate::figure::{Figure, Mark, MarkPlace, Panel, Series, Style, Symbol};
use crate::palette::{BLACK, BLUE, GREEN, GREY, ORANGE, VERMILION};
use crate::read::StepResponse;
use steerwright_formats::{Specification, StepMetrics};

/// Yaw and steering after a yaw step, with the band of the steady state, the largest overshoot
/// allowed, when the response settled, and the limits of the steering.
pub fn yaw_step(
    title: &str,
    response: &StepResponse,
    specification: &Specification,
    reached: &StepMetrics,
    largest_angle_rad: f64,
) -> Figure {
    let t = &response.time_s;
    let step = specification.step_rad * DEG;
    let band = specification.settling_band_percent;
    let end = t.iter().copied().filter(|t| t.is_finite()).fold(0.0, f64::max);
    let reference = vec![(0.0, step), (end, step)];
    let tolerance = 0.01 * band * step.abs();
    let overshoot = specification.overshoot_percent.map(|share| step * (1.0 + 0.01 * share));
    let overshot = format!("overshoot {} %", text(reached.overshoot_percent, 2));
    let steady = MarkPlace::YBand(step - tolerance, step + tolerance);
    let mut yaw = Panel::new("Time (s)", "Yaw (deg)")
        .with(Series::new("reference", reference, Style::line(GREY).width(1.0)))
        .with(
            Series::over("yaw", t, (&response.yaw_rad, DEG), Style::line(BLUE).width(2.0))
                .noted(format!(" ({overshot})")),
        )
        .mark(Mark::new(format!("±{} %", short(band)), steady, GREEN));
    if let (Some(line), Some(share)) = (overshoot, specification.overshoot_percent) {
        let name = format!("overshoot allowed {} %", short(share));
        yaw = yaw.mark(Mark::new(name, MarkPlace::YLine(line), VERMILION));
    }
    if let Some(time) = specification.settling_time_s {
        let name = format!("to settle by {} s", short(time));
        yaw = yaw.mark(Mark::new(name, MarkPlace::XLine(time), BLACK));
    }
    if let Some(settled) = reached.settling_time_s {
        let name = format!("settled at {} s", text(settled, 3));
        let at = value_at(t, &response.yaw_rad, settled) * DEG;
        let style = Style::symbols(ORANGE, Symbol::Dot, 4.5);
        yaw = yaw.with(Series::shape(name, vec![(settled, at)], style));
    }
    yaw.weight = 1.3;
    // The band is thin compared with the step: the same, magnified.
    let mut near = Panel { y_label: "Yaw, magnified (deg)".into(), ..yaw.clone() };
    near.series.iter_mut().for_each(|s| s.note.clear());
    let most = tolerance.max(overshoot.map_or(0.0, |line| (line - step).abs()));
    near.y_limits = if most > 0.0 { Some((step - 2.5 * most, step + 2.5 * most)) } else { None };
    near.weight = 0.8;
    let largest = largest_angle_rad * DEG;
    let used = format!("largest {} deg", text(reached.largest_angle_rad * DEG, 2));
    let mut steering = Panel::new("Time (s)", "Steering angle (deg)").with(
        Series::over("steering", t, (&response.steering_rad, DEG), Style::line(BLUE))
            .noted(format!(" ({used})")),
    );
    let limit = |name: String, at| Mark::new(name, MarkPlace::YLine(at), VERMILION);
    let name = format!("limits ±{} deg", short(largest));
    steering = steering.mark(limit(name, largest)).mark(limit(String::new(), -largest));
    let settled = match reached.settling_time_s {
        Some(s) => format!("settled at {} s", text(s, 3)),
        None => "never settled".to_owned(),
    };
    let panels = [yaw, near, steering].map(|p| Panel { link: "step", ..p }).to_vec();
    let result = format!(
        "The step to {} deg: {overshot}, {settled}; steering: {used} of {} deg.",
        text(step, 1),
        short(largest)
    );
    Figure::new(title, panels).stating(result)
}

/// Digits as few as a requirement was written with.
fn short(value: f64) -> String {
    format!("{}", (value * 100.0).round() / 100.0)
}

/// The response between its samples.
fn value_at(t: &[f64], y: &[f64], at: f64) -> f64 {
    let pairs = t.windows(2).zip(y.windows(2));
    let mut around = pairs.filter(|(t, _)| t[0] <= at && at <= t[1] && t[1] > t[0]);
    around.next().map_or(f64::NAN, |(t, y)| y[0] + (at - t[0]) / (t[1] - t[0]) * (y[1] - y[0]))
}
