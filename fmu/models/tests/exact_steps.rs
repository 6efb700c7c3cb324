//! However time is cut into steps, a held input and a ramp give the same states: those of one
//! exponential over the whole, found here by a Taylor series of its own.
#![allow(clippy::unwrap_used)]

use crate::common;

use common::{car, from_continuous, runge_kutta, taylor_exponential};
use nalgebra::DMatrix;
use proptest::prelude::*;
use std::sync::Arc;
use steerwright_formats::InputKind;
use steerwright_models::{
    BicycleParameters, BicyclePlant, IdentifiedData, IdentifiedModel, IdentifiedPlant, Sideslip,
    bicycle_body_frame,
};

fn plant(data: &IdentifiedData) -> IdentifiedPlant {
    IdentifiedPlant::new(Arc::new(IdentifiedModel::new(data.clone()).unwrap()))
}

/// States after `time` under `u(t) = u0 + slope·t`, from `x0`.
fn ramped(f: &[f64], g: &[f64], x0: &[f64], (u0, slope): (f64, f64), time: f64) -> Vec<f64> {
    let n = g.len();
    let m = DMatrix::from_fn(n + 2, n + 2, |i, j| match (i < n, j) {
        (true, j) if j < n => f[i * n + j],
        (true, j) if j == n => g[i],
        (false, j) if i == n && j == n + 1 => 1.0,
        _ => 0.0,
    });
    let z = DMatrix::from_iterator(n + 2, 1, x0.iter().copied().chain([u0, slope]));
    (taylor_exponential(&(m * time)) * z).iter().take(n).copied().collect()
}

fn assert_close(ours: &[f64], expected: &[f64], relative: f64) -> Result<(), TestCaseError> {
    let scale = expected.iter().fold(0.0_f64, |m, x| m.max(x.abs()));
    for (a, b) in ours.iter().zip(expected) {
        prop_assert!((a - b).abs() <= relative * scale, "{ours:?} {expected:?}");
    }
    Ok(())
}

