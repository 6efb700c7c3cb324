//! The guidance of a vehicle whose course is not its yaw.

#![allow(clippy::unwrap_used)]

use crate::common;

use common::{guided, road};
use std::sync::Arc;
use steerwright_formats::Guidance;
use steerwright_models::{
    BicycleParameters, BicyclePlant, GuidanceParameters, NonlinearParameters, NonlinearVehicle,
    PathFollower, PathGeometry, PathOutput, Sideslip,
};

/// A vehicle with sideslip S·r, its yaw steered perfectly, on a double bend of clothoids: it is not
/// led out of the bend before it is led in, and stays near the road.
#[test]
fn sideslip_leaves_little_where_the_curvature_changes() {
    let bend = |s: f64| match s {
        ..40.0 => 0.0,
        ..46.0 => (s - 40.0) / 100.0,
        ..58.0 => (52.0 - s) / 100.0,
        ..64.0 => (s - 64.0) / 100.0,
        _ => 0.0,
    };
    let path = Arc::new(PathGeometry::new(&road(120.0, 0.1, bend), false).unwrap());
    let (speed, h, sideslip) = (8.0, 0.005, 0.16);
    let g = guided(knowing(sideslip, 0.0, 0.0));
    let mut follower = PathFollower::new(path);
    let (mut x, mut y, mut yaw) = (0.0, 0.0, 0.0);
    let (mut largest, mut astray) = (0.0_f64, 0.0_f64);
    for _ in 0..2_800 {
        let out = follower.evaluate(&g, x, y, yaw, speed);
        follower.commit(&out);
        let course = out.yaw_reference + sideslip * (out.yaw_reference - yaw) / h;
        yaw = out.yaw_reference;
        x += h * speed * course.cos();
        y += h * speed * course.sin();
        largest = largest.max(out.cross_track_error.abs());
        if out.distance < 44.0 {
            astray = astray.max(-yaw);
        }
    }
    assert!(largest < 0.045, "{largest} m");
    assert!(astray < 0.002, "{astray} rad");
}

/// Sideslip of the multi-body cars of the experiment: speed, S, Q and C.
const CARS: [[f64; 4]; 3] = [
    [15.0, 0.040, -0.00101, 0.0033],
    [22.0, 0.0044, -0.00141, 0.0042],
    [8.0, 0.1655, -0.00044, 0.0011],
];

/// Lateral acceleration of the double bend's turns, m/s².
const ACCELERATION: f64 = 4.0;

/// Left, right and straight again: clothoids of 1.2 s between turns of 0.6 s.
fn double_bend(speed: f64) -> Arc<PathGeometry> {
    let curvature = move |s: f64| {
        let share = match s / speed - 2.0 {
            t if t < 0.0 => 0.0,
            t if t < 1.2 => t / 1.2,
            t if t < 1.8 => 1.0,
            t if t < 4.2 => 1.0 - (t - 1.8) / 1.2,
            t if t < 4.8 => -1.0,
            t if t < 6.0 => (t - 6.0) / 1.2,
            _ => 0.0,
        };
        share * ACCELERATION / (speed * speed)
    };
    Arc::new(PathGeometry::new(&road(10.0 * speed, speed / 50.0, curvature), false).unwrap())
}

/// A point whose course is its yaw and β = (S + Q·(v·r)²)·r + C·ṙ, on a yaw loop of third order which
/// the preview makes up for: largest and RMS cross-track error on the double bend.
fn followed(car: [f64; 4], law: Guidance) -> (f64, f64) {
    const BANDWIDTH: f64 = 60.0;
    let [speed, s, q, c] = car;
    let guided = guided(Guidance { preview_time_s: 3.0 / BANDWIDTH, ..law });
    let mut follower = PathFollower::new(double_bend(speed));
    let (mut x, mut y, mut yaw, mut rate, mut turning) = (0.0, 0.0, 0.0, 0.0, 0.0);
    let (mut largest, mut squares, h) = (0.0_f64, 0.0, 1e-3);
    for _ in 0..10_000 {
        let out: PathOutput = follower.evaluate(&guided, x, y, yaw, speed);
        follower.commit(&out);
        let jerk = BANDWIDTH
            * (BANDWIDTH * (BANDWIDTH * (out.yaw_reference - yaw) - 3.0 * rate) - 3.0 * turning);
        turning += h * jerk;
        rate += h * turning;
        yaw += h * rate;
        let course = yaw + (s + q * (speed * rate).powi(2)) * rate + c * turning;
        x += h * speed * course.cos();
        y += h * speed * course.sin();
        largest = largest.max(out.cross_track_error.abs());
        squares += out.cross_track_error.powi(2);
    }
    (largest, (squares * 1e-4).sqrt())
}

