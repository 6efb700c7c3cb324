//! The structure `bicycle`: known vehicles are recovered from drives that the FMU's own plant made,
//! standard errors cover, hopeless drives ([`limits`]) are refused.

mod ensemble;
mod limits;
mod multibody;
mod rate_limit;
mod structures;
mod validated;

use crate::common::{car, recording};
use crate::known::Random;
use std::f64::consts::TAU;
use steerwright_drivelog::DriveLog;
use steerwright_formats::{Bicycle, BicycleEvidence, ChannelSummary, Continuous, Document, Matrix};
use steerwright_models::{BicycleParameters, BicyclePlant, bicycle_body_frame};
use steerwright_sysid::bicycle::{BicycleOptions, IdentifiedBicycle, identify_bicycle};
use steerwright_sysid::{Error, ValidationData, ValidationPlace};

const T: f64 = 0.04;

/// How a vehicle is driven and measured.
#[derive(Clone, Copy)]
struct Drive {
    seconds: f64,
    /// Standard deviation of the gyro's noise, rad/s, and its pole.
    noise: f64,
    noise_pole: f64,
    seed: u64,
    /// Samples by which the steering acts late.
    delay: usize,
    /// Angle that drives straight, and the gyro's bias.
    offset: f64,
    bias: f64,
    slowest: f64,
    fastest: f64,
}

const DRIVE: Drive = Drive {
    seconds: 120.0,
    noise: 0.0,
    noise_pole: 0.0,
    seed: 1,
    delay: 0,
    offset: 0.004,
    bias: -0.003,
    slowest: 8.0,
    fastest: 28.0,
};

/// Drives a vehicle by the plant that runs in the FMU.
fn drive(vehicle: BicycleParameters, d: Drive) -> DriveLog {
    let mut plant = BicyclePlant::new(vehicle).unwrap();
    let mut random = Random(d.seed);
    let n = (d.seconds / T) as usize;
    let (mut input, mut output, mut speeds) = (Vec::new(), Vec::new(), Vec::new());
    let (mut phase, mut level, mut e) = (0.0, 0.0, 0.0);
    for k in 0..n {
        let t = k as f64 * T;
        let speed = d.slowest + 0.5 * (d.fastest - d.slowest) * (1.0 - (TAU * t / 50.0).cos());
        // A sweep from 0.1 to 2 Hz, and random steps.
        phase += TAU * T * 0.1 * 20.0_f64.powf((t / 25.0).fract());
        if k % 40 == 39 {
            level = 0.01 * random.normal();
        }
        input.push((0.015 * phase.sin() + level) * vehicle.steering_ratio + d.offset);
        e = d.noise_pole * e
            + (1.0 - d.noise_pole * d.noise_pole).sqrt() * d.noise * random.normal();
        output.push(plant.yaw_rate() + d.bias + e);
        speeds.push(speed);
        plant.steering_angle = input[k.saturating_sub(d.delay)] - d.offset;
        plant.speed = speed;
        plant.step(T).unwrap();
    }
    DriveLog {
        speed: Some(speeds),
        steering_ratio: vehicle.steering_ratio,
        ..recording(T, input, output)
    }
}

/// What is known of [`car`] in addition to its yaw rate.
fn known() -> BicycleOptions {
    let car = car();
    BicycleOptions {
        mass_kg: Some(car.mass),
        front_share: Some(car.distance_rear / car.wheelbase()),
        ..BicycleOptions::default()
    }
}

/// The last half validates: both parts are in one piece.
fn at_end() -> ValidationData {
    ValidationData { place: ValidationPlace::End, ..ValidationData::default() }
}

/// The model from steering angle to yaw rate at one speed.
fn at_speed(vehicle: &BicycleParameters, speed: f64) -> Continuous {
    let (f, g) = bicycle_body_frame(vehicle, speed);
    Continuous {
        f: Matrix::from_fn(3, 3, |i, j| f[(i, j)]),
        g: Matrix::from_fn(3, 1, |i, _| g[i]),
        h: Matrix::from_fn(1, 3, |_, j| if j == 1 { 1.0 } else { 0.0 }),
    }
}

