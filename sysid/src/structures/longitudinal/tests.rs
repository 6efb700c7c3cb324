mod car;
mod response;
mod variation;

use super::options::LongitudinalOptions;
use super::{identify_longitudinal, validate_longitudinal};
use car::{Car, Drive};
use std::f64::consts::TAU;
use std::fmt::Write;
use steerwright_drivelog::{DriveLog, LogOptions, Response, read_log};
use steerwright_formats::{
    Document, Estimate, Grade, Intersample, Longitudinal, NORMAL_95, ReasonCode,
};

fn read(csv: &str) -> Result<DriveLog, String> {
    let options = LogOptions { response: Response::Speed, ..LogOptions::default() };
    let files = [("drive.csv".into(), csv.as_bytes().to_vec())];
    read_log(&files, &options).map_err(|e| e.to_string())
}

fn identify(csv: &str) -> Longitudinal {
    let log = read(csv).unwrap();
    identify_longitudinal(&log, &LongitudinalOptions::default()).unwrap()
}

fn grade_or_error(csv: &str) -> String {
    let log = match read(csv) {
        Ok(log) => log,
        Err(error) => return error,
    };
    match identify_longitudinal(&log, &LongitudinalOptions::default()) {
        Ok(model) => format!("{} {}", model.quality.grade, model.quality.codes()),
        Err(error) => {
            assert!(!error.hint().is_empty());
            error.to_string()
        }
    }
}

/// The estimates of a linear car with their true values.
fn estimates(model: &Longitudinal, car: &Car) -> Vec<(&'static str, Estimate, f64)> {
    let Drive::Linear(gain) = car.drive else { panic!("no linear car") };
    let mut all = vec![
        ("gain", model.gains[0].gain, gain),
        ("lag", model.time_constant_s, car.lag_s),
        ("delay", model.delay_s, car.delay_s),
        ("resistance", model.resistance_mps2, car.resistance_mps2),
        ("drag", model.drag_per_m, car.drag_per_m),
    ];
    if let Some(brake) = model.brake {
        all.push(("brake", brake.gain_mps2, car.brake_mps2));
        all.push(("brake lag", brake.time_constant_s, car.brake_lag_s));
        all.push(("brake delay", brake.delay_s, car.brake_delay_s));
    }
    if let Some(share) = model.grade_coefficient {
        all.push(("grade", share, 1.0));
    }
    all
}

#[test]
fn a_grade_of_the_other_sign_is_named_with_what_reverses_it() {
    let drive = Car { logs_grade: true, ..Car::linear() }.drive(2, 400.0);
    let channels = [("grade".to_owned(), "-grade".to_owned())].into();
    let options = LogOptions { response: Response::Speed, channels, ..LogOptions::default() };
    let log = read_log(&[("drive.csv".into(), drive.into_bytes())], &options).unwrap();
    let model = identify_longitudinal(&log, &LongitudinalOptions::default()).unwrap();
    assert!((model.grade_coefficient.unwrap().value + 1.0).abs() < 0.3);
    assert_eq!(model.quality.codes().to_string(), "unusual-parameter");
    let advice = &model.quality.advice;
    assert!(advice[0].starts_with("reverse the sign of the grade: --channel grade="), "{advice:?}");
    assert_eq!(advice.len(), 1, "{advice:?}");
}

/// An acceleration that was measured in place of a command pitches with the body, which moves no vehicle.
#[test]
fn what_noise_in_the_command_hides_of_the_gain_is_found_or_stated() {
    const GAIN: f64 = 0.95;
    for (noise, is_found) in [(0.4, true), (1.2, false)] {
        let mut random = car::Random::new(3);
        let mut csv = String::from("time_s,acceleration_command_mps2,speed_mps\n");
        let (mut wanted, mut acceleration, mut speed, mut phase) = (0.0, 0.0, 30.0, 0.0_f64);
        for k in 0..30_000 {
            if k % 300 == 0 {
                wanted = 2.0 * random.normal() - 0.1 * (speed - 30.0);
            }
            acceleration += 0.01 / 0.3 * (wanted - acceleration);
            phase += 0.01 * TAU * 6.0 + 0.2 * random.normal();
            let (measured, seen) =
                (acceleration + noise * phase.sin(), speed + 0.01 * random.normal());
            writeln!(csv, "{:.2},{measured:.5},{seen:.5}", 0.01 * f64::from(k)).unwrap();
            speed += 0.01 * GAIN * acceleration;
        }
        let model = identify(&csv);
        let gain = model.gains[0].gain.value;
        let codes = model.quality.codes().to_string();
        println!("{noise}: gain {gain:.3}, {codes}");
        if is_found {
            assert!((gain / GAIN - 1.0).abs() < 0.05, "{noise}: {gain}");
            assert_eq!(model.quality.grade, Grade::Pass, "{:?}", model.quality);
        } else {
            assert!((gain / GAIN - 1.0).abs() > 0.1, "{noise}: {gain}");
            assert!(codes.contains("uncertain-gain"), "{:?}", model.quality);
            assert!(model.quality.advice[0].contains("name the command"), "{:?}", model.quality);
        }
    }
}

