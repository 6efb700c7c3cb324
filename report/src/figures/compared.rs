//! Several models against one drive (the paper's Fig. 3), and several plants under one controller
//! along the reference road (its Fig. 5 to 7).

use super::tracking::{reference_road, tracking_errors};
use super::{DEG, text};
use crate::figure::{Figure, Mark, MarkPlace, Panel, Series, Style};
use crate::palette::{BLUE, Color, GREY, nth};
use crate::read::{StepResponse, Track};
use steerwright_formats::PathPoint;

/// The measurement, drawn under the simulations.
const HALO: Color = Color(185, 185, 185);

/// The validation data of a drive; yaw is the integral of the measured yaw rate. NaN is a gap.
#[derive(Debug, Clone, Copy)]
#[allow(missing_docs)]
pub struct Driven<'a> {
    pub time_s: &'a [f64],
    pub yaw_rate_radps: &'a [f64],
    pub yaw_rad: &'a [f64],
}

/// The simulation of the drive's steering by a model, sample by sample.
#[derive(Debug, Clone, Copy)]
#[allow(missing_docs)]
pub struct Simulated<'a> {
    pub name: &'a str,
    /// Fit of the yaw rate, percent.
    pub fit: f64,
    pub yaw_rate_radps: &'a [f64],
    pub yaw_rad: &'a [f64],
}

/// Yaw rate and yaw, measured and simulated, and what each simulation is off by.
pub fn models_against_drive(driven: Driven<'_>, models: &[Simulated<'_>]) -> Figure {
    let t = driven.time_s;
    let label = "Time (s)";
    // Wide and light: good simulations lie on it.
    let measured = Style::line(HALO).width(4.5);
    let over = |name: &str, y: &[f64], style: Style| Series::over(name, t, (y, DEG), style);
    let reference = over("measured", driven.yaw_rate_radps, measured);
    let mut rate = Panel::new(label, "Yaw rate (deg/s)").with(reference);
    let mut yaw = Panel::new(label, "Yaw (deg)").with(over("measured", driven.yaw_rad, measured));
    let mut error = Panel::new(label, "Yaw rate error (deg/s)").mark(zero());
    let mut drift = Panel::new(label, "Yaw error (deg)").mark(zero());
    for (k, model) in models.iter().enumerate() {
        let style = Style { dashed: k % 2 == 1, ..Style::line(nth(k)) };
        let (name, fit) = (model.name, format!(" (fit {} %)", text(model.fit, 2)));
        rate = rate.with(over(name, model.yaw_rate_radps, style).noted(fit));
        yaw = yaw.with(over(name, model.yaw_rad, style));
        let solid = Style { dashed: false, ..style }.width(1.0);
        let off = |simulated: &[f64], measured: &[f64]| -> Vec<f64> {
            simulated.iter().zip(measured).map(|(s, m)| s - m).collect()
        };
        let of_rate = off(model.yaw_rate_radps, driven.yaw_rate_radps);
        let of_yaw = off(model.yaw_rad, driven.yaw_rad);
        error = error.with(over(name, &of_rate, solid));
        drift = drift.with(over(name, &of_yaw, solid));
    }
    for panel in [&mut rate, &mut yaw] {
        panel.y_limits = panel.limits_of_the_first();
    }
    for panel in [&mut error, &mut yaw, &mut drift] {
        panel.weight = 0.8;
    }
    let fits: Vec<_> =
        models.iter().map(|m| format!("{} by {} %", m.name, text(m.fit, 2))).collect();
    let title = "Models against the drive, validation data";
    Figure::new(title, vec![rate, error, yaw, drift]).stating(format!(
        "The models fit the yaw rate of the validation data: {}.",
        fits.join(", ")
    ))
}

fn zero() -> Mark {
    Mark::new("", MarkPlace::YLine(0.0), GREY)
}

/// The reference road in the plane, and its curvature, with the lateral acceleration that it needs
/// at a speed in the legend.
pub fn road_and_curvature(points: &[PathPoint], closed: bool, speed: f64) -> Figure {
    let plane = reference_road(points, closed, &[]);
    let label = "Distance along the road (m)";
    let over = points.iter().map(|p| (p.distance_m, p.curvature_per_m)).collect();
    let most = points.iter().map(|p| p.curvature_per_m.abs()).fold(0.0, f64::max) * speed * speed;
    let name =
        format!("lateral acceleration up to {} m/s² at {} m/s", text(most, 2), text(speed, 2));
    let result = format!("The road requires {name}.");
    let curve = Series::new(name, over, Style::line(BLUE));
    let curvature = Panel::new(label, "Curvature (1/m)").mark(zero()).with(curve);
    let panels = plane.panels.into_iter().chain([curvature]).collect();
    Figure::new("Reference road", panels).stating(result)
}

/// One controller on several plants: the tracks in the plane, and cross-track error, yaw error and
/// steering along the road.
pub fn tracking(title: &str, points: &[PathPoint], closed: bool, on: &[(&str, &Track)]) -> Figure {
    let mut panels = reference_road(points, closed, on).panels;
    let errors = tracking_errors(on);
    panels.extend(errors.panels);
    // The plane is drawn to scale; what matters is below it.
    if let Some(plane) = panels.first_mut() {
        plane.weight = 1.3;
    }
    Figure::new(title, panels).stating(errors.result)
}

/// One of several yaw steps.
#[derive(Debug, Clone, Copy)]
#[allow(missing_docs)]
pub struct YawStep<'a> {
    pub name: &'a str,
    /// Steps of equal rank have one colour.
    pub rank: usize,
    /// Whether this is what was predicted, which is dashed.
    pub predicted: bool,
    pub response: &'a StepResponse,
}

/// Yaw steps to `height`, rad, next to each other, until a time: whole, about the height, and the
/// steering.
pub fn yaw_steps(height: f64, until: f64, steps: &[YawStep<'_>]) -> Figure {
    let label = "Time (s)";
    let aim = height * DEG;
    let mut yaw = Panel::new(label, "Yaw (deg)").mark(Mark::new("", MarkPlace::YLine(aim), GREY));
    let mut steering = Panel::new(label, "Steering angle (deg)");
    let mut reached = Vec::new();
    for step in steps {
        let r = step.response;
        let end = r.time_s.iter().take_while(|t| **t <= until).count();
        let style = Style { dashed: step.predicted, ..Style::line(nth(step.rank)) };
        let x = &r.time_s[..end];
        yaw = yaw.with(Series::over(step.name, x, (&r.yaw_rad[..end], DEG), style));
        let most = r.yaw_rad[..end].iter().fold(0.0, |m: f64, y| m.max(y * height.signum()));
        reached.push(format!("{} {} deg", step.name, text(most * DEG, 2)));
        steering = steering.with(Series::over(step.name, x, (&r.steering_rad[..end], DEG), style));
    }
    yaw.weight = 1.3;
    let mut near = Panel { y_label: "Yaw, magnified (deg)".into(), weight: 0.9, ..yaw.clone() };
    near.y_limits = Some((0.9 * aim, 1.1 * aim));
    let result = format!("Step to {} deg; largest yaw: {}.", text(aim, 2), reached.join(", "));
    Figure::new("Yaw steps", vec![yaw, near, steering]).stating(result)
}