fn knowing(s: f64, q: f64, c: f64) -> Guidance {
    Guidance {
        sideslip_per_yaw_rate_s: s,
        sideslip_growth_s5pm2: q,
        sideslip_per_yaw_acceleration_s2: c,
        ..Guidance::default()
    }
}

#[test]
fn what_is_known_of_the_sideslip_leaves_little_error() {
    for car in CARS {
        let [speed, s, q, c] = car;
        // What a straight line through the same drive's turns would have yielded.
        let mean = s + 0.6 * q * ACCELERATION * ACCELERATION;
        let (line, without_growth, without_lead, full) = (
            followed(car, knowing(mean, 0.0, 0.0)),
            followed(car, knowing(mean, 0.0, c)),
            followed(car, knowing(s, q, 0.0)),
            followed(car, knowing(s, q, c)),
        );
        println!("{speed} m/s: {line:.4?} {without_growth:.4?} {without_lead:.4?} {full:.4?}");
        assert!(full.1 < 0.0016 && full.0 < 0.004, "{speed} m/s: {full:?}");
        // Where C is small beside S², the lag S is nearly all.
        if c < 0.25 * s * s {
            continue;
        }
        assert!(full.1 < line.1 / 6.0 && full.0 < line.0 / 5.0, "{speed} m/s: {full:?} {line:?}");
        assert!(full.1 < without_lead.1 / 4.0, "{speed} m/s: {full:?} {without_lead:?}");
        assert!(full.1 < without_growth.1 / 4.0, "{speed} m/s: {without_growth:?}");
    }
}

/// In a circle the yaw is the path's heading less (S + σ + Q·a²)·κ·v; C has no part in it. Beyond g no
/// tyre follows: the yaw goes on from there in proportion. σ counts up to 0.15 s.
#[test]
fn a_steady_turn_asks_for_the_steady_sideslip() {
    let (s, q, c) = (0.04, -0.001, 0.003);
    let turns = [(15.0, 0.0178), (15.0, -0.0178), (5.0, 0.1), (20.0, 0.1)];
    for ((speed, curvature), offset) in turns.into_iter().zip([0.0, 0.02, -0.03, -2.0]) {
        // What is read ahead or behind is on the circle, too.
        let path = PathGeometry::new(&road(200.0, 0.5, |_| curvature), false).unwrap();
        let point = path.point_at(100.0);
        let mut follower = PathFollower::new(Arc::new(path));
        let law =
            GuidanceParameters { sideslip_per_yaw_rate_offset: offset, ..guided(knowing(s, q, c)) };
        follower.integrate(&law, &PathOutput::default(), speed, 1e3);
        let out = follower.evaluate(&law, point.x_m, point.y_m, point.heading_rad, speed);
        let acceleration = (speed * speed * curvature).clamp(-9.81, 9.81);
        let per_yaw_rate = s + offset.max(-0.15) + q * acceleration * acceleration;
        let sideslip = per_yaw_rate * curvature * speed;
        let off = out.yaw_reference - (point.heading_rad - sideslip);
        assert!(off.abs() < 1e-9, "{speed} m/s, {curvature} 1/m: {off}");
    }
}

/// What C adds is what a change of the yaw rate asks for, of either sign of S² − 2C: on a clothoid,
/// whose heading is of second degree, ½·S² − C times the course's second derivative, exactly.
#[test]
fn a_clothoid_asks_for_the_lead_exactly() {
    let (speed, slope) = (12.0, 0.0008);
    let path = PathGeometry::new(&road(80.0, 0.5, |s| slope * s), false).unwrap();
    let point = path.point_at(40.0);
    let follower = PathFollower::new(Arc::new(path));
    for (s, c) in [(0.1, 0.001), (0.1, 0.02), (-0.05, 0.004), (0.0, 0.004), (0.0, -0.004)] {
        let out = follower.evaluate(&guided(knowing(s, 0.0, c)), point.x_m, point.y_m, 0.0, speed);
        let (rate, turning) = (point.curvature_per_m * speed, slope * speed * speed);
        let expected = point.heading_rad - s * rate + (s * s - c) * turning;
        assert!((out.yaw_reference - expected).abs() < 1e-9, "{s} {c}: {out:?} {expected}");
    }
}

