//! The steering of a slow log, which the model takes as held over each sample.

use crate::known::Random;
use faer::linalg::solvers::Solve;
use faer::{Mat, c64};
use std::f64::consts::{PI, TAU};
use std::fmt::Write;
use steerwright_drivelog::{DriveLog, LogOptions, read_log};
use steerwright_formats::{Continuous, Grade, ReasonCode, VehicleData};
use steerwright_sysid::bicycle::{BicycleOptions, identify_bicycle, validate_bicycle};
use steerwright_sysid::model::conversion::discretize;
use steerwright_sysid::{IdentifyOptions, Intersample, identify, validate_plant};

const ANGLE: &str = "roadwheel_angle_rad";

/// `c·(s I − a)⁻¹·b`.
fn pencil(a: &Mat<f64>, b: &[f64], c: &[f64], s: c64) -> c64 {
    let n = a.nrows();
    let zero = c64::new(0.0, 0.0);
    let m = Mat::from_fn(n, n, |i, j| if i == j { s } else { zero } - a[(i, j)]);
    let x = m.partial_piv_lu().solve(Mat::from_fn(n, 1, |i, _| c64::new(b[i], 0.0)));
    (0..n).fold(zero, |sum, j| sum + x[(j, 0)] * c[j])
}

/// A bicycle at 20 m/s without a servo.
fn car(omega: f64) -> c64 {
    let f = Mat::from_fn(2, 2, |i, j| [[-6.0, -18.0], [0.9, -7.0]][i][j]);
    pencil(&f, &[80.0, 55.0], &[0.0, 1.0], c64::new(0.0, omega))
}

/// At 12 m/s, where its poles decay to a third over a sample of 0.1 s.
fn slow_car(omega: f64) -> c64 {
    let f = Mat::from_fn(2, 2, |i, j| [[-10.0, -10.0], [1.5, -11.5]][i][j]);
    pencil(&f, &[80.0, 55.0], &[0.0, 1.0], c64::new(0.0, omega))
}

/// Samples of a steering angle of many sines up to 3 Hz and of the car's yaw rate.
fn log(rate_hz: f64, seconds: f64) -> DriveLog {
    log_of(car, rate_hz, seconds)
}

fn log_of(car: fn(f64) -> c64, rate_hz: f64, seconds: f64) -> DriveLog {
    let mut random = Random(5);
    let sines: Vec<(f64, f64, c64)> = (0..80)
        .map(|k| {
            let hz = 0.05 * 60_f64.powf(f64::from(k) / 79.0);
            (TAU * hz, TAU * random.uniform(), car(TAU * hz))
        })
        .collect();
    let mut csv = String::from("time_s,roadwheel_angle_rad,yaw_rate_radps,speed_mps\n");
    for k in 0..(seconds * rate_hz) as usize {
        let t = k as f64 / rate_hz;
        let (mut u, mut y) = (0.0, 1e-3 * random.normal());
        for (omega, phase, response) in &sines {
            let turned = c64::cis(omega * t + phase);
            u += 0.003 * turned.re;
            y += 0.003 * (turned * response).re;
        }
        writeln!(csv, "{t:.3},{u:.9},{y:.9},20").unwrap();
    }
    let options = LogOptions {
        steering_ratio: Some(1.0),
        intersample: Some(Intersample::Bl),
        ..LogOptions::default()
    };
    read_log(&[("slow.csv".into(), csv.into_bytes())], &options).unwrap()
}