fn evidence(found: &IdentifiedBicycle) -> &BicycleEvidence {
    found.bicycle.evidence.as_ref().unwrap()
}

/// Estimate and standard error of a combination.
fn estimated(e: &BicycleEvidence, name: &str) -> (f64, f64) {
    let q = e.identified.iter().find(|q| q.name == name).unwrap_or_else(|| panic!("{name}"));
    (q.value, q.standard_error)
}

fn parameters(bicycle: &Bicycle) -> BicycleParameters {
    steerwright_models::files::bicycle_parameters(&bicycle.vehicle)
}

fn values(p: &BicycleParameters) -> [f64; 8] {
    [
        p.mass,
        p.yaw_inertia,
        p.distance_front,
        p.distance_rear,
        p.cornering_stiffness_front,
        p.cornering_stiffness_rear,
        p.actuator_time_constant,
        p.steering_ratio,
    ]
}

fn assert_same(a: &BicycleParameters, b: &BicycleParameters, tolerance: f64) {
    for (x, y) in values(a).into_iter().zip(values(b)) {
        assert!((x / y - 1.0).abs() < tolerance, "{a:?}\n{b:?}");
    }
}

#[test]
fn without_noise_the_vehicle_itself_comes_out() {
    let found = identify_bicycle(&drive(car(), DRIVE), &known()).unwrap();
    let e = evidence(&found);
    println!("{e:?}");
    assert!(e.estimation_fit > 99.99 && e.validation_fit > 99.99);
    assert_same(&parameters(&found.bicycle), &car(), 1e-3);
    assert!((e.steering_offset_rad - DRIVE.offset).abs() < 1e-5);
    assert!((e.yaw_rate_offset_radps - DRIVE.bias).abs() < 1e-5);
    assert!(e.with_delay.input_delay_s.abs() < 1e-3);
    assert!(found.bicycle.quality.allows_design() && e.warnings.is_empty(), "{:?}", e.warnings);
    let gradient = car().understeer_gradient();
    assert!((estimated(e, "understeer_gradient").0 / gradient - 1.0).abs() < 1e-2);
}

#[test]
fn the_file_holds_eq_13_as_the_paper_prints_it() {
    let found = identify_bicycle(&drive(car(), DRIVE), &BicycleOptions::default()).unwrap();
    let bicycle = &found.bicycle;
    let p = parameters(bicycle);
    p.check().unwrap();
    let v = bicycle.vehicle.speed_mps;
    let (lf, lr) = (p.distance_front, p.distance_rear);
    let (cf, cr) = (p.cornering_stiffness_front, p.cornering_stiffness_rear);
    let (m, j) = (p.mass, p.yaw_inertia);
    let lateral = [-(cf + cr) / m, (cr * lr - cf * lf) / m, cf / m / p.steering_ratio];
    let turning = [
        (cr * lr - cf * lf) / j,
        -(cf * lf * lf + cr * lr * lr) / j,
        cf * lf / j / p.steering_ratio,
    ];
    let row = |[x1, x2, u]: [f64; 3]| [0.0, x1 / v, -x1, x2 / v, u];
    let expected = [
        [0.0, 1.0, 0.0, 0.0, 0.0],
        row(lateral),
        [0.0, 0.0, 0.0, 1.0, 0.0],
        row(turning),
        [0.0, 0.0, 0.0, 0.0, -1.0 / p.actuator_time_constant],
    ];
    let close = |a: f64, b: f64| (a - b).abs() <= 1e-12 * b.abs();
    for (i, row) in expected.iter().enumerate() {
        for (j, entry) in row.iter().enumerate() {
            assert!(close(bicycle.state_matrix.entry(i, j), *entry), "{i} {j}");
        }
        let input = if i == 4 { 1.0 / p.actuator_time_constant } else { 0.0 };
        assert!(close(bicycle.input_matrix.entry(i, 0), input));
    }
    let text = bicycle.to_json();
    assert_eq!(&Bicycle::from_json(&text, "bicycle.json").unwrap(), bicycle);
    // A file from before there was evidence still reads.
    let mut old: serde_json::Value = serde_json::from_str(&text).unwrap();
    old.as_object_mut().unwrap().remove("evidence");
    assert!(Bicycle::from_json(&old.to_string(), "old.json").unwrap().evidence.is_none());
}