/// What of the yaw acceleration the reference is to hold comes to it besides the sideslip's lead, known or
/// not: on a clothoid exactly.
#[test]
fn a_clothoid_asks_for_its_yaw_acceleration_exactly() {
    let (speed, slope, s) = (12.0, 0.0008, 0.1);
    let path = PathGeometry::new(&road(80.0, 0.5, |s| slope * s), false).unwrap();
    let point = path.point_at(40.0);
    let follower = PathFollower::new(Arc::new(path));
    for (c, gain) in [(0.0, -0.006), (0.0, 0.01), (0.002, -0.006), (0.002, 0.004), (0.02, 0.015)] {
        let guided = guided(Guidance { yaw_acceleration_gain_s2: gain, ..knowing(s, 0.0, c) });
        let out = follower.evaluate(&guided, point.x_m, point.y_m, 0.0, speed);
        let (rate, turning) = (point.curvature_per_m * speed, slope * speed * speed);
        let expected = point.heading_rad - s * rate + (s * s - c + gain) * turning;
        assert!((out.yaw_reference - expected).abs() < 1e-9, "{c} {gain}: {out:?} {expected}");
    }
}

/// On a road whose curvature's derivative changes, too, what of the yaw's jerk belongs into the reference:
/// that of the sideslip, `S·C − S³/3` of the logarithm of its transfer function, and what the loop needs.
#[test]
fn a_growing_change_asks_for_its_jerk_exactly() {
    let (speed, bend) = (12.0, 2e-5);
    let path = PathGeometry::new(&road(80.0, 0.1, |s| bend * s * s), false).unwrap();
    let point = path.point_at(40.0);
    let (distance, follower) = (point.distance_m, PathFollower::new(Arc::new(path)));
    for (s, c, gain) in [(0.1, 0.001, 0.0), (0.1, 0.02, 0.0), (0.0, 0.0, 8e-4), (0.16, 1e-3, -5e-4)]
    {
        let guided = guided(Guidance { yaw_jerk_gain_s3: gain, ..knowing(s, 0.0, c) });
        let out = follower.evaluate(&guided, point.x_m, point.y_m, 0.0, speed);
        // Heading, yaw rate, and its derivatives where the heading is read.
        let m = distance - speed * s;
        let heading = bend * m.powi(3) / 3.0;
        let [turning, jerk] = [2.0 * bend * m * speed.powi(2), 2.0 * bend * speed.powi(3)];
        let [second, third] =
            if c == 0.0 { [0.0; 2] } else { [0.5 * s * s - c, s * c - s.powi(3) / 3.0] };
        let expected = heading + second * turning + (third + gain) * jerk;
        assert!((out.yaw_reference - expected).abs() < 1e-6, "{s} {c} {gain}: {out:?} {expected}");
        // As much as the jerk's smallest part here.
        assert!(((third + gain) * jerk).abs() > 1e-5);
    }
}

/// The feedforward belongs to the yaw that is asked for: it is read where the heading is.
#[test]
fn the_feedforward_turns_with_the_yaw() {
    let (speed, slope, s, preview) = (12.0, 0.0008, 0.1, 0.3);
    let path = PathGeometry::new(&road(80.0, 0.5, |s| slope * s), false).unwrap();
    let point = path.point_at(40.0);
    let follower = PathFollower::new(Arc::new(path));
    let guided = guided(Guidance {
        feedforward_gain_radm: 2.5,
        preview_time_s: preview,
        ..knowing(s, 0.0, 0.0)
    });
    let out = follower.evaluate(&guided, point.x_m, point.y_m, 0.0, speed);
    let expected = 2.5 * slope * (point.distance_m + speed * (preview - s));
    assert!((out.steering_feedforward - expected).abs() < 1e-9, "{out:?} {expected}");
}

/// The yaw that is asked for moves about as the course does, also where clothoids begin and end.
#[test]
fn the_yaw_asked_for_is_continuous() {
    for [speed, s, q, c] in CARS {
        let path = double_bend(speed);
        let step = 0.01 * speed;
        let follower = PathFollower::new(path.clone());
        let mut before: Option<f64> = None;
        for k in 1..900 {
            let p = path.point_at(f64::from(k) * step);
            let yaw = follower
                .evaluate(&guided(knowing(s, q, c)), p.x_m, p.y_m, p.heading_rad, speed)
                .yaw_reference;
            if let Some(before) = before {
                // The course turns by 4 m/s² over the speed.
                let most = 1.25 * ACCELERATION / speed * 0.01;
                assert!((yaw - before).abs() < most, "{speed} m/s, {k}: {}", yaw - before);
            }
            before = Some(yaw);
        }
    }
}