fn hundred_steps() -> impl Strategy<Value = Vec<f64>> {
    prop::collection::vec(prop_oneof![1 => Just(0.01), 3 => 0.0001..0.05_f64], 100)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    /// A held input, at once and delayed: 100 steps are one exponential, to 1e-12.
    #[test]
    fn held_input(steps in hundred_steps(), delay in prop_oneof![Just(0.0), 0.001..0.6_f64]) {
        let data = IdentifiedData { delay, ..car() };
        let mut p = plant(&data);
        p.initial_states_mut().copy_from_slice(&[0.1, -0.2, 0.3]);
        p.start();
        p.steering_angle = 0.3;
        for &h in &steps {
            p.step(h).unwrap();
        }
        let total: f64 = steps.iter().sum();
        let c = data.continuous.unwrap();
        let free = ramped(&c.f, &c.g, &[0.1, -0.2, 0.3], (0.0, 0.0), delay.min(total));
        let expected = ramped(&c.f, &c.g, &free, (0.29, 0.0), (total - delay).max(0.0));
        assert_close(p.states(), &expected, 1e-12)?;
    }

    /// A ramp, at once and delayed: 100 pieces of it are the one ramp, to 1e-12.
    #[test]
    fn ramp(
        steps in hundred_steps(),
        delay in prop_oneof![Just(0.0), 0.001..0.6_f64],
        (u0, slope) in (-0.3..0.3_f64, -0.5..0.5_f64),
        product in any::<bool>(),
    ) {
        let mut data = IdentifiedData { delay, ..car() };
        if product {
            data.input = InputKind::SteeringTimesSpeed;
        }
        let total: f64 = steps.iter().sum();
        let mut one = plant(&data);
        (one.steering_angle, one.steering_rate) = (u0, slope);
        one.step(total).unwrap();
        let mut many = plant(&data);
        many.steering_rate = slope;
        let mut time = 0.0;
        for &h in &steps {
            many.steering_angle = u0 + slope * time;
            many.step(h).unwrap();
            time += h;
        }
        let c = data.continuous.unwrap();
        let gain = if product { 15.0 } else { 1.0 };
        let input = (gain * (u0 - 0.01), gain * slope);
        let expected = ramped(&c.f, &c.g, &[0.0; 3], input, (total - delay).max(0.0));
        assert_close(one.states(), &expected, 1e-12)?;
        assert_close(many.states(), &expected, 1e-12)?;
        prop_assert!((one.yaw() - many.yaw()).abs() < 1e-11 * (1.0 + one.yaw().abs()));
        prop_assert!((one.x() - many.x()).hypot(one.y() - many.y()) < 1e-9);
    }

    /// Yaw and position under ramps, with feedthrough, against Runge–Kutta.
    #[test]
    fn pose_under_ramps(
        steps in prop::collection::vec((0.001..0.2_f64, -0.5..0.5_f64, -2.0..2.0_f64, 0.0..50.0_f64), 1..8),
        d in prop_oneof![Just(0.0), -0.5..0.5_f64],
    ) {
        let data = IdentifiedData { d, ..car() };
        let mut p = plant(&data);
        let c = data.continuous.clone().unwrap();
        let mut w = [0.0; 7];
        for (h, steering, slope, speed) in steps {
            (p.steering_angle, p.steering_rate, p.speed) = (steering, slope, speed);
            p.step(h).unwrap();
            w[6] = steering - 0.01;
            w = runge_kutta(w, h, 1 + (h / 5e-5) as usize, |w| {
                let row = |i: usize| (0..3).map(|j| c.f[3 * i + j] * w[j]).sum::<f64>() + c.g[i] * w[6];
                let rate = c.h.iter().zip(w).map(|(h, x)| h * x).sum::<f64>() + d * w[6] + 0.02;
                let (sin, cos) = w[3].sin_cos();
                let slip = data.sideslip.per_yaw_rate * rate;
                let (x, y) = (speed * (cos - slip * sin), speed * (sin + slip * cos));
                [row(0), row(1), row(2), rate, x, y, slope]
            });
            prop_assert!((p.yaw() - w[3]).abs() < 1e-11, "yaw {} {}", p.yaw(), w[3]);
            prop_assert!((p.x() - w[4]).abs() < 1e-9, "x {} {}", p.x(), w[4]);
            prop_assert!((p.y() - w[5]).abs() < 1e-9, "y {} {}", p.y(), w[5]);
        }
    }

    /// The same of a sideslip that grows with the lateral acceleration and leads, as far as tyres carry, and
    /// that is `b/v − κ·v` from 1 m/s on.
    #[test]
    fn pose_with_growth_and_lead(
        steps in prop::collection::vec((0.001..0.2_f64, -0.1..0.1_f64, -0.3..0.3_f64, 0.0..15.0_f64), 1..8),
        d in prop_oneof![Just(0.0), -0.5..0.5_f64],
        (growth, lead) in prop_oneof![
            (Just(0.0), -0.01..0.01_f64), (-0.002..0.002_f64, Just(0.0)), (-0.002..0.002_f64, -0.01..0.01_f64)
        ],
        (distance_rear, kappa) in prop_oneof![Just((0.0, 0.0)), (0.5..2.0_f64, 0.0..0.008_f64)],
    ) {
        let reference_speed = 8.0;
        let over_speed = distance_rear != 0.0;
        let s = |v: f64| if over_speed { distance_rear / v - kappa * v } else { -0.06 };
        let data = IdentifiedData {
            d,
            sideslip: Sideslip {
                per_yaw_rate: s(reference_speed),
                growth,
                per_yaw_acceleration: lead,
                reference_speed,
                distance_rear,
            },
            ..car()
        };
        let mut p = plant(&data);
        let c = data.continuous.clone().unwrap();
        let mut w = [0.0; 7];
        let largest = std::cell::Cell::new(0.0_f64);
        for (h, steering, slope, speed) in steps {
            (p.steering_angle, p.steering_rate, p.speed) = (steering, slope, speed);
            p.step(h).unwrap();
            let v = f64::max(speed, 1.0);
            let share = if over_speed { v / reference_speed } else { 1.0 };
            let grown = if lead == 0.0 { 0.0 } else { kappa.powi(2) * (v * v - 64.0) };
            let (s, growth, lead) = (s(v), growth * share, lead + grown);
            // Derivatives of the model's states, yaw rate and sideslip.
            let moving = |w: &[f64; 7]| {
                let moved: Vec<f64> = (0..3)
                    .map(|i| (0..3).map(|j| c.f[3 * i + j] * w[j]).sum::<f64>() + c.g[i] * w[6])
                    .collect();
                let by = |v: &[f64]| c.h.iter().zip(v).map(|(h, x)| h * x).sum::<f64>();
                let rate = by(&w[..3]) + d * w[6] + 0.02;
                largest.set(largest.get().max((speed * rate).abs()));
                let steady = s + growth * (speed * rate).powi(2);
                let slip = steady * rate + lead * (by(&moved) + d * slope);
                (moved, rate, slip)
            };
            w[6] = steering - 0.01;
            w = runge_kutta(w, h, 1 + (h / 5e-5) as usize, |w| {
                let (moved, rate, slip) = moving(w);
                let (sin, cos) = w[3].sin_cos();
                let (x, y) = (speed * (cos - slip * sin), speed * (sin + slip * cos));
                [moved[0], moved[1], moved[2], rate, x, y, slope]
            });
            prop_assume!(largest.get() < 9.8);
            prop_assert!((p.x() - w[4]).hypot(p.y() - w[5]) < 1e-9, "{} {} {w:?}", p.x(), p.y());
            // The velocity that it reports, as if it went on along this ramp.
            (p.steering_angle, p.steering_rate) = (w[6] + 0.01, slope);
            let (_, _, slip) = moving(&w);
            let (sin, cos) = w[3].sin_cos();
            let (x, y) = (speed * (cos - slip * sin), speed * (sin + slip * cos));
            prop_assert!((p.state_rate(4) - x).hypot(p.state_rate(5) - y) < 1e-8, "{slip}");
        }
    }

    /// The bicycle under a ramp or a held input: one step, 100 pieces, and from 1 m/s on one exponential.
    #[test]
    fn bicycle_ramp(
        steps in hundred_steps(),
        v in prop_oneof![0.0..1.0_f64, 1.0..50.0_f64],
        u0 in -0.3..0.3_f64,
        slope in prop_oneof![1 => Just(0.0), 3 => -0.5..0.5_f64],
        initial in prop::array::uniform3(-0.1..0.1_f64),
    ) {
        let parameters = BicycleParameters::default();
        let mut one = BicyclePlant::new(parameters).unwrap();
        (one.speed, one.initial_states) = (v, initial);
        one.start().unwrap();
        let mut many = one.clone();
        let total: f64 = steps.iter().sum();
        (one.steering_angle, one.steering_rate) = (u0, slope);
        one.step(total).unwrap();
        many.steering_rate = slope;
        let mut time = 0.0;
        for &h in &steps {
            many.steering_angle = u0 + slope * time;
            many.step(h).unwrap();
            time += h;
        }
        let states = |p: &BicyclePlant| [p.lateral_velocity(), p.yaw_rate(), p.road_wheel_angle()];
        let expected = if v < 1.0 {
            states(&one).to_vec()
        } else {
            let (f, g) = bicycle_body_frame(&parameters, v);
            ramped(f.transpose().as_slice(), g.as_slice(), &initial, (u0, slope), total)
        };
        for plant in [&one, &many] {
            assert_close(&states(plant), &expected, 1e-12)?;
        }
        prop_assert!((one.yaw() - many.yaw()).abs() < 1e-11 * (1.0 + one.yaw().abs()));
        prop_assert!((one.x() - many.x()).hypot(one.y() - many.y()) < 1e-9);
    }

    /// The bicycle's position under a ramp, against Runge–Kutta.
    #[test]
    fn bicycle_pose_under_a_ramp(
        h in 0.001..0.5_f64, v in 1.0..40.0_f64, (u0, slope) in (-0.3..0.3_f64, -2.0..2.0_f64),
    ) {
        let parameters = BicycleParameters::default();
        let mut p = BicyclePlant::new(parameters).unwrap();
        (p.speed, p.steering_angle, p.steering_rate) = (v, u0, slope);
        p.step(h).unwrap();
        let (f, g) = bicycle_body_frame(&parameters, v);
        let w = runge_kutta([0.0, 0.0, 0.0, 0.0, 0.0, 0.0, u0], h, 1 + (h / 2e-5) as usize, |w| {
            let row = |i: usize| (0..3).map(|j| f[(i, j)] * w[j]).sum::<f64>() + g[i] * w[6];
            let (sin, cos) = w[3].sin_cos();
            [row(0), row(1), row(2), w[1], v * cos - w[0] * sin, v * sin + w[0] * cos, slope]
        });
        prop_assert!((p.yaw() - w[3]).abs() < 1e-10);
        prop_assert!((p.x() - w[4]).hypot(p.y() - w[5]) < 1e-9, "{} {}", p.x() - w[4], p.y() - w[5]);
    }
}