/// An angle that moves on between slow samples does to the vehicle what the model says, in gain and phase.
#[test]
fn a_slow_log_biases_neither_gain_nor_phase() {
    for rate_hz in [10.0, 12.5, 20.0, 50.0] {
        let log = log(rate_hz, 120.0);
        let found = identify(&log, &IdentifyOptions::default()).unwrap();
        let c = found.plant.continuous.as_ref().unwrap();
        let n = found.plant.order();
        let f = Mat::from_fn(n, n, |i, j| c.f.entry(i, j));
        let g: Vec<f64> = (0..n).map(|i| c.g.entry(i, 0)).collect();
        let h: Vec<f64> = (0..n).map(|j| c.h.entry(0, j)).collect();
        for hz in [0.3, 1.0, 2.0] {
            let s = c64::new(0.0, TAU * hz);
            let late = c64::cis(-TAU * hz * found.plant.input_delay_s);
            let ratio = pencil(&f, &g, &h, s) * late / car(TAU * hz);
            let (gain, degrees) = (ratio.re.hypot(ratio.im), ratio.im.atan2(ratio.re) * 180.0 / PI);
            println!("{rate_hz} Hz: at {hz} Hz gain {gain:.4}, phase {degrees:.3}°");
            assert!((gain - 1.0).abs() < 0.01, "{rate_hz} Hz: gain {gain} at {hz} Hz");
            assert!(degrees.abs() < 0.5, "{rate_hz} Hz: phase {degrees}° at {hz} Hz");
        }
        // The plant holds the steering of another log as its own.
        let fit = validate_plant(&log, &IdentifyOptions::default(), &found.plant).unwrap();
        let apart = fit.validation_fit - found.plant.evidence.fit.validation;
        assert!(apart.abs() < 1e-6, "{rate_hz} Hz: {apart}");
        // What is shown is the angle that was read.
        assert_eq!(found.traces.steering_rad, log.input);
    }
}

/// The steering is held as suits the vehicle that is identified from it, not one that an earlier estimate determined.
#[test]
fn the_vehicle_that_the_steering_is_held_for_is_the_one_identified() {
    let found = identify(&log_of(slow_car, 10.0, 120.0), &IdentifyOptions::default()).unwrap();
    let response = |c: &Continuous, s: c64| {
        let n = c.f.rows();
        let f = Mat::from_fn(n, n, |i, j| c.f.entry(i, j));
        let g: Vec<f64> = (0..n).map(|i| c.g.entry(i, 0)).collect();
        let h: Vec<f64> = (0..n).map(|j| c.h.entry(0, j)).collect();
        pencil(&f, &g, &h, s)
    };
    let held_for = found.plant.evidence.held_for.as_ref().unwrap();
    let identified = found.plant.continuous.as_ref().unwrap();
    for hz in [1.0, 2.0] {
        let s = c64::new(0.0, TAU * hz);
        // Their units of yaw rate and steering differ, so that phases are compared.
        let [vehicle, model, truth] =
            [response(held_for, s), response(identified, s), slow_car(TAU * hz)];
        let [apart, off] = [vehicle / model, model / truth].map(|r| r.im.atan2(r.re) * 180.0 / PI);
        println!("at {hz} Hz held for {apart:.3}° from the model, which is {off:.3}° from the car");
        assert!(apart.abs() < 1.0, "{apart}° at {hz} Hz");
        assert!(off.abs() < 0.5, "{off}° at {hz} Hz");
    }
}

