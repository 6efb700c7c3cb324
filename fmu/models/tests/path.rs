//! The path's geometry and the guidance on it.
#![allow(clippy::unwrap_used)]

use crate::common;

use common::{guided, road};
use proptest::prelude::*;
use std::f64::consts::{FRAC_PI_2, PI, TAU};
use std::sync::Arc;
use steerwright_formats::{Guidance, PathPoint};
use steerwright_models::{
    Error, GuidanceParameters, GuidanceState, PathFollower, PathGeometry, wrap_angle,
};

fn winding(s: f64) -> f64 {
    0.04 * (s / 17.0).sin()
}

/// A figure eight: two circles of 20 m radius, the left one first, crossing at the origin.
fn eight() -> Arc<PathGeometry> {
    let (radius, count) = (20.0, 200_i32);
    let points: Vec<PathPoint> = (0..=2 * count)
        .map(|i| {
            let a = f64::from(i) * TAU / f64::from(count);
            let side = if i <= count { 1.0 } else { -1.0 };
            let angle = if i <= count { a } else { TAU - (a - TAU) };
            PathPoint {
                distance_m: a * radius,
                x_m: radius * a.sin(),
                y_m: side * radius * (1.0 - a.cos()),
                heading_rad: angle,
                curvature_per_m: side / radius,
            }
        })
        .collect();
    Arc::new(PathGeometry::new(&points, true).unwrap())
}

#[test]
fn interpolation_is_true_to_the_road() {
    let exact = PathGeometry::new(&road(200.0, 0.25, winding), false).unwrap();
    let sparse = PathGeometry::new(&road(200.0, 4.0, winding), false).unwrap();
    for k in 0..2000 {
        let s = f64::from(k) * 0.1;
        let (a, b) = (exact.point_at(s), sparse.point_at(s));
        assert!((a.x_m - b.x_m).hypot(a.y_m - b.y_m) < 1e-5, "{s}: {a:?} {b:?}");
        assert!((a.heading_rad - b.heading_rad).abs() < 1e-4);
        assert!((b.curvature_per_m - winding(s)).abs() < 3e-4);
    }
    // On a circle the error is of sixth order.
    let circle = PathGeometry::new(&road(60.0, 5.0, |_| 0.1), false).unwrap();
    for k in 0..600 {
        let s = f64::from(k) * 0.1;
        let p = circle.point_at(s);
        assert!((p.x_m.hypot(p.y_m - 10.0) - 10.0).abs() < 1e-5, "{s}");
    }
}

proptest! {
    /// On the path the errors are zero, off the path they are as placed.
    #[test]
    fn finds_the_foot(s in 1.0..199.0_f64, offset in -8.0..8.0_f64, from in -9.0..9.0_f64) {
        let path = PathGeometry::new(&road(200.0, 1.0, winding), false).unwrap();
        let p = path.point_at(s);
        let (x, y) = (p.x_m - offset * p.heading_rad.sin(), p.y_m + offset * p.heading_rad.cos());
        let found = path.project(x, y, s + from);
        prop_assert!((found.foot.distance_m - s).abs() < 1e-9, "{} {s}", found.foot.distance_m);
        prop_assert!((found.cross_track_error - offset).abs() < 1e-9);
        let anywhere = path.locate(x, y, p.heading_rad);
        prop_assert!((anywhere.foot.distance_m - s).abs() < 1e-9);
    }

    /// Turning and shifting road and vehicle together changes the yaw reference by the turn alone.
    #[test]
    fn is_invariant_to_rotation_and_shift(
        turn in -7.0..7.0_f64, dx in -500.0..500.0_f64, dy in -500.0..500.0_f64,
        s in 5.0..190.0_f64, offset in -5.0..5.0_f64, yaw in -3.0..3.0_f64,
    ) {
        let points = road(200.0, 1.0, winding);
        let (sin, cos) = turn.sin_cos();
        let moved = |x: f64, y: f64| (cos * x - sin * y + dx, sin * x + cos * y + dy);
        let turned: Vec<PathPoint> = points.iter().map(|p| {
            let (x, y) = moved(p.x_m, p.y_m);
            PathPoint { x_m: x, y_m: y, heading_rad: p.heading_rad + turn, ..*p }
        }).collect();
        let here = Arc::new(PathGeometry::new(&points, false).unwrap());
        let there = PathFollower::new(Arc::new(PathGeometry::new(&turned, false).unwrap()));
        let guidance = guided(Guidance {
            preview_time_s: 0.3, feedforward_gain_radm: 40.0, sideslip_per_yaw_rate_s: 0.05,
            ..Guidance::default()
        });
        let p = here.point_at(s);
        let (x, y) = (p.x_m - offset * p.heading_rad.sin(), p.y_m + offset * p.heading_rad.cos());
        let a = PathFollower::new(here).evaluate(&guidance, x, y, yaw, 10.0);
        let (x, y) = moved(x, y);
        let b = there.evaluate(&guidance, x, y, yaw + turn, 10.0);
        prop_assert!((b.yaw_reference - a.yaw_reference - turn).abs() < 1e-9);
        for (a, b) in [
            (a.cross_track_error, b.cross_track_error),
            (a.steering_feedforward, b.steering_feedforward),
            (a.distance, b.distance),
            (a.curvature, b.curvature),
            (wrap_angle(a.heading_error - b.heading_error), 0.0),
        ] {
            prop_assert!((a - b).abs() < 1e-8, "{a} {b}");
        }
    }
}