/// Long steps: 1, 10 and 100 panels, to 1e-9 m against panels of a tenth of a millisecond.
#[test]
fn position_of_long_steps() {
    for h in [0.01, 0.1, 1.0, 7.3] {
        let (mut coarse, mut fine) = (plant(&car()), plant(&car()));
        coarse.steering_angle = 0.4;
        fine.steering_angle = 0.4;
        coarse.step(h).unwrap();
        let count = (h / 1e-4_f64).round() as u32;
        for _ in 0..count {
            fine.step(h / f64::from(count)).unwrap();
        }
        let away = (coarse.x() - fine.x()).hypot(coarse.y() - fine.y());
        assert!(away < 1e-9, "{h}: {away:e}");
    }
}

/// The ramp ends with the step: after it the angle is what was set, and so is the feedthrough.
#[test]
fn ramp_ends_with_its_step() {
    let mut p = plant(&from_continuous(vec![-3.0], vec![0.0], vec![1.0], 1.0, 0.01));
    (p.steering_angle, p.steering_rate) = (0.01, 2.0);
    p.step(0.1).unwrap();
    p.steering_rate = 0.0;
    // D = 1 and no dynamics: yaw is the integral of the ramp, the yaw rate that of its beginning.
    assert!((p.yaw() - (0.02 * 0.1 + 0.5 * 2.0 * 0.01)).abs() < 1e-14);
    assert!((p.yaw_rate() - 0.02).abs() < 1e-15);
    p.step(0.1).unwrap();
    assert!((p.yaw() - (0.02 * 0.2 + 0.5 * 2.0 * 0.01)).abs() < 1e-14);
}