/// The angle of a servo behind the steps of a controller is not band-limited. Models of the band-limited angle fit by an order
/// that takes over what it does between its samples, with a response that is wrong by tens of percent.
#[test]
fn an_angle_behind_steps_goes_along_straight_lines() {
    const STEPS: usize = 100;
    let f = Mat::from_fn(2, 2, |i, j| [[-10.0, -10.0], [1.5, -11.5]][i][j]);
    let g = Mat::from_fn(2, 1, |i, _| [80.0, 55.0][i]);
    let (a, b) = discretize(f.as_ref(), g.as_ref(), 0.1 / STEPS as f64);
    let mut random = Random(21);
    let (mut x, mut u, mut wanted) = ([0.0; 2], 0.0, 0.0);
    let mut csv = format!("time_s,{ANGLE},yaw_rate_radps,speed_mps\n");
    for k in 0..6000 {
        let noise = 0.002 * random.normal();
        writeln!(csv, "{:.1},{u:.9},{:.9},12", 0.1 * f64::from(k), x[1] + noise).unwrap();
        if k % 4 == 0 {
            wanted = 0.02 * random.normal();
        }
        for _ in 0..STEPS {
            let before = u;
            u = wanted + (u - wanted) * (-0.1 / STEPS as f64 / 0.15).exp();
            let mean = 0.5 * (before + u);
            x = [0, 1].map(|i| a[(i, 0)] * x[0] + a[(i, 1)] * x[1] + b[(i, 0)] * mean);
        }
    }
    let options = LogOptions { steering_ratio: Some(1.0), ..LogOptions::default() };
    let log = read_log(&[("steps.csv".into(), csv.into_bytes())], &options).unwrap();
    let plant = identify(&log, &IdentifyOptions::default()).unwrap().plant;
    let quality = &plant.quality;
    println!(
        "order {} fit {:.2} {}",
        plant.order(),
        plant.evidence.fit.validation,
        quality.summary
    );
    let steering = plant.evidence.channels.iter().find(|c| c.role == "steering").unwrap();
    assert_eq!(steering.intersample, Some(Intersample::Foh), "{:?}", plant.evidence.warnings);
    let warnings = &plant.evidence.warnings;
    assert!(warnings.iter().any(|w| w.contains("along straight lines")), "{warnings:?}");
    let c = plant.continuous.as_ref().unwrap();
    let n = plant.order();
    let f = Mat::from_fn(n, n, |i, j| c.f.entry(i, j));
    let g: Vec<f64> = (0..n).map(|i| c.g.entry(i, 0)).collect();
    let h: Vec<f64> = (0..n).map(|j| c.h.entry(0, j)).collect();
    for hz in [0.3, 1.0, 2.0] {
        let s = c64::new(0.0, TAU * hz);
        let late = c64::cis(-TAU * hz * plant.input_delay_s);
        let ratio = pencil(&f, &g, &h, s) * late / slow_car(TAU * hz);
        let (gain, phase) = (ratio.re.hypot(ratio.im), ratio.im.atan2(ratio.re));
        let stated = plant.uncertainty.as_ref().unwrap().errors_at(hz).unwrap()[1];
        println!("at {hz} Hz gain {gain:.4}, phase {:.2} of its standard error", phase / stated);
        assert!((gain - 1.0).abs() < 0.06, "gain {gain} at {hz} Hz");
        assert!(phase.abs() < 1.96 * stated, "phase {phase} ± {stated} at {hz} Hz");
    }
    // The file is enough to read the same log in the same way.
    let fit = validate_plant(&log, &IdentifyOptions::default(), &plant).unwrap();
    let apart = fit.validation_fit - plant.evidence.fit.validation;
    assert!(apart.abs() < 1e-6, "{apart}");
}

/// A command in a column with the name of an angle, held from row to row, and the car's yaw rate; held or moving on.
fn angle(rate_hz: f64, is_held: bool, column: &str, intersample: Option<Intersample>) -> DriveLog {
    const STEPS: usize = 20;
    let f = Mat::from_fn(2, 2, |i, j| [[-6.0, -18.0], [0.9, -7.0]][i][j]);
    let g = Mat::from_fn(2, 1, |i, _| [80.0, 55.0][i]);
    let (a, b) = discretize(f.as_ref(), g.as_ref(), 1.0 / (rate_hz * STEPS as f64));
    let mut random = Random(8);
    let sines: Vec<(f64, f64)> = (0..60)
        .map(|k| (TAU * 0.05 * 60_f64.powf(f64::from(k) / 59.0), TAU * random.uniform()))
        .collect();
    let wanted = |t: f64| 0.003 * sines.iter().map(|(w, p)| (w * t + p).sin()).sum::<f64>();
    let mut csv = format!("time_s,{column},yaw_rate_radps,speed_mps\n");
    let mut x = [0.0; 2];
    for k in 0..(120.0 * rate_hz) as usize {
        let at = |step: f64| (k as f64 + step / STEPS as f64) / rate_hz;
        let u = wanted(at(0.0));
        let y = x[1] + 1e-3 * random.normal();
        writeln!(csv, "{:.4},{u:.9},{y:.9},20", at(0.0)).unwrap();
        for step in 0..STEPS {
            let u = if is_held { u } else { wanted(at(step as f64 + 0.5)) };
            x = [0, 1].map(|i| a[(i, 0)] * x[0] + a[(i, 1)] * x[1] + b[(i, 0)] * u);
        }
    }
    let options = LogOptions { steering_ratio: Some(1.0), intersample, ..LogOptions::default() };
    read_log(&[("angle.csv".into(), csv.into_bytes())], &options).unwrap()
}