#[test]
fn the_plant_of_the_fmu_follows_the_traces() {
    for delay in [0, 3] {
        follows_the_traces(Drive { noise: 0.01, fastest: 20.0, slowest: 0.2, delay, ..DRIVE });
    }
}

fn follows_the_traces(of: Drive) {
    let log = drive(car(), of);
    let options = BicycleOptions {
        least_speed_mps: Some(0.0),
        validation: at_end(),
        ..BicycleOptions::default()
    };
    let found = identify_bicycle(&log, &options).unwrap();
    assert_eq!(found.bicycle.vehicle.actuator_delay_s > 0.0, of.delay > 0);
    let e = evidence(&found);
    let mut plant = BicyclePlant::new(parameters(&found.bicycle)).unwrap();
    let mut worst: f64 = 0.0;
    // The plant starts straight: its own transient is over after some seconds.
    let half = log.len() / 2;
    for k in 0..half {
        if k > 500 {
            let simulated = found.traces.simulated_yaw_rate_radps[k];
            worst = worst.max((plant.yaw_rate() + e.yaw_rate_offset_radps - simulated).abs());
        }
        plant.steering_angle = log.input[k] - e.steering_offset_rad;
        plant.speed = log.speed.as_ref().unwrap()[k];
        plant.step(T).unwrap();
    }
    println!("{worst:e}");
    assert!(worst < 1e-9, "{worst:e}");
}

/// Standardised errors of the combinations over repeated drives that differ in their noise.
fn scores(d: Drive, runs: u64) -> Vec<f64> {
    let truth = car();
    let mut all = Vec::new();
    for seed in 0..runs {
        let log = drive(truth, Drive { seed: 100 + seed, ..d });
        let found = identify_bicycle(&log, &known()).unwrap();
        let e = evidence(&found);
        let speed = e.speed.mean_mps;
        for (name, expected) in [
            ("effective_wheelbase", truth.wheelbase()),
            ("understeer_gradient", truth.understeer_gradient()),
            ("yaw_rate_gain", truth.yaw_rate_gain(speed)),
            ("yaw_acceleration_gain", truth.coefficients().b2),
            ("actuator_time_constant", truth.actuator_time_constant),
            ("steering_offset_road_wheel", d.offset),
            ("yaw_rate_offset", d.bias),
        ] {
            let (value, error) = estimated(e, name);
            all.push((value - expected) / error);
        }
    }
    all
}

#[test]
#[ignore = "slow: cargo xtask test"]
fn standard_errors_cover_as_often_as_stated() {
    for (noise_pole, noise) in [(0.0, 0.01), (0.9, 0.01)] {
        let z = scores(Drive { noise, noise_pole, ..DRIVE }, 10);
        let rms = (z.iter().map(|z| z * z).sum::<f64>() / z.len() as f64).sqrt();
        let within = z.iter().filter(|z| z.abs() < 2.0).count() as f64 / z.len() as f64;
        println!("noise_pole {noise_pole}: rms {rms:.2}, within two deviations {within:.3}");
        assert!((0.7..1.3).contains(&rms), "noise_pole {noise_pole}: {rms}");
        assert!(within > 0.88, "noise_pole {noise_pole}: {within}");
    }
}

