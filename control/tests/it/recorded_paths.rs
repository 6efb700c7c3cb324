//! Paths from recorded positions: known curves with noise and faults, and the recordings of
//! examples/drives.

use std::f64::consts::TAU;
use steerwright_control::Error;
use steerwright_control::paths::{
    FixOptions, PathComposer, PointOptions, RecordedPath, from_points, path_from_recording,
    read_points,
};

fn data(name: &str) -> (String, String) {
    let path = format!("{}/../examples/drives/{name}", env!("CARGO_MANIFEST_DIR"));
    (std::fs::read_to_string(&path).expect("the recording"), name.to_owned())
}

fn fault(result: Result<RecordedPath, Error>) -> Error {
    result.map(|_| ()).expect_err("a fault")
}

/// Uniform in (−1, 1) from a linear congruence, so that the tests draw the same each time.
fn noise(state: &mut u64) -> f64 {
    *state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
    (*state >> 11) as f64 / (1u64 << 52) as f64 - 1.0
}

fn circle(radius: f64, spacing: f64, turn: f64, sigma: f64) -> (Vec<f64>, Vec<f64>) {
    let mut state = 7;
    let n = (turn * radius / spacing) as usize;
    (0..n)
        .map(|i| {
            let a = i as f64 * spacing / radius;
            let mut e = || sigma * 3.0_f64.sqrt() * noise(&mut state);
            (radius * a.sin() + e(), radius * (1.0 - a.cos()) + e())
        })
        .unzip()
}

#[test]
fn a_noisy_circle_has_its_curvature_heading_and_length() {
    let (x, y) = circle(50.0, 1.5, 4.0, 0.02);
    let recorded = from_points(&x, &y, &PointOptions::default()).expect("a path");
    let points = &recorded.path.points;
    let inner = &points[40..points.len() - 40];
    for p in inner {
        assert!((p.curvature_per_m - 0.02).abs() < 0.002, "{p:?}");
        let radius = p.x_m.hypot(p.y_m - 50.0);
        assert!((radius - 50.0).abs() < 0.03, "{radius}");
        let heading = p.x_m.atan2(50.0 - p.y_m);
        assert!((p.heading_rad - heading).sin().abs() < 0.005, "{p:?}");
    }
    // Heading is not wrapped.
    assert!((points[points.len() - 1].heading_rad - 4.0).abs() < 0.1);
    let length = points[points.len() - 1].distance_m;
    assert!((length - 50.0 * 4.0).abs() < 2.0, "{length}");
    assert!(recorded.rms_distance_m < 0.025 && recorded.warnings.is_empty());
}

/// Noise as large as the spacing lengthens the way from point to point by half; the path must not
/// grow with it.
#[test]
fn noise_does_not_lengthen_the_path() {
    let (x, y) = circle(200.0, 0.5, 2.0, 0.3);
    let options = PointOptions { smoothing_length: 60.0, largest_jump: 5.0, ..Default::default() };
    let recorded = from_points(&x, &y, &options).expect("a path");
    let length = recorded.path.points[recorded.path.points.len() - 1].distance_m;
    let raw: f64 = (1..x.len()).map(|i| (x[i] - x[i - 1]).hypot(y[i] - y[i - 1])).sum();
    assert!(raw > 1.2 * 400.0, "{raw}");
    assert!((length / 400.0 - 1.0).abs() < 5e-4, "{length}");
    let points = &recorded.path.points;
    for p in &points[points.len() / 6..5 * points.len() / 6] {
        assert!((p.curvature_per_m - 0.005).abs() < 5e-4, "{p:?}");
    }
}

