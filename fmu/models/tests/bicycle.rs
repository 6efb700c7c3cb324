//! The bicycle model and its plant against the paper, textbook formulas and Runge–Kutta.
#![allow(clippy::unwrap_used)]

use crate::common;

use common::{runge_kutta, sample};
use nalgebra::{DMatrix, Matrix2, SVector, Vector2};
use proptest::prelude::*;
use steerwright_formats::VehicleData;
use steerwright_models::{BicycleParameters, BicyclePlant, Error, Sideslip, bicycle_body_frame};

fn car() -> BicycleParameters {
    BicycleParameters {
        mass: 1640.0,
        yaw_inertia: 2900.0,
        distance_front: 1.15,
        distance_rear: 1.55,
        cornering_stiffness_front: 105_000.0,
        cornering_stiffness_rear: 131_000.0,
        actuator_time_constant: 0.08,
        steering_ratio: 14.3,
        ..BicycleParameters::default()
    }
}

#[test]
fn every_number_of_the_file_arrives() {
    let vehicle = VehicleData {
        name: "car".into(),
        mass_kg: 1.0,
        yaw_inertia_kgm2: 2.0,
        distance_front_m: 3.0,
        distance_rear_m: 4.0,
        cornering_stiffness_front_npr: 5.0,
        cornering_stiffness_rear_npr: 6.0,
        actuator_time_constant_s: 7.0,
        actuator_delay_s: 10.0,
        actuator_rate_max_radps: Some(11.0),
        steering_ratio: 8.0,
        speed_mps: 9.0,
    };
    let expected = BicycleParameters {
        mass: 1.0,
        yaw_inertia: 2.0,
        distance_front: 3.0,
        distance_rear: 4.0,
        cornering_stiffness_front: 5.0,
        cornering_stiffness_rear: 6.0,
        actuator_time_constant: 7.0,
        actuator_delay: 10.0,
        actuator_rate_max: 11.0,
        steering_ratio: 8.0,
    };
    assert_eq!(BicycleParameters::from(&vehicle), expected);
    let unlimited = VehicleData { actuator_rate_max_radps: None, ..vehicle };
    assert_eq!(BicycleParameters::from(&unlimited).actuator_rate_max, 1e6);
}

/// Tyre forces by their definition, not by the coefficients A1…B2: (v̇_y, ṙ, δ̇, ψ̇, Ẋ, Ẏ).
fn newton(p: &BicycleParameters, v: f64, steering: f64, w: &[f64; 6]) -> [f64; 6] {
    let [vy, r, delta, psi, ..] = *w;
    let front = p.cornering_stiffness_front * (delta - (vy + p.distance_front * r) / v);
    let rear = p.cornering_stiffness_rear * (-(vy - p.distance_rear * r) / v);
    let (s, c) = psi.sin_cos();
    [
        (front + rear) / p.mass - v * r,
        (p.distance_front * front - p.distance_rear * rear) / p.yaw_inertia,
        ((steering / p.steering_ratio - delta) / p.actuator_time_constant)
            .clamp(-p.actuator_rate_max, p.actuator_rate_max),
        r,
        v * c - vy * s,
        v * s + vy * c,
    ]
}

#[test]
fn coefficients_are_the_papers() {
    let p = car();
    let k = p.coefficients();
    let (cf, cr, lf, lr, m, j) = (105_000.0, 131_000.0, 1.15, 1.55, 1640.0, 2900.0);
    for (ours, paper) in [
        (k.a1, -(cf + cr) / m),
        (k.a2, -(cf * lf - cr * lr) / m),
        (k.a3, (-cf * lf + cr * lr) / j),
        (k.a4, -(cf * lf * lf + cr * lr * lr) / j),
        (k.b1, cf / m),
        (k.b2, cf * lf / j),
        (k.n, 1.0 / 14.3),
        (k.tn, 0.08),
    ] {
        assert!((ours - paper).abs() < 1e-12 * paper.abs());
    }
}

