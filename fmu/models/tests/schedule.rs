//! Parameters over speed: interpolation, and a controller whose speed changes.

use crate::common::guided;
use steerwright_formats::{Guidance, LargeErrors, PidGains};
use steerwright_models::{
    GuidanceParameters, GuidanceSchedule, Pid, PidInput, PidParameters, PidSchedule,
};

/// Gains of a fast car in the file, and of three speeds.
fn slow() -> PidParameters {
    PidParameters {
        gains: PidGains {
            kp: 6.0,
            ki: 17.0,
            kd: 0.22,
            derivative_filter_time_s: 0.02,
            setpoint_weight_proportional: 0.6,
            ..PidParameters::default().gains
        },
        max_angle: 10.0,
        max_increment: 1.0,
        max_rate: 100.0,
        large_errors: LargeErrors {
            yaw_rate_lag_s: 0.1,
            rate_reserve_time_s: 0.4,
            ..PidParameters::default().large_errors
        },
        ..PidParameters::default()
    }
}

fn fast() -> PidParameters {
    PidParameters {
        gains: PidGains {
            kp: 0.9,
            ki: 1.9,
            kd: 0.07,
            derivative_filter_time_s: 0.05,
            setpoint_weight_proportional: 0.4,
            anti_windup_time_s: 0.5,
            ..slow().gains
        },
        large_errors: LargeErrors {
            yaw_rate_lag_s: 0.3,
            rate_reserve_time_s: 0.2,
            ..slow().large_errors
        },
        ..slow()
    }
}

fn schedule() -> PidSchedule {
    PidSchedule::new(slow(), vec![(30.0, fast()), (5.0, slow())])
}

#[test]
fn entries_hold_at_their_speeds_and_beyond_the_ends() {
    let table = schedule();
    for (speed, expected) in [(0.0, slow()), (5.0, slow()), (30.0, fast()), (80.0, fast())] {
        assert_eq!(table.parameters_at(&slow(), speed), expected, "{speed}");
    }
    assert_eq!(table.parameters_at(&slow(), f64::NAN), slow());
    let middle = table.parameters_at(&slow(), 17.5);
    assert!((middle.gains.kp - 3.45).abs() < 1e-12 && (middle.gains.ki - 9.45).abs() < 1e-12);
    assert!((middle.large_errors.rate_reserve_time_s - 0.3).abs() < 1e-12);
    assert!((middle.large_errors.yaw_rate_lag_s - 0.2).abs() < 1e-12);
    assert_eq!(middle.max_angle, slow().max_angle);
}

#[test]
fn a_parameter_that_was_set_holds_at_every_speed() {
    let set =
        PidParameters { gains: PidGains { kp: 2.0, ..slow().gains }, max_angle: 0.1, ..slow() };
    let now = schedule().parameters_at(&set, 30.0);
    assert_eq!(
        now,
        PidParameters { gains: PidGains { kp: 2.0, ..fast().gains }, max_angle: 0.1, ..fast() }
    );
    let entries = vec![(10.0, GuidanceParameters::default())];
    let preview = Guidance { preview_time_s: 0.3, ..Guidance::default() };
    let start = guided(Guidance { feedforward_gain_radm: 2.0, ..Guidance::default() });
    let table = GuidanceSchedule::new(start, entries);
    let set = guided(Guidance { feedforward_gain_radm: 2.0, ..preview });
    assert_eq!(table.parameters_at(&set, 7.0), guided(preview));
}

#[test]
fn without_entries_nothing_changes() {
    assert_eq!(PidSchedule::new(slow(), vec![]).parameters_at(&fast(), 12.0), fast());
}

fn at(speed: f64, error: f64, yaw: f64) -> PidInput {
    PidInput { yaw_reference: yaw + error, yaw, speed, enabled: true, ..PidInput::default() }
}

/// With a constant error and a constant yaw rate the output moves on by the integral action alone, whether the
/// speed jumps or ramps, and does not jump with the gains.
#[test]
fn the_output_does_not_jump_with_the_speed() {
    const ERROR: f64 = 0.05;
    const YAW_INCREMENT: f64 = 1e-4;
    let table = schedule();
    let step = |k: i32| if k < 200 { 5.0 } else { 30.0 };
    let back = |k: i32| if k < 200 { 30.0 } else { 5.0 };
    let ramp = |k: i32| (5.0 + 0.03 * f64::from((k - 200).max(0))).min(30.0);
    for speed in [&step as &dyn Fn(i32) -> f64, &back, &ramp] {
        let mut pid = Pid::default();
        let mut before: Option<f64> = None;
        for k in 0..1200 {
            let p = table.parameters_at(&slow(), speed(k));
            let input = at(speed(k), ERROR, YAW_INCREMENT * f64::from(k));
            let now = pid.tick(&p, &input).steering_angle;
            if let Some(before) = before.filter(|_| k >= 200) {
                // The integral action, the weight on the reference's increment, and the derivative on its way
                // from one gain to the other, which the filter spreads.
                let weight =
                    p.gains.kp * (1.0 - p.gains.setpoint_weight_proportional) * YAW_INCREMENT;
                let rate = YAW_INCREMENT / p.sample_time;
                let filter = p.sample_time / (p.gains.derivative_filter_time_s + p.sample_time);
                let derivative = (slow().gains.kd - fast().gains.kd) * rate * filter;
                let allowed = p.gains.ki * p.sample_time * ERROR + weight + derivative;
                assert!((now - before).abs() <= allowed + 1e-12, "{k}: {before} {now}");
                // Far less than the proportional action would jump by.
                assert!(
                    (now - before).abs() < 0.06 * (slow().gains.kp - fast().gains.kp) * ERROR,
                    "{k}"
                );
            }
            before = Some(now);
        }
    }
}
