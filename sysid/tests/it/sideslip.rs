//! The sideslip from fixes and gyro, on drives whose truth is known.

use crate::common::{car, data};
use crate::known::Random;
use std::f64::consts::TAU;
use std::fmt::Write;
use steerwright_drivelog::{LogOptions, read_log};
use steerwright_formats::{Grade, ReasonCode};
use steerwright_models::{BicyclePlant, Sideslip};
use steerwright_sysid::sideslip::{FromFixes, sideslip};

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
    /// Samples between fixes.
    fix_every: usize,
    /// Every so many fixes one is twenty metres off.
    outlier: usize,
    /// How much the speed changes to either side, m/s.
    swing: f64,
    /// Age of a fix at the time that the log states, s.
    latency: f64,
    /// What the speed is shown as, over what it is.
    speed_scale: f64,
}

const DRIVE: Drive = Drive {
    seconds: 240.0,
    seed: 1,
    steering: 0.03,
    fix_std: 0.02,
    antenna_x: 0.0,
    degrees: false,
    fix_every: 10,
    outlier: usize::MAX,
    swing: 0.0,
    latency: LATENCY,
    speed_scale: 1.0,
};

/// What is driven.
trait Vehicle {
    /// A sample further.
    fn advance(&mut self, steering: f64);
    /// Takes a speed, m/s.
    fn drive_at(&mut self, speed: f64);
    /// x, y, yaw and yaw rate.
    fn seen(&self) -> [f64; 4];
}

impl Vehicle for BicyclePlant {
    fn advance(&mut self, steering: f64) {
        self.steering_angle = steering;
        self.step(H).unwrap();
    }

    fn drive_at(&mut self, speed: f64) {
        self.speed = speed;
    }

    fn seen(&self) -> [f64; 4] {
        [self.x(), self.y(), self.yaw(), self.yaw_rate()]
    }
}

fn bicycle() -> BicyclePlant {
    let mut plant = BicyclePlant::new(car()).unwrap();
    plant.speed = SPEED;
    plant.initial_yaw = 2.0;
    plant.start().unwrap();
    plant
}

/// A point that moves by β = (S + Q·a²)·r + C·ṙ to the letter, its yaw rate 8 1/s times the steering
/// by a second order.
#[derive(Default)]
struct Point {
    s: f64,
    q: f64,
    c: f64,
    /// x, y, yaw, yaw rate and its derivative.
    state: [f64; 5],
}

impl Vehicle for Point {
    fn advance(&mut self, steering: f64) {
        const PARTS: u32 = 20;
        let (h, [x, y, yaw, rate, turning]) = (H / f64::from(PARTS), &mut self.state);
        for _ in 0..PARTS {
            *turning += h * (64.0 * (8.0 * steering - *rate) - 11.0 * *turning);
            *rate += h * *turning;
            *yaw += h * *rate;
            let slip = (self.s + self.q * (SPEED * *rate).powi(2)) * *rate + self.c * *turning;
            let middle = *yaw - 0.5 * h * *rate;
            *x += h * SPEED * (middle.cos() - slip * middle.sin());
            *y += h * SPEED * (middle.sin() + slip * middle.cos());
        }
    }

    fn drive_at(&mut self, speed: f64) {
        assert!((speed - SPEED).abs() < 1e-12);
    }

    fn seen(&self) -> [f64; 4] {
        let [x, y, yaw, rate, _] = self.state;
        [x, y, yaw, rate]
    }
}

/// The drive's log: gyro with bias and noise at 100 Hz, fixes at 10 Hz that are logged 0.1 s late.
fn logged(d: Drive, options: &LogOptions) -> FromFixes {
    logged_of(&mut bicycle(), d, options)
}

