//! The PID against the textbook's positional form, and its properties.

use proptest::prelude::*;
use std::f64::consts::PI;
use steerwright_formats::{LargeErrors, LateralAcceleration, PidGains};
use steerwright_models::{Pid, PidInput, PidParameters};

const UNLIMITED: f64 = 1e9;

fn linear(kp: f64, ki: f64, kd: f64, tf: f64, b: f64, c: f64) -> PidParameters {
    PidParameters {
        gains: PidGains {
            kp,
            ki,
            kd,
            derivative_filter_time_s: tf,
            setpoint_weight_proportional: b,
            setpoint_weight_derivative: c,
            ..PidParameters::default().gains
        },
        max_angle: UNLIMITED,
        max_increment: UNLIMITED,
        max_rate: UNLIMITED,
        ..PidParameters::default()
    }
}

fn full() -> PidParameters {
    PidParameters {
        gains: PidGains {
            ki: 2.0,
            kd: 0.1,
            derivative_filter_time_s: 0.03,
            setpoint_weight_proportional: 0.6,
            setpoint_weight_derivative: 0.2,
            anti_windup_time_s: 0.2,
            ..PidParameters::default().gains
        },
        ..PidParameters::default()
    }
}

fn input(yaw_reference: f64, yaw: f64) -> PidInput {
    PidInput { yaw_reference, yaw, steering_feedforward: 0.0, enabled: true, speed: 0.0 }
}

/// Bounded, smooth signals: a reference and a yaw that stay within half a turn of each other.
fn signals(k: usize) -> (f64, f64) {
    let t = k as f64 * 0.01;
    (0.5 * t + 0.3 * (1.7 * t).sin(), 0.5 * t + 0.2 * (2.9 * t + 1.0).cos())
}

proptest! {
    /// `u = kp·(b·r − y) + ki·Ts·Σe + D(c·r − y)`, angles counted from the first yaw, with the
    /// filtered derivative as a convolution sum: no recursion shared with the code under test.
    #[test]
    fn is_the_textbook_positional_form(
        kp in 0.1..5.0_f64, ki in 0.0..3.0_f64, kd in 0.0..1.0_f64, tf in prop_oneof![Just(0.0), 0.0..0.2_f64],
        b in 0.0..1.0_f64, c in 0.0..1.0_f64,
    ) {
        let p = linear(kp, ki, kd, tf, b, c);
        let ts = p.sample_time;
        let mut pid = Pid::default();
        let yaw0 = signals(0).1;
        for n in 0..300_usize {
            let (r, y) = signals(n);
            let output = pid.tick(&p, &input(r, y));
            let (r0, y0) = (r - yaw0, y - yaw0);
            let sum: f64 = (0..=n).map(|k| { let (r, y) = signals(k); r - y }).sum();
            let decay: f64 = tf / (tf + ts);
            let derivative: f64 = (1..=n).map(|k| {
                let ((r1, y1), (r2, y2)) = (signals(k - 1), signals(k));
                kd / (tf + ts) * decay.powi((n - k) as i32) * (c * (r2 - r1) - (y2 - y1))
            }).sum();
            let expected = kp * (b * r0 - y0) + ki * ts * sum + derivative;
            prop_assert!((output.steering_angle - expected).abs() < 1e-11, "tick {n}: {} {expected}", output.steering_angle);
            prop_assert!(!output.saturated);
        }
    }

    /// Where north is does not matter, and whole turns of either signal do not.
    #[test]
    fn is_invariant_to_rotation(turn in -20.0..20.0_f64, wraps in -3..3_i32) {
        let p = full();
        let (mut here, mut there) = (Pid::default(), Pid::default());
        for k in 0..500 {
            let (r, y) = signals(k);
            let a = here.tick(&p, &input(r, y)).steering_angle;
            let b = there.tick(&p, &input(r + turn, y + turn + f64::from(wraps) * 2.0 * PI)).steering_angle;
            prop_assert!((a - b).abs() < 1e-9, "tick {k}: {a} {b}");
        }
    }

    /// Wrapped signals are followed across the jump from π to −π.
    #[test]
    fn takes_wrapped_signals(turn in -4.0..4.0_f64) {
        let p = full();
        let (mut plain, mut wrapped) = (Pid::default(), Pid::default());
        for k in 0..1000 {
            let (r, y) = signals(k);
            let a = plain.tick(&p, &input(r, y)).steering_angle;
            let w = steerwright_models::wrap_angle;
            let b = wrapped.tick(&p, &input(w(r + turn), w(y + turn))).steering_angle;
            prop_assert!((a - b).abs() < 1e-9, "tick {k}: {a} {b}");
        }
    }

    /// No sequence of inputs, gains and switches makes the output leave its limits.
    #[test]
    fn limits_are_never_exceeded(
        ticks in prop::collection::vec((-9.0..9.0_f64, -9.0..9.0_f64, -2.0..2.0_f64, any::<bool>(), 0.0..20.0_f64, 0.0..20.0_f64), 1..200),
        max_angle in 0.01..1.0_f64, max_increment in 0.001..0.5_f64, max_rate in 0.1..50.0_f64,
    ) {
        let mut pid = Pid::default();
        let mut before = 0.0;
        for (r, y, ff, enabled, kp, ki) in ticks {
            let gains = PidGains { kp, ki, ..full().gains };
            let p = PidParameters { gains, max_angle, max_increment, max_rate, ..full() };
            let input = PidInput { yaw_reference: r, yaw: y, steering_feedforward: ff, enabled, speed: 0.0 };
            let u = pid.tick(&p, &input).steering_angle;
            prop_assert!(u.abs() <= max_angle);
            let change = (u - before).abs();
            prop_assert!(change <= max_increment * (1.0 + 1e-9) + 1e-15);
            prop_assert!(change <= max_rate * p.sample_time * (1.0 + 1e-9) + 1e-15);
            before = u;
        }
    }
}