/// A steering that moves on is seen to; one that is held may be late, so that it stays open, and the stated phase covers
/// the half sample; what is stated or named is not open.
#[test]
fn a_hold_that_the_log_does_not_show_widens_the_phase() {
    let moving = identify(&angle(10.0, false, ANGLE, None), &IdentifyOptions::default()).unwrap();
    let stated = moving.plant.uncertainty.as_ref().unwrap();
    assert_eq!(stated.open_hold_s, None);
    assert!(moving.plant.quality.grade == Grade::Pass, "{}", moving.plant.quality.summary);

    let log = angle(10.0, true, ANGLE, None);
    let held = identify(&log, &IdentifyOptions::default()).unwrap();
    let open = held.plant.uncertainty.as_ref().unwrap();
    assert!((open.open_hold_s.unwrap() - 0.1).abs() < 1e-6);
    let half_sample = TAU * 2.0 * 0.05;
    assert!(open.errors_at(2.0).unwrap()[1] > half_sample / 1.96);
    let quality = &held.plant.quality;
    assert!(quality.has(ReasonCode::UncertainPhase), "{}", quality.summary);
    assert!(quality.advice.iter().any(|a| a.contains("held between its samples")), "{quality:?}");
    let warnings = &held.plant.evidence.warnings;
    assert!(warnings.iter().any(|w| w.contains("read as held over 0.100 s")), "{warnings:?}");
    // The file is enough to read the same log in the same way.
    let fit = validate_plant(&log, &IdentifyOptions::default(), &held.plant).unwrap();
    let apart = fit.validation_fit - held.plant.evidence.fit.validation;
    assert!(apart.abs() < 1e-6, "{apart} {:?} {fit:?}", held.plant.evidence.fit);

    let command = "roadwheel_command_rad";
    for known in
        [angle(10.0, true, command, None), angle(10.0, true, ANGLE, Some(Intersample::Zoh))]
    {
        let plant = identify(&known, &IdentifyOptions::default()).unwrap().plant;
        let errors = plant.uncertainty.unwrap();
        assert!(errors.open_hold_s.is_none() && errors.errors_at(2.0).unwrap()[1] < 0.1);
        assert!(plant.quality.grade == Grade::Pass, "{}", plant.quality.summary);
    }
}