/// Yaw-rate and lateral response of eq 13 and of the body-frame form, simulated apart.
#[test]
fn both_forms_are_one_at_constant_speed() {
    let p = car();
    for v in [3.0, 15.0, 40.0] {
        let (state, input) = p.coefficients().matrices(v);
        let (f, g) = bicycle_body_frame(&p, v);
        let h = 0.01;
        let (a5, b5) = sample(
            &DMatrix::from_fn(5, 5, |i, j| state.entry(i, j)),
            &DMatrix::from_fn(5, 1, |i, _| input.entry(i, 0)),
            h,
        );
        let (a3, b3) = sample(
            &DMatrix::from_fn(3, 3, |i, j| f[(i, j)]),
            &DMatrix::from_fn(3, 1, |i, _| g[i]),
            h,
        );
        let (mut x, mut w) = (DMatrix::zeros(5, 1), DMatrix::zeros(3, 1));
        let (mut yaw, mut lateral) = (0.0, 0.0);
        for k in 0..300 {
            let u = 0.4 * (f64::from(k) * 0.05).sin() + 0.1;
            x = &a5 * &x + &b5 * u;
            // Integrals of r and of ẏ = v_y + V·ψ over the step, for small yaw as in eq 13.
            let state = runge_kutta([w[0], w[1], w[2], yaw, lateral], h, 200, |s| {
                let d = f * SVector::<f64, 3>::new(s[0], s[1], s[2]) + g * u;
                [d[0], d[1], d[2], s[1], s[0] + v * s[3]]
            });
            (yaw, lateral) = (state[3], state[4]);
            w = &a3 * &w + &b3 * u;
            assert!((x[3] - w[1]).abs() < 1e-11, "yaw rate");
            assert!((x[1] - v * x[2] - w[0]).abs() < 1e-11, "lateral velocity");
            assert!((x[2] - yaw).abs() < 1e-10 && (x[0] - lateral).abs() < 1e-8, "yaw, lateral");
            assert!((x[4] / p.steering_ratio - w[2]).abs() < 1e-13, "actuator");
        }
    }
}

#[test]
fn steady_turn_is_the_textbooks() {
    let p = car();
    for v in [0.3, 0.9, 1.0, 5.0, 15.0, 35.0] {
        let mut plant = BicyclePlant::new(p).unwrap();
        (plant.speed, plant.steering_angle) = (v, 0.2);
        plant.step(30.0).unwrap();
        let (l, k) = (2.7, 1640.0 / 2.7 * (1.55 / 105_000.0 - 1.15 / 131_000.0));
        let gain = v / (l + k * v * v) / p.steering_ratio;
        assert!((plant.yaw_rate() / 0.2 - gain).abs() < 1e-12 * gain, "{v}");
        assert!((p.yaw_rate_gain(v) - gain).abs() < 1e-14);
        assert!((p.understeer_gradient() - k).abs() < 1e-15);
        let sideslip = plant.lateral_velocity() / v / plant.yaw_rate();
        assert!((sideslip - p.sideslip_per_yaw_rate(v)).abs() < 1e-9, "{v}");
        assert!((plant.lateral_acceleration() - v * plant.yaw_rate()).abs() < 1e-9);
        // The sideslip formula against force balance: rear force = m·ay·Lf/L.
        let balance = 1.55 / v - 1640.0 * v * 1.15 / (131_000.0 * l);
        assert!((sideslip - balance).abs() < 1e-9);
    }
}

/// On a slow wave of the steering β is S·r + C·ṙ but for what the square of its frequency brings.
#[test]
fn sideslip_leads_a_change_of_the_yaw_rate() {
    let (p, h) = (car(), 1e-3);
    for v in [4.0, 15.0, 35.0] {
        let off = |omega: f64| {
            let mut plant = BicyclePlant::new(p).unwrap();
            plant.speed = v;
            let (mut largest, mut before, mut scale) = (0.0_f64, [0.0; 2], 0.0_f64);
            let Sideslip { per_yaw_rate: s, per_yaw_acceleration: c, .. } =
                p.sideslip(12.0).at_speed(v);
            for k in 0..(30.0 / h) as usize {
                plant.steering_angle = 0.1 * (omega * (k as f64 + 0.5) * h).sin();
                plant.step(h).unwrap();
                let [r, beta] = [plant.yaw_rate(), plant.lateral_velocity() / v];
                let [middle, turning] = [0.5 * (r + before[0]), (r - before[0]) / h];
                if k as f64 * h > 10.0 {
                    let expected = s * middle + c * turning;
                    largest = largest.max((0.5 * (beta + before[1]) - expected).abs());
                    scale = scale.max((c * turning).abs());
                }
                before = [r, beta];
            }
            largest / scale
        };
        // What is left of the share of C falls with the frequency.
        let (slow, slower) = (off(0.8), off(0.4));
        assert!(slower < 0.1 && slower < 0.6 * slow, "{v} m/s: {slow} {slower}");
    }
}