#[test]
fn each_limit_is_reported() {
    let wide = linear(1.0, 0.0, 0.0, 0.0, 1.0, 0.0);
    let saturated = |p: &PidParameters| Pid::default().tick(p, &input(0.2, 0.0)).saturated;
    assert!(!saturated(&wide));
    assert!(saturated(&PidParameters { max_angle: 0.1, ..wide }));
    assert!(saturated(&PidParameters { max_increment: 0.1, ..wide }));
    assert!(saturated(&PidParameters { max_rate: 10.0, ..wide }));
    assert!(!saturated(&PidParameters { max_rate: 20.1, ..wide }));
}

/// Yaw rate proportional to steering: the loop's integral must not carry on after a saturation.
fn overshoot(anti_windup_time: f64) -> f64 {
    let p = PidParameters {
        gains: PidGains {
            kp: 1.5,
            ki: 1.5,
            setpoint_weight_proportional: 1.0,
            anti_windup_time_s: anti_windup_time,
            ..PidParameters::default().gains
        },
        max_angle: 0.1,
        ..PidParameters::default()
    };
    let (mut pid, mut yaw, mut most) = (Pid::default(), 0.0, 0.0_f64);
    for _ in 0..3000 {
        yaw += 0.01 * 2.0 * pid.tick(&p, &input(1.5, yaw)).steering_angle;
        most = most.max(yaw);
    }
    if anti_windup_time < 1.0 {
        assert!((yaw - 1.5).abs() < 1e-3, "{yaw}");
    }
    most - 1.5
}

#[test]
fn anti_windup_recovers() {
    let (with, without) = (overshoot(0.3), overshoot(1e12));
    assert!(with < 0.15, "{with}");
    assert!(without > 3.0 * with, "{without} {with}");
}

