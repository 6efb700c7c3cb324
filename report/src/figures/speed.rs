//! Figures of the speed: the profile over a path, and the responses of a speed controller.

use super::text;
use crate::figure::{Figure, Mark, MarkPlace, Panel, Series, Style};
use crate::palette::{BLACK, GREEN, GREY, VERMILION, nth};
use steerwright_formats::{Path, ProfileLimit, ProfilePoint, SpeedProfile, SpeedSpecification};

/// Speed and accelerations of a profile over the distance along its path, each part in the colour of the limit that binds
/// there.
pub fn speed_profile(path: &Path, profile: &SpeedProfile) -> Figure {
    let label = "Distance along the path (m)";
    let over = |value: &dyn Fn(f64, f64, f64) -> f64| -> Vec<(f64, f64)> {
        let at = |p: &ProfilePoint| {
            (p.distance_m, value(p.distance_m, p.speed_mps, p.acceleration_mps2))
        };
        profile.points.iter().map(at).collect()
    };
    let points = curvatures(path, profile);
    let curvature = |distance: f64| curvature_at(&points, distance);
    let speed = over(&|_, speed, _| speed);
    let along = over(&|_, _, acceleration| acceleration);
    let across = over(&|distance, speed, _| speed * speed * curvature(distance));
    let thin = Style::line(GREY).width(1.0);
    let mut speeds =
        Panel::new(label, "Speed (m/s)").with(Series::new("no limit binds", speed.clone(), thin));
    let mut longitudinal = Panel::new(label, "Acceleration (m/s²)").with(Series::new(
        "no limit binds",
        along.clone(),
        thin,
    ));
    let mut lateral = Panel::new(label, "Lateral acceleration (m/s²)").with(Series::new(
        "no limit binds",
        across.clone(),
        thin,
    ));
    let mut binding = Vec::new();
    for (rank, limit) in ProfileLimit::ALL.into_iter().enumerate() {
        let segments: Vec<_> = profile.binding.iter().filter(|s| s.limit == limit).collect();
        if segments.is_empty() {
            continue;
        }
        let name = limit.name().replace('-', " ");
        let time = segments.iter().fold(0.0, |time, s| time + s.time_s);
        binding.push(format!("{name} {} %", text(100.0 * time / profile.time_s, 1)));
        // Where another limit binds the curve has a gap.
        let bound = |curve: &[(f64, f64)]| -> Vec<(f64, f64)> {
            let is_bound = |x: f64| segments.iter().any(|s| s.from_m <= x && x <= s.to_m);
            curve.iter().map(|&(x, y)| (x, if is_bound(x) { y } else { f64::NAN })).collect()
        };
        let style = Style::line(if rank < 6 { nth(rank) } else { BLACK }).width(2.5);
        let style = Style { dashed: rank >= 6, ..style };
        speeds = speeds.with(Series::new(name.clone(), bound(&speed), style));
        longitudinal = longitudinal.with(Series::new(name.clone(), bound(&along), style));
        lateral = lateral.with(Series::new(name, bound(&across), style));
    }
    let limits = &profile.limits;
    let line = |at: f64| Mark::new("", MarkPlace::YLine(at), VERMILION);
    longitudinal = longitudinal
        .mark(line(limits.max_acceleration_mps2))
        .mark(line(-limits.max_deceleration_mps2));
    let largest = limits.max_lateral_acceleration_mps2;
    lateral = lateral.mark(line(largest)).mark(line(-largest));
    speeds.weight = 1.3;
    let panels = [speeds, longitudinal, lateral].map(|p| Panel { link: "distance", ..p }).to_vec();
    let result = format!(
        "The path takes {} s; of this time a limit binds: {}.",
        text(profile.time_s, 2),
        if binding.is_empty() { "none".to_owned() } else { binding.join(", ") }
    );
    Figure::new("Speed profile", panels).stating(result)
}

/// Distance and curvature, 1/m, of the points of a path up to the end of its profile, where a lap ends as it begins.
fn curvatures(path: &Path, profile: &SpeedProfile) -> Vec<(f64, f64)> {
    let mut all: Vec<_> = path.points.iter().map(|p| (p.distance_m, p.curvature_per_m)).collect();
    if let (true, Some(first), Some(end)) =
        (path.closed, path.points.first(), profile.points.last())
    {
        all.push((end.distance_m, first.curvature_per_m));
    }
    all
}

