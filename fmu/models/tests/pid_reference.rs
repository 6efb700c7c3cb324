//! The yaw controller against an independent solution, that of `data/pid_reference.py`, and against
//! cases that are solved on paper.
#![allow(clippy::unwrap_used)]

use nalgebra::DMatrix;
use std::collections::BTreeMap;
use steerwright_formats::PidGains;
use steerwright_models::linear::discretize;
use steerwright_models::{Pid, PidInput, PidParameters};

const FREE: f64 = 1e6;

fn parameters() -> PidParameters {
    PidParameters {
        gains: PidGains {
            kp: 1.1,
            ki: 0.9,
            kd: 0.06,
            derivative_filter_time_s: 0.03,
            setpoint_weight_proportional: 0.7,
            setpoint_weight_derivative: 0.0,
            anti_windup_time_s: 0.25,
        },
        max_angle: FREE,
        max_increment: FREE,
        max_rate: FREE,
        sample_time: 0.02,
        ..PidParameters::default()
    }
}

fn input(yaw_reference: f64, yaw: f64) -> PidInput {
    PidInput { yaw_reference, yaw, steering_feedforward: 0.0, enabled: true, speed: 0.0 }
}

/// A step, a disturbance and a step back: the linear loop, and each of the three limits acting.
#[test]
fn closed_loops_are_those_of_scipy() {
    let mut lines = include_str!("data/pid_reference.csv").lines();
    let header: Vec<&str> = lines.next().unwrap().split(',').collect();
    let mut columns: BTreeMap<&str, Vec<f64>> = BTreeMap::new();
    for line in lines {
        for (name, field) in header.iter().zip(line.split(',')) {
            columns.entry(name).or_default().push(field.parse().unwrap());
        }
    }
    let f = DMatrix::from_row_slice(2, 2, &[-10.0, 0.0, 1.0, 0.0]);
    let (a, b) = discretize(&f, &DMatrix::from_row_slice(2, 1, &[40.0, 0.0]), 0.02).unwrap();
    for (case, p, limit) in [
        ("linear", parameters(), None),
        ("angle", PidParameters { max_angle: 0.12, ..parameters() }, Some(0.12)),
        ("increment", PidParameters { max_increment: 0.015, ..parameters() }, Some(0.015)),
        ("rate", PidParameters { max_rate: 0.5, ..parameters() }, Some(0.01)),
    ] {
        let yaw = &columns[format!("{case}_yaw").as_str()];
        let steering = &columns[format!("{case}_steering").as_str()];
        assert_eq!(yaw.len(), 300);
        let mut pid = Pid::default();
        pid.tick(&p, &input(0.0, 0.0));
        let mut z: DMatrix<f64> = DMatrix::zeros(2, 1);
        let mut saturated = 0;
        for k in 0..300 {
            let r = if k < 150 { 0.5 } else { -0.2 };
            assert!(
                (z[(1, 0)] - yaw[k]).abs() < 1e-9,
                "{case}, tick {k}: {} {}",
                z[(1, 0)],
                yaw[k]
            );
            let out = pid.tick(&p, &input(r, z[(1, 0)]));
            assert!((out.steering_angle - steering[k]).abs() < 1e-8, "{case}, tick {k}");
            saturated += usize::from(out.saturated);
            let disturbance = if k < 75 { 0.0 } else { -0.02 };
            z = &a * z + &b * (out.steering_angle + disturbance);
        }
        assert_eq!(saturated > 5, limit.is_some(), "{case}: {saturated}");
    }
}

/// Held at the angle limit with a constant error, each tick takes `Ts/Tt` of the excess off the
/// integral and `ki·Ts·e` on: the excess v − u_max tends to `ki·e·Tt` geometrically with 1 − Ts/Tt.
/// When the error vanishes, v jumps by −(kp + ki·Ts)·e, and below the limit nothing is left of it.
#[test]
fn anti_windup_forgets_geometrically() {
    let p = PidParameters {
        gains: PidGains { kd: 0.0, setpoint_weight_proportional: 1.0, ..parameters().gains },
        max_angle: 0.1,
        ..parameters()
    };
    let (e, share) = (1.0, p.sample_time / p.gains.anti_windup_time_s);
    let mut pid = Pid::default();
    let mut integral = 0.0;
    for k in 0..60 {
        assert_eq!(pid.tick(&p, &input(e, 0.0)).steering_angle, 0.1);
        // On paper: I(k) = I* + (I(0) − I*)·(1 − Ts/Tt)^k.
        let rest = 0.1 - p.gains.kp * e + (1.0 / share - 1.0) * p.gains.ki * p.sample_time * e;
        let first = p.gains.ki * p.sample_time * e
            + share * (0.1 - p.gains.kp * e - p.gains.ki * p.sample_time * e);
        integral = rest + (first - rest) * (1.0 - share).powi(k);
    }
    let out = pid.tick(&p, &input(0.0, 0.0));
    // The step of the reference back is seen whole by a weight of 1; the error is 0.
    assert!(integral < -0.1, "the integral must have been driven below the limit: {integral}");
    assert_eq!((out.steering_angle, out.saturated), (-0.1, true));
    // From there it comes back to the limit as 0.1 + (|I| − 0.1)·(1 − share)^k, without overshoot.
    let mut excess = (integral.abs() - 0.1) * (1.0 - share);
    for k in 0..40 {
        // An error that brings the unlimited output to the very edge measures the integral.
        let probe = (excess - 1e-9) / (p.gains.kp + p.gains.ki * p.sample_time);
        assert!(pid.clone().tick(&p, &input(probe, 0.0)).saturated, "tick {k}");
        let probe = (excess + 1e-9) / (p.gains.kp + p.gains.ki * p.sample_time);
        assert!(!pid.clone().tick(&p, &input(probe, 0.0)).saturated, "tick {k}");
        pid.tick(&p, &input(0.0, 0.0));
        excess *= 1.0 - share;
    }
}

/// Enabled from a held angle at a constant error the output goes on from there with the integral
/// alone: u(k) = u(0) + k·ki·Ts·e. Disabled it is the feedforward at once.
#[test]
fn switching_is_bumpless_on_paper() {
    let p = parameters();
    let mut pid = Pid::default();
    let at = |enabled| PidInput {
        yaw_reference: 0.3,
        yaw: 0.1,
        steering_feedforward: 0.05,
        enabled,
        speed: 0.0,
    };
    for _ in 0..10 {
        assert_eq!(pid.tick(&p, &at(false)).steering_angle, 0.05);
    }
    for k in 0..50 {
        let expected = 0.05 + f64::from(k) * p.gains.ki * p.sample_time * 0.2;
        let out = pid.tick(&p, &at(true));
        assert!((out.steering_angle - expected).abs() < 1e-12, "tick {k}: {out:?} {expected}");
    }
    // A change of kp and kd at a constant error does not show; ki changes the slope from there on.
    let before = pid.clone().tick(&p, &at(true)).steering_angle;
    let changed = PidParameters { gains: PidGains { kp: 3.0, kd: 0.5, ..p.gains }, ..p };
    assert!((pid.tick(&changed, &at(true)).steering_angle - before).abs() < 1e-12);
    let steeper =
        PidParameters { gains: PidGains { ki: 2.0 * p.gains.ki, ..changed.gains }, ..changed };
    let next = pid.tick(&steeper, &at(true)).steering_angle;
    assert!((next - before - 2.0 * p.gains.ki * p.sample_time * 0.2).abs() < 1e-12);
    assert_eq!(pid.tick(&steeper, &at(false)).steering_angle, 0.05);
}
