//! The speed profile: exact solutions, its limits sampled between the points, and errors.
//!
//! The samples are computed here from the written points alone: acceleration linear in the distance, and constant jerk beside
//! a standstill.

use crate::common::car;
use proptest::prelude::*;
use steerwright_control::paths::PathComposer;
use steerwright_control::{DesignPlant, Error, speed_profile, unlimited_steering};
use steerwright_formats::{
    Document, Path, ProfileLimit, ProfileLimits, SpeedProfile, SteeringLimits,
};

/// Share by which a limit may be exceeded between the points.
const MARGIN: f64 = 0.005;
const GRAVITY: f64 = 9.80665;

fn limits() -> ProfileLimits {
    ProfileLimits {
        max_speed_mps: 25.0,
        max_lateral_acceleration_mps2: 4.0,
        max_acceleration_mps2: 2.0,
        max_deceleration_mps2: 3.5,
        max_jerk_mps3: None,
        friction: None,
        steering: None,
        end_speeds_mps: Some([0.0; 2]),
    }
}

/// The limits of a car of 2.578 m of wheelbase with a servo at the road wheel.
fn steering() -> SteeringLimits {
    let plant = DesignPlant::from_bicycle(&car(1.0)).unwrap();
    SteeringLimits {
        max_angle_rad: Some(0.35),
        max_rate_radps: Some(0.3),
        ..unlimited_steering(&plant)
    }
}

fn composed(composer: PathComposer) -> Path {
    composer.finish("road", 15.0).unwrap()
}

/// A lap of a circle of points 1 m apart.
fn circle(radius: f64) -> Path {
    let count = (std::f64::consts::TAU * radius).ceil();
    let mut path = composed(PathComposer::new().straight(1.0));
    path.closed = true;
    path.points = (0..count as usize)
        .map(|k| {
            let angle = std::f64::consts::TAU * k as f64 / count;
            steerwright_formats::PathPoint {
                distance_m: radius * angle,
                x_m: radius * angle.sin(),
                y_m: radius * (1.0 - angle.cos()),
                heading_rad: angle,
                curvature_per_m: 1.0 / radius,
            }
        })
        .collect();
    path
}

/// Distance, speed, acceleration, jerk.
type Motion = [f64; 4];

/// The motion within each interval of a profile, at places strictly inside of it.
fn samples(profile: &SpeedProfile) -> Vec<Motion> {
    let mut all = Vec::new();
    for pair in profile.points.windows(2) {
        let (a, b) = (pair[0], pair[1]);
        let h = b.distance_m - a.distance_m;
        let rests = [a, b].map(|p| p.speed_mps == 0.0 && p.acceleration_mps2 == 0.0);
        for k in 0..7 {
            let share = (f64::from(k) + 0.5) / 7.0;
            let distance = a.distance_m + share * h;
            if rests != [false; 2] {
                let (end, along) = if rests[0] { (b, share) } else { (a, 1.0 - share) };
                // s = j·t³/6, v = j·t²/2 and a = j·t over the time 3·h/v.
                let time = 3.0 * h / end.speed_mps;
                let jerk = 2.0 * end.speed_mps / (time * time);
                let t = time * along.cbrt();
                let sign = if rests[0] { 1.0 } else { -1.0 };
                all.push([distance, 0.5 * jerk * t * t, sign * jerk * t, jerk]);
                assert!((end.acceleration_mps2 - sign * jerk * time).abs() < 1e-6, "{end:?}");
                continue;
            }
            let change = b.acceleration_mps2 - a.acceleration_mps2;
            let square = a.speed_mps.powi(2)
                + 2.0 * a.acceleration_mps2 * share * h
                + change * share * share * h;
            let speed = square.sqrt();
            let acceleration = a.acceleration_mps2 + share * change;
            all.push([distance, speed, acceleration, speed * change / h]);
        }
    }
    all
}