#[test]
fn a_closed_track_meets_its_start() {
    let (x, y) = circle(30.0, 1.0, TAU - 0.02, 0.01);
    let options = PointOptions { closed: true, ..Default::default() };
    let path = from_points(&x, &y, &options).expect("a path").path;
    let (first, last) = (path.points[0], path.points[path.points.len() - 1]);
    assert!(path.closed);
    assert!((last.distance_m - TAU * 30.0).abs() < 0.5, "{}", last.distance_m);
    assert!((last.heading_rad - first.heading_rad - TAU).abs() < 1e-3);
    for w in path.points.windows(2) {
        assert!((w[1].x_m - w[0].x_m).hypot(w[1].y_m - w[0].y_m) < 0.51);
        assert!((w[1].curvature_per_m - 1.0 / 30.0).abs() < 0.004, "{:?}", w[1]);
    }
}

/// A lap that was not driven to its end is closed by a piece of road that nobody drove.
#[test]
fn the_closing_part_of_a_track_that_ends_far_from_its_start_is_reported() {
    let closed = PointOptions { closed: true, ..Default::default() };
    let warnings = |turn: f64| {
        let (x, y) = circle(60.0, 1.0, turn, 0.01);
        from_points(&x, &y, &closed).expect("a path").warnings
    };
    assert_eq!(warnings(TAU - 0.05), Vec::<String>::new());
    let all = warnings(0.9 * TAU);
    assert!(all.len() == 1 && all[0].starts_with("the last point is 3"), "{all:?}");
}

#[test]
fn repeated_points_and_single_outliers_are_left_out_with_a_word() {
    let (mut x, mut y) = circle(50.0, 1.0, 3.0, 0.0);
    y[70] += 6.0;
    let (x70, y70) = (x[20], y[20]);
    for _ in 0..5 {
        x.insert(20, x70);
        y.insert(20, y70);
    }
    let recorded = from_points(&x, &y, &PointOptions::default()).expect("a path");
    assert_eq!(recorded.warnings.len(), 2, "{:?}", recorded.warnings);
    assert!(recorded.warnings[0].contains("5 of"), "{}", recorded.warnings[0]);
    assert!(recorded.warnings[1].contains("point 76"), "{}", recorded.warnings[1]);
    assert!(recorded.largest_distance_m < 0.05, "{}", recorded.largest_distance_m);
}

/// A long recording with as many outliers as are allowed must not take a time that grows with both.
#[test]
fn many_outliers_of_a_long_recording_are_left_out_in_a_moment() {
    let (mut x, mut y) = circle(50_000.0, 0.5, 2.0, 0.0);
    let wrong: Vec<usize> = (50..x.len() - 50).step_by(60).collect();
    for &i in &wrong {
        (x[i], y[i]) = (x[i] + 3.0, y[i] - 4.0);
    }
    let start = std::time::Instant::now();
    let options = PointOptions { spacing: 50.0, smoothing_length: 100.0, ..Default::default() };
    let recorded = from_points(&x, &y, &options).expect("a path");
    assert_eq!(recorded.warnings.len(), wrong.len());
    // Looking at all points for each of them takes minutes.
    assert!(start.elapsed().as_secs() < 20, "{:?}", start.elapsed());
}

#[test]
fn jumps_and_nonsense_are_refused() {
    let (mut x, y) = circle(50.0, 1.0, 3.0, 0.0);
    for x in &mut x[60..] {
        *x -= 10.0;
    }
    let error = fault(from_points(&x, &y, &PointOptions::default()));
    assert!(matches!(error, Error::Jump { after: 60, .. }), "{error}");
    assert!(error.hint().contains("jump"));

    let error = fault(from_points(&[1.0; 9], &[2.0; 9], &PointOptions::default()));
    assert_eq!(error, Error::TooFewPoints { got: 1, need: 4 });
    assert!(from_points(&[], &[], &PointOptions::default()).is_err());
    assert!(from_points(&[0.0, f64::NAN], &[0.0, 1.0], &PointOptions::default()).is_err());
    assert!(from_points(&[0.0, 1.0], &[0.0], &PointOptions::default()).is_err());

    // A random walk has no curvature that a car could follow.
    let mut state = 3;
    let (x, y): (Vec<f64>, Vec<f64>) =
        (0..400).map(|_| (3.0 * noise(&mut state), 3.0 * noise(&mut state))).unzip();
    let options = PointOptions { max_curvature: 0.02, largest_jump: 100.0, ..Default::default() };
    assert!(from_points(&x, &y, &options).is_err());
}