fn logged_of(vehicle: &mut impl Vehicle, d: Drive, options: &LogOptions) -> FromFixes {
    let mut random = Random(d.seed);
    let mut drive = String::from("time_s,roadwheel_angle_rad,yaw_rate_radps,speed_mps\n");
    let mut fixes = String::from(match d.degrees {
        true => "time_s,latitude_deg,longitude_deg\n",
        false => "time_s,x_m,y_m\n",
    });
    let (mut phase, mut level) = (0.0, 0.0);
    for k in 0..(d.seconds / H) as usize {
        let t = k as f64 * H;
        let [x, y, yaw, rate] = vehicle.seen();
        if k % d.fix_every == 0 {
            let wrong = if k / d.fix_every % d.outlier == d.outlier - 1 { 20.0 } else { 0.0 };
            let x = x + d.antenna_x * yaw.cos() + d.fix_std * random.normal() + wrong;
            let y = y + d.antenna_x * yaw.sin() + d.fix_std * random.normal();
            let logged = t + d.latency;
            let _ = match d.degrees {
                // On a ball: a kilometre or two, to a few parts in a thousand.
                true => writeln!(
                    fixes,
                    "{logged:.2},{:.10},{:.10}",
                    48.0 + y / 111_200.0,
                    11.0 + x / (111_320.0 * 48.0_f64.to_radians().cos())
                ),
                false => writeln!(fixes, "{logged:.2},{x:.5},{y:.5}"),
            };
        }
        // A sweep from 0.1 to 1 Hz, and random steps.
        phase += TAU * H * 0.1 * 10.0_f64.powf((t / 25.0).fract());
        if k % 150 == 149 {
            level = 0.3 * d.steering * random.normal();
        }
        let command = d.steering * phase.sin() + level;
        let rate = rate + 0.005 + 0.003 * random.normal();
        let steering = command + 1e-5 * random.normal();
        let speed_at = |t: f64| SPEED + d.swing * (TAU * t / 23.0).sin();
        let speed = speed_at(t);
        let shown =
            d.speed_scale * speed + if d.swing > 0.0 { 0.02 * random.normal() } else { 0.0 };
        let _ = writeln!(drive, "{t:.2},{steering:.7},{rate:.7},{shown:.4}");
        // The plant holds it over the step.
        vehicle.drive_at(speed_at(t + 0.5 * H));
        vehicle.advance(command);
    }
    let files =
        [("drive.csv".into(), drive.into_bytes()), ("fixes.csv".into(), fixes.into_bytes())];
    of(&files, options)
}

/// The sideslip of a log, and what its reading and the fixes were reported with.
fn of(files: &[(String, Vec<u8>)], options: &LogOptions) -> FromFixes {
    let log = read_log(files, options).unwrap();
    let found = sideslip(&log);
    FromFixes { warnings: [&*log.warnings, &found.warnings].concat(), ..found }
}

fn stated_age() -> LogOptions {
    LogOptions { gnss_latency_s: Some(LATENCY), ..LogOptions::default() }
}

/// The module's own standard error is that of noise. The part of the transients that the three terms do
/// not represent is an additional bias, here below 2 ms and 1 ms².
#[test]
fn the_sideslip_of_a_known_vehicle_is_found() {
    let truth = car().sideslip_per_yaw_rate(SPEED);
    assert!(truth.abs() > 0.02, "{truth}");
    let seeds = 6;
    let (mut mean, mut squares, mut claimed) = (0.0, 0.0, 0.0);
    for seed in 1..=seeds {
        let found = logged(Drive { seed, ..DRIVE }, &stated_age()).sideslip.unwrap();
        let off = found.sideslip_per_yaw_rate_s - truth;
        println!("{truth:.4}: {off:.5} off, standard error {:.5}", found.standard_error_s);
        mean += off / seeds as f64;
        squares += off * off / seeds as f64;
        claimed += found.standard_error_s.powi(2) / seeds as f64;
        assert_eq!(found.gnss_latency_s, LATENCY);
        // Tyres that never saturate.
        assert_eq!(found.sideslip_growth_s5pm2, None);
        assert!((found.per_yaw_acceleration() - lead_of_a_bicycle()).abs() < 0.001, "{found:?}");
    }
    assert!(mean.abs() < 0.002, "{mean}");
    let scatter = (squares - mean * mean).max(0.0).sqrt();
    assert!(claimed.sqrt() < 0.002 && scatter < 2.5 * claimed.sqrt(), "{scatter} {claimed}");
}