/// A command that was set more often than it was logged, held over the rows, would come after the yaw rate; the file reads
/// the same log in the same way.
#[test]
fn a_command_that_is_set_more_often_than_logged_moves_on() {
    let command = "roadwheel_command_rad";
    let moves_on = |log: &DriveLog| {
        let found = identify(log, &IdentifyOptions::default()).unwrap().plant;
        let warnings = &found.evidence.warnings;
        let seen = warnings.iter().any(|w| w.contains("set more often than it was logged"));
        (seen, found)
    };
    for rate_hz in [10.0, 20.0] {
        let log = angle(rate_hz, false, command, None);
        let (seen, plant) = moves_on(&log);
        println!("{rate_hz} Hz: {:?}", plant.evidence.warnings);
        assert!(seen);
        for fault in [ReasonCode::EarlyYawRate, ReasonCode::SteeringPlay] {
            assert!(!plant.quality.has(fault), "{}", plant.quality.summary);
        }
        let fit = validate_plant(&log, &IdentifyOptions::default(), &plant).unwrap();
        let apart = fit.validation_fit - plant.evidence.fit.validation;
        assert!(apart.abs() < 1e-6, "{apart}");
        assert!(!moves_on(&angle(rate_hz, true, command, None)).0);
        assert!(!moves_on(&angle(rate_hz, false, command, Some(Intersample::Zoh))).0);
    }
}

/// A bicycle of a held angle has the response of the car, the phase of half a period included, and reproduces its fit;
/// its grade knows what is open.
#[test]
fn a_bicycle_holds_the_steering_as_the_data_prefer() {
    let (options, validation) = (BicycleOptions::default(), IdentifyOptions::default());
    for (is_held, stated, passes) in
        [(true, None, false), (false, None, true), (true, Some(Intersample::Zoh), true)]
    {
        let log = angle(10.0, is_held, ANGLE, stated);
        let found = identify_bicycle(&log, &options).unwrap();
        let quality = &found.bicycle.quality;
        let is_uncertain = quality.has(ReasonCode::UncertainPhase);
        let is_advised = quality.advice.iter().any(|a| a.contains("held between its samples"));
        println!("{is_held} {stated:?}: {}", quality.summary);
        assert!(!quality.has(ReasonCode::LateYawRate), "half a sample is no late clock");
        assert_eq!((!is_uncertain, !is_advised), (passes, passes), "{is_held} {stated:?}");
        for hz in [0.3, 1.0, 2.0] {
            let ratio = response(&found.bicycle.vehicle, TAU * hz) / car(TAU * hz);
            let (gain, degrees) = (ratio.re.hypot(ratio.im), ratio.im.atan2(ratio.re) * 180.0 / PI);
            println!("at {hz} Hz gain {gain:.4}, phase {degrees:.3}°");
            assert!((gain - 1.0).abs() < 0.02, "{is_held} {stated:?}: gain {gain} at {hz} Hz");
            assert!(degrees.abs() < 2.0, "{is_held} {stated:?}: phase {degrees}° at {hz} Hz");
        }
        let fit = validate_bicycle(&log, &validation, &found.bicycle).unwrap().validation_fit;
        let apart = fit - found.bicycle.evidence.as_ref().unwrap().validation_fit;
        assert!(apart.abs() < 0.1, "{is_held} {stated:?}: {apart}");
        assert_eq!(found.traces.steering_rad, log.input);
    }
}

/// Yaw rate over road-wheel angle of eq 13 with its actuator.
fn response(vehicle: &VehicleData, omega: f64) -> c64 {
    let (m, j, v) = (vehicle.mass_kg, vehicle.yaw_inertia_kgm2, vehicle.speed_mps);
    let (lf, lr) = (vehicle.distance_front_m, vehicle.distance_rear_m);
    let (cf, cr) = (vehicle.cornering_stiffness_front_npr, vehicle.cornering_stiffness_rear_npr);
    let a = [
        [-(cf + cr) / (m * v), -v - (cf * lf - cr * lr) / (m * v)],
        [-(cf * lf - cr * lr) / (j * v), -(cf * lf * lf + cr * lr * lr) / (j * v)],
    ];
    let f = Mat::from_fn(2, 2, |i, k| a[i][k]);
    let s = c64::new(0.0, omega);
    let actuator = c64::cis(-omega * vehicle.actuator_delay_s)
        / (s * vehicle.actuator_time_constant_s + c64::new(1.0, 0.0));
    pencil(&f, &[cf / m, cf * lf / j], &[0.0, 1.0], s) * actuator
}
