//! The identified plant against independent references.
#![allow(clippy::unwrap_used)]

use crate::common;

use common::{car, from_continuous, runge_kutta, sample, taylor_exponential};
use nalgebra::DMatrix;
use proptest::prelude::*;
use std::sync::Arc;
use steerwright_formats::InputKind;
use steerwright_models::linear::{discretize, exponential};
use steerwright_models::noise::gaussian;
use steerwright_models::{Error, IdentifiedData, IdentifiedModel, IdentifiedPlant};

fn plant(data: IdentifiedData) -> IdentifiedPlant {
    IdentifiedPlant::new(Arc::new(IdentifiedModel::new(data).unwrap()))
}

proptest! {
    #[test]
    fn exponential_agrees_with_a_long_series(
        entries in prop::collection::vec(-1.0..1.0_f64, 25), scale in 0.01..20.0_f64,
    ) {
        let a = DMatrix::from_row_slice(5, 5, &entries) * scale;
        let (ours, reference) = (exponential(&a), taylor_exponential(&a));
        let error = (&ours - &reference).amax() / reference.amax();
        prop_assert!(error < 1e-13 * (1.0 + scale), "{error:e}");
    }

    /// Yaw and position when the inputs change with the steps, against Runge–Kutta.
    #[test]
    fn pose_is_exact(
        steps in prop::collection::vec((0.001..0.2_f64, -0.5..0.5_f64, 0.0..50.0_f64), 1..12),
        d in prop_oneof![Just(0.0), -0.5..0.5_f64],
        product in any::<bool>(),
    ) {
        let mut data = IdentifiedData { d, ..car() };
        if product {
            data.input = InputKind::SteeringTimesSpeed;
            data.c.iter_mut().for_each(|c| *c /= 30.0);
            data.continuous.as_mut().unwrap().h.clone_from(&data.c);
            data.d /= 30.0;
        }
        let mut p = plant(data.clone());
        (p.initial_x, p.initial_y, p.initial_yaw) = (3.0, -4.0, 2.5);
        p.start();
        let c = data.continuous.clone().unwrap();
        let mut w = [0.0, 0.0, 0.0, 2.5, 3.0, -4.0];
        for (h, steering, speed) in steps {
            p.steering_angle = steering;
            p.speed = speed;
            p.step(h).unwrap();
            let u = (steering - 0.01) * if product { speed } else { 1.0 };
            let rate = |w: &[f64; 6]| {
                c.h.iter().zip(w).map(|(h, x)| h * x).sum::<f64>() + data.d * u + 0.02
            };
            w = runge_kutta(w, h, 1 + (h / 5e-5) as usize, |w| {
                let row = |i: usize| (0..3).map(|j| c.f[3 * i + j] * w[j]).sum::<f64>() + c.g[i] * u;
                let (s, co) = w[3].sin_cos();
                let (r, slip) = (rate(w), data.sideslip.per_yaw_rate * rate(w));
                [row(0), row(1), row(2), r, speed * (co - slip * s), speed * (s + slip * co)]
            });
            prop_assert!((p.yaw() - w[3]).abs() < 1e-11, "yaw {} {}", p.yaw(), w[3]);
            prop_assert!((p.x() - w[4]).abs() < 1e-9, "x {} {}", p.x(), w[4]);
            prop_assert!((p.y() - w[5]).abs() < 1e-9, "y {} {}", p.y(), w[5]);
            prop_assert!((p.yaw_rate() - rate(&w)).abs() < 1e-11);
        }
    }

    /// The delayed plant is the undelayed one, later.
    #[test]
    fn delay_is_a_shift(
        steps in prop::collection::vec((0.001..0.05_f64, -0.3..0.3_f64), 1..40),
        delay in 0.0001..0.4_f64,
    ) {
        let still = IdentifiedData { yaw_rate_offset: 0.0, ..car() };
        let mut late = plant(IdentifiedData { delay, ..still.clone() });
        let mut now = plant(still);
        for &(h, u) in &steps {
            (late.steering_angle, now.steering_angle) = (u, u);
            late.step(h).unwrap();
            now.step(h).unwrap();
        }
        // Whatever comes in from here on is still under way.
        late.steering_angle = 0.7;
        late.step(delay).unwrap();
        let scale = now.states().iter().fold(0.0_f64, |m, x| m.max(x.abs()));
        for (a, b) in late.states().iter().zip(now.states()) {
            prop_assert!((a - b).abs() < 1e-10 * scale.max(0.1), "{a} {b}");
        }
        prop_assert!((late.yaw() - now.yaw()).abs() < 1e-11);
        // The vehicle drove straight on for the time of the delay.
        prop_assert!((late.x() - now.x() - 15.0 * delay).abs() < 1e-9);
        prop_assert!((late.y() - now.y()).abs() < 1e-9);
    }
}