#[test]
fn guidance_law() {
    let path = Arc::new(PathGeometry::new(&road(200.0, 1.0, |_| 0.02), false).unwrap());
    let follower = PathFollower::new(path.clone());
    let g = guided(Guidance {
        lookahead_time_s: 0.5,
        lookahead_min_m: 6.0,
        preview_time_s: 0.2,
        feedforward_gain_radm: 45.0,
        sideslip_per_yaw_rate_s: -0.03,
        ..Guidance::default()
    });
    let p = path.point_at(50.0);
    let (x, y) = (p.x_m - 2.0 * p.heading_rad.sin(), p.y_m + 2.0 * p.heading_rad.cos());
    for (speed, lookahead) in [(10.0, 6.0), (20.0, 10.0)] {
        let out = follower.evaluate(&g, x, y, p.heading_rad + 0.1 + TAU, speed);
        let ahead = 0.02 * (50.0 + 0.2 * speed);
        let expected = ahead - 2.0_f64.atan2(lookahead) + 0.03 * 0.02 * speed;
        assert!((out.yaw_reference - expected).abs() < 1e-6, "{out:?} {expected}");
        assert!((out.steering_feedforward - 0.9).abs() < 1e-9);
        assert!((out.cross_track_error - 2.0).abs() < 1e-6 && !out.finished);
        assert!((out.heading_error - 0.1).abs() < 1e-6 && (out.curvature - 0.02).abs() < 1e-12);
    }
}

/// A vehicle whose course is its yaw and a constant, steered perfectly along a straight: where it
/// ends off the path, and the furthest it was on the other side on the way.
fn crabbing(gain: f64, crab: f64, start: f64) -> (f64, f64) {
    let path = Arc::new(PathGeometry::new(&road(3000.0, 10.0, |_| 0.0), false).unwrap());
    let mut follower = PathFollower::new(path);
    let g = guided(Guidance { cross_track_integral_gain_per_s: gain, ..Guidance::default() });
    let (mut x, mut y, speed, h) = (0.0, start, 15.0, 0.01);
    let mut beyond = 0.0_f64;
    for _ in 0..15_000 {
        let out = follower.evaluate(&g, x, y, 0.0, speed);
        follower.commit(&out);
        follower.integrate(&g, &out, speed, h);
        let course = out.yaw_reference + crab;
        x += h * speed * course.cos();
        y += h * speed * course.sin();
        beyond = beyond.max(-y * start.signum());
    }
    (y, beyond)
}

