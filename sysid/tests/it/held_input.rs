//! The steering of a slow log, which the model takes as held over each sample.

use crate::known::Random;
use faer::linalg::solvers::Solve;
use faer::{Mat, c64};
use std::f64::consts::{PI, TAU};
use std::fmt::Write;
use steerwright_drivelog::{DriveLog, LogOptions, read_log};
use steerwright_sysid::{IdentifyOptions, Intersample, identify, validate_plant};

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

/// Samples of a steering angle of many sines up to 3 Hz and of the car's yaw rate.
fn log(rate_hz: f64, seconds: f64) -> DriveLog {
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
        let f = Mat::from_fn(n, n, |i, j| c.f.at(i, j));
        let g: Vec<f64> = (0..n).map(|i| c.g.at(i, 0)).collect();
        let h: Vec<f64> = (0..n).map(|j| c.h.at(0, j)).collect();
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
        assert!(apart.abs() < 0.02, "{rate_hz} Hz: {apart}");
        // What is shown is the angle that was read.
        assert_eq!(found.traces.steering_rad, log.input);
    }
}