/// The saturated output moves back as soon as the unlimited one would, not seconds later.
#[test]
fn leaves_the_limit_when_the_error_turns() {
    let p = PidParameters {
        gains: PidGains { ki: 5.0, anti_windup_time_s: 0.05, ..full().gains },
        max_angle: 0.1,
        ..full()
    };
    let mut pid = Pid::default();
    for _ in 0..1000 {
        assert!(pid.tick(&p, &input(1.0, 0.0)).steering_angle <= 0.1);
    }
    let back = (0..1000).find(|_| pid.tick(&p, &input(-0.05, 0.0)).steering_angle < 0.0);
    assert!(back.is_some_and(|ticks| ticks < 30), "{back:?}");
}

/// Without integral action a saturation leaves nothing behind.
#[test]
fn proportional_control_keeps_no_bias() {
    let p = PidParameters {
        gains: PidGains { kp: 2.0, ..PidParameters::default().gains },
        max_angle: 0.1,
        ..PidParameters::default()
    };
    let mut pid = Pid::default();
    for _ in 0..500 {
        assert!(pid.tick(&p, &input(1.0, 0.0)).saturated);
    }
    for _ in 0..10 {
        pid.tick(&p, &input(0.02, 0.0));
    }
    assert!((pid.tick(&p, &input(0.02, 0.0)).steering_angle - 0.04).abs() < 1e-12);
}

#[test]
fn disabled_is_the_limited_feedforward() {
    let p = full();
    let mut pid = Pid::default();
    let at = |ff: f64| PidInput {
        yaw_reference: 1.0,
        yaw: 0.0,
        steering_feedforward: ff,
        enabled: false,
        speed: 0.0,
    };
    assert_eq!(pid.tick(&p, &at(0.05)).steering_angle, 0.05);
    let output = pid.tick(&p, &at(5.0));
    assert!((output.steering_angle - (0.05 + p.max_increment)).abs() < 1e-15 && output.saturated);
    for _ in 0..5 {
        pid.tick(&p, &at(5.0));
    }
    assert_eq!(pid.tick(&p, &at(5.0)).steering_angle, p.max_angle);
}

#[test]
fn enabling_is_bumpless_and_then_converges() {
    let p = full();
    let mut pid = Pid::default();
    let mut at = |ff: f64, yaw: f64, enabled: bool| {
        pid.tick(
            &p,
            &PidInput { yaw_reference: 0.3, yaw, steering_feedforward: ff, enabled, speed: 0.0 },
        )
        .steering_angle
    };
    for _ in 0..20 {
        at(0.12, 0.1, false);
    }
    let before = at(0.12, 0.1, false);
    let first = at(0.02, 0.1, true);
    assert!((first - before).abs() < 1e-15, "{before} {first}");
    let mut yaw = 0.1;
    let mut last = first;
    for k in 0..3000 {
        let u = at(0.02, yaw, true);
        // It moves on by the integral action, not by a jump.
        assert!((u - last).abs() < 0.01, "tick {k}");
        last = u;
        yaw += 0.01 * 3.0 * u;
    }
    assert!((yaw - 0.3).abs() < 1e-3, "{yaw}");
}