#[test]
fn the_integral_takes_the_place_of_a_lasting_error() {
    let crab = 0.02;
    // Without it the look-ahead distance of 15 m times the crab's tangent remains.
    assert!((crabbing(0.0, crab, 1.0).0 - 15.0 * crab.tan()).abs() < 1e-3);
    for gain in [0.05, 0.2] {
        assert!(crabbing(gain, crab, 1.0).0.abs() < 1e-3, "{gain}");
    }
    // From afar it does not wind up: the path is met with hardly more overshoot than from near by.
    let (end, beyond) = crabbing(0.05, 0.0, 80.0);
    assert!(end.abs() < 1e-3 && beyond < 0.15 * 15.0, "{end} {beyond}");
    // At a standstill it waits.
    let mut follower = PathFollower::new(eight());
    let g = guided(Guidance { cross_track_integral_gain_per_s: 1.0, ..Guidance::default() });
    let out = follower.evaluate(&g, 1.0, 2.0, 0.0, 0.0);
    follower.integrate(&g, &out, 0.0, 1e3);
    assert_eq!(follower.state().integral, 0.0);
    follower.integrate(&g, &out, 1.0, 1e9);
    assert!(follower.state().integral.abs() <= g.guidance.lookahead_min_m);
}

/// A vehicle with a sideslip of 0 is steered perfectly round the eight by a follower with another one: the largest error on
/// the first lap and on the third, and the correction.
fn with_a_wrong_sideslip(time: f64, wrong: f64) -> ([f64; 2], f64) {
    let mut follower = PathFollower::new(eight());
    let g = guided(Guidance {
        sideslip_per_yaw_rate_s: wrong,
        sideslip_correction_time_s: time,
        ..Guidance::default()
    });
    let (mut x, mut y, mut yaw, speed, h) = (0.0, 0.0, 0.0, 6.0, 0.01);
    let mut largest = [0.0_f64; 2];
    let length = follower.geometry().end();
    loop {
        let out = follower.evaluate(&g, x, y, yaw, speed);
        follower.commit(&out);
        follower.integrate(&g, &out, speed, h);
        yaw = out.yaw_reference;
        x += h * speed * yaw.cos();
        y += h * speed * yaw.sin();
        match (out.distance / length) as usize {
            0 => largest[0] = largest[0].max(out.cross_track_error.abs()),
            2 => largest[1] = largest[1].max(out.cross_track_error.abs()),
            3 => return (largest, follower.state().sideslip_correction),
            _ => {}
        }
    }
}

#[test]
fn the_cross_track_error_of_turns_corrects_the_sideslip() {
    let ([_, with_right], _) = with_a_wrong_sideslip(0.0, 0.0);
    for wrong in [-0.08, 0.08] {
        let ([first, third], correction) = with_a_wrong_sideslip(0.0, wrong);
        assert!(first > 0.12 && third > 0.12 && correction == 0.0, "{first} {third}");
        let ([_, third], correction) = with_a_wrong_sideslip(4.0, wrong);
        assert!(third < 1.3 * with_right, "{third} {with_right}");
        assert!((correction + wrong).abs() < 0.01, "{correction}");
    }
    // Neither far off the path, nor at a standstill, nor by more than a sideslip may be.
    let mut follower = PathFollower::new(eight());
    let g = guided(Guidance { sideslip_correction_time_s: 4.0, ..Guidance::default() });
    let off = follower.evaluate(&g, 1.0, -9.0, 0.0, 6.0);
    follower.integrate(&g, &off, 6.0, 1.0);
    let before = follower.state().sideslip_correction;
    assert!(before.abs() < 0.02, "{before}");
    follower.integrate(&g, &off, 0.0, 1e3);
    assert_eq!(follower.state().sideslip_correction, before);
    follower.integrate(&g, &off, 6.0, 1e9);
    assert_eq!(follower.state().sideslip_correction.abs(), 0.15);
    for wrong in [f64::NAN, f64::INFINITY] {
        for state in [
            GuidanceState { sideslip_correction: wrong, ..*follower.state() },
            GuidanceState { sideslip_offset: wrong, ..*follower.state() },
            GuidanceState { integral: wrong, ..*follower.state() },
            GuidanceState { progress: Some(wrong), ..*follower.state() },
        ] {
            assert!(follower.restore(state).is_err(), "{state:?}");
        }
    }
}