/// C of the two-wheel model: by the moments about the front axle the rear tyres' slip is
/// `(m·Lf·(v̇_y + v·r) − I·ṙ)/(Cr·L)`, and β̇ = S·ṙ to first order.
fn lead_of_a_bicycle() -> f64 {
    let p = car();
    let s = p.sideslip_per_yaw_rate(SPEED);
    let stiffness = p.cornering_stiffness_rear * (p.distance_front + p.distance_rear);
    (p.yaw_inertia - p.mass * p.distance_front * SPEED * s) / stiffness
}

/// Where the speed varies b is found, too: of many drives the mean is near the truth, they scatter by what
/// each drive claims, and the law is that of the vehicle at other speeds.
#[test]
fn a_varying_speed_determines_the_distance_to_the_rear_axle() {
    let law = car().sideslip(SPEED);
    let seeds = 6;
    let (mut mean, mut squares, mut claimed) = (0.0, 0.0, 0.0);
    for seed in 1..=seeds {
        let found = logged(Drive { seed, swing: 6.0, ..DRIVE }, &stated_age()).sideslip.unwrap();
        let distance = found.distance_rear_m.expect("b");
        let found_law = Sideslip {
            per_yaw_rate: found.sideslip_per_yaw_rate_s,
            growth: found.growth(),
            per_yaw_acceleration: found.per_yaw_acceleration(),
            reference_speed: SPEED,
            distance_rear: distance.value,
        };
        println!("{found:?}");
        for speed in [8.0, 15.0, 25.0] {
            let off = found_law.at_speed(speed).per_yaw_rate - law.at_speed(speed).per_yaw_rate;
            println!("  {speed} m/s: {:.4} s, {off:.4} off", law.at_speed(speed).per_yaw_rate);
            assert!(off.abs() < 0.012, "{speed} m/s: {off}");
        }
        let off = distance.value - law.distance_rear;
        mean += off / seeds as f64;
        squares += off * off / seeds as f64;
        claimed += distance.standard_error.powi(2) / seeds as f64;
    }
    let scatter = (squares - mean * mean).max(0.0).sqrt();
    // However much: a constant S of such a drive would be too uncertain to be stated.
    let wide = Drive { swing: 9.0, seconds: 80.0, ..DRIVE };
    let wide = logged(wide, &stated_age()).sideslip.unwrap();
    println!("{wide:?}");
    let off = wide.distance_rear() - law.distance_rear;
    assert!(off.abs() < 0.1, "{wide:?}");
    println!("{mean:.3} m off, scatter {scatter:.3}, claimed {:.3}", claimed.sqrt());
    assert!(mean.abs() < 0.06 && scatter < 2.5 * claimed.sqrt(), "{mean} {scatter} {claimed}");
}

/// An antenna ahead is further ahead of the rear axle, and that is corrected.
#[test]
fn the_distance_to_the_rear_axle_is_that_of_the_centre_of_gravity() {
    let drive = Drive { antenna_x: 1.2, swing: 6.0, ..DRIVE };
    let distance = |antenna_x_m: f64| {
        let options = LogOptions { antenna_x_m, ..stated_age() };
        logged(drive, &options).sideslip.unwrap().distance_rear_m.unwrap().value
    };
    let (ignored, known) = (distance(0.0), distance(1.2));
    println!("{ignored} {known}");
    assert!((ignored - known - 1.2).abs() < 1e-9, "{ignored} {known}");
    assert!((known - car().distance_rear).abs() < 0.15, "{known}");
}