/// Every row, or every one of a number of rows, of a log.
fn every(rows: usize, csv: &str) -> String {
    let kept = |(line, _): &(usize, &str)| *line == 0 || (line - 1).is_multiple_of(rows);
    csv.lines().enumerate().filter(kept).map(|(_, row)| format!("{row}\n")).collect()
}

/// A pedal that is held and one that moves on between its samples fit equally well, with half a period between their
/// delays.
#[test]
fn the_band_of_the_delay_covers_a_pedal_that_may_be_held() {
    let drive = Car { hills: 0.0, ..Car::linear() }.drive(1, 400.0);
    let with = |csv: &str, intersample| {
        let options =
            LogOptions { response: Response::Speed, intersample, ..LogOptions::default() };
        let log = read_log(&[("drive.csv".into(), csv.as_bytes().to_vec())], &options).unwrap();
        identify_longitudinal(&log, &LongitudinalOptions::default()).unwrap()
    };
    let tenth = every(5, &drive);
    let [open, moving_on, held] =
        [None, Some(Intersample::Bl), Some(Intersample::Zoh)].map(|stated| with(&tenth, stated));
    let widened = moving_on.delay_s.standard_error + 0.05 / NORMAL_95;
    assert!((open.delay_s.standard_error / widened - 1.0).abs() < 1e-9, "{:?}", open.delay_s);
    let apart = moving_on.delay_s.value - held.delay_s.value;
    assert!((apart - 0.05).abs() < 0.01, "{:?} {:?}", moving_on.delay_s, held.delay_s);
    let half = |model: &Longitudinal| NORMAL_95 * model.brake.unwrap().delay_s.standard_error;
    assert!(half(&open) > half(&moving_on) + 0.049);
    assert_eq!(open.quality.grade, Grade::Pass, "{:?}", open.quality);
    // Half of a second is too much to leave open.
    let slow = with(&every(25, &drive), None);
    let codes: Vec<ReasonCode> = slow.quality.reasons.iter().map(|reason| reason.code).collect();
    assert!(codes.contains(&ReasonCode::SlowLog), "{:?}", slow.quality);
    assert!(slow.quality.advice.iter().any(|line| line.contains("intersample")));
}

fn lacks_the_gear_alone(model: &Longitudinal) -> bool {
    model.quality.reasons.iter().map(|reason| reason.code).eq([ReasonCode::UnknownGear])
}

#[test]
fn a_linear_car_in_a_closed_loop_is_returned() {
    let car = Car { logs_grade: true, ..Car::linear() };
    let model = identify(&car.drive(1, 400.0));
    assert_eq!(model.quality.grade, Grade::Pass, "{:?}", model.quality);
    assert_eq!(model.pedal_curvature, None);
    assert_eq!(model.gains.len(), 1, "{:?}", model.gains);
    for (name, estimate, truth) in estimates(&model, &car) {
        let error = (estimate.value - truth).abs();
        assert!(error < 3.5 * estimate.standard_error, "{name}: {estimate:?} {truth}");
    }
    assert!(model.evidence.validation_fit > 85.0, "{:?}", model.evidence);
}

