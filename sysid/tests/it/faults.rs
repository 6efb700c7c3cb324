//! Faults of a recording, each on the same drive of a known car: what is found, and what is advised.

use crate::known::Random;
use std::fmt::Write;
use steerwright_drivelog::{DriveLog, LogFile, LogOptions, read_log};
use steerwright_formats::{Bicycle, Grade, Plant, Quality, ReasonCode};
use steerwright_sysid::bicycle::{BicycleOptions, identify_bicycle};
use steerwright_sysid::{AccumulateOptions, Accumulated, IdentifyOptions, identify};

const PERIOD: f64 = 0.01;
const SPEED: f64 = 20.0;
const RATIO: f64 = 15.0;

/// What is wrong with a drive.
#[derive(Clone, Copy)]
struct Fault {
    /// Play at the road wheel, deg.
    play_deg: f64,
    /// The yaw rate is logged so much later than it was, s.
    late_s: f64,
    /// Seconds of slalom, and of straight after it.
    seconds: (f64, f64),
    /// Done to the logged yaw rate, rad/s, of row k.
    yaw_rate: fn(usize, f64) -> f64,
    /// Done to the logged steering-wheel angle, rad, of row k.
    steering: fn(usize, f64) -> f64,
}

const NONE: Fault = Fault {
    play_deg: 0.0,
    late_s: 0.0,
    seconds: (80.0, 0.0),
    yaw_rate: |_, r| r,
    steering: |_, d| d,
};

/// A linear single-track car (1500 kg, 2.7 m) at 20 m/s, steered by filtered noise of 1.1° at the road
/// wheel, with gusts and a gyro of 0.1 °/s noise; as CSV.
fn drive(fault: &Fault) -> String {
    let (m, i, l, lf, cf, cr) = (1500.0, 2500.0, 2.7, 1.3, 80e3, 90e3);
    let lr = l - lf;
    let mut random = Random(17);
    let (mut steer, mut wheel, mut gust) = ([0.0; 2], 0.0_f64, 0.0);
    let (mut vy, mut r) = (0.0_f64, 0.0_f64);
    let half = 0.5 * fault.play_deg.to_radians();
    let n = ((fault.seconds.0 + fault.seconds.1) / PERIOD) as usize;
    let (mut steering, mut yaw_rate) = (Vec::new(), Vec::new());
    for k in 0..n {
        let pull = if k as f64 * PERIOD < fault.seconds.0 { 0.16 * random.normal() } else { 0.0 };
        steer[0] += PERIOD / 0.15 * (pull - steer[0]);
        steer[1] += PERIOD / 0.15 * (steer[0] - steer[1]);
        gust += PERIOD / 0.3 * (0.06 * random.normal() - gust);
        steering.push(steer[1]);
        yaw_rate.push(r + 0.0017 * random.normal());
        wheel = wheel.clamp(steer[1] - half, steer[1] + half);
        for _ in 0..10 {
            let (af, ar) = (wheel - (vy + lf * r) / SPEED, -(vy - lr * r) / SPEED);
            let (ff, fr) = (cf * af, cr * ar);
            vy += 0.1 * PERIOD * ((ff + fr) / m - SPEED * r);
            r += 0.1 * PERIOD * ((lf * ff - lr * fr) / i + gust);
        }
    }
    let late = (fault.late_s / PERIOD).round() as isize;
    let mut csv = String::from("time_s,steering_wheel_angle_rad,yaw_rate_radps,speed_mps\n");
    for (k, angle) in steering.iter().enumerate() {
        let then = k as isize - late;
        if !(0..n as isize).contains(&then) {
            continue;
        }
        let (d, r) =
            ((fault.steering)(k, RATIO * angle), (fault.yaw_rate)(k, yaw_rate[then as usize]));
        writeln!(csv, "{:.2},{d:.9},{r:.9},{SPEED}", k as f64 * PERIOD).unwrap();
    }
    csv
}

fn log_options(ratio: f64) -> LogOptions {
    LogOptions { steering_ratio: Some(ratio), ..LogOptions::default() }
}

fn recorded(fault: &Fault, ratio: f64) -> DriveLog {
    read_log(&[("drive.csv".into(), drive(fault).into_bytes())], &log_options(ratio)).unwrap()
}

/// Identified from what was accumulated.
fn accumulated(fault: &Fault, ratio: f64) -> Plant {
    let csv = drive(fault);
    let options = AccumulateOptions { log: log_options(ratio), ..AccumulateOptions::default() };
    let drives = Accumulated::of_log(LogFile::of_bytes("drive.csv", csv.as_bytes()), &options);
    drives
        .unwrap()
        .identify(&IdentifyOptions { max_order: 3, ..IdentifyOptions::default() })
        .unwrap()
}