/// The largest share of any limit over all samples, with the limit and the place.
fn largest_share(path: &Path, profile: &SpeedProfile) -> (f64, &'static str, f64) {
    let l = &profile.limits;
    let geometry = steerwright_models::files::path_geometry(path).unwrap();
    let mut worst = (0.0, "", 0.0);
    for [distance, v, a, jerk] in samples(profile) {
        let step = 1e-5;
        let [before, here, after] =
            [-step, 0.0, step].map(|shift| geometry.point_at(distance + shift).curvature_per_m);
        let slope = (after - before) / (2.0 * step);
        let lateral = v * v * here;
        let mut shares = vec![
            (v / l.max_speed_mps, "speed"),
            (lateral.abs() / l.max_lateral_acceleration_mps2, "lateral acceleration"),
            (a / l.max_acceleration_mps2, "acceleration"),
            (-a / l.max_deceleration_mps2, "deceleration"),
        ];
        if let Some(largest) = l.max_jerk_mps3 {
            shares.push((jerk.abs() / largest, "jerk"));
        }
        if let Some(friction) = l.friction {
            shares.push((lateral.hypot(a) / (friction * GRAVITY), "friction"));
        }
        if let Some(s) = &l.steering {
            let (slow, gradient) = (s.steering_per_curvature_radm, s.understeer_gradient_rads2pm);
            let angle = (slow + gradient * v * v) * here;
            // dδ/dt = ∂δ/∂s·v + ∂δ/∂v·a, and away from a corner of the curvature.
            let rate = (slow + gradient * v * v) * slope * v + 2.0 * gradient * v * here * a;
            shares.push((angle.abs() / s.max_angle_rad.unwrap_or(f64::INFINITY), "angle"));
            let is_corner = (after - 2.0 * here + before).abs() > 1e-9;
            if !is_corner {
                shares.push((rate.abs() / s.max_rate_radps.unwrap_or(f64::INFINITY), "rate"));
            }
        }
        for (share, name) in shares {
            if share > worst.0 {
                worst = (share, name, distance);
            }
        }
    }
    worst
}

fn profiled(path: &Path, limits: &ProfileLimits) -> SpeedProfile {
    let profile = speed_profile(path, limits).unwrap_or_else(|e| panic!("{e}; {}", e.hint()));
    let (share, name, distance) = largest_share(path, &profile);
    assert!(share <= 1.0 + MARGIN, "{name} at {distance} m: {share}");
    let written = Path { profile: Some(profile.clone()), ..path.clone() };
    written.checked("path.json").unwrap();
    profile
}

fn assert_time(profile: &SpeedProfile, exact: f64) {
    let ratio = profile.time_s / exact;
    assert!((ratio - 1.0).abs() < 1e-3, "{} s instead of {exact} s: {ratio}", profile.time_s);
}

#[test]
fn a_straight_without_jerk_has_the_exact_time() {
    let (a, d, v) = (2.0, 3.5, 25.0);
    for length in [3.0, 80.0, 250.0, 2000.0] {
        let path = composed(PathComposer::new().straight(length));
        let peak = f64::min(v, (2.0 * length * a * d / (a + d)).sqrt());
        let driven = 0.5 * peak * peak * (1.0 / a + 1.0 / d);
        let exact = peak / a + peak / d + (length - driven) / peak;
        assert_time(&profiled(&path, &limits()), exact);
    }
}

/// Acceleration and deceleration in trapezoids, the largest speed between.
#[test]
fn a_straight_with_jerk_has_the_exact_time() {
    let (a, v, j) = (2.0, 20.0, 2.5);
    let l = ProfileLimits {
        max_speed_mps: v,
        max_deceleration_mps2: a,
        max_jerk_mps3: Some(j),
        ..limits()
    };
    for length in [300.0, 1000.0] {
        let path = composed(PathComposer::new().straight(length));
        let exact = length / v + v / a + a / j;
        assert_time(&profiled(&path, &l), exact);
    }
}

#[test]
fn a_circle_has_the_exact_time() {
    for radius in [12.0, 30.0, 400.0] {
        let path = circle(radius);
        for max_jerk_mps3 in [None, Some(2.5)] {
            let l = ProfileLimits { max_jerk_mps3, end_speeds_mps: None, ..limits() };
            let speed = f64::min(25.0, (4.0 * radius).sqrt());
            let profile = profiled(&path, &l);
            assert_time(&profile, std::f64::consts::TAU * radius / speed);
            let share: f64 = profile.binding.iter().map(|segment| segment.time_s).sum();
            assert!(share > 0.99 * profile.time_s, "{:?}", profile.binding);
            let expected = if radius > 100.0 {
                ProfileLimit::Speed
            } else {
                ProfileLimit::LateralAcceleration
            };
            assert!(profile.binding.iter().all(|segment| segment.limit == expected));
        }
    }
}