#[test]
#[ignore = "slow: cargo xtask test"]
fn the_bands_of_a_hundred_closed_loop_drives_contain_the_truth() {
    let mut counts: std::collections::BTreeMap<&str, [f64; 3]> = std::collections::BTreeMap::new();
    let mut rows = 0;
    for seed in 0..120 {
        let is_commanded = seed % 3 == 2;
        let car = Car {
            logs_grade: seed % 2 == 0,
            is_commanded,
            drive: Drive::Linear(if is_commanded { 0.95 } else { 3.2 }),
            ..Car::linear()
        };
        let model = identify(&car.drive(100 + seed, 300.0));
        rows += usize::from(model.gains.len() > 1);
        for (name, estimate, truth) in estimates(&model, &car) {
            if name == "gain" && model.gains.len() > 1 {
                continue;
            }
            let count = counts.entry(name).or_default();
            let error = estimate.value - truth;
            count[0] += 1.0;
            count[1] += f64::from(u8::from(error.abs() < 1.96 * estimate.standard_error));
            count[2] += error / estimate.standard_error;
        }
    }
    let (mut inside, mut all) = (0.0, 0.0);
    for (name, [count, own, bias]) in &counts {
        let (share, bias) = (100.0 * own / count, bias / count);
        eprintln!("{name}: {share:.0} % of {count} inside, mean error {bias:+.2} deviations");
        inside += own;
        all += count;
    }
    eprintln!("all: {:.1} %; tables of gains over the speed: {rows}", 100.0 * inside / all);
    let share = 100.0 * inside / all;
    assert!((90.0..=98.0).contains(&share), "{share}");
}

/// The gain of an engine varies at one speed, and that of a motor does not.
#[test]
fn gears_that_the_log_does_not_have_are_noticed() {
    let engine = Car::usual(3);
    let motor = Car::usual(1);
    assert!(matches!(engine.drive, Drive::Engine { .. }) && !engine.logs_gear);
    assert!(matches!(motor.drive, Drive::Motor { .. }));
    let [engine, motor] = [(engine, 3), (motor, 1)].map(|(car, seed)| car.drive(seed, 420.0));
    let model = identify(&engine);
    assert!(lacks_the_gear_alone(&model), "{:?}", model.quality);
    let variation = model.evidence.gain_variation.unwrap();
    assert!(variation.deviation > 0.1 && variation.log_likelihood_ratio > 10.0, "{variation:?}");
    // Who states one gear is told that the log shows more.
    let options = LongitudinalOptions { single_gear: true, ..LongitudinalOptions::default() };
    let stated = identify_longitudinal(&read(&engine).unwrap(), &options).unwrap();
    assert!(lacks_the_gear_alone(&stated), "{:?}", stated.quality);
    assert!(stated.quality.reasons[0].message.contains("one gear is stated"));
    let model = identify(&motor);
    assert_eq!(model.quality.grade, Grade::Pass, "{:?}", model.quality);
    // Its acceleration grows with the accelerator to the power of 0.86.
    assert!(model.pedal_curvature.unwrap().value > 0.3, "{:?}", model.pedal_curvature);
}

/// With what their users know: the gear of an engine is logged, and that an electric motor has one is stated.
#[test]
#[ignore = "slow: cargo xtask test"]
fn usual_vehicles_of_known_gears_pass() {
    let mut passed = 0;
    for seed in 0..24 {
        let car = Car::usual(seed);
        let (logs_gear, single_gear) =
            (matches!(car.drive, Drive::Engine { .. }), matches!(car.drive, Drive::Motor { .. }));
        let car = Car { logs_gear, ..car };
        let log = read(&car.drive(seed, 420.0)).unwrap();
        let options = LongitudinalOptions { single_gear, ..LongitudinalOptions::default() };
        let model = identify_longitudinal(&log, &options).unwrap();
        eprintln!("{seed} {:?}: {} {}", car.drive, model.quality.grade, model.quality.codes());
        passed += usize::from(model.quality.grade == Grade::Pass);
        if logs_gear {
            let stated = LongitudinalOptions { single_gear: true, ..options };
            let error = identify_longitudinal(&log, &stated).unwrap_err();
            assert!(error.to_string().contains("single gear"), "{error}");
        }
    }
    eprintln!("{passed} of 24 pass");
    assert!(passed >= 20, "{passed}");
}