#[test]
fn gain_changes_are_bumpless() {
    let base = PidParameters {
        gains: PidGains { derivative_filter_time_s: 0.0, ..full().gains },
        ..full()
    };
    for change in [
        PidParameters { gains: PidGains { kp: 3.0, ..base.gains }, ..base },
        PidParameters { gains: PidGains { ki: 9.0, ..base.gains }, ..base },
        PidParameters { gains: PidGains { kd: 0.0, ..base.gains }, ..base },
        PidParameters { gains: PidGains { kd: 0.9, ..base.gains }, ..base },
        PidParameters { gains: PidGains { setpoint_weight_derivative: 1.0, ..base.gains }, ..base },
        PidParameters {
            gains: PidGains { setpoint_weight_proportional: 0.0, ..base.gains },
            ..base
        },
        PidParameters { gains: PidGains { anti_windup_time_s: 5.0, ..base.gains }, ..base },
    ] {
        let (mut kept, mut changed) = (Pid::default(), Pid::default());
        // Ramps: constant error, constant increments. Only ki·Ts·e may differ at the change.
        let ramp = |k: i32| input(0.1 + 1e-4 * f64::from(k), 1e-4 * f64::from(k));
        for k in 0..100 {
            kept.tick(&base, &ramp(k));
            changed.tick(&base, &ramp(k));
        }
        let kept = kept.tick(&base, &ramp(100)).steering_angle;
        let now = changed.tick(&change, &ramp(100)).steering_angle;
        let integral = (change.gains.ki - base.gains.ki) * 0.01 * 0.1;
        // And the part of the reference's next increment that the weight keeps out.
        let unweighted =
            |p: &PidParameters| p.gains.kp * (1.0 - p.gains.setpoint_weight_proportional);
        let weights = -(unweighted(&change) - unweighted(&base)) * 1e-4;
        assert!((now - kept - integral - weights).abs() < 1e-12, "{change:?}: {kept} {now}");
    }
}

#[test]
fn prime_only_starts_the_memory() {
    let p = PidParameters {
        gains: PidGains { kp: 1.0, kd: 1.0, ..PidParameters::default().gains },
        ..PidParameters::default()
    };
    let mut pid = Pid::default();
    let unset = PidInput { steering_feedforward: 0.01, enabled: true, ..PidInput::default() };
    assert_eq!(pid.prime(&p, &unset).steering_angle, 0.01);
    // The yaw appears; no derivative kick of 1.0/0.01 comes of it.
    let output = pid.tick(&p, &input(1.1, 1.0));
    assert!((output.steering_angle - 0.1).abs() < 1e-12, "{output:?}");
}

/// A loop that meets a step of 0.1 rad at the rate limit.
fn limited() -> PidParameters {
    PidParameters {
        gains: PidGains {
            kp: 3.0,
            ki: 8.0,
            kd: 0.1,
            derivative_filter_time_s: 0.02,
            setpoint_weight_proportional: 0.5,
            anti_windup_time_s: 0.15,
            ..PidParameters::default().gains
        },
        max_rate: 0.4,
        large_errors: LargeErrors {
            max_yaw_error_rad: 0.11,
            yaw_rate_lag_s: 0.01,
            sustained_rate_radps: 0.14,
            rate_reserve_time_s: 0.3,
        },
        lateral_acceleration: LateralAcceleration {
            max_mps2: 6.0,
            steering_per_curvature_radm: 8.0 / 3.0,
            ..PidParameters::default().lateral_acceleration
        },
        ..PidParameters::default()
    }
}

/// Yaw over the step's height, of a yaw rate proportional to steering that a servo turns at some of the rate
/// that the controller counts on: the largest, and the last.
fn slow_servo(p: &PidParameters, height: f64, share: f64) -> [f64; 2] {
    let (mut pid, mut yaw, mut servo, mut most) = (Pid::default(), 0.0, 0.0, 0.0_f64);
    for _ in 0..3000 {
        let at = PidInput { speed: 8.0, ..input(height, yaw) };
        let command = pid.tick(p, &at).steering_angle;
        servo += (command - servo).clamp(-0.004 * share, 0.004 * share);
        yaw += 0.01 * 3.0 * servo;
        most = most.max(yaw);
    }
    [most / height, yaw / height]
}

