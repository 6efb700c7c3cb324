//! The actuator between a steering command and the measured angle beside it.

use crate::known::Random;
use std::fmt::Write;
use steerwright_drivelog::{DriveLog, LogOptions, read_log};
use steerwright_formats::IdentifiedActuator;
use steerwright_sysid::{IdentifyOptions, identify};

/// A lag behind a delay that turns at most at a rate, and how it is logged.
#[derive(Clone, Copy)]
struct Truth {
    lag_s: f64,
    delay_s: f64,
    rate_radps: f64,
    gain: f64,
    rate_hz: f64,
}

/// A drive of 120 s at 13 m/s, commanded at 100 Hz and integrated in steps of 1 ms.
fn drive(truth: Truth, seed: u64) -> DriveLog {
    let mut noise = Random(seed + 1);
    let (step, count) = (0.001, 120_000);
    let (mut first, mut command, mut commands) = (0.0, 0.0, Vec::with_capacity(count));
    let (mut angle, mut yaw_rate) = (0.0_f64, 0.0_f64);
    let late = (truth.delay_s / step).round() as usize;
    let every = (1.0 / truth.rate_hz / step).round() as usize;
    let mut csv =
        String::from("time_s,steering_command_rad,roadwheel_angle_rad,yaw_rate_radps,speed_mps\n");
    for k in 0..count {
        if k % 10 == 0 {
            let share = 0.043;
            first += share * (noise.normal() - first);
            command += share * (0.4 * first - command);
        }
        commands.push(command);
        if k % every == 0 {
            let measured = angle + 2e-4 * noise.normal();
            let turned = yaw_rate + 2e-3 * noise.normal();
            let t = step * k as f64;
            let _ = writeln!(csv, "{t:.3},{command:.6},{measured:.6},{turned:.6},13");
        }
        let delayed = truth.gain * commands[k.saturating_sub(late)];
        let rate = ((delayed - angle) / truth.lag_s).clamp(-truth.rate_radps, truth.rate_radps);
        yaw_rate += step * 7.0 * (4.5 * angle - yaw_rate);
        angle += step * rate;
    }
    let options = LogOptions {
        input: Some("roadwheel_angle_rad".into()),
        channels: [("steering_command".into(), "steering_command_rad".into())].into(),
        ..LogOptions::default()
    };
    read_log(&[("drive.csv".into(), csv.into_bytes())], &options).unwrap()
}

fn identified(truth: Truth, seed: u64) -> (IdentifiedActuator, Vec<String>) {
    let evidence =
        identify(&drive(truth, seed), &IdentifyOptions::default()).unwrap().plant.evidence;
    (evidence.actuator.unwrap(), evidence.warnings)
}

const FREE: f64 = f64::INFINITY;

#[test]
fn lag_delay_and_rate_are_those_of_the_servo() {
    for (seed, (rate_hz, lag_s, delay_s, rate_radps)) in [
        (100.0, 0.05, 0.02, FREE),
        (100.0, 0.05, 0.02, 0.1),
        (50.0, 0.1, 0.06, FREE),
        (100.0, 0.25, 0.1, FREE),
        (20.0, 0.1, 0.06, FREE),
        (20.0, 0.05, 0.02, 0.1),
    ]
    .into_iter()
    .enumerate()
    {
        let truth = Truth { lag_s, delay_s, rate_radps, gain: 1.0, rate_hz };
        let (found, warnings) = identified(truth, seed as u64);
        let all = format!("{rate_hz} Hz, {lag_s} s, {delay_s} s, {rate_radps} rad/s: {found:?}");
        println!("{all}");
        let slack = 0.002;
        let lag = (found.time_constant_s - lag_s).abs();
        assert!(lag <= 3.0 * found.time_constant_standard_error_s + slack, "{all}");
        let delay = (found.delay_s - delay_s).abs();
        assert!(delay <= 3.0 * found.delay_standard_error_s + slack, "{all}");
        // What a loop sees. The log does not say what a command does between its rows.
        let all_s = found.time_constant_s + found.delay_s - lag_s - delay_s;
        assert!(all_s.abs() < 0.003 + 0.25 / rate_hz, "{all}");
        match found.max_rate_radps {
            Some(rate) => assert!((rate / rate_radps - 1.0).abs() < 0.1, "{all}"),
            None => assert!(rate_radps.is_infinite(), "{all}"),
        }
        assert!(
            found.fault().is_none() && !warnings.iter().any(|w| w.contains("actuator")),
            "{all}"
        );
    }
}

#[test]
fn a_command_of_the_steering_wheel_is_no_command_of_the_road_wheels() {
    let truth = Truth { lag_s: 0.05, delay_s: 0.02, rate_radps: FREE, gain: 0.066, rate_hz: 100.0 };
    let (found, warnings) = identified(truth, 9);
    assert!(found.fault().is_some_and(|fault| fault.contains("0.07 times the command")));
    assert!(warnings.iter().any(|w| w.contains("no controller is designed for the actuator")));
}