proptest! {
    /// Speeds and steps that change all the time, against Newton's law by Runge–Kutta.
    #[test]
    fn follows_newton(
        steps in prop::collection::vec((0.001..0.15_f64, -3.0..3.0_f64, 1.0..60.0_f64), 1..10),
    ) {
        let p = car();
        let mut plant = BicyclePlant::new(p).unwrap();
        (plant.initial_x, plant.initial_y, plant.initial_yaw) = (-2.0, 7.0, -1.0);
        plant.start().unwrap();
        let mut w = [0.0, 0.0, 0.0, -1.0, -2.0, 7.0];
        for (h, steering, v) in steps {
            (plant.steering_angle, plant.speed) = (steering, v);
            plant.step(h).unwrap();
            w = runge_kutta(w, h, 1 + (h / 2e-5) as usize, |w| newton(&p, v, steering, w));
            prop_assert!((plant.lateral_velocity() - w[0]).abs() < 1e-10);
            prop_assert!((plant.yaw_rate() - w[1]).abs() < 1e-10);
            prop_assert!((plant.road_wheel_angle() - w[2]).abs() < 1e-12);
            prop_assert!((plant.yaw() - w[3]).abs() < 1e-10);
            prop_assert!((plant.x() - w[4]).abs() < 1e-9, "{} {}", plant.x(), w[4]);
            prop_assert!((plant.y() - w[5]).abs() < 1e-9, "{} {}", plant.y(), w[5]);
            let d = newton(&p, v, steering, &w);
            prop_assert!((plant.lateral_acceleration() - (d[0] + v * w[1])).abs() < 1e-8);
        }
    }
}

/// From standstill: nothing moves at v = 0, and nothing jumps at 1 m/s.
#[test]
fn starts_from_standstill() {
    let p = car();
    let mut plant = BicyclePlant::new(p).unwrap();
    (plant.speed, plant.steering_angle) = (0.0, 5.0);
    for _ in 0..100 {
        plant.step(0.01).unwrap();
    }
    assert_eq!((plant.x(), plant.y(), plant.yaw()), (0.0, 0.0, 0.0));
    // At walking pace the rear axle rolls on a circle about the kinematic centre.
    plant.speed = 0.05;
    plant.step(60.0).unwrap();
    let kinematic = 0.05 * 5.0 / p.steering_ratio / p.wheelbase();
    assert!((plant.yaw_rate() / kinematic - 1.0).abs() < 1e-3);
    assert!((plant.lateral_velocity() / plant.yaw_rate() - p.distance_rear).abs() < 1e-3);
    // Back to a stop: it stands.
    plant.speed = 0.0;
    plant.step(1.0).unwrap();
    let stood = (plant.x(), plant.y(), plant.yaw());
    plant.step(1.0).unwrap();
    assert!((plant.yaw() - stood.2).abs() < 1e-12 && (plant.x() - stood.0).abs() < 1e-12);
}

#[test]
fn blend_is_continuous_in_speed() {
    let respond = |v: f64| {
        let mut plant = BicyclePlant::new(car()).unwrap();
        (plant.speed, plant.steering_angle) = (v, 2.0);
        plant.step(0.1).unwrap();
        [plant.yaw_rate(), plant.lateral_velocity(), plant.lateral_acceleration(), plant.y()]
    };
    for v in [1e-9, 0.3, 1.0] {
        let (below, above) = (respond(v - 1e-9), respond(v + 1e-9));
        for (a, b) in below.iter().zip(above) {
            assert!((a - b).abs() < 1e-6, "{v}: {a} {b}");
        }
    }
}

/// At 1 m/s and above it is eq 13 and nothing else.
#[test]
fn blend_ends_at_one_metre_per_second() {
    let p = car();
    let (f, g) = bicycle_body_frame(&p, 1.0);
    let column = Vector2::new(f[(0, 2)], f[(1, 2)]);
    let steady = Vector2::new(p.lateral_velocity_per_yaw_rate(1.0), 1.0)
        * (p.yaw_rate_gain(1.0) * p.steering_ratio);
    let lateral: Matrix2<f64> = f.fixed_view::<2, 2>(0, 0).into();
    assert!((lateral * steady + column).amax() < 1e-10);
    assert!((g[2] * p.steering_ratio * p.actuator_time_constant - 1.0).abs() < 1e-15);
}