/// A speed that hardly changes leaves b to the steering and to usual tyres, and the sideslip at other speeds is nearer
/// to the vehicle's than a constant one.
#[test]
fn a_steady_speed_leaves_the_distance_to_usual_tyres() {
    for (swing, antenna_x) in [(0.0, 0.0), (0.3, 0.0), (0.0, 1.2)] {
        let options = LogOptions { antenna_x_m: antenna_x, ..stated_age() };
        let from_fixes = logged(Drive { swing, antenna_x, ..DRIVE }, &options);
        let found = from_fixes.sideslip.unwrap();
        println!("{swing} m/s: {:?} {:?}", found.distance_rear_m, from_fixes.warnings);
        assert!((found.sideslip_per_yaw_rate_s - car().sideslip_per_yaw_rate(SPEED)).abs() < 0.005);
        assert!(from_fixes.warnings.iter().any(|w| w.contains("the speed changes too little")));
        let distance = found.distance_rear_m.unwrap();
        assert!((distance.value - car().distance_rear).abs() < 2.0 * distance.standard_error);
        assert!(distance.standard_error > 0.1, "{distance:?}");
        let law = Sideslip {
            per_yaw_rate: found.sideslip_per_yaw_rate_s,
            growth: 0.0,
            per_yaw_acceleration: 0.0,
            reference_speed: SPEED,
            distance_rear: distance.value,
        };
        for speed in [6.5, 8.0, 22.0, 30.0] {
            let truth = car().sideslip_per_yaw_rate(speed);
            let error = (law.at_speed(speed).per_yaw_rate - truth).abs();
            let of_constant = (law.per_yaw_rate - truth).abs();
            println!("{speed} m/s: {error:.4} s, constant {of_constant:.4} s");
            assert!(error < 0.5 * of_constant, "{speed} m/s: {error} {of_constant}");
        }
    }
}

/// All three of a vehicle that moves by them: of many drives the mean is the truth, and they scatter by
/// what each drive claims.
#[test]
fn growth_and_lead_are_found() {
    for (s, q, c) in [(0.04, -0.00101, 0.0033), (0.0044, -0.00141, 0.0042), (0.1, 0.0, 0.006)] {
        let seeds = 6;
        let (mut mean, mut squares, mut claimed) = ([0.0; 3], [0.0; 3], [0.0; 3]);
        for seed in 1..=seeds {
            let mut point = Point { s, q, c, ..Point::default() };
            let found =
                logged_of(&mut point, Drive { seed, ..DRIVE }, &stated_age()).sideslip.unwrap();
            println!("{found:?}");
            // What is nothing may be taken for something by chance, but only for little.
            let determined = found.sideslip_growth_s5pm2.is_some();
            assert!(determined || q == 0.0, "{found:?}");
            let growth = found.sideslip_growth_s5pm2.map_or(0.0, |term| term.standard_error);
            let lead = found.sideslip_per_yaw_acceleration_s2.unwrap();
            let off = [
                (found.sideslip_per_yaw_rate_s - s, found.standard_error_s),
                (found.growth() - q, growth),
                (lead.value - c, lead.standard_error),
            ];
            for (i, (off, error)) in off.into_iter().enumerate() {
                mean[i] += off / seeds as f64;
                squares[i] += off * off / seeds as f64;
                claimed[i] += error * error / seeds as f64;
            }
        }
        println!("{mean:?} {squares:?} {claimed:?}");
        for i in 0..3 {
            let scatter = (squares[i] - mean[i] * mean[i]).max(0.0).sqrt();
            if i == 1 && q == 0.0 {
                assert!(scatter < 0.0001, "{scatter}");
                continue;
            }
            assert!(mean[i].abs() <= [0.0012, 0.0001, 0.0003][i], "{i}: {mean:?}");
            assert!(scatter <= 2.0 * claimed[i].sqrt(), "{i}: {scatter} {claimed:?}");
            assert!(claimed[i].sqrt() < [0.004, 0.0004, 0.0006][i], "{i}: {claimed:?}");
        }
    }
}