/// A bend of straights, clothoids and an arc; its forward and backward pass in steps of a millimetre, with the friction
/// circle.
#[test]
fn clothoids_without_jerk_have_the_time_of_the_two_passes() {
    let (curvature, ramp, hold, straight) = (0.04, 25.0, 40.0, 120.0);
    let path = composed(
        PathComposer::new()
            .straight(straight)
            .clothoid(0.0, curvature, ramp)
            .arc(curvature, hold)
            .clothoid(curvature, -curvature, 2.0 * ramp)
            .clothoid(-curvature, 0.0, ramp)
            .straight(straight),
    );
    let length = path.points.last().unwrap().distance_m;
    let shape = |s: f64| {
        let bends = [
            (straight, 0.0),
            (ramp, curvature),
            (hold, curvature),
            (2.0 * ramp, -curvature),
            (ramp, 0.0),
            (straight, 0.0),
        ];
        let (mut before, mut from) = (0.0, 0.0);
        for (long, to) in bends {
            if s <= before + long {
                return from + (to - from) * (s - before) / long;
            }
            (before, from) = (before + long, to);
        }
        0.0
    };
    for friction in [None, Some(0.42)] {
        let l = ProfileLimits { friction, ..limits() };
        let grip = friction.map_or(f64::INFINITY, |mu| mu * GRAVITY);
        let steps = (length / 1e-3).round() as usize;
        let h = length / steps as f64;
        let most = |s: f64| {
            let bound = f64::min(4.0, grip);
            (bound / shape(s).abs()).min(25.0 * 25.0)
        };
        // Half of the change of v² per distance, at most, in a direction.
        let slope = |s: f64, z: f64, largest: f64| {
            let rest = grip * grip - (shape(s) * z).powi(2);
            rest.max(0.0).sqrt().min(largest)
        };
        let mut z: Vec<f64> = (0..=steps).map(|k| most(k as f64 * h)).collect();
        z[0] = 0.0;
        z[steps] = 0.0;
        for k in 1..=steps {
            let reached = z[k - 1] + 2.0 * h * slope((k - 1) as f64 * h, z[k - 1], 2.0);
            z[k] = z[k].min(reached);
        }
        for k in (0..steps).rev() {
            let reached = z[k + 1] + 2.0 * h * slope((k + 1) as f64 * h, z[k + 1], 3.5);
            z[k] = z[k].min(reached);
        }
        let exact: f64 = z.windows(2).map(|p| 2.0 * h / (p[0].sqrt() + p[1].sqrt())).sum();
        assert_time(&profiled(&path, &l), exact);
    }
}

fn double_bend(curvature: f64, ramp: f64) -> Path {
    composed(
        PathComposer::new()
            .straight(60.0)
            .clothoid(0.0, curvature, ramp)
            .arc(curvature, 15.0)
            .clothoid(curvature, -curvature, 2.0 * ramp)
            .arc(-curvature, 15.0)
            .clothoid(-curvature, 0.0, ramp)
            .straight(60.0),
    )
}

#[test]
fn the_steering_rate_is_kept_while_the_speed_changes() {
    let path = double_bend(0.06, 6.0);
    let free = profiled(&path, &limits());
    let slow = SteeringLimits { max_rate_radps: Some(0.15), ..steering() };
    let l = ProfileLimits { steering: Some(slow), ..limits() };
    let profile = profiled(&path, &l);
    assert!(profile.time_s > 1.05 * free.time_s, "{} {}", profile.time_s, free.time_s);
    let binds = |limit| profile.binding.iter().any(|segment| segment.limit == limit);
    assert!(binds(ProfileLimit::SteeringRate), "{:?}", profile.binding);
    let all = ProfileLimits { max_jerk_mps3: Some(2.5), friction: Some(0.5), ..l };
    let softer = profiled(&path, &all);
    assert!(softer.time_s > profile.time_s, "{} {}", softer.time_s, profile.time_s);
}