#[test]
fn discretization_is_eq_9_and_10() {
    let c = car().continuous.unwrap();
    let (f, g) = (DMatrix::from_row_slice(3, 3, &c.f), DMatrix::from_row_slice(3, 1, &c.g));
    for step in [1e-6, 0.01, 0.1, 3.0] {
        let (a, b) = discretize(&f, &g, step).unwrap();
        let (ra, rb) = sample(&f, &g, step);
        assert!((a - ra).amax() < 1e-13 && (b - rb).amax() < 1e-13);
    }
    assert!(discretize(&f, &g, 0.0).is_err());
    assert!(discretize(&f, &DMatrix::zeros(2, 1), 0.1).is_err());
}

/// A sample of the continuous plant is the discrete model: eq 3 at every sample.
#[test]
fn samples_are_the_discrete_model() {
    let data = IdentifiedData { steering_offset: 0.0, ..car() };
    let mut p = plant(data.clone());
    let mut x = [0.0; 3];
    for k in 0..400 {
        p.steering_angle = 0.1 * (f64::from(k) * 0.3).sin();
        p.step(data.sample_time).unwrap();
        x = eq3(&data, x, p.steering_angle, 0.0);
        for (ours, x) in p.states().iter().zip(x) {
            assert!((ours - x).abs() < 1e-13);
        }
    }
}

