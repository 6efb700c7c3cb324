use super::identify_torque;
use super::options::TorqueOptions;
use std::fmt::Write;
use steerwright_drivelog::{DriveLog, LogOptions, Response, read_log};
use steerwright_formats::{Estimate, Grade, Torque};

const FACTOR: f64 = 2.5;
const FRICTION: f64 = 0.12;
const OFFSET: f64 = 0.05;
const DELAY: f64 = 0.27;

struct Random(u64);

impl Random {
    fn normal(&mut self) -> f64 {
        (0..12)
            .map(|_| {
                self.0 = self
                    .0
                    .wrapping_mul(6_364_136_223_846_793_005)
                    .wrapping_add(1_442_695_040_888_963_407);
                (self.0 >> 11) as f64 / (1_u64 << 53) as f64
            })
            .sum::<f64>()
            - 6.0
    }
}

/// Twenty minutes of a car whose acceleration follows the delayed command with friction, on a road whose bank varies,
/// with disturbances that last 0.5 s; `feedback` is the gain of the controller on the error of the acceleration.
fn drive(seed: u64, rate_hz: usize, feedback: f64) -> String {
    let mut random = Random(seed);
    let fine = 0.01;
    let (mut desired, mut smooth, mut angle, mut roll, mut wind) = (0.0, 0.0, 0.0, 0.0, 0.0_f64);
    let (mut error, mut command, mut last_rate) = (0.0, 0.0, 0.0_f64);
    let mut past = std::collections::VecDeque::from(vec![0.0; (DELAY / fine).round() as usize]);
    let mut log = String::from(
        "t,latActive,steeringPressed,vEgo,aEgo,steeringAngleDeg,steer,steerFiltered,roll,latAccelDesired,latAccelSteeringAngle,latAccelLocalizer,epsFwVersion\n",
    );
    for k in 0..120_000 {
        desired += fine * (-desired / 2.0) + 0.35 * fine.sqrt() * random.normal();
        smooth += fine * (desired - smooth) / 0.3;
        command += fine * ((smooth + feedback * error) / FACTOR - command) / 0.1;
        roll += fine * (-roll / 10.0) + 0.012 * fine.sqrt() * random.normal();
        wind += fine * (-wind / 0.5) + 0.1 * fine.sqrt() * random.normal();
        past.push_back(command);
        let delayed: f64 = past.pop_front().unwrap_or_default();
        // The steering wheel creeps toward the angle of the command.
        let rate = (0.3 * delayed - angle) / 0.15;
        // That of the angle at this instant, between two steps.
        let rate_here = f64::midpoint(rate, last_rate);
        last_rate = rate;
        let acceleration = FACTOR * (delayed - FRICTION * (rate_here / 0.05).tanh())
            + 9.80665 * f64::sin(roll)
            + OFFSET
            + wind;
        error = smooth - acceleration;
        if k % (100 / rate_hz) == 0 {
            let active = if k % 40_000 > 500 { "True" } else { "False" };
            let degrees = f64::to_degrees(angle);
            writeln!(
                log,
                "{:.2},{active},False,25.0,0.0,{degrees:.5},{command:.5},{command:.5},{roll:.6},0,0,{acceleration:.5},b''",
                k as f64 * fine
            )
            .unwrap();
        }
        angle += fine * rate;
    }
    log
}

fn read(csv: &str) -> DriveLog {
    let options = LogOptions { response: Response::LateralAcceleration, ..LogOptions::default() };
    read_log(&[("drive.csv".into(), csv.as_bytes().to_vec())], &options).unwrap()
}

fn estimates(found: &Torque) -> [(Estimate, f64); 5] {
    [
        (found.acceleration_per_command, FACTOR),
        (found.friction, FRICTION),
        (found.offset_mps2, OFFSET),
        (found.roll_coefficient.unwrap(), 1.0),
        (found.delay_s, DELAY),
    ]
}

/// How many of the bands of 95 % contain the truth, and the mean errors.
fn coverage(drives: u64, rate_hz: usize, feedback: f64) -> ([u64; 5], [f64; 5]) {
    let (mut inside, mut bias) = ([0; 5], [0.0; 5]);
    for seed in 0..drives {
        let log = read(&drive(seed, rate_hz, feedback));
        let found = identify_torque(&log, &TorqueOptions::default()).unwrap();
        assert_eq!(found.quality.grade, Grade::Pass, "{:?}", found.quality);
        for (i, (estimate, truth)) in estimates(&found).into_iter().enumerate() {
            let error = estimate.value - truth;
            inside[i] += u64::from(error.abs() < 1.96 * estimate.standard_error);
            bias[i] += error / drives as f64;
        }
    }
    (inside, bias)
}