fn identified(log: &DriveLog) -> Plant {
    // The car is of order 2.
    let options = IdentifyOptions { max_order: 3, ..IdentifyOptions::default() };
    identify(log, &options).unwrap().plant
}

fn bicycle(log: &DriveLog) -> Bicycle {
    identify_bicycle(log, &BicycleOptions::default()).unwrap().bicycle
}

/// fault, what is found with its grade, words of the advice about it
type Case = (&'static str, Fault, f64, ReasonCode, Grade, &'static [&'static str]);

#[test]
#[ignore = "slow: cargo xtask test"]
fn each_fault_is_found_with_its_cause() {
    fn frozen(k: usize, r: f64) -> f64 {
        if (3000..3200).contains(&k) || (5000..5200).contains(&k) { 0.0123 } else { r }
    }
    fn zeroed(k: usize, r: f64) -> f64 {
        if (3000..3200).contains(&k) || (5000..5200).contains(&k) { 0.0 } else { r }
    }
    let cases: [Case; 14] = [
        (
            "yaw rate negated",
            Fault { yaw_rate: |_, r| -r, ..NONE },
            RATIO,
            ReasonCode::WrongSign,
            Grade::Fail,
            &["axes", "ISO 8855"],
        ),
        (
            "yaw rate in rad/s read as deg/s",
            Fault { yaw_rate: |_, r| r.to_radians(), ..NONE },
            RATIO,
            ReasonCode::ImplausibleGain,
            Grade::Fail,
            &["units", "ratio"],
        ),
        (
            "steering in rad read as deg",
            Fault { steering: |_, d| d.to_radians(), ..NONE },
            RATIO,
            ReasonCode::ImplausibleGain,
            Grade::Fail,
            &["rad read as deg"],
        ),
        (
            "steering wheel taken for the road wheel",
            NONE,
            1.0,
            ReasonCode::ImplausibleGain,
            Grade::Fail,
            &["steering wheel taken for the road wheel"],
        ),
        (
            "gyro frozen for 2 s, twice",
            Fault { yaw_rate: frozen, ..NONE },
            RATIO,
            ReasonCode::FrozenYawRate,
            Grade::Warn,
            &["gyro", "left out"],
        ),
        (
            "gyro zeroed for 2 s, twice",
            Fault { yaw_rate: zeroed, ..NONE },
            RATIO,
            ReasonCode::FrozenYawRate,
            Grade::Warn,
            &["gyro", "left out"],
        ),
        (
            "play of 2° at the steering wheel",
            Fault { play_deg: 2.0 / RATIO, ..NONE },
            RATIO,
            ReasonCode::SteeringPlay,
            Grade::Warn,
            &["play (lash)", "hunt"],
        ),
        (
            "play of 0.5° at the road wheel",
            Fault { play_deg: 0.5, ..NONE },
            RATIO,
            ReasonCode::SteeringPlay,
            Grade::Warn,
            &["play (lash)", "hunt", "period"],
        ),
        (
            "play of 2° at the road wheel",
            Fault { play_deg: 2.0, ..NONE },
            RATIO,
            ReasonCode::SteeringPlay,
            Grade::Fail,
            &["play (lash)"],
        ),
        (
            "gyro bias of 1 °/s",
            Fault { yaw_rate: |_, r| r + 0.0175, ..NONE },
            RATIO,
            ReasonCode::Offset,
            Grade::Warn,
            &["bias of the gyro", "standstill"],
        ),
        (
            "yaw rate quantised to 2 °/s",
            Fault { yaw_rate: |_, r| 0.0349 * (r / 0.0349).round(), ..NONE },
            RATIO,
            ReasonCode::CoarseResolution,
            Grade::Warn,
            &["resolution"],
        ),
        (
            "yaw rate 100 ms late",
            Fault { late_s: 0.1, ..NONE },
            RATIO,
            ReasonCode::LateYawRate,
            Grade::Warn,
            &["clocks"],
        ),
        (
            "yaw rate 100 ms early",
            Fault { late_s: -0.1, ..NONE },
            RATIO,
            ReasonCode::EarlyYawRate,
            Grade::Fail,
            &["clocks"],
        ),
        (
            "spikes, one every five seconds",
            Fault { yaw_rate: |k, r| if k % 500 == 7 { r + 1.0 } else { r }, ..NONE },
            RATIO,
            ReasonCode::Spikes,
            Grade::Warn,
            &["sensor"],
        ),
    ];
    let validate = |(name, fault, ratio, code, grade, words): Case| {
        let log = recorded(&fault, ratio);
        let mut of = vec![("plant", identified(&log).quality), ("bicycle", bicycle(&log).quality)];
        // Play and clocks need the samples themselves.
        let in_sums = !matches!(
            code,
            ReasonCode::SteeringPlay | ReasonCode::LateYawRate | ReasonCode::EarlyYawRate
        );
        if in_sums {
            of.push(("accumulated", accumulated(&fault, ratio).quality));
        }
        let missed = |(model, quality): (&str, Quality)| {
            println!("{name}, {model}: {:?}\n{:#?}", quality.reasons, quality.advice);
            let found = quality.reasons.iter().any(|r| r.code == code && r.grade == grade);
            let advised = quality.advice.iter().any(|a| words.iter().all(|word| a.contains(word)));
            (!(found && advised)).then(|| format!("{name}, {model}: {}", quality.codes()))
        };
        of.into_iter().filter_map(missed).collect::<Vec<_>>()
    };
    let missed: Vec<String> = std::thread::scope(|scope| {
        let threads = cases.map(|case| scope.spawn(move || validate(case)));
        threads.into_iter().flat_map(|thread| thread.join().unwrap()).collect()
    });
    assert!(missed.is_empty(), "{missed:#?}");
}

/// The same car without a fault passes.
#[test]
#[ignore = "slow: cargo xtask test"]
fn a_sound_drive_passes() {
    let log = recorded(&NONE, RATIO);
    let plant = identified(&log);
    assert_eq!(plant.quality.grade, Grade::Pass, "{:?}", plant.quality);
    assert_eq!(plant.evidence.held_out.unwrap().selection, "end");
    let quality = accumulated(&NONE, RATIO).quality;
    assert_eq!(quality.grade, Grade::Pass, "{quality:?}");
    let bicycle = bicycle(&log);
    assert_eq!(bicycle.quality.grade, Grade::Pass, "{:?}", bicycle.quality);
    assert_eq!(bicycle.evidence.unwrap().held_out.unwrap().selection, "end");
}

/// 12 s of slalom and 8 s straight: the slalom validates, and the blocks are stated.
#[test]
fn a_straight_at_the_end_does_not_validate() {
    let fault =
        Fault { seconds: (12.0, 8.0), yaw_rate: |_, r| 0.0087 * (r / 0.0087).round(), ..NONE };
    let log = recorded(&fault, RATIO);
    let found = bicycle(&log);
    let evidence = found.evidence.unwrap();
    println!("bicycle: {} {:?}", evidence.validation_fit, found.quality);
    assert_eq!(evidence.held_out.unwrap().selection, "excited-blocks");
    assert!(evidence.validation_fit > 80.0 && found.quality.allows_design());
    let plant = identified(&log);
    let validation = plant.evidence.held_out.unwrap();
    println!("{:?} {validation:?} {:?}", plant.evidence.fit, plant.quality);
    assert_eq!(validation.selection, "excited-blocks");
    assert!(validation.segments_s.iter().all(|[_, to]| *to < 14.0), "{:?}", validation.segments_s);
    assert!(plant.evidence.fit.validation > 80.0, "{:?}", plant.evidence.fit);
    let bound = validation.fit_bound.unwrap();
    assert!(bound > plant.evidence.fit.validation && bound < 100.0, "{bound}");
    assert!(plant.quality.allows_design(), "{:?}", plant.quality);
}

/// Three spikes are handled as missing samples, and reported with their instants: the model is that of
/// the drive without them.
#[test]
fn a_few_spikes_change_nothing() {
    fn spiked(k: usize, r: f64) -> f64 {
        if [2000, 5000, 7000].contains(&k) { r - 2.0 } else { r }
    }
    let [sound, plant] = [NONE, Fault { yaw_rate: spiked, ..NONE }]
        .map(|fault| identified(&recorded(&fault, RATIO)));
    let channel = plant.evidence.channels.iter().find(|c| c.role == "yaw_rate").unwrap();
    assert_eq!(channel.spikes_s, [20.0, 50.0, 70.0]);
    let warned = plant.evidence.warnings.iter().any(|w| w.contains("20.000 s, 50.000 s, 70.000 s"));
    assert!(warned, "{:?}", plant.evidence.warnings);
    let apart = plant.evidence.fit.validation - sound.evidence.fit.validation;
    assert!(apart.abs() < 0.05, "{apart}");
    assert_eq!(plant.quality.grade, Grade::Pass, "{:?}", plant.quality);
}