/// `A x + B u + K e`.
fn eq3(data: &IdentifiedData, x: [f64; 3], u: f64, e: f64) -> [f64; 3] {
    std::array::from_fn(|i| {
        (0..3).map(|j| data.a[3 * i + j] * x[j]).sum::<f64>() + data.b[i] * u + data.k[i] * e
    })
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// With noise, eq 3–4 hold at every grid point, whatever the importer's step.
#[test]
fn noise_is_eq_3_and_4_for_every_step() {
    for discrete_only in [false, true] {
        let mut data = IdentifiedData { steering_offset: 0.0, ..car() };
        if discrete_only {
            data.continuous = None;
        }
        let ts = data.sample_time;
        for per_five in [15, 5, 2] {
            // h = Ts/3, Ts, 2.5 Ts.
            let h = ts * 5.0 / f64::from(per_five);
            let mut p = plant(data.clone());
            (p.noise_scale, p.noise_seed, p.steering_angle) = (0.5, 42, 0.2);
            p.start();
            let mut x = [0.0; 3];
            let mut grid = 0;
            for step in 1..=600 {
                // Grid points in time so far; their values can be seen where a step ends on one.
                p.step(h).unwrap();
                let points = step * 5 / per_five;
                while grid < points {
                    let e = 0.5 * data.innovation_std * gaussian(42, grid as u64);
                    x = eq3(&data, x, 0.2, e);
                    grid += 1;
                }
                if step * 5 % per_five == 0 {
                    let e = 0.5 * data.innovation_std * gaussian(42, grid as u64);
                    let y = dot(&data.c, &x) + 0.02 + e;
                    assert!((p.yaw_rate() - y).abs() < 1e-11, "{per_five} step {step}");
                }
            }
        }
    }
}

#[test]
fn noise_is_as_strong_as_identified_and_stays_out_of_yaw() {
    // A static model: the output is the innovation alone.
    let mut data = from_continuous(vec![-3.0], vec![1.0], vec![1.0], 0.0, 0.01);
    data.k = vec![0.0];
    (data.yaw_rate_offset, data.steering_offset) = (0.0, 0.0);
    let mut p = plant(data);
    (p.noise_scale, p.noise_seed) = (1.0, 7);
    p.start();
    let n = 100_000;
    let (mut sum, mut square) = (0.0, 0.0);
    for _ in 0..n {
        let e = p.yaw_rate();
        sum += e;
        square += e * e;
        p.step(0.01).unwrap();
    }
    let variance = square / f64::from(n);
    assert!((variance / 1e-4 - 1.0).abs() < 5.0 * (2.0 / f64::from(n)).sqrt(), "{variance}");
    assert!((sum / f64::from(n)).abs() < 5.0 * 0.01 / f64::from(n).sqrt());
    assert_eq!(p.yaw(), 0.0);
}

#[test]
fn noise_of_nothing_costs_nothing_and_a_clone_repeats() {
    let mut quiet = plant(car());
    quiet.noise_seed = 3;
    quiet.start();
    let mut other = plant(car());
    for _ in 0..100 {
        quiet.step(0.013).unwrap();
        other.step(0.013).unwrap();
    }
    assert_eq!((quiet.x(), quiet.yaw_rate()), (other.x(), other.yaw_rate()));

    let mut p = plant(car());
    p.noise_scale = 1.0;
    p.start();
    p.step(0.05).unwrap();
    let mut saved = p.clone();
    for _ in 0..100 {
        p.step(0.007).unwrap();
        saved.step(0.007).unwrap();
        assert_eq!((p.x(), p.y(), p.yaw_rate()), (saved.x(), saved.y(), saved.yaw_rate()));
    }
}

/// A has a negative real pole, so no real logarithm: stepped on its grid and held between.
#[test]
fn without_continuous_form_it_holds() {
    let data = IdentifiedData {
        a: vec![-0.5],
        b: vec![1.0],
        c: vec![1.0],
        k: vec![0.0],
        continuous: None,
        sample_time: 0.1,
        steering_offset: 0.0,
        yaw_rate_offset: 0.0,
        ..car()
    };
    let mut p = plant(data);
    p.steering_angle = 0.2;
    // x: 0, 0.2, 0.1, 0.15 on the grid.
    let mut seen = vec![p.yaw_rate()];
    for _ in 0..12 {
        p.step(0.025).unwrap();
        seen.push(p.yaw_rate());
    }
    let expected = [0.0, 0.0, 0.0, 0.0, 0.2, 0.2, 0.2, 0.2, 0.1, 0.1, 0.1, 0.1, 0.2 - 0.5 * 0.1];
    for (s, e) in seen.iter().zip(expected) {
        assert!((s - e).abs() < 1e-15, "{seen:?}");
    }
    assert!((p.yaw() - 0.1 * (0.0 + 0.2 + 0.1)).abs() < 1e-15);
    // One long step does the same as the twelve.
    let mut q = p.clone();
    q.start();
    q.step(0.3).unwrap();
    assert!((q.yaw() - p.yaw()).abs() < 1e-15 && (q.y() - p.y()).abs() < 1e-12);
}

#[test]
fn feedthrough_answers_at_once() {
    let mut p = plant(IdentifiedData { d: 0.5, steering_offset: 0.0, ..car() });
    let before = p.yaw_rate();
    p.steering_angle = 0.2;
    assert!((p.yaw_rate() - before - 0.1).abs() < 1e-15);
}

#[test]
fn warns_of_a_foreign_speed_and_refuses_bad_steps() {
    let mut p = plant(car());
    for (speed, far) in [(15.0, false), (12.1, false), (17.9, false), (11.9, true), (18.1, true)] {
        p.speed = speed;
        assert_eq!(p.speed_far_from_identified(), far, "{speed}");
    }
    for h in [0.0, -0.01, f64::NAN, f64::INFINITY, 1e9] {
        assert!(matches!(p.step(h), Err(Error::Step { .. })));
    }
    // Unstable: an error, not a NaN.
    let mut unstable = plant(from_continuous(vec![40.0], vec![1.0], vec![1.0], 0.0, 0.01));
    unstable.steering_angle = 1.0;
    assert!((0..1000).any(|_| unstable.step(1.0).is_err()));
}