#[test]
#[ignore = "slow: cargo xtask test"]
fn the_bands_of_a_hundred_drives_contain_factor_friction_offset_roll_and_delay() {
    let (inside, _) = coverage(100, 10, 0.0);
    eprintln!("of 100 drives at 10 Hz: {inside:?}");
    assert!(inside.iter().all(|n| (88..=100).contains(n)), "of 100: {inside:?}");
    // Feedback correlates command and disturbance.
    let (inside, bias) = coverage(30, 50, 0.5);
    eprintln!("with feedback, of 30 drives at 50 Hz: {inside:?}, mean errors {bias:?}");
    assert!(bias[0].abs() < 0.01 * FACTOR && bias[4].abs() < 0.005, "{bias:?}");
}

#[test]
fn a_drive_at_10_hz_returns_the_simulated_car() {
    let log = read(&drive(7, 10, 0.0));
    let found = identify_torque(&log, &TorqueOptions::default()).unwrap();
    for (estimate, truth) in estimates(&found) {
        let error = (estimate.value - truth).abs();
        assert!(error < 3.0 * estimate.standard_error, "{estimate:?} {truth}");
        assert!(estimate.standard_error < 0.05 * truth.abs().max(0.1), "{estimate:?} {truth}");
    }
    // Three parts with the controller engaged, of which the first two seconds are not used.
    assert_eq!(log.segments.len(), 3);
    let samples = found.evidence.estimation_samples + found.evidence.validation_samples;
    assert!((11_700..11_800).contains(&samples), "{samples}");
    assert!(found.evidence.validation_fit > 85.0, "{:?}", found.evidence);
}

#[test]
fn a_reversed_command_fails_and_a_missing_roll_is_absent() {
    let csv = drive(8, 10, 0.0);
    let of = |csv: &str, options| {
        let log = read_log(&[("drive.csv".into(), csv.as_bytes().to_vec())], &options).unwrap();
        identify_torque(&log, &TorqueOptions::default()).unwrap()
    };
    let torque = || LogOptions { response: Response::LateralAcceleration, ..LogOptions::default() };
    let reversed = of(&csv, LogOptions { input: Some("-steerFiltered".into()), ..torque() });
    assert_eq!(reversed.quality.grade, Grade::Fail);
    assert_eq!(reversed.quality.codes(), "wrong-sign");

    let unknown = csv.replacen(",roll,", ",bank_of_another_name,", 1);
    let units = [
        ("t", "s"),
        ("vEgo", "m/s"),
        ("steeringAngleDeg", "deg"),
        ("steerFiltered", "1"),
        ("latAccelLocalizer", "m/s2"),
    ];
    let units = units.map(|(name, unit)| (name.to_string(), unit.to_string())).into();
    let level = of(&unknown, LogOptions { units, ..torque() });
    assert_eq!(level.roll_coefficient, None);
    let factor = level.acceleration_per_command;
    assert!((factor.value - FACTOR).abs() < 3.0 * factor.standard_error, "{factor:?}");
}

#[test]
fn what_is_missing_is_named() {
    let csv = drive(9, 10, 0.0);
    let refused = |csv: &str, options: TorqueOptions| {
        identify_torque(&read(csv), &options).unwrap_err().to_string()
    };
    let fast = TorqueOptions { least_speed_mps: 30.0, ..TorqueOptions::default() };
    assert!(refused(&csv, fast).contains("0 samples of 0.1 s are too few: 1500 are needed"));
    let wrong = TorqueOptions { friction_rate_radps: 0.0, ..TorqueOptions::default() };
    assert!(refused(&csv, wrong).contains("friction rate: 0 is out of range"));
    let yaw = format!("time_s,delta_rad,yaw_rate_radps\n{}", {
        let row = |k: u32| {
            let t = 0.02 * f64::from(k);
            format!("{t:.2},{:.5},{:.5}\n", 0.1 * t.sin(), t.sin())
        };
        (0..400).map(row).collect::<String>()
    });
    let log = read_log(&[("yaw.csv".into(), yaw.into_bytes())], &LogOptions::default()).unwrap();
    let error = identify_torque(&log, &TorqueOptions::default()).unwrap_err();
    assert!(error.to_string().contains("read for the response of the yaw rate"), "{error}");
}

#[test]
fn a_log_without_engagement_is_refused_with_its_seconds() {
    let csv = drive(10, 10, 0.0).replace("True", "False");
    let options = LogOptions { response: Response::LateralAcceleration, ..LogOptions::default() };
    let error = read_log(&[("drive.csv".into(), csv.into_bytes())], &options).unwrap_err();
    assert!(error.to_string().contains("engaged for 0.0 s only"), "{error}");
    assert!(!error.hint().is_empty());
}