/// Nor does a servo slower than counted on keep yaw from coming to rest; a step within the bound is untouched.
#[test]
fn large_steps_do_not_overshoot_at_the_rate_limit() {
    let p = limited();
    let alike = PidParameters {
        large_errors: LargeErrors { max_yaw_error_rad: PI, ..p.large_errors },
        ..p
    };
    for height in [0.3, 0.6, 1.5] {
        let bounded = slow_servo(&p, height, 1.0)[0];
        assert!(bounded < 1.02, "{height}: {bounded}");
        // With a servo of 3/8 of the rate it comes to rest.
        let slower = slow_servo(&p, height, 0.375);
        assert!((slower[1] - 1.0).abs() < 0.01, "{height}: {slower:?}");
    }
    assert_eq!(slow_servo(&p, 0.1, 1.0), slow_servo(&alike, 0.1, 1.0));
}

/// A servo of 3/8 of the rate is noticed within the first step beyond it, and the loop calms down.
#[test]
fn a_slow_actuator_is_noticed_by_the_yaw_rate() {
    let p = limited();
    let unnoticed =
        PidParameters { large_errors: LargeErrors { yaw_rate_lag_s: 0.0, ..p.large_errors }, ..p };
    let [most, last] = slow_servo(&p, 0.1, 0.375);
    let [before, _] = slow_servo(&unnoticed, 0.1, 0.375);
    assert!(most - 1.0 < 0.7 * (before - 1.0), "{most}, unnoticed {before}");
    assert!((last - 1.0).abs() < 0.01, "{last}");
}

/// A winding road that needs most of the steering rate, on a vehicle whose yaw rate per angle is off by up to
/// 10 %, lags, and at times jumps with a correction of the pose: the actuator follows, so the road is followed.
#[test]
fn a_road_that_needs_the_steering_rate_is_no_slow_actuator() {
    let p = PidParameters {
        large_errors: LargeErrors { yaw_rate_lag_s: 0.1, ..limited().large_errors },
        ..limited()
    };
    for (share, factor) in [(0.95, 1.0), (0.8, 0.9), (0.8, 1.1)] {
        let follow = |p: &PidParameters| {
            let (mut pid, mut yaw, mut rate, mut reference) = (Pid::default(), 0.0, 0.0, 0.0);
            let mut angles = Vec::new();
            let mut largest = 0.0_f64;
            for k in 0..3000 {
                // Triangles of 0.25 rad to both sides.
                let phase = (share * 0.4 * 0.01 * f64::from(k)) % 1.0;
                let angle = if phase < 0.25 {
                    phase
                } else if phase < 0.75 {
                    0.5 - phase
                } else {
                    phase - 1.0
                };
                reference += 0.01 * 3.0 * angle;
                let jump = if k % 100 == 50 { 0.002 } else { 0.0 };
                let at = PidInput {
                    steering_feedforward: angle,
                    speed: 8.0,
                    ..input(reference, yaw + jump)
                };
                largest = largest.max((reference - yaw).abs());
                let sent = pid.tick(p, &at).steering_angle;
                angles.push(sent);
                rate += 0.1 * (3.0 * factor * sent - rate);
                yaw += 0.01 * rate;
            }
            (angles, largest)
        };
        let (angles, largest) = follow(&p);
        let (unwatched, usual) = follow(&PidParameters {
            large_errors: LargeErrors { yaw_rate_lag_s: 0.0, ..p.large_errors },
            ..p
        });
        assert!(factor != 1.0 || angles == unwatched, "{share}");
        assert!(largest < 1.1 * usual, "{share} {factor}: {largest} {usual}");
        assert!(largest < 0.13, "{share} {factor}: {largest}");
    }
}

/// The reserve holds what it was measured for, and no more.
#[test]
fn the_time_at_the_largest_rate_is_counted() {
    let p = limited();
    let steering: Vec<f64> = (1..=50).map(|k| 0.004 * f64::from(k)).collect();
    let full = steerwright_models::time_at_largest_rate(&p, 0.0, &steering);
    // The filter takes 2.3 of its time constants of 0.05 s.
    assert!((full - 0.38).abs() < 0.03, "{full}");
    let slower: Vec<f64> = steering.iter().map(|u| 0.8 * u).collect();
    assert_eq!(steerwright_models::time_at_largest_rate(&p, 0.0, &slower), 0.0);
}