#[test]
fn refuses_what_is_no_vehicle() {
    let refused = |p: BicycleParameters| BicyclePlant::new(p).unwrap_err();
    assert!(
        refused(BicycleParameters { mass: 0.0, ..car() }).to_string().contains("the mass is 0")
    );
    assert!(matches!(
        refused(BicycleParameters { yaw_inertia: f64::NAN, ..car() }),
        Error::NotFinite { .. }
    ));
    assert!(matches!(
        refused(BicycleParameters { actuator_time_constant: 1e-9, ..car() }),
        Error::TooFast { .. }
    ));
    assert!(matches!(
        refused(BicycleParameters { cornering_stiffness_rear: 100.0, ..car() }),
        Error::CriticalSpeed { .. }
    ));
    let mut plant = BicyclePlant::new(car()).unwrap();
    for h in [0.0, -1.0, f64::NAN, 1e9] {
        assert!(plant.step(h).is_err());
    }
    plant.parameters.mass = -1.0;
    assert!(plant.start().is_err());
}

proptest! {
    /// The same of an actuator whose rate is limited, in and out of the limit within a step, and in parts of one.
    #[test]
    fn follows_newton_at_the_largest_rate(
        rate in 0.02..0.5_f64,
        steps in prop::collection::vec((0.01..0.15_f64, -3.0..3.0_f64, 1.0..60.0_f64), 1..10),
    ) {
        let p = BicycleParameters { actuator_rate_max: rate, ..car() };
        let mut plant = BicyclePlant::new(p).unwrap();
        let mut w = [0.0; 6];
        for (h, steering, v) in steps {
            (plant.steering_angle, plant.speed) = (steering, v);
            let mut halves = plant.clone();
            plant.step(h).unwrap();
            halves.step(0.5 * h).unwrap();
            halves.step(0.5 * h).unwrap();
            w = runge_kutta(w, h, 1 + (h / 2e-5) as usize, |w| newton(&p, v, steering, w));
            for (i, known) in w.into_iter().enumerate() {
                prop_assert!((plant.state(i) - known).abs() < 1e-7, "{i}: {known}");
                prop_assert!((plant.state(i) - halves.state(i)).abs() < 1e-9, "{i}");
            }
            let derivative = newton(&p, v, steering, &w);
            prop_assert!((plant.state_rate(2) - derivative[2]).abs() < 1e-6);
        }
    }
}

#[test]
fn a_ramp_faster_than_the_actuator_is_followed_at_its_largest_rate() {
    let p = BicycleParameters { actuator_rate_max: 0.2, ..car() };
    let mut plant = BicyclePlant::new(p).unwrap();
    plant.steering_rate = 2.0 * 0.2 * p.steering_ratio;
    plant.step(0.5).unwrap();
    // The lag ends where its error is the rate times the time constant; the error grows by 0.2 rad/s after.
    assert!(plant.road_wheel_angle() > 0.2 * 0.5 - 0.2 * 0.08 && plant.road_wheel_angle() < 0.1);
    let at = plant.road_wheel_angle();
    plant.steering_angle = 0.4 * 0.5 * p.steering_ratio;
    plant.step(0.1).unwrap();
    assert!((plant.road_wheel_angle() - at - 0.02).abs() < 1e-12);
}

#[test]
fn a_delay_is_a_shift_of_the_steering() {
    let late = BicycleParameters { actuator_delay: 0.125, ..car() };
    let (mut delayed, mut shifted) =
        (BicyclePlant::new(late).unwrap(), BicyclePlant::new(car()).unwrap());
    let steering = |k: i32| if k < 0 { 0.0 } else { 0.3 * (0.4 * f64::from(k)).sin() + 0.05 };
    for k in 0..400 {
        let h = 0.03125;
        delayed.steering_angle = steering(k);
        shifted.steering_angle = steering(k - 4);
        for plant in [&mut delayed, &mut shifted] {
            plant.speed = 12.0 + 0.02 * f64::from(k);
            plant.step(h).unwrap();
        }
        for i in 0..6 {
            assert!((delayed.state(i) - shifted.state(i)).abs() < 1e-12, "{k} {i}");
        }
        if k == 200 {
            let copy = BicyclePlant::restore(&delayed.save()).unwrap();
            assert_eq!(copy, delayed);
            delayed = copy;
        }
    }
    // The wheel rests where it starts, also behind a delay.
    delayed.initial_states = [0.0, 0.0, 0.01];
    delayed.start().unwrap();
    delayed.steering_angle = 0.0;
    delayed.step(0.1).unwrap();
    assert_eq!(delayed.road_wheel_angle(), 0.01);
    delayed.step(0.1).unwrap();
    assert!(delayed.road_wheel_angle() < 0.01);
    let refused = BicyclePlant::new(BicycleParameters { actuator_delay: -0.1, ..car() });
    assert!(refused.unwrap_err().to_string().contains("actuator's delay"));
}