#[test]
fn the_file_reproduces_the_stated_fit() {
    let csv = Car::usual(1).drive(3, 300.0);
    let log = read(&csv).unwrap();
    let options = LongitudinalOptions::default();
    let model = identify_longitudinal(&log, &options).unwrap();
    let file = Longitudinal::from_json(&model.to_json(), "longitudinal.json").unwrap();
    let fit = validate_longitudinal(&log, &options, &file).unwrap();
    let stated = model.evidence.validation_fit;
    assert!((fit - stated).abs() < 0.1, "{fit} {stated}");
}

#[test]
fn drives_without_information_are_refused_or_graded() {
    let drive = |row: &dyn Fn(f64) -> (f64, f64, f64)| {
        let mut csv = String::from("time_s,accelerator [1],brake [1],speed_mps\n");
        for k in 0..6000 {
            let t = 0.02 * f64::from(k);
            let (accelerator, brake, speed) = row(t);
            csv += &format!("{t:.2},{accelerator:.4},{brake:.4},{speed:.4}\n");
        }
        csv
    };
    let nothing = grade_or_error(&drive(&|_| (0.0, 0.0, 0.0)));
    assert!(nothing.contains("accelerator"), "{nothing}");
    let standing = grade_or_error(&drive(&|t| (0.1 * t.sin().max(0.0), 0.0, 0.0)));
    assert!(standing.contains("speed"), "{standing}");
    let constant = grade_or_error(&drive(&|t| (0.2, 0.0, 20.0 + 0.01 * (7.0 * t).sin())));
    assert!(constant.contains("accelerator"), "{constant}");
    // The pedal moves, and the speed does not follow it.
    let unrelated = grade_or_error(&drive(&|t| (0.2 + 0.1 * t.sin(), 0.0, 20.0 + (0.4 * t).sin())));
    assert!(!unrelated.starts_with("pass"), "{unrelated}");
    let reversing = grade_or_error(&drive(&|t| (0.2 + 0.1 * t.sin(), 0.0, -3.0 - t.sin())));
    assert!(reversing.contains("reverse"), "{reversing}");
    let one = grade_or_error("time_s,accelerator [1],brake [1],speed_mps\n0,0.1,0,12\n");
    assert!(one.contains("a log needs 100 or more"), "{one}");
    let gaps = Car::linear().drive(5, 200.0);
    let gaps: Vec<String> = gaps
        .lines()
        .enumerate()
        .map(|(i, line)| match i % 1500 > 1400 && i > 0 {
            true => format!("{},nan,nan,nan", line.split(',').next().unwrap_or_default()),
            false => line.to_owned(),
        })
        .collect();
    let gaps = grade_or_error(&gaps.join("\n"));
    assert!(gaps.starts_with("pass") || gaps.starts_with("warn"), "{gaps}");
}

#[test]
fn wrong_signs_and_units_are_noticed() {
    let car = Car { is_commanded: true, drive: Drive::Linear(1.0), ..Car::linear() };
    let csv = car.drive(2, 200.0);
    let in_g = csv.replace("acceleration_command_mps2", "acceleration_command [g]");
    let in_g = grade_or_error(&in_g);
    assert!(in_g.starts_with("warn") && in_g.contains("implausible-gain"), "{in_g}");
    let reversed = identify_reversed(&csv);
    assert!(reversed.starts_with("fail") && reversed.contains("wrong-sign"), "{reversed}");
}

fn identify_reversed(csv: &str) -> String {
    let options = LogOptions {
        response: Response::Speed,
        input: Some("-acceleration_command_mps2".into()),
        ..LogOptions::default()
    };
    let files = [("drive.csv".into(), csv.as_bytes().to_vec())];
    let log = read_log(&files, &options).unwrap();
    let model = identify_longitudinal(&log, &LongitudinalOptions::default()).unwrap();
    format!("{} {}", model.quality.grade, model.quality.codes())
}

#[test]
fn a_log_of_another_response_is_refused() {
    let mut csv = String::from("time_s,delta_rad,yaw_rate_radps,speed_mps\n");
    for k in 0..400 {
        let t = 0.02 * f64::from(k);
        csv += &format!("{t:.2},{:.5},{:.5},15\n", 0.1 * t.sin(), t.sin());
    }
    let log = read_log(&[("yaw.csv".into(), csv.into_bytes())], &LogOptions::default()).unwrap();
    let error = identify_longitudinal(&log, &LongitudinalOptions::default()).unwrap_err();
    assert!(error.to_string().contains("read for the response yaw-rate"), "{error}");
}