/// Nothing known beyond S: the yaw lags the course's heading by S, `S·dψ/dt = ψ_p − ψ`. Absurd values give numbers or are
/// refused.
#[test]
fn without_growth_and_lead_the_yaw_lags() {
    let (speed, s) = (15.0, 0.07);
    let path = double_bend(speed);
    let (mut lagging, mut largest, step) = (0.0, 0.0_f64, 0.001);
    for k in 0..10_000 {
        let p = path.point_at(speed * step * f64::from(k));
        // Exact for a heading that moves on evenly: half a step later.
        let between = path.point_at(speed * step * (f64::from(k) - 0.5));
        lagging += (1.0 - (-step / s).exp()) * (between.heading_rad - lagging);
        if k % 10 != 0 {
            continue;
        }
        let mut follower = PathFollower::new(path.clone());
        follower.commit(&PathOutput { distance: p.distance_m, ..PathOutput::default() });
        let law = guided(knowing(s, 0.0, 0.0));
        let out = follower.evaluate(&law, p.x_m, p.y_m, p.heading_rad, speed);
        largest = largest.max((out.yaw_reference - lagging).abs());
        // A delay by S would differ by up to 0.5 mrad.
        assert!(largest < 1e-4, "{}: {largest}", p.distance_m);
        for (q, c) in [(1e300, 1e300), (-1e300, -1e300), (f64::MAX, f64::MIN), (-1e3, 1e6)] {
            let out =
                follower.evaluate(&guided(knowing(s, q, c)), p.x_m, p.y_m, p.heading_rad, speed);
            assert!(out.check().is_err() || out.yaw_reference.abs() < 10.0, "{out:?}");
        }
    }
}

/// A law identified at one speed is that of the vehicle at all others: of the two-wheel model exactly.
#[test]
fn the_law_is_that_of_a_bicycle_at_every_speed() {
    let car = BicycleParameters { yaw_inertia: 1500.0, ..BicycleParameters::default() };
    let law = car.sideslip(15.0);
    assert_eq!(law.at_speed(15.0), law);
    for speed in [5.0, 10.0, 20.0, 30.0] {
        let mut plant = BicyclePlant::new(car).unwrap();
        (plant.speed, plant.steering_angle) = (speed, 0.03);
        for _ in 0..3000 {
            plant.step(0.01).unwrap();
        }
        let simulated = plant.lateral_velocity() / speed / plant.yaw_rate();
        let here = law.at_speed(speed);
        println!("{speed} m/s: {simulated:.6} s simulated, {here:.6?}");
        assert!((here.per_yaw_rate - simulated).abs() < 1e-9, "{speed} m/s: {simulated} {here:?}");
        // A constant S is wrong there by as much as it is.
        assert!((law.per_yaw_rate - simulated).abs() > 0.02, "{speed} m/s: {simulated}");
        let lead = car.sideslip_per_yaw_acceleration(speed);
        assert!((here.per_yaw_acceleration - lead).abs() < 1e-12, "{speed} m/s: {lead} {here:?}");
        // There and back again.
        let back = here.at_speed(15.0);
        assert!((back.per_yaw_rate - law.per_yaw_rate).abs() < 1e-12, "{back:?}");
        assert!((back.per_yaw_acceleration - law.per_yaw_acceleration).abs() < 1e-12, "{back:?}");
    }
}

/// The growth with the lateral acceleration, too, is that of tyres that saturate: S and Q of a vehicle with
/// load transfer at 15 m/s give its sideslip in tight turns at other speeds.
#[test]
fn the_growth_is_that_of_saturating_tyres_at_every_speed() {
    let car = NonlinearParameters::default();
    // Sideslip angle over yaw rate and lateral acceleration.
    let turn = |speed: f64, acceleration: f64| {
        let mut plant = NonlinearVehicle::new(car).unwrap();
        plant.speed = speed;
        plant.start().unwrap();
        // Steered until the turn is as tight.
        for _ in 0..60_000 {
            let off = acceleration - speed * plant.yaw_rate();
            plant.steering_angle += 2e-6 * off;
            plant.step(1e-3).unwrap();
        }
        let rate = plant.yaw_rate();
        [(plant.lateral_velocity() / speed).atan() / rate, speed * rate]
    };
    let ([gentle, a1], [tight, a2]) = (turn(15.0, 0.5), turn(15.0, 4.0));
    let growth = (tight - gentle) / (a2 * a2 - a1 * a1);
    let law = Sideslip {
        per_yaw_rate: gentle - growth * a1 * a1,
        growth,
        reference_speed: 15.0,
        distance_rear: car.body.distance_rear_m,
        ..Sideslip::default()
    };
    for speed in [10.0, 22.0, 30.0] {
        let [sideslip, a] = turn(speed, 4.0);
        let expected = law.at_speed(speed).in_turn(a);
        let off = (expected - sideslip).abs();
        let constant = (law.at_speed(speed).per_yaw_rate + law.growth * a * a - sideslip).abs();
        println!(
            "{speed} m/s, {a:.3} m/s²: {sideslip:.5} {expected:.5} s, Q constant {constant:.5} off"
        );
        assert!(off < 5e-4 && constant > 3.0 * off, "{speed} m/s: {sideslip} {expected}");
    }
}