/// The curvature at a distance, linear between the points.
fn curvature_at(points: &[(f64, f64)], distance: f64) -> f64 {
    let after = points.partition_point(|(at, _)| *at <= distance);
    let before = points.get(after.saturating_sub(1));
    let (Some((from, a)), Some((to, b))) = (before, points.get(after)) else {
        return points.last().map_or(0.0, |(_, curvature)| *curvature);
    };
    let share = if to > from { (distance - from) / (to - from) } else { 0.0 };
    a + share.clamp(0.0, 1.0) * (b - a)
}

/// The responses of a speed controller at one speed: the change of the speed, m/s, at ticks.
#[derive(Debug, Clone, PartialEq)]
pub struct SpeedResponse {
    /// Speed before, m/s.
    pub speed_mps: f64,
    /// After the step up.
    pub up_mps: Vec<f64>,
    /// After the step down.
    pub down_mps: Vec<f64>,
    /// After the beginning of the grade.
    pub on_grade_mps: Vec<f64>,
}

/// Steps up and down and the grade that begins at once, at several speeds, over the time in samples of `sample_time_s`.
pub fn speed_steps(
    specification: &SpeedSpecification,
    sample_time_s: f64,
    responses: &[SpeedResponse],
) -> Figure {
    let s = specification;
    let tolerance = 0.01 * s.settling_band_percent * s.step_mps;
    let shown = 2.0 * s.settling_time_s.unwrap_or(0.5 * s.steady_state_time_s);
    let step = |label: &str, height: f64, of: &dyn Fn(&SpeedResponse) -> &[f64]| -> Panel {
        let band = MarkPlace::YBand(height - tolerance, height + tolerance);
        let mut panel = Panel::new("Time (s)", label).mark(Mark::new(
            format!("±{} %", text(s.settling_band_percent, 1)),
            band,
            GREEN,
        ));
        if height != 0.0
            && let Some(time) = s.settling_time_s
        {
            panel = panel.mark(Mark::new("to settle by", MarkPlace::XLine(time), BLACK));
        }
        for (rank, response) in responses.iter().enumerate() {
            let curve = of(response).iter().enumerate();
            let curve: Vec<_> = curve.map(|(k, y)| (k as f64 * sample_time_s, *y)).collect();
            let until = if height == 0.0 { s.steady_state_time_s } else { shown };
            let curve = curve.into_iter().take_while(|(t, _)| *t <= until).collect();
            let name = format!("{} m/s", text(response.speed_mps, 1));
            panel = panel.with(Series::new(name, curve, Style::line(nth(rank))));
        }
        panel
    };
    let panels = vec![
        Panel { link: "speed", ..step("Step up (m/s)", s.step_mps, &|r| &r.up_mps) },
        Panel { link: "speed", ..step("Step down (m/s)", -s.step_mps, &|r| &r.down_mps) },
        step("On the grade (m/s)", 0.0, &|r| &r.on_grade_mps),
    ];
    let loss = |r: &SpeedResponse| r.on_grade_mps.iter().copied().fold(0.0, f64::min);
    let lost = responses.iter().map(loss).fold(0.0, f64::min);
    let result = format!(
        "Steps of {} m/s and a grade of {} % at {} speeds; the largest loss of speed on the grade is {} m/s.",
        text(s.step_mps, 1),
        text(s.grade_percent, 1),
        responses.len(),
        text(-lost, 2)
    );
    Figure::new("Responses of the speed", panels).stating(result)
}

#[cfg(test)]
mod tests {
    use super::curvature_at;

    #[test]
    fn the_curvature_of_a_lap_is_linear_up_to_its_first_point() {
        let lap = [(0.0, 0.02), (10.0, 0.04), (20.0, 0.0), (30.0, 0.02)];
        for (distance, expected) in
            [(-1.0, 0.02), (0.0, 0.02), (5.0, 0.03), (15.0, 0.02), (25.0, 0.01), (30.0, 0.02)]
        {
            let found = curvature_at(&lap, distance);
            assert!((found - expected).abs() < 1e-12, "{distance}: {found}");
        }
    }
}
