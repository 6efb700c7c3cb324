//! Drives of a known vehicle at 100 Hz: decimated, in many segments, long.

use crate::common::vehicle;
use crate::drives::quick;
use crate::known::Random;
use faer::Mat;
use faer::linalg::solvers::Solve;
use std::f64::consts::PI;
use steerwright_drivelog::{DriveLog, LogOptions, read_log};
use steerwright_sysid::model::conversion::discretize;
use steerwright_sysid::{Detrend, IdentifyOptions, Intersample, fit_percent, identify};

/// The yaw rate of the states of [`vehicle`].
const H: [f64; 3] = [0.0, 1.0, 0.0];

/// Response of H(jωI − F)⁻¹G.
fn response(f: &Mat<f64>, g: &Mat<f64>, h: &[f64], omega: f64) -> (f64, f64) {
    let n = f.nrows();
    let big = Mat::from_fn(2 * n, 2 * n, |i, j| match (i < n, j < n) {
        (true, true) | (false, false) => -f[(i % n, j % n)],
        (true, false) if i == j - n => -omega,
        (false, true) if i - n == j => omega,
        _ => 0.0,
    });
    let rhs = Mat::from_fn(2 * n, 1, |i, _| if i < n { g[(i, 0)] } else { 0.0 });
    let x = big.partial_piv_lu().solve(&rhs);
    ((0..n).map(|i| h[i] * x[(i, 0)]).sum(), (0..n).map(|i| h[i] * x[(n + i, 0)]).sum())
}

/// A drive of the known vehicle at 100 Hz as CSV: a steering command held over each row.
fn known_drive(seconds: usize) -> Vec<u8> {
    let (f, g) = vehicle(12.0);
    let (a, b) = discretize(f.as_ref(), g.as_ref(), 0.01);
    let mut random = Random(11);
    let mut x = [0.0_f64; 3];
    let mut text = String::from("time_s,steer_rad,yaw_rate_radps,speed_mps\n");
    let (mut phase, mut level) = (0.0, 0.0);
    for k in 0..100 * seconds {
        let t = k as f64 * 0.01;
        let frequency = 0.2 * 15.0_f64.powf((t / 30.0).fract());
        phase += 2.0 * PI * frequency * 0.01;
        if k % 37 == 0 {
            level = 0.01 * random.normal();
        }
        let u = 0.03 * f64::sin(phase) + level;
        let y: f64 = (0..3).map(|i| H[i] * x[i]).sum();
        text += &format!("{t:.2},{u:.9},{:.9},20\n", y + 1e-4 * random.normal());
        x = std::array::from_fn(|i| (0..3).map(|j| a[(i, j)] * x[j]).sum::<f64>() + b[(i, 0)] * u);
    }
    text.into_bytes()
}

#[test]
fn decimation_biases_neither_gain_nor_phase_of_the_continuous_model() {
    let (f, g) = vehicle(12.0);
    let files = vec![("known.csv".to_owned(), known_drive(90))];
    for sample_time in [0.01, 0.04, 0.05] {
        let options = LogOptions {
            sample_time_s: Some(sample_time),
            steering_ratio: Some(1.0),
            intersample: Some(Intersample::Zoh),
            ..LogOptions::default()
        };
        let log = read_log(&files, &options).unwrap();
        let plant = identify(&log, &quick(3)).unwrap().plant;
        assert!(plant.evidence.fit.validation > 99.0, "{:?}", plant.evidence.fit);
        let c = plant.continuous.unwrap();
        let fi = Mat::from_fn(3, 3, |i, j| c.f.entry(i, j));
        let gi = Mat::from_fn(3, 1, |i, _| c.g.entry(i, 0));
        let hi: Vec<f64> = (0..3).map(|j| c.h.entry(0, j)).collect();
        for hertz in [0.3, 1.0, 2.0, 3.0] {
            let omega = 2.0 * PI * hertz;
            let (a, b) = (response(&f, &g, &H, omega), response(&fi, &gi, &hi, omega));
            let gain = b.0.hypot(b.1) / a.0.hypot(a.1);
            let phase = (b.1.atan2(b.0) - a.1.atan2(a.0) + 3.0 * PI).rem_euclid(2.0 * PI) - PI;
            println!(
                "T {sample_time} at {hertz} Hz: gain {gain:.4}, delay {:.2} ms",
                -1e3 * phase / omega
            );
            assert!((gain - 1.0).abs() < 0.02, "T {sample_time} at {hertz} Hz: gain {gain}");
            assert!((phase / omega).abs() < 1e-3, "T {sample_time} at {hertz} Hz: {phase} rad");
        }
    }
}

/// The known vehicle's log on its own grid.
fn known_log(seconds: usize) -> DriveLog {
    let options = LogOptions {
        sample_time_s: Some(0.01),
        intersample: Some(Intersample::Zoh),
        ..LogOptions::default()
    };
    read_log(&[("known.csv".into(), known_drive(seconds))], &options).unwrap()
}

/// Initial states are estimated for each segment; they are no evidence for another state.
#[test]
#[ignore = "slow: cargo xtask test"]
fn a_log_in_many_segments_has_the_order_of_the_whole() {
    let mut whole = known_log(160);
    let n = whole.len() / 200 * 200;
    whole.input.truncate(n);
    whole.output.truncate(n);
    whole.speed = None;
    whole.segments[0].range = 0..n;
    let pieces = (0..n)
        .step_by(200)
        .map(|k| steerwright_drivelog::Segment { time0_s: 0.01 * k as f64, range: k..k + 200 });
    let cut = DriveLog { segments: pieces.collect(), ..whole.clone() };
    let options =
        IdentifyOptions { delay_s: Some(0.0), feedthrough: Some(false), ..Default::default() };
    let order = |log: &DriveLog| identify(log, &options).unwrap().plant.order();
    assert_eq!([order(&cut), order(&whole)], [3; 2]);
}

/// Blocks of a long log estimate; all of it is simulated and reported.
#[test]
fn a_long_log_is_estimated_from_blocks() {
    let log = known_log(300);
    let options = IdentifyOptions {
        max_samples: Some(6000),
        delay_s: Some(0.0),
        detrend: Detrend::Mean,
        ..quick(3)
    };
    let found = identify(&log, &options).unwrap();
    let e = &found.plant.evidence;
    assert_eq!(e.estimation_samples, 6000);
    let warned = format!("6000 of {} estimation samples", log.len() - e.validation_samples);
    assert!(e.warnings.iter().any(|w| w.contains(&warned)), "{:?}", e.warnings);
    let all = identify(&log, &IdentifyOptions { max_samples: None, ..options }).unwrap();
    let apart = all.plant.evidence.fit.validation - e.fit.validation;
    assert!(apart.abs() < 0.01, "{apart}");
    let simulated = &found.traces.simulated_yaw_rate_radps;
    assert!(fit_percent(&log.output, simulated) > e.fit.validation - 0.1);
}