/// Weaker limits never cost time.
#[test]
fn more_of_a_limit_is_never_slower() {
    let path = double_bend(0.05, 10.0);
    let all = ProfileLimits {
        max_jerk_mps3: Some(2.0),
        friction: Some(0.45),
        steering: Some(steering()),
        ..limits()
    };
    let time = profiled(&path, &all).time_s;
    let more = [
        ProfileLimits { max_speed_mps: 30.0, ..all },
        ProfileLimits { max_lateral_acceleration_mps2: 5.0, ..all },
        ProfileLimits { max_acceleration_mps2: 3.0, ..all },
        ProfileLimits { max_deceleration_mps2: 5.0, ..all },
        ProfileLimits { max_jerk_mps3: Some(4.0), ..all },
        ProfileLimits { max_jerk_mps3: None, ..all },
        ProfileLimits { friction: None, ..all },
        ProfileLimits { steering: None, ..all },
    ];
    for l in more {
        let less = profiled(&path, &l).time_s;
        assert!(less <= time * (1.0 + 1e-4), "{less} {time}: {l:?}");
    }
}

#[test]
fn ends_may_have_a_speed() {
    let path = double_bend(0.03, 20.0);
    for max_jerk_mps3 in [None, Some(2.5)] {
        let ends = Some([12.0, 15.0]);
        let profile =
            profiled(&path, &ProfileLimits { end_speeds_mps: ends, max_jerk_mps3, ..limits() });
        let [first, last] = [profile.points[0], *profile.points.last().unwrap()];
        assert!((first.speed_mps - 12.0).abs() < 0.01, "{first:?}");
        assert!((last.speed_mps - 15.0).abs() < 0.01, "{last:?}");
        if max_jerk_mps3.is_some() {
            assert!(first.acceleration_mps2.abs() < 1e-9 && last.acceleration_mps2.abs() < 1e-9);
        }
    }
}

/// The unlimited two-pass solution has them exactly; braking from 24 m/s takes 82 m.
#[test]
fn speeds_at_ends_that_are_not_feasible_are_errors() {
    let bend = composed(PathComposer::new().straight(30.0).clothoid(0.0, 0.1, 5.0).arc(0.1, 20.0));
    for max_jerk_mps3 in [None, Some(2.5)] {
        let l = ProfileLimits { max_jerk_mps3, end_speeds_mps: Some([24.0, 0.0]), ..limits() };
        let error = speed_profile(&bend, &l).unwrap_err();
        let Error::ProfileEnd { end: "start", reached_mps, .. } = error else {
            panic!("{error}");
        };
        // v² = 4/0.1 + 2·3.5·(about 33 m).
        assert!((10.0..17.0).contains(&reached_mps), "{reached_mps}");
        assert!(error.hint().contains("start speed of at most"), "{}", error.hint());
        // What the error advises is feasible.
        let advised = (10.0 * reached_mps).floor() / 10.0;
        profiled(&bend, &ProfileLimits { end_speeds_mps: Some([advised, 0.0]), ..l });
        let l = ProfileLimits { end_speeds_mps: Some([0.0, 20.0]), ..l };
        assert!(matches!(speed_profile(&bend, &l), Err(Error::ProfileEnd { end: "end", .. })));
    }
}