/// A ramp from rest, where the first term of the bicycle's series is zero.
#[test]
fn bicycle_ramp_from_rest() {
    let parameters = BicycleParameters::default();
    let mut p = BicyclePlant::new(parameters).unwrap();
    p.steering_rate = 0.5;
    p.step(0.008).unwrap();
    let (f, g) = bicycle_body_frame(&parameters, p.speed);
    let expected = ramped(f.transpose().as_slice(), g.as_slice(), &[0.0; 3], (0.0, 0.5), 0.008);
    let states = [p.lateral_velocity(), p.yaw_rate(), p.road_wheel_angle()];
    assert_close(&states, &expected, 1e-13).unwrap();
}

/// Without continuous form a ramp is sampled on the grid.
#[test]
fn ramp_on_the_grid() {
    let data = IdentifiedData {
        a: vec![0.0],
        b: vec![1.0],
        c: vec![1.0],
        k: vec![0.0],
        continuous: None,
        sample_time: 0.1,
        steering_offset: 0.0,
        yaw_rate_offset: 0.0,
        ..car()
    };
    for (delay, expected) in [(0.0, 0.2), (0.1, 0.1), (0.05, 0.15)] {
        let mut p = plant(&IdentifiedData { delay, ..data.clone() });
        p.steering_rate = 1.0;
        // The output at 0.3 is the input at 0.2, less the delay.
        p.step(0.3).unwrap();
        assert!((p.yaw_rate() - expected).abs() < 1e-12, "{delay}: {}", p.yaw_rate());
    }
}