/// The multi-body car of examples/drives, whose own states have S = 0.044 s, Q = −0.0009 s⁵/m² and C =
/// 0.0027 s² at this speed (evaluation/experiment): tyres that saturate, and a body that leads.
#[test]
fn a_multi_body_car_determines_all_three() {
    let read = |name: &str| (name.to_owned(), data(&format!("multibody/{name}")));
    let options = LogOptions {
        input: Some("steering_command_rad".into()),
        output: Some("yaw_rate_radps".into()),
        steering_ratio: Some(1.0),
        gnss_latency_s: Some(0.0),
        ..LogOptions::default()
    };
    let found = of(&[read("drive.csv"), read("position.csv")], &options);
    let found = found.sideslip.unwrap();
    println!("{found:?}");
    assert!((found.sideslip_per_yaw_rate_s - 0.044).abs() < 0.006, "{found:?}");
    assert!((found.growth() + 0.0009).abs() < 0.0006, "{found:?}");
    assert!((found.per_yaw_acceleration() - 0.0027).abs() < 0.001, "{found:?}");
}

/// A receiver of one fix a second has no shorter segments: the terms are those of the long ones.
#[test]
fn a_fix_a_second_will_do() {
    let (s, q, c) = (0.04, -0.00101, 0.0033);
    let mut point = Point { s, q, c, ..Point::default() };
    let drive = Drive { fix_every: 100, seconds: 600.0, ..DRIVE };
    let found = logged_of(&mut point, drive, &stated_age()).sideslip.unwrap();
    println!("{found:?}");
    assert!((found.sideslip_per_yaw_rate_s - s).abs() < 0.003, "{found:?}");
    assert!((found.growth() - q).abs() < 0.0003, "{found:?}");
    assert!((found.per_yaw_acceleration() - c).abs() < 0.0015, "{found:?}");
}

/// In gentle turns tyres do not saturate: the drive does not determine it, and S is as certain as ever.
#[test]
fn gentle_turns_determine_no_growth() {
    let mut point = Point { s: 0.04, q: -0.00101, c: 0.0033, ..Point::default() };
    let gentle = Drive { steering: 0.008, ..DRIVE };
    let found = logged_of(&mut point, gentle, &stated_age()).sideslip.unwrap();
    assert_eq!(found.sideslip_growth_s5pm2, None);
    assert!((found.sideslip_per_yaw_rate_s - 0.04).abs() < 0.004, "{found:?}");
    assert!(found.standard_error_s < 0.003, "{found:?}");
}

#[test]
fn latency_antenna_and_coordinates_count() {
    let truth = car().sideslip_per_yaw_rate(SPEED);
    let found = |d: Drive, options: &LogOptions| {
        logged(d, options).sideslip.unwrap().sideslip_per_yaw_rate_s
    };
    // Late fixes that are taken for prompt ones.
    let late = found(DRIVE, &LogOptions { gnss_latency_s: Some(0.0), ..LogOptions::default() });
    assert!((late - (truth - LATENCY)).abs() < 0.005, "{late}");
    let ahead = Drive { antenna_x: 1.2, ..DRIVE };
    let ignored = found(ahead, &stated_age());
    assert!((ignored - (truth + 1.2 / SPEED)).abs() < 0.004, "{ignored}");
    let known = found(ahead, &LogOptions { antenna_x_m: 1.2, ..stated_age() });
    assert!((known - truth).abs() < 0.004, "{known}");
    let degrees = found(Drive { degrees: true, ..DRIVE }, &stated_age());
    assert!((degrees - truth).abs() < 0.004, "{degrees}");
    let outliers = found(Drive { outlier: 97, ..DRIVE }, &stated_age());
    assert!((outliers - truth).abs() < 0.004, "{outliers}");
}

#[test]
fn what_fixes_do_not_determine_is_left_out_with_a_reason() {
    for (drive, why) in [
        (Drive { fix_std: 1.5, ..DRIVE }, "standard error would be"),
        (Drive { steering: 0.0005, ..DRIVE }, "standard error would be"),
        (Drive { seconds: 40.0, ..DRIVE }, "are too few"),
    ] {
        let log = logged(drive, &stated_age());
        assert_eq!(log.sideslip, None, "{why}");
        let warned = log.warnings.iter().any(|w| w.contains("no sideslip") && w.contains(why));
        assert!(warned, "{why}: {:?}", log.warnings);
    }
}

