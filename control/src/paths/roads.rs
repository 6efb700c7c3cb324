//! Reference roads with bounded curvature and curvature rate.
//!
//! Straights and clothoids whose largest curvature is κ_max = a/v² for the lateral acceleration a at speed
//! v, reached and never exceeded. A lane change is four clothoids of equal length
//! (0 → κ_max → 0 → −κ_max → 0); the S-curve changes curvature at the rate `lateral_jerk`/v³.

use super::compose::{PathComposer, displacement};
use crate::Error;
use crate::error::{positive, require};
use steerwright_formats::Path;

/// The shape of the roads.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RoadOptions {
    /// Lateral move of a lane change, m, to the left first.
    pub lane_offset: f64,
    /// Time in the other lane, s.
    pub lane_time: f64,
    /// Turn of each half of the S-curve, rad, at least that of its clothoids alone.
    pub turn_angle: f64,
    /// Lateral jerk of the S-curve, m/s³.
    pub lateral_jerk: f64,
    /// Time of the straight before, s.
    pub lead_in: f64,
    /// Time of the straight after, s.
    pub lead_out: f64,
    /// Largest distance between points, m.
    pub spacing: f64,
}

impl Default for RoadOptions {
    fn default() -> Self {
        Self {
            lane_offset: 3.5,
            lane_time: 1.0,
            turn_angle: 40.0_f64.to_radians(),
            lateral_jerk: 6.0,
            lead_in: 2.0,
            lead_out: 3.0,
            spacing: super::compose::DEFAULT_SPACING,
        }
    }
}

/// Straight, a lane change to the left and one back, straight.
///
/// # Errors
/// [`Error::Option`] for values that are not positive, [`Error::Road`] where the speed is too low
/// for that curve to fit the offset.
pub fn double_lane_change(
    speed: f64,
    lateral_acceleration: f64,
    options: &RoadOptions,
) -> Result<Path, Error> {
    let curvature = curvature(speed, lateral_acceleration, options)?;
    let path = PathComposer::new().spacing(options.spacing).straight(speed * options.lead_in);
    let path = lane_changes(path, speed, curvature, options)?;
    named(path.straight(speed * options.lead_out), "double lane change", speed, curvature, options)
}

/// Straight, a turn to the left and one to the right, straight.
///
/// # Errors
/// [`Error::Option`] for values that are not positive.
pub fn s_curve(
    speed: f64,
    lateral_acceleration: f64,
    options: &RoadOptions,
) -> Result<Path, Error> {
    let curvature = curvature(speed, lateral_acceleration, options)?;
    let path = PathComposer::new().spacing(options.spacing).straight(speed * options.lead_in);
    let path = s_turns(path, speed, curvature, options);
    named(path.straight(speed * options.lead_out), "S-curve", speed, curvature, options)
}

/// The road on which controllers are compared (after Fig. 5): straight, a double lane change,
/// straight, an S-curve, straight.
///
/// # Errors
/// As [`double_lane_change`] and [`s_curve`].
pub fn reference_road(speed: f64, lateral_acceleration: f64) -> Result<Path, Error> {
    let options = RoadOptions::default();
    let curvature = curvature(speed, lateral_acceleration, &options)?;
    let path = PathComposer::new().spacing(options.spacing).straight(speed * options.lead_in);
    let path = lane_changes(path, speed, curvature, &options)?.straight(speed * options.lead_in);
    let path = s_turns(path, speed, curvature, &options).straight(speed * options.lead_out);
    named(path, "reference road", speed, curvature, &options)
}

fn lane_changes(
    mut path: PathComposer,
    speed: f64,
    curvature: f64,
    options: &RoadOptions,
) -> Result<PathComposer, Error> {
    let ramp = lane_change_ramp(curvature, options.lane_offset)?;
    for side in [curvature, -curvature] {
        path = path
            .clothoid(0.0, side, ramp)
            .clothoid(side, 0.0, ramp)
            .clothoid(0.0, -side, ramp)
            .clothoid(-side, 0.0, ramp);
        if side > 0.0 {
            path = path.straight(speed * options.lane_time);
        }
    }
    Ok(path)
}

fn s_turns(path: PathComposer, speed: f64, curvature: f64, options: &RoadOptions) -> PathComposer {
    let ramp = curvature * speed.powi(3) / options.lateral_jerk;
    // Both ramps of a turn together turn κ·L.
    let hold = (options.turn_angle / curvature - ramp).max(0.0);
    path.clothoid(0.0, curvature, ramp)
        .arc(curvature, hold)
        .clothoid(curvature, -curvature, 2.0 * ramp)
        .arc(-curvature, hold)
        .clothoid(-curvature, 0.0, ramp)
}

/// Length of each of the four clothoids of a lane change, by bisection on the exact offset.
fn lane_change_ramp(curvature: f64, offset: f64) -> Result<f64, Error> {
    let rise = |ramp: f64| {
        let rate = curvature / ramp;
        let first = displacement(0.0, 0.0, rate, ramp).1;
        let second = displacement(0.5 * curvature * ramp, curvature, -rate, ramp).1;
        // The second half mirrors the first about the middle.
        2.0 * (first + second)
    };
    // The heading in the middle is κ·L: beyond a right angle this is no lane change.
    let (mut low, mut high) = (0.0, std::f64::consts::FRAC_PI_2 / curvature);
    let largest = rise(high);
    if largest < offset {
        return Err(Error::Road {
            road: "double lane change",
            problem: format!(
                "a curvature of {curvature:.4} 1/m cannot move {offset} m sideways without turning by more than 90 degrees (it reaches {largest:.3} m)"
            ),
        });
    }
    for _ in 0..200 {
        let middle = 0.5 * (low + high);
        if rise(middle) < offset { low = middle } else { high = middle }
    }
    Ok(0.5 * (low + high))
}