#[test]
fn limits_that_allow_no_motion_are_errors() {
    let path = double_bend(0.06, 6.0);
    let bad = [
        ProfileLimits { max_speed_mps: 0.0, ..limits() },
        ProfileLimits { max_lateral_acceleration_mps2: -1.0, ..limits() },
        ProfileLimits { max_acceleration_mps2: 0.0, ..limits() },
        ProfileLimits { max_deceleration_mps2: f64::NAN, ..limits() },
        ProfileLimits { max_jerk_mps3: Some(0.0), ..limits() },
        ProfileLimits { friction: Some(0.0), ..limits() },
        ProfileLimits { end_speeds_mps: Some([-1.0, 0.0]), ..limits() },
    ];
    for l in bad {
        let error = speed_profile(&path, &l).unwrap_err();
        assert!(matches!(error, Error::Option { .. }), "{error}");
    }
    let tight = SteeringLimits { max_angle_rad: Some(0.1), ..steering() };
    let error = speed_profile(&path, &ProfileLimits { steering: Some(tight), ..limits() });
    let text = error.unwrap_err().to_string();
    assert!(text.contains("`steering-angle` allows a speed of 0.000 m/s at 6"), "{text}");
    // A jump of the curvature, which the composer makes in a millimetre.
    let jump = composed(PathComposer::new().straight(50.0).arc(0.05, 30.0));
    let error = speed_profile(&jump, &ProfileLimits { steering: Some(steering()), ..limits() });
    let text = error.unwrap_err().to_string();
    assert!(text.contains("`steering-rate` allows a speed of 0.00"), "{text}");
    assert!(text.contains(" at 50.00 m") || text.contains(" at 49.99"), "{text}");
    let closed = ProfileLimits { end_speeds_mps: None, ..limits() };
    assert!(matches!(speed_profile(&jump, &closed), Err(Error::Contradiction { .. })));
}

#[test]
fn jumps_of_the_curvature_and_paths_of_two_points_have_profiles() {
    let jump = composed(PathComposer::new().straight(50.0).arc(0.05, 30.0).straight(40.0));
    let mut two = composed(PathComposer::new().straight(300.0));
    two.points = vec![two.points[0], *two.points.last().unwrap()];
    for max_jerk_mps3 in [None, Some(2.5)] {
        let l = ProfileLimits { max_jerk_mps3, ..limits() };
        profiled(&jump, &l);
        profiled(&two, &l);
    }
}

#[test]
fn very_short_and_very_long_paths_have_profiles() {
    for length in [0.02, 0.3, 30_000.0] {
        let path = composed(PathComposer::new().spacing(5.0_f64.min(length)).straight(length));
        let l = ProfileLimits { max_jerk_mps3: Some(2.5), ..limits() };
        let profile = profiled(&path, &l);
        if length < 1.0 {
            // Four parts of constant jerk; neither acceleration nor speed reach their limits.
            let ratio = profile.time_s / (32.0 * length / 2.5).cbrt();
            assert!((1.0 - 1e-6..1.006).contains(&ratio), "{length} m: {ratio}");
        }
    }
}

fn random_path() -> impl Strategy<Value = Path> {
    let segment = (-0.12..0.12_f64, 1.0..60.0_f64, 3.0..40.0_f64);
    prop::collection::vec(segment, 1..7).prop_map(|segments| {
        let mut composer = PathComposer::new();
        let mut from = 0.0;
        for (to, ramp, hold) in segments {
            // Every third bend is a straight.
            let to = if to.abs() < 0.04 { 0.0 } else { to };
            composer = composer.clothoid(from, to, ramp).arc(to, hold);
            from = to;
        }
        composed(composer)
    })
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 48, ..ProptestConfig::default() })]

    /// Whatever the path and the limits: a profile that keeps them between its points.
    #[test]
    fn every_limit_is_kept_between_the_points(
        path in random_path(),
        speed in 3.0..50.0_f64,
        lateral in 1.0..10.0_f64,
        along in (0.5..6.0_f64, 0.5..9.0_f64),
        jerk in prop::option::of(0.5..20.0_f64),
        friction in prop::option::of(0.15..1.1_f64),
        rate in prop::option::of(0.1..1.0_f64),
        understeer in prop::sample::select(vec![0.0, 0.002, 0.006, -0.0005]),
    ) {
        let l = ProfileLimits {
            max_speed_mps: speed,
            max_lateral_acceleration_mps2: lateral,
            max_acceleration_mps2: along.0,
            max_deceleration_mps2: along.1,
            max_jerk_mps3: jerk,
            friction,
            steering: rate.map(|rate| SteeringLimits {
                steering_per_curvature_radm: 2.6,
                understeer_gradient_rads2pm: understeer,
                max_angle_rad: Some(0.6),
                max_rate_radps: Some(rate),
            }),
            end_speeds_mps: Some([0.0; 2]),
        };
        profiled(&path, &l);
    }
}