/// β's partial derivatives by speed and yaw rate, for laws of one and of every speed.
#[test]
fn the_law_s_derivatives_are_those_of_differences() {
    let of_one = Sideslip {
        per_yaw_rate: 0.04,
        growth: -0.001,
        per_yaw_acceleration: 0.003,
        reference_speed: 15.0,
        distance_rear: 0.0,
    };
    let turning = 0.4;
    for law in [
        of_one,
        Sideslip { distance_rear: 1.5, ..of_one },
        Sideslip { distance_rear: 1.5, growth: 0.0, ..of_one },
        Sideslip { distance_rear: 1.5, per_yaw_acceleration: 0.0, ..of_one },
        Sideslip { distance_rear: 1.5, reference_speed: 0.3, ..of_one },
    ] {
        let beta = |speed: f64, rate: f64| {
            let here = law.at_speed(speed);
            here.in_turn(speed * rate) * rate + here.per_yaw_acceleration * turning
        };
        // Beyond g, below 1 m/s and backwards, too.
        for (speed, rate) in [(15.0, 0.2), (8.0, -0.4), (30.0, 0.5), (0.5, 0.3), (-2.0, 0.1)] {
            let h = 1e-5;
            let by_speed = (beta(speed + h, rate) - beta(speed - h, rate)) / (2.0 * h);
            let off = law.by_speed(speed, rate, turning) - by_speed;
            assert!(off.abs() < 1e-8, "{law:?} {speed} {rate}: {off}");
            let by_rate = (beta(speed, rate + h) - beta(speed, rate - h)) / (2.0 * h);
            let off = law.at_speed(speed).by_yaw_rate(speed * rate) - by_rate;
            assert!(off.abs() < 1e-8, "{law:?} {speed} {rate}: {off}");
        }
    }
}

/// Without the distance to the rear axle the terms are those of every speed, to the last bit.
#[test]
fn without_a_distance_the_law_is_constant() {
    let law = Sideslip {
        per_yaw_rate: 0.04,
        growth: -0.001,
        per_yaw_acceleration: 0.003,
        reference_speed: 15.0,
        distance_rear: 0.0,
    };
    for speed in [0.0, 0.2, 7.0, 40.0] {
        assert_eq!(law.at_speed(speed), Sideslip { reference_speed: speed, ..law });
    }
}

/// The path follower takes the law's terms at its own speed.
#[test]
fn guidance_takes_the_law_at_its_speed() {
    let law = Sideslip {
        per_yaw_rate: 0.02,
        growth: -0.0005,
        per_yaw_acceleration: 0.003,
        reference_speed: 15.0,
        distance_rear: 1.5,
    };
    for speed in [6.0, 15.0, 25.0] {
        let path = double_bend(speed);
        for k in 0..200 {
            let p = path.point_at(0.04 * speed * f64::from(k));
            let mut follower = PathFollower::new(path.clone());
            follower.commit(&PathOutput { distance: p.distance_m, ..PathOutput::default() });
            let yaw = |sideslip: Sideslip| {
                let guidance = Guidance {
                    sideslip_per_yaw_rate_s: sideslip.per_yaw_rate,
                    sideslip_growth_s5pm2: sideslip.growth,
                    sideslip_per_yaw_acceleration_s2: sideslip.per_yaw_acceleration,
                    distance_rear_m: sideslip.distance_rear,
                    ..Guidance::default()
                };
                let guided = GuidanceParameters {
                    guidance,
                    reference_speed: sideslip.reference_speed,
                    ..Default::default()
                };
                follower.evaluate(&guided, p.x_m, p.y_m, p.heading_rad, speed).yaw_reference
            };
            let here = Sideslip { distance_rear: 0.0, ..law.at_speed(speed) };
            assert_eq!(yaw(law).to_bits(), yaw(here).to_bits(), "{speed} m/s, {k}");
        }
    }
}