#[test]
fn curvature_stays_within_its_bound() {
    // A right-angled corner.
    let x: Vec<f64> = (0..120).map(|i| f64::from(i.min(60))).collect();
    let y: Vec<f64> = (0..120).map(|i| f64::from((i - 60).max(0))).collect();
    let options = PointOptions { max_curvature: 0.06, largest_jump: 3.0, ..Default::default() };
    let recorded = from_points(&x, &y, &options).expect("a path");
    assert!(recorded.smoothing_length_m > 20.0 && recorded.warnings.len() == 1);
    for p in &recorded.path.points {
        assert!(p.curvature_per_m.abs() <= 0.06);
    }
}

/// The RAV4's minute: 1014 m, bending by less than a degree from end to end.
#[test]
fn the_city_street() {
    let (text, name) = data("comma2k19/gnss_pose.csv");
    let points = read_points(&text, &name, &FixOptions::default()).expect("positions");
    assert_eq!(points.x_m.len(), 1200);
    let options = PointOptions { speed: 16.8, ..Default::default() };
    let recorded = path_from_recording(&text, &name, &options).expect("a path");
    let path = &recorded.path.points;
    println!(
        "rms {:.4} m, largest {:.4} m, {} points, length {:.1} m",
        recorded.rms_distance_m,
        recorded.largest_distance_m,
        path.len(),
        path[path.len() - 1].distance_m
    );
    // As long as the way from point to point, and as the CAN speed integrates (1004 m within 1 %).
    let raw: f64 = (1..1200)
        .map(|i| (points.x_m[i] - points.x_m[i - 1]).hypot(points.y_m[i] - points.y_m[i - 1]))
        .sum();
    let length = path[path.len() - 1].distance_m;
    assert!((length - raw).abs() < 0.1, "{length} {raw}");
    assert!((length / 1003.8 - 1.0).abs() < 0.01, "{length}");
    assert!(recorded.rms_distance_m < 0.02, "{}", recorded.rms_distance_m);

    // The direction of travel over 40 recorded rows (2 s) is the heading in their middle.
    let (mut worst, mut i) = (0.0_f64, 0);
    for k in (20..1180).step_by(10) {
        let (x, y) = (points.x_m[k], points.y_m[k]);
        let course = (points.y_m[k + 20] - points.y_m[k - 20])
            .atan2(points.x_m[k + 20] - points.x_m[k - 20]);
        let away = |i: usize| (path[i].x_m - x).hypot(path[i].y_m - y);
        while i + 1 < path.len() && away(i + 1) < away(i) {
            i += 1;
        }
        worst = worst.max(steerwright_models::wrap_angle(path[i].heading_rad - course).abs());
    }
    println!("largest difference of heading and course {:.3} deg", worst.to_degrees());
    assert!(worst.to_degrees() < 0.5, "{}", worst.to_degrees());
    let curvature = path.iter().map(|p| p.curvature_per_m.abs()).fold(0.0, f64::max);
    println!("largest curvature {curvature:.5} 1/m");
    assert!(curvature < 0.01, "{curvature}");
}

/// The simulated drive at 15 m/s up to 3.8 m/s²: its positions carry 2 cm of noise.
#[test]
fn the_test_drive() {
    let (text, name) = data("multibody/position.csv");
    let options = PointOptions { speed: 15.0, smoothing_length: 15.0, ..Default::default() };
    let recorded = path_from_recording(&text, &name, &options).expect("a path");
    let curvature =
        recorded.path.points.iter().map(|p| p.curvature_per_m.abs()).fold(0.0, f64::max);
    println!("rms {:.4} m, v²κ {:.2} m/s²", recorded.rms_distance_m, curvature * 225.0);
    assert!(recorded.rms_distance_m < 0.035, "{}", recorded.rms_distance_m);
    assert!((curvature * 225.0 - 3.85).abs() < 0.8, "{}", curvature * 225.0);
}