/// The age of fixes that is not stated is found where the speed changes, with its standard error, whatever
/// it is and whatever the speed's scale; the sideslip is then that of a stated age.
#[test]
#[ignore = "slow: cargo xtask test"]
fn an_age_that_is_not_stated_is_found_where_the_speed_changes() {
    for latency in [0.0, 0.1, 0.2] {
        for (speed_scale, fix_std) in [(1.0, 0.02), (1.03, 0.02), (0.98, 0.03)] {
            let seeds = 4;
            let (mut squares, mut claimed) = (0.0, 0.0);
            for seed in 1..=seeds {
                let d = Drive { seed, latency, swing: 4.0, speed_scale, fix_std, ..DRIVE };
                let log = logged(d, &LogOptions::default());
                let found = log.sideslip.expect("a sideslip");
                let stated = LogOptions { gnss_latency_s: Some(latency), ..LogOptions::default() };
                let with_age = logged(d, &stated).sideslip.expect("a sideslip");
                let error = found.gnss_latency_standard_error_s.expect("an error");
                println!(
                    "{latency} s, {speed_scale}, {fix_std} m: {:.4} ± {error:.4} s, S {:.4} ± {:.4}, with the age stated {:.4}",
                    found.gnss_latency_s,
                    found.sideslip_per_yaw_rate_s,
                    found.standard_error_s,
                    with_age.sideslip_per_yaw_rate_s
                );
                squares += (found.gnss_latency_s - latency).powi(2) / seeds as f64;
                claimed += error * error / seeds as f64;
                let off = found.sideslip_per_yaw_rate_s - with_age.sideslip_per_yaw_rate_s;
                assert!(off.abs() < 4.0 * found.standard_error_s, "{off} {found:?}");
                assert_eq!(with_age.gnss_latency_standard_error_s, None);
                assert!(log.warnings.iter().any(|w| w.contains("age of the fixes")), "{latency}");
            }
            let (scatter, claimed) = (f64::sqrt(squares), f64::sqrt(claimed));
            println!("  {scatter:.4} s off, {claimed:.4} s claimed");
            assert!(claimed < 0.01 && scatter < 1.5 * claimed, "{scatter} {claimed}");
        }
    }
}

/// 50 ms is seen; the right age, and a drive without speed changes, are not in doubt.
#[test]
fn a_stated_age_that_the_drive_contradicts_is_a_reason() {
    let changing = Drive { latency: 0.1, swing: 4.0, ..DRIVE };
    let constant = Drive { latency: 0.1, ..DRIVE };
    for (drive, stated, is_wrong) in [
        (changing, 0.1, false),
        (changing, 0.05, true),
        (changing, 0.15, true),
        (constant, 0.15, false),
    ] {
        let options = LogOptions { gnss_latency_s: Some(stated), ..LogOptions::default() };
        let fault = logged(drive, &options).fault;
        assert_eq!(fault.is_some(), is_wrong, "{stated}: {fault:?}");
        if let Some((reason, _)) = fault {
            assert_eq!((reason.code, reason.grade), (ReasonCode::AgeOfFixes, Grade::Warn));
            assert!(reason.message.contains("not 0.") && reason.message.contains(" as stated"));
        }
    }
}

/// At a constant speed an unknown age cannot be separated from the sideslip: none is stated, however
/// certain it would look.
#[test]
fn an_age_that_is_not_known_leaves_no_sideslip() {
    let log = logged(DRIVE, &LogOptions::default());
    assert_eq!(log.sideslip, None);
    let warned = log.warnings.iter().any(|w| w.contains("no sideslip") && w.contains("not stated"));
    assert!(warned, "{:?}", log.warnings);
    // Speed changes too small to see are no reason for one.
    let log = logged(Drive { swing: 0.05, ..DRIVE }, &LogOptions::default());
    assert!(log.sideslip.is_none(), "{:?} {:?}", log.sideslip, log.warnings);
}