/// An offset of the sideslip is taken over with the time constant Δ/v, whatever the step, and not at a standstill.
#[test]
fn an_offset_of_the_sideslip_is_followed() {
    let law = GuidanceParameters {
        sideslip_per_yaw_rate_offset: 0.02,
        ..guided(Guidance { lookahead_time_s: 1.2, lookahead_min_m: 3.0, ..Guidance::default() })
    };
    let after = |speed: f64, steps: i32, step: f64| {
        let mut follower = PathFollower::new(eight());
        let out = follower.evaluate(&law, 1.0, 2.0, 0.0, speed);
        (0..steps).for_each(|_| follower.integrate(&law, &out, speed, step));
        follower.state().sideslip_offset
    };
    for step in [0.01, 0.001] {
        let offset = after(10.0, (1.2 / step) as i32, step);
        assert!((offset / 0.02 - (1.0 - (-1.0_f64).exp())).abs() < 0.005, "{step}: {offset}");
    }
    assert!((after(10.0, 1000, 0.1) - 0.02).abs() < 1e-12 && after(0.0, 10, 1.0) == 0.0);
    assert_eq!(after(10.0, 1, 1e6), 0.02);
}

/// Round the eight for five laps, also right through the crossing, with an error to the side.
#[test]
fn progress_is_monotone_and_never_jumps_on_an_eight() {
    let path = eight();
    let length = path.end() - path.start();
    for offset in [0.0, 1.5, -1.5] {
        for step in [0.05, 0.7, 5.0] {
            let mut follower = PathFollower::new(path.clone());
            let (mut before, mut reference) = (0.0, None::<f64>);
            for k in 0..(5.0 * length / step) as i32 {
                let s = f64::from(k) * step;
                let p = path.point_at(s);
                let (x, y) =
                    (p.x_m - offset * p.heading_rad.sin(), p.y_m + offset * p.heading_rad.cos());
                let guidance = GuidanceParameters::default();
                let out = follower.evaluate(&guidance, x, y, p.heading_rad, 10.0);
                assert!((out.distance - s).abs() < 1e-6, "{step}: at {s}, found {}", out.distance);
                assert!((out.cross_track_error - offset).abs() < 1e-6 && !out.finished);
                assert!(k == 0 || out.distance > before, "{} {before}", out.distance);
                if let Some(r) = reference {
                    assert!((out.yaw_reference - r).abs() < step / 20.0 + 0.03, "{s}: {r} {out:?}");
                }
                (before, reference) = (out.distance, Some(out.yaw_reference));
                follower.commit(&out);
            }
        }
    }
}

/// At the crossing of the eight both branches are equally near: the heading decides.
#[test]
fn starts_on_the_branch_that_goes_its_way() {
    // A road out and back: the return runs 0.5 m from the way out.
    let mut points = road(100.0, 1.0, |_| 0.0);
    for k in 0..=40 {
        let a = f64::from(k) * PI / 40.0;
        points.push(PathPoint {
            distance_m: 100.0 + 0.01 + a * 2.0,
            x_m: 100.01 + 2.0 * a.sin(),
            y_m: 2.0 - 2.0 * a.cos(),
            heading_rad: a,
            curvature_per_m: 0.5,
        });
    }
    let d = points[points.len() - 1].distance_m;
    for k in 1..=90 {
        points.push(PathPoint {
            distance_m: d + f64::from(k) + 0.1,
            x_m: 100.01 - f64::from(k),
            y_m: 4.0 - 3.5 * (f64::from(k) / 20.0).min(1.0),
            heading_rad: PI,
            curvature_per_m: 0.0,
        });
    }
    let path = PathGeometry::new(&points, false).unwrap();
    assert!(path.locate(50.0, 0.3, 0.0).foot.distance_m < 60.0);
    assert!(path.locate(50.0, 0.2, PI).foot.distance_m > 100.0);
    assert!(path.locate(50.0, 0.2, FRAC_PI_2 + 3.0).foot.distance_m > 100.0);
}