/// A road of straights, clothoids and arcs, with a point each centimetre.
fn road(bends: &[(f64, f64, f64)]) -> Vec<(f64, f64)> {
    let mut road = PathComposer::new().spacing(0.01).straight(40.0);
    for &(radius, angle, clothoid) in bends {
        let k = 1.0 / radius;
        let arc = (radius * angle.abs() - clothoid).max(0.1);
        let k = if angle < 0.0 { -k } else { k };
        road = road.clothoid(0.0, k, clothoid).arc(k, arc).clothoid(k, 0.0, clothoid);
        road = road.straight(30.0);
    }
    let path = road.finish("road", 10.0).expect("a road");
    path.points.iter().map(|p| (p.x_m, p.y_m)).collect()
}

/// A point of the road each so many metres, with noise of that standard deviation.
fn drive(road: &[(f64, f64)], spacing: f64, sigma: f64) -> (Vec<f64>, Vec<f64>) {
    let mut state = 11;
    let mut normal = move || (0..12).map(|_| noise(&mut state)).sum::<f64>() / 2.0 * sigma;
    let step = (spacing / 0.01).round() as usize;
    road.iter().step_by(step).map(|&(x, y)| (x + normal(), y + normal())).unzip()
}

/// Largest distance of the path from the road.
fn off_road(recorded: &RecordedPath, road: &[(f64, f64)]) -> f64 {
    let mut near = 0;
    let away = |k: usize, x: f64, y: f64| (road[k].0 - x).hypot(road[k].1 - y);
    let mut worst = 0.0_f64;
    for p in &recorded.path.points {
        let range = near..(near + 2000).min(road.len());
        let distances = range.map(|k| (away(k, p.x_m, p.y_m), k));
        let (distance, k) =
            distances.fold((f64::INFINITY, near), |a, b| if b.0 < a.0 { b } else { a });
        near = k.saturating_sub(500);
        worst = worst.max(distance);
    }
    worst
}

/// What real tracks are like: the spacing (m), the noise (m) and how far the path may be off the road.
#[test]
fn real_tracks_are_followed() {
    let (pi, half) = (std::f64::consts::PI, std::f64::consts::FRAC_PI_2);
    // At 15 m/s, 2.5 m/s² and 6 m/s².
    let country = road(&[(90.0, half, 30.0), (90.0, -half, 30.0), (37.5, half, 20.0)]);
    // Hairpins and kinks of a race track.
    let circuit =
        road(&[(12.0, pi, 8.0), (60.0, -half, 20.0), (15.0, -pi, 10.0), (150.0, 1.0, 30.0)]);
    // A bend of 6 m radius, as at a crossing.
    let town = road(&[(6.0, half, 3.0), (6.0, -half, 3.0), (6.5, pi, 3.0)]);
    for (name, road, spacing, sigma, allowed) in [
        ("1 Hz at 15 m/s", &country, 15.0, 0.0, 0.6),
        ("1 Hz at 15 m/s, RTK", &country, 15.0, 0.02, 0.6),
        ("1 Hz at 15 m/s, corrected", &country, 15.0, 0.3, 1.2),
        ("1 Hz at 15 m/s, alone", &country, 15.0, 1.5, 5.0),
        ("10 Hz at 15 m/s, RTK", &country, 1.5, 0.02, 0.1),
        ("10 Hz at 15 m/s, corrected", &country, 1.5, 0.3, 0.5),
        ("10 Hz at 15 m/s, alone", &country, 1.5, 1.5, 3.0),
        ("circuit, 5 m", &circuit, 5.0, 0.0, 0.3),
        ("circuit, 5 m, RTK", &circuit, 5.0, 0.02, 0.3),
        ("circuit, 5 m, corrected", &circuit, 5.0, 0.3, 1.0),
        ("crossing, 10 Hz at 4 m/s", &town, 0.4, 0.0, 0.12),
        ("crossing, 10 Hz at 4 m/s, RTK", &town, 0.4, 0.02, 0.12),
        ("crossing, 10 Hz at 7 m/s, RTK", &town, 0.7, 0.02, 0.15),
    ] {
        let (x, y) = drive(road, spacing, sigma);
        let recorded = from_points(&x, &y, &PointOptions::default()).expect(name);
        let off = off_road(&recorded, road);
        println!(
            "{name}: off {off:.3} m, rms {:.3}, largest {:.3}, noise {:.3}, smoothing {:.1} m, {:?} {:?}",
            recorded.rms_distance_m,
            recorded.largest_distance_m,
            recorded.noise_m,
            recorded.smoothing_length_m,
            recorded.excess,
            recorded.warnings,
        );
        assert!(off < allowed, "{name}: {off}");
        assert!(recorded.excess.is_none(), "{name}: {:?}", recorded.excess);
        if spacing < 2.0 && sigma < spacing {
            assert!((recorded.noise_m - sigma).abs() < 0.1 * sigma + 1e-3, "{name}");
        }
        assert!(!recorded.warnings.iter().any(|w| w.contains("left out point")), "{name}");
    }
}

