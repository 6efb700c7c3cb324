//! The sideslip per yaw rate from fixes and gyro, on drives whose truth is known.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

mod common;

use common::car;
use std::f64::consts::TAU;
use std::fmt::Write;
use sysid::{DriveLog, LogOptions, read_log};
use sysid_evaluation::Random;
use vehicle_models::BicyclePlant;

const H: f64 = 0.01;
const SPEED: f64 = 15.0;
const LATENCY: f64 = 0.1;

/// How a vehicle is driven and seen.
#[derive(Clone, Copy)]
struct Drive {
    seconds: f64,
    seed: u64,
    /// Amplitude of the steering, rad.
    steering: f64,
    /// Of a fix in each coordinate, m.
    fix_std: f64,
    antenna_x: f64,
    degrees: bool,
    /// Every so many fixes one is twenty metres off.
    outlier: usize,
}

const DRIVE: Drive = Drive {
    seconds: 240.0,
    seed: 1,
    steering: 0.03,
    fix_std: 0.02,
    antenna_x: 0.0,
    degrees: false,
    outlier: usize::MAX,
};

/// The drive's log: gyro with bias and noise at 100 Hz, fixes at 10 Hz that are told 0.1 s late.
fn logged(d: Drive, options: &LogOptions) -> DriveLog {
    let mut plant = BicyclePlant::new(car()).unwrap();
    plant.speed = SPEED;
    plant.initial_yaw = 2.0;
    plant.start().unwrap();
    let mut random = Random(d.seed);
    let mut drive = String::from("time_s,roadwheel_angle_rad,yaw_rate_radps,speed_mps\n");
    let mut fixes = String::from(match d.degrees {
        true => "time_s,latitude_deg,longitude_deg\n",
        false => "time_s,x_m,y_m\n",
    });
    let (mut phase, mut level) = (0.0, 0.0);
    for k in 0..(d.seconds / H) as usize {
        let t = k as f64 * H;
        if k % 10 == 0 {
            let yaw = plant.yaw();
            let wrong = if k / 10 % d.outlier == d.outlier - 1 { 20.0 } else { 0.0 };
            let x = plant.x() + d.antenna_x * yaw.cos() + d.fix_std * random.normal() + wrong;
            let y = plant.y() + d.antenna_x * yaw.sin() + d.fix_std * random.normal();
            let told = t + LATENCY;
            let _ = match d.degrees {
                // On a ball: a kilometre or two, to a few parts in a thousand.
                true => writeln!(
                    fixes,
                    "{told:.2},{:.10},{:.10}",
                    48.0 + y / 111_200.0,
                    11.0 + x / (111_320.0 * 48.0_f64.to_radians().cos())
                ),
                false => writeln!(fixes, "{told:.2},{x:.5},{y:.5}"),
            };
        }
        // A sweep from 0.1 to 1 Hz, and random levels.
        phase += TAU * H * 0.1 * 10.0_f64.powf((t / 25.0).fract());
        if k % 150 == 149 {
            level = 0.3 * d.steering * random.normal();
        }
        plant.steering_angle = d.steering * phase.sin() + level;
        let rate = plant.yaw_rate() + 0.005 + 0.003 * random.normal();
        let steering = plant.steering_angle + 1e-5 * random.normal();
        let _ = writeln!(drive, "{t:.2},{steering:.7},{rate:.7},{SPEED}");
        plant.step(H).unwrap();
    }
    let files =
        [("drive.csv".into(), drive.into_bytes()), ("fixes.csv".into(), fixes.into_bytes())];
    read_log(&files, options).unwrap()
}

fn told() -> LogOptions {
    LogOptions { gnss_latency_s: LATENCY, ..LogOptions::default() }
}

/// What the module's own standard error is of: noise. The transients that a second does not average
/// away are a bias beside it, here below 2 ms.
#[test]
fn the_sideslip_of_a_known_vehicle_is_found() {
    let truth = car().sideslip_per_yaw_rate(SPEED);
    assert!(truth.abs() > 0.02, "{truth}");
    let seeds = 6;
    let (mut mean, mut squares, mut claimed) = (0.0, 0.0, 0.0);
    for seed in 1..=seeds {
        let found = logged(Drive { seed, ..DRIVE }, &told()).sideslip.unwrap();
        let off = found.sideslip_per_yaw_rate_s - truth;
        println!("{truth:.4}: {off:.5} off, standard error {:.5}", found.standard_error_s);
        mean += off / seeds as f64;
        squares += off * off / seeds as f64;
        claimed += found.standard_error_s.powi(2) / seeds as f64;
        assert_eq!(found.gnss_latency_s, LATENCY);
    }
    assert!(mean.abs() < 0.002, "{mean}");
    let scatter = (squares - mean * mean).max(0.0).sqrt();
    assert!(claimed.sqrt() < 0.002 && scatter < 2.5 * claimed.sqrt(), "{scatter} {claimed}");
}

#[test]
fn latency_antenna_and_coordinates_count() {
    let truth = car().sideslip_per_yaw_rate(SPEED);
    let found = |d: Drive, options: &LogOptions| {
        logged(d, options).sideslip.unwrap().sideslip_per_yaw_rate_s
    };
    // Late fixes that are taken for prompt ones.
    let late = found(DRIVE, &LogOptions::default());
    assert!((late - (truth - LATENCY)).abs() < 0.005, "{late}");
    let ahead = Drive { antenna_x: 1.2, ..DRIVE };
    let ignored = found(ahead, &told());
    assert!((ignored - (truth + 1.2 / SPEED)).abs() < 0.004, "{ignored}");
    let known = found(ahead, &LogOptions { antenna_x_m: 1.2, ..told() });
    assert!((known - truth).abs() < 0.004, "{known}");
    let degrees = found(Drive { degrees: true, ..DRIVE }, &told());
    assert!((degrees - truth).abs() < 0.004, "{degrees}");
    let outliers = found(Drive { outlier: 97, ..DRIVE }, &told());
    assert!((outliers - truth).abs() < 0.004, "{outliers}");
}

#[test]
fn what_fixes_cannot_tell_is_left_out_with_a_reason() {
    for (drive, why) in [
        (Drive { fix_std: 1.5, ..DRIVE }, "standard error would be"),
        (Drive { steering: 0.0005, ..DRIVE }, "standard error would be"),
        (Drive { seconds: 40.0, ..DRIVE }, "are too few"),
    ] {
        let log = logged(drive, &told());
        assert_eq!(log.sideslip, None, "{why}");
        let warned = log.warnings.iter().any(|w| w.contains("no sideslip") && w.contains(why));
        assert!(warned, "{why}: {:?}", log.warnings);
    }
}