#[test]
fn goes_on_straight_beyond_the_ends() {
    let path = Arc::new(PathGeometry::new(&road(50.0, 1.0, |_| 0.02), false).unwrap());
    let mut follower = PathFollower::new(path.clone());
    let g = guided(Guidance { feedforward_gain_radm: 1.0, ..Guidance::default() });
    let mut k = 0;
    for i in -60..=220 {
        let s = f64::from(i) * 0.5;
        let p = path.point_at(s);
        let out = follower.evaluate(
            &g,
            p.x_m - p.heading_rad.sin(),
            p.y_m + p.heading_rad.cos(),
            0.0,
            10.0,
        );
        assert!((out.distance - s).abs() < 1e-9, "{s} {}", out.distance);
        assert!((out.cross_track_error - 1.0).abs() < 1e-9);
        assert_eq!(out.finished, s >= 50.0, "{s}");
        if !(0.0..50.0).contains(&s) {
            assert_eq!((out.curvature, out.steering_feedforward), (0.0, 0.0));
            k += 1;
        }
        follower.commit(&out);
    }
    assert!(k > 100);
    assert!((path.point_at(80.0).heading_rad - 1.0).abs() < 1e-12);
    // And back in again.
    let p = path.point_at(40.0);
    let mut end = PathFollower::new(path.clone());
    end.commit(&follower.evaluate(&g, path.point_at(60.0).x_m, path.point_at(60.0).y_m, 1.0, 10.0));
    assert!((end.evaluate(&g, p.x_m, p.y_m, 0.8, 10.0).distance - 40.0).abs() < 1e-9);
}

#[test]
fn a_closed_path_closes_itself() {
    // A circle whose last point is one spacing before the first, headings wrapped.
    let circle: Vec<PathPoint> = (0..60)
        .map(|k| {
            let a = f64::from(k) * TAU / 60.0;
            PathPoint {
                distance_m: a * 30.0,
                x_m: 30.0 * a.cos(),
                y_m: 30.0 * a.sin(),
                heading_rad: wrap_angle(a + FRAC_PI_2),
                curvature_per_m: 1.0 / 30.0,
            }
        })
        .collect();
    let path = PathGeometry::new(&circle, true).unwrap();
    assert!((path.end() - TAU * 30.0).abs() < 1e-9);
    for lap in [-2.0, 0.0, 7.0] {
        let p = path.point_at(lap * path.end() + 40.0);
        assert!((p.heading_rad - (40.0 / 30.0 + FRAC_PI_2 + lap * TAU)).abs() < 1e-7);
        assert!((p.x_m - 30.0 * (40.0_f64 / 30.0).cos()).abs() < 1e-7);
    }
}

/// Wherever the vehicle is, also at the centre of a circle, there is an answer and it is finite.
#[test]
fn survives_lost_vehicles() {
    for path in [eight(), Arc::new(PathGeometry::new(&road(100.0, 1.0, winding), false).unwrap())] {
        let mut follower = PathFollower::new(path);
        for k in 0..3000 {
            let a = f64::from(k);
            let (x, y) =
                (300.0 * (a * 0.7).sin(), 20.0 + 200.0 * (a * 1.3).cos() * (a * 0.01).sin());
            let out = follower.evaluate(&GuidanceParameters::default(), x, y, a, 5.0);
            assert!(out.yaw_reference.is_finite() && out.distance.is_finite());
            follower.commit(&out);
        }
        let out = follower.evaluate(&GuidanceParameters::default(), 0.0, 20.0, 0.0, 0.0);
        assert!(out.yaw_reference.is_finite());
    }
}

#[test]
fn bad_paths_are_refused_by_point() {
    let good = road(10.0, 1.0, |_| 0.0);
    let refused = |change: &dyn Fn(&mut Vec<PathPoint>)| {
        let mut points = good.clone();
        change(&mut points);
        let error = PathGeometry::new(&points, false).unwrap_err();
        assert!(!error.hint().is_empty());
        error
    };
    assert_eq!(refused(&|p| p.truncate(1)), Error::TooFewPoints { got: 1 });
    assert!(matches!(refused(&|p| p[3].x_m = f64::NAN), Error::Point { index: 3, name: "x", .. }));
    assert!(matches!(refused(&|p| p[4].distance_m = 3.0), Error::Distance { index: 4, .. }));
    assert!(matches!(refused(&|p| p[4].y_m = 9.0), Error::ShorterThanChord { index: 4, .. }));
    assert!(matches!(
        refused(&|p| p.iter_mut().for_each(|p| p.heading_rad = 3.0)),
        Error::Heading { index: 0, .. }
    ));
}