#[test]
fn a_delay_is_identified_with_the_lag() {
    let log = drive(car(), Drive { delay: 3, noise: 0.002, ..DRIVE });
    let found = identify_bicycle(&log, &known()).unwrap();
    let e = evidence(&found);
    let d = e.with_delay;
    println!("{d:?} {} {}", e.estimation_fit, e.validation_fit);
    assert!((d.input_delay_s - 3.0 * T).abs() < 0.005 && d.standard_error_s < 0.01);
    assert!((d.actuator_time_constant_s - 0.06).abs() < 0.015);
    assert_eq!(d.validation_fit, e.validation_fit);
    let vehicle = &found.bicycle.vehicle;
    assert_eq!(vehicle.actuator_delay_s, d.input_delay_s);
    assert_eq!(vehicle.actuator_time_constant_s, d.actuator_time_constant_s);
    let (delay, error) = estimated(e, "actuator_delay");
    assert_eq!((delay, error), (d.input_delay_s, d.standard_error_s));
    assert!(e.directions.iter().any(|direction| direction.actuator_delay_s != 0.0));
    // A prompt steering has none in its file.
    let prompt = identify_bicycle(&drive(car(), Drive { noise: 0.002, ..DRIVE }), &known());
    assert_eq!(prompt.unwrap().bicycle.vehicle.actuator_delay_s, 0.0);
    // A steering channel that comes late itself.
    let mut early = log;
    early.input.rotate_right(6);
    let found = identify_bicycle(&early, &known()).unwrap();
    let e = evidence(&found);
    assert!((e.with_delay.input_delay_s + 3.0 * T).abs() < 0.02, "{:?}", e.with_delay);
    assert!(e.warnings.iter().any(|w| w.contains("before its steering")), "{:?}", e.warnings);
}

#[test]
fn standstill_is_left_out_and_reported() {
    // A vehicle that is steered at rest, and whose gyro drifts there.
    let mut log = drive(car(), Drive { fastest: 18.0, slowest: 6.0, noise: 0.002, ..DRIVE });
    let from = log.len() / 4;
    for k in from..from + 500 {
        log.speed.as_mut().unwrap()[k] = 0.0;
        log.input[k] = 0.5 * car().steering_ratio * (0.01 * k as f64).sin();
        log.output[k] = 0.02;
    }
    let found = identify_bicycle(&log, &known()).unwrap();
    let e = evidence(&found);
    assert!(e.warnings.iter().any(|w| w.contains("below 3.1 m/s in 19.")), "{:?}", e.warnings);
    let (length, error) = estimated(e, "effective_wheelbase");
    assert!((length - car().wheelbase()).abs() < 3.0 * error && error < 0.05, "{length} {error}");
    let all = BicycleOptions { least_speed_mps: Some(0.0), ..known() };
    let fit = evidence(&identify_bicycle(&log, &all).unwrap()).estimation_fit;
    assert!(e.estimation_fit > fit + 2.0, "{} {fit}", e.estimation_fit);
}

#[test]
fn an_oversteering_vehicle_keeps_its_critical_speed() {
    let vehicle = BicycleParameters {
        cornering_stiffness_front: 120_000.0,
        cornering_stiffness_rear: 88_000.0,
        ..car()
    };
    let critical = vehicle.critical_speed().unwrap();
    // Beyond that speed for a part of the drive: unstable there, and rightly so.
    let d = Drive { noise: 0.003, slowest: 6.0, fastest: critical + 1.0, offset: 0.0, ..DRIVE };
    let log = drive(vehicle, d);
    let found = identify_bicycle(&log, &known()).unwrap();
    let e = evidence(&found);
    let (value, error) = estimated(e, "critical_speed");
    println!("{critical} {value} ± {error}, {} {}", e.estimation_fit, e.validation_fit);
    assert!((value - critical).abs() < 3.0 * error.max(0.02), "{critical} {value} {error}");
}

#[test]
fn the_steering_ratio_changes_the_ratio_alone() {
    let log = drive(car(), Drive { noise: 0.005, ..DRIVE });
    let mut wheel = log.clone();
    wheel.steering_ratio = 15.0;
    wheel.input.iter_mut().for_each(|u| *u *= 15.0);
    let [a, b] = [&log, &wheel].map(|l| identify_bicycle(l, &known()).unwrap());
    let scaled = BicycleParameters { steering_ratio: 1.0, ..parameters(&b.bicycle) };
    assert_same(&parameters(&a.bicycle), &scaled, 1e-6);
    assert_eq!(b.bicycle.vehicle.steering_ratio, 15.0);
    let offsets = [&a, &b].map(|f| evidence(f).steering_offset_rad);
    assert!((15.0 * offsets[0] - offsets[1]).abs() < 1e-6);
    assert!((evidence(&a).validation_fit - evidence(&b).validation_fit).abs() < 1e-6);
}