/// What is within the bound is untouched, bit by bit, and so is a smooth ramp that the loop lags by more.
#[test]
fn small_errors_and_ramps_are_not_bounded() {
    let p = PidParameters {
        large_errors: LargeErrors {
            max_yaw_error_rad: 0.08,
            rate_reserve_time_s: 0.2,
            ..full().large_errors
        },
        ..full()
    };
    let free = PidParameters {
        large_errors: LargeErrors { max_yaw_error_rad: PI, ..p.large_errors },
        ..p
    };
    let (mut bounded, mut unbounded) = (Pid::default(), Pid::default());
    let (mut yaw, mut largest) = (0.0, 0.0_f64);
    for k in 0..800 {
        // From rest to 0.5 rad/s within a second.
        let t = 0.01 * f64::from(k);
        let reference = if t < 1.0 { 0.25 * t * t } else { 0.5 * t - 0.25 };
        largest = largest.max(reference - yaw);
        let at = PidInput { speed: 8.0, ..input(reference, yaw) };
        let u = bounded.tick(&p, &at).steering_angle;
        assert_eq!(u, unbounded.tick(&free, &at).steering_angle, "tick {k}");
        yaw += 0.01 * 3.0 * u;
    }
    assert!(largest > 0.12, "{largest}");
}

/// At standstill the steering stays where the error puts it, for however long; of half a metre per second half of the
/// integral action is left. Without a bound the speed is not known, and the integral acts.
#[test]
fn the_integral_waits_at_standstill() {
    let bounded = limited();
    let unbounded =
        PidParameters { lateral_acceleration: PidParameters::ANY_ACCELERATION, ..limited() };
    let error = 0.0003;
    let after = |p: &PidParameters, speed: f64| {
        let mut pid = Pid::default();
        let mut first = None;
        let mut last = 0.0;
        for _ in 0..=1000 {
            last = pid.tick(p, &PidInput { speed, ..input(error, 0.0) }).steering_angle;
            first.get_or_insert(last);
        }
        last - first.unwrap()
    };
    let whole = bounded.gains.ki * 10.0 * error;
    assert!(whole > 0.01 && whole < bounded.largest_angle(20.0));
    for (p, speed, share) in [
        (bounded, 0.0, 0.0),
        (bounded, 0.5, 0.5),
        (bounded, 1.0, 1.0),
        (bounded, 20.0, 1.0),
        (unbounded, 0.0, 1.0),
    ] {
        let moved = after(&p, speed);
        assert!((moved - share * whole).abs() < 1e-9, "{speed}: {moved} of {whole}");
    }
}

/// δ = a·(L/v² + K), and the fixed bound where that is less.
#[test]
fn the_largest_angle_follows_the_speed() {
    let p = PidParameters {
        lateral_acceleration: LateralAcceleration {
            max_mps2: 6.0,
            steering_per_curvature_radm: 2.6,
            understeer_gradient_rads2pm: 0.002,
        },
        ..PidParameters::default()
    };
    assert!((p.largest_angle(15.0) - 6.0 * (2.6 / 225.0 + 0.002)).abs() < 1e-15);
    assert_eq!(p.largest_angle(0.0), p.max_angle);
    assert_eq!(p.largest_angle(f64::NAN), p.max_angle);
    let mut pid = Pid::default();
    for _ in 0..50 {
        let at = PidInput { speed: 15.0, ..input(1.5, 0.0) };
        let output = pid.tick(&p, &at);
        assert!(output.steering_angle <= p.largest_angle(15.0));
    }
    // Faster, it obeys at once.
    let output = pid.tick(&p, &PidInput { speed: 30.0, ..input(1.5, 0.0) });
    assert_eq!(output.steering_angle, p.largest_angle(30.0));
}