#[test]
fn faults_are_found_among_fixes_that_are_far_apart() {
    let country = road(&[(90.0, 1.57, 30.0), (90.0, -1.57, 30.0), (60.0, 1.57, 20.0)]);
    for sigma in [0.0, 0.02, 0.3] {
        let (x, mut y) = drive(&country, 15.0, sigma);
        // On a straight, and in a bend.
        for wrong in [2, 9] {
            y[wrong] += 20.0;
            let recorded = from_points(&x, &y, &PointOptions::default()).expect("a path");
            let named = format!("left out point {}:", wrong + 1);
            let warnings = &recorded.warnings;
            assert!(warnings.iter().any(|w| w.starts_with(&named)), "{sigma}: {warnings:?}");
            y[wrong] -= 20.0;
        }
        let (mut x, y) = drive(&country, 15.0, sigma);
        for x in &mut x[14..] {
            *x += 60.0;
        }
        let error = fault(from_points(&x, &y, &PointOptions::default()));
        assert!(matches!(error, Error::Jump { .. } | Error::Jumps { .. }), "{sigma}: {error}");
    }
}

#[test]
fn a_deviation_that_is_exceeded_is_returned_with_its_place() {
    let town = road(&[(6.0, 1.57, 3.0)]);
    let (x, y) = drive(&town, 0.4, 0.0);
    let at = |options: PointOptions| from_points(&x, &y, &options).expect("a path");
    let recorded = at(PointOptions { max_deviation: Some(0.02), ..Default::default() });
    assert!(recorded.excess.is_none() && recorded.largest_distance_m <= 0.02, "{recorded:?}");
    assert_eq!(recorded.path.provenance.options["max_deviation_m"], "0.02");
    // A curvature that the bend does not have room for.
    let recorded =
        at(PointOptions { max_deviation: Some(0.1), max_curvature: 0.1, ..Default::default() });
    let excess = recorded.excess.expect("an excess");
    assert!(excess.deviation_m > 0.1 && excess.limit_m == 0.1 && !excess.is_mean);
    assert!((excess.at_m[0] - 44.0).abs() < 8.0 && excess.at_m[1].abs() < 8.0, "{excess:?}");
    let recorded = at(PointOptions { max_curvature: 0.1, ..Default::default() });
    assert!(recorded.excess.is_some_and(|e| e.is_mean), "{:?}", recorded.excess);
}