#[test]
fn a_stated_wheelbase_stays_and_the_ratio_is_identified() {
    let vehicle = BicycleParameters { steering_ratio: 16.0, ..car() };
    let mut log = drive(vehicle, Drive { noise: 0.003, offset: 0.0, ..DRIVE });
    log.steering_ratio = 14.0;
    let options = BicycleOptions { wheelbase_m: Some(vehicle.wheelbase()), ..known() };
    let found = identify_bicycle(&log, &options).unwrap();
    let p = parameters(&found.bicycle);
    assert!((p.wheelbase() - vehicle.wheelbase()).abs() < 1e-9);
    assert!((p.steering_ratio / 16.0 - 1.0).abs() < 0.02, "{p:?}");
    assert!((p.understeer_gradient() / vehicle.understeer_gradient() - 1.0).abs() < 0.1);
}

/// A servo of 0.35 rad at 1, percent of a steering wheel's travel, and a command whose 1 is a turn of one.
#[test]
fn a_command_that_is_no_angle_needs_the_wheelbase() {
    let vehicle = BicycleParameters { steering_ratio: 1.0, ..car() };
    for angle_at_one in [0.35, 0.005, 6.0] {
        let mut log = drive(vehicle, Drive { noise: 0.003, offset: 0.0, ..DRIVE });
        log.input.iter_mut().for_each(|u| *u /= angle_at_one);
        log.steering_ratio = 1.0;
        let channel = |rows| ChannelSummary {
            role: "steering".into(),
            column: "command".into(),
            unit: "1".into(),
            rows,
            rate_hz: 1.0 / log.sample_time_s,
            intersample: None,
            along_lines: false,
            min: -1.0,
            mean: 0.0,
            max: 1.0,
            resolution: None,
            spikes_s: Vec::new(),
            frozen_s: Vec::new(),
        };
        log.channels = vec![channel(log.len())];
        assert_eq!(identify_bicycle(&log, &known()).unwrap_err(), Error::WheelbaseNeeded);
        let options = BicycleOptions { wheelbase_m: Some(vehicle.wheelbase()), ..known() };
        let found = identify_bicycle(&log, &options).unwrap();
        let ratio = parameters(&found.bicycle).steering_ratio;
        assert!((ratio * angle_at_one - 1.0).abs() < 0.02, "{angle_at_one}: {ratio}");
    }
}

#[test]
fn mass_is_stated_and_moves_no_response() {
    let log = drive(car(), Drive { noise: 0.005, ..DRIVE });
    let with = |mass| {
        let options = BicycleOptions { mass_kg: Some(mass), ..known() };
        identify_bicycle(&log, &options).unwrap()
    };
    let (light, heavy) = (with(800.0), with(1600.0));
    assert_eq!(light.traces, heavy.traces);
    let [a, b] = [&light, &heavy].map(|f| values(&parameters(&f.bicycle)));
    for i in [0, 1, 4, 5] {
        assert!((b[i] / a[i] - 2.0).abs() < 1e-12);
    }
    let stated = &evidence(&light).stated;
    assert!(stated.iter().any(|s| s.name == "mass_kg" && s.origin.starts_with("given")));
}

#[test]
fn segments_have_initial_states_of_their_own() {
    let whole = drive(car(), Drive { noise: 0.001, ..DRIVE });
    // Ten seconds are lost, in which the vehicle turned on.
    let (a, b) = (0..700, 950..whole.len());
    let keep = |x: &[f64]| [&x[a.clone()], &x[b.clone()]].concat();
    let log = DriveLog {
        input: keep(&whole.input),
        output: keep(&whole.output),
        speed: whole.speed.as_deref().map(keep),
        segments: vec![
            steerwright_drivelog::Segment { time0_s: 0.0, range: a.clone() },
            steerwright_drivelog::Segment { time0_s: 950.0 * T, range: 700..700 + b.len() },
        ],
        ..whole
    };
    let found = identify_bicycle(&log, &known()).unwrap();
    let e = evidence(&found);
    assert!(e.estimation_fit > 97.0 && e.validation_fit > 97.0, "{e:?}");
    assert_same(&parameters(&found.bicycle), &car(), 0.15);
}