fn curvature(speed: f64, acceleration: f64, options: &RoadOptions) -> Result<f64, Error> {
    positive([
        ("speed", speed, " m/s"),
        ("lateral acceleration", acceleration, " m/s²"),
        ("lane offset", options.lane_offset, " m"),
        ("turn angle", options.turn_angle, " rad"),
        ("lateral jerk", options.lateral_jerk, " m/s³"),
        ("lead-in", options.lead_in, " s"),
        ("lead-out", options.lead_out, " s"),
    ])?;
    // Beyond these no car drives, and the roads would have too many points.
    let (lateral, stated) = ("lateral acceleration", (acceleration, " m/s²"));
    require(speed <= 150.0, "speed", (speed, " m/s"), "at most 150 m/s")?;
    require(acceleration <= 50.0, lateral, stated, "at most 50 m/s²")?;
    require(0.1 / acceleration <= 1.0, lateral, stated, "at least 0.1 m/s²")?;
    Ok(acceleration / (speed * speed))
}

fn named(
    path: PathComposer,
    name: &str,
    speed: f64,
    curvature: f64,
    options: &RoadOptions,
) -> Result<Path, Error> {
    let mut path = path.finish(name, speed)?;
    path.provenance.options = [
        ("speed_mps", speed),
        ("lateral_acceleration_mps2", curvature * speed * speed),
        ("lane_offset_m", options.lane_offset),
        ("lane_time_s", options.lane_time),
        ("turn_angle_rad", options.turn_angle),
        ("lateral_jerk_mps3", options.lateral_jerk),
    ]
    .into_iter()
    .map(|(key, value)| (key.to_owned(), format!("{}", (value * 1e9).round() / 1e9)))
    .collect();
    Ok(path)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn largest(path: &Path, f: impl Fn(&steerwright_formats::PathPoint) -> f64) -> f64 {
        path.points.iter().map(f).fold(0.0, f64::max)
    }

    #[test]
    fn lateral_acceleration_is_reached_and_not_exceeded() {
        for speed in [8.0, 15.0, 30.0] {
            for path in [
                double_lane_change(speed, 4.0, &RoadOptions::default()).unwrap(),
                s_curve(speed, 4.0, &RoadOptions::default()).unwrap(),
                reference_road(speed, 4.0).unwrap(),
            ] {
                for sign in [1.0, -1.0] {
                    let a = largest(&path, |p| sign * p.curvature_per_m) * speed * speed;
                    assert!((a - 4.0).abs() < 1e-9, "{} at {speed}: {a}", path.name);
                }
                let steepest = path
                    .points
                    .windows(2)
                    .map(|w| {
                        ((w[1].curvature_per_m - w[0].curvature_per_m)
                            / (w[1].distance_m - w[0].distance_m))
                            .abs()
                    })
                    .fold(0.0, f64::max);
                let jerk = steepest * speed.powi(3);
                assert!(jerk < 6.2, "{} at {speed}: lateral jerk {jerk}", path.name);
            }
        }
    }

    #[test]
    fn lane_changes_move_by_the_offset_and_come_back() {
        let path = double_lane_change(15.0, 4.0, &RoadOptions::default()).unwrap();
        let end = path.points[path.points.len() - 1];
        assert!((largest(&path, |p| p.y_m) - 3.5).abs() < 1e-9);
        assert!(end.y_m.abs() < 1e-9 && end.heading_rad.abs() < 1e-12);
        let road = reference_road(15.0, 4.0).unwrap();
        let end = road.points[road.points.len() - 1];
        assert!(end.heading_rad.abs() < 1e-12);
        assert!((largest(&road, |p| p.heading_rad) - 40.0_f64.to_radians()).abs() < 1e-9);
    }

    /// Consecutive points must agree with their headings and curvatures.
    #[test]
    fn points_headings_and_curvatures_are_consistent() {
        let road = reference_road(15.0, 4.0).unwrap();
        for w in road.points.windows(2) {
            let ds = w[1].distance_m - w[0].distance_m;
            assert!(ds > 0.0 && ds <= 0.5 + 1e-9);
            let rate = (w[1].curvature_per_m - w[0].curvature_per_m) / ds;
            let (dx, dy) = displacement(w[0].heading_rad, w[0].curvature_per_m, rate, ds);
            assert!((w[1].x_m - w[0].x_m - dx).hypot(w[1].y_m - w[0].y_m - dy) < 1e-9);
            let turn = 0.5 * (w[0].curvature_per_m + w[1].curvature_per_m) * ds;
            assert!((w[1].heading_rad - w[0].heading_rad - turn).abs() < 1e-9);
        }
    }

    #[test]
    fn a_road_that_does_not_exist_is_rejected() {
        let error = double_lane_change(1.0, 4.0, &RoadOptions::default()).unwrap_err();
        assert!(error.to_string().contains("cannot move 3.5 m sideways"), "{error}");
        assert!(reference_road(f64::NAN, 4.0).is_err());
        assert!(s_curve(15.0, -4.0, &RoadOptions::default()).is_err());
    }
}
