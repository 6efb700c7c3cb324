//! `excite`: files, errors, and a car whose first drive determines too little, from its advice to a model that passes.

use crate::support::{column, data, document, done, read_json, run, text_of};
use std::fmt::Write;
use std::path::Path;
use steerwright_formats::{Bicycle, Document, Manoeuvre, VehicleData};
use steerwright_models::BicyclePlant;
use steerwright_models::files::bicycle_parameters;

const DT: f64 = 0.01;
/// Standard deviation of the gyro, rad/s.
const NOISE: f64 = 0.0015;

fn car() -> VehicleData {
    VehicleData { steering_ratio: 16.9, ..VehicleData::default() }
}

/// Uniform and normal numbers from a linear congruential generator.
pub(crate) struct Random(pub(crate) u64);

impl Random {
    pub(crate) fn normal(&mut self) -> f64 {
        let mut sum = -6.0;
        for _ in 0..12 {
            let next = self.0.wrapping_mul(6_364_136_223_846_793_005);
            self.0 = next.wrapping_add(1_442_695_040_888_963_407);
            sum += (self.0 >> 11) as f64 / (1_u64 << 53) as f64;
        }
        sum
    }
}

/// A log of the car under steering angles and speeds, by the plant of the FMU.
fn log(steering: &[f64], speed: &[f64], seed: u64) -> String {
    let mut plant = BicyclePlant::new(bicycle_parameters(&car())).unwrap();
    let mut random = Random(seed);
    let mut text = String::from("time_s,steering_rad,yaw_rate_radps,speed_mps\n");
    for (k, (angle, speed)) in steering.iter().zip(speed).enumerate() {
        let yaw_rate = plant.yaw_rate() + NOISE * random.normal();
        writeln!(text, "{:.2},{angle:.7},{yaw_rate:.7},{speed:.4}", k as f64 * DT).unwrap();
        (plant.steering_angle, plant.speed) = (*angle, *speed);
        plant.step(DT).unwrap();
    }
    text
}

/// A column of a table with times, at the multiples of 10 ms.
pub(crate) fn resampled(file: &Path, name: &str) -> Vec<f64> {
    let text = std::fs::read_to_string(file).unwrap();
    let mut lines = text.lines();
    let place = lines.next().unwrap().split(',').position(|cell| cell == name).unwrap();
    let number = |cell: Option<&str>| -> f64 { cell.unwrap().parse().unwrap() };
    let rows: Vec<[f64; 2]> = lines
        .map(|line| [number(line.split(',').next()), number(line.split(',').nth(place))])
        .collect();
    let mut at = 0;
    let mut values = Vec::new();
    let mut time = rows[0][0];
    while time < rows[rows.len() - 1][0] {
        while rows[at + 1][0] <= time {
            at += 1;
        }
        values.push(rows[at][1]);
        time += DT;
    }
    values
}

/// The steering and the speed of the city drive, on a simulated car: its log determines too little, identify ends with the
/// command, and the recording of the manoeuvre that it designs passes.
#[test]
fn a_weak_log_leads_to_a_manoeuvre_whose_recording_passes() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    let city = data().join("comma2k19");
    let steering: Vec<f64> =
        resampled(&city.join("steering_wheel_angle.csv"), "steering_wheel_angle_deg")
            .into_iter()
            .map(f64::to_radians)
            .collect();
    let speed = resampled(&city.join("speed.csv"), "speed_mps");
    std::fs::write(at("city.csv"), log(&steering, &speed, 1)).unwrap();
    let identify = "--steering-ratio 16.9 --structure bicycle";
    let weak = run(folder.path(), &format!("identify city.csv {identify} -o weak.json"));
    assert_eq!(weak.status.code(), Some(1), "{}", text_of(&weak));
    let page = String::from_utf8_lossy(&weak.stdout);
    let verdict = page.lines().next().unwrap();
    assert!(verdict.ends_with("; next: steerwright excite weak.json"), "{page}");

    let options = "--speed 15m/s --time 120s --max-lateral-acceleration 3m/s2 --max-rate 400deg/s --road-width 7m";
    let designed = run(folder.path(), &format!("excite weak.json {options} -o drive"));
    assert_eq!(designed.status.code(), Some(0), "{}", text_of(&designed));
    let column = |name: &str| resampled(&at("drive/excitation.csv"), name);
    let recorded = log(&column("steering_rad"), &column("speed_mps"), 2);
    std::fs::write(at("second.csv"), recorded).unwrap();
    let found = run(folder.path(), &format!("identify second.csv {identify} -o found.json"));
    assert_eq!(found.status.code(), Some(0), "{}", text_of(&found));
    assert!(!text_of(&found).contains("steerwright excite"), "{}", text_of(&found));
    let quality = &read_json(&at("found.json"))["quality"];
    assert_eq!(quality["grade"], "pass", "{quality}");

    // By default the structure is chosen, and the advice is the same.
    let chosen = run(folder.path(), "identify city.csv --steering-ratio 16.9 --force");
    assert!(text_of(&chosen).contains("steerwright excite"), "{}", text_of(&chosen));
}

#[test]
fn files_are_written_by_the_ending_of_the_output() {
    let folder = tempfile::tempdir().unwrap();
    let sheet = "excite {data}/multibody/vehicle.toml";
    let output =
        run(folder.path(), &format!("{sheet} --speeds 12..20 --time 120s --max-angle 5deg"));
    assert_eq!(output.status.code(), Some(0), "{}", text_of(&output));
    assert!(
        text_of(&output).contains("10 % of each cornering stiffness are assumed"),
        "{}",
        text_of(&output)
    );
    let names = ["excitation.csv", "excitation.html", "excitation.json"];
    let read = |name: &str| std::fs::read_to_string(folder.path().join("excitation").join(name));
    let [csv, page, document] = names.map(|name| read(name).unwrap());
    let manoeuvre = Manoeuvre::from_json(&document, "excitation.json").unwrap();
    assert_eq!(csv.lines().count(), 12_001);
    assert!(csv.starts_with("time_s,steering_rad,speed_mps\n0.0000,"), "{}", &csv[..80]);
    let angle = manoeuvre.signals.iter().map(|s| s.peaks.angle_rad).fold(0.0, f64::max);
    assert!(angle <= 5_f64.to_radians() * (1.0 + 1e-9), "{angle}");
    for part in ["20.0 m/s", "Lateral acceleration".to_lowercase().as_str(), "yaw rate gain"] {
        assert!(page.contains(part), "{part}");
    }
    for (name, count) in [("a.json", 1), ("a.csv", 2), ("a.html", 3)] {
        let output = run(folder.path(), &format!("{sheet} --time 40s --by driver -o {name}"));
        assert_eq!(output.status.code(), Some(0), "{}", text_of(&output));
        let all = std::fs::read_dir(folder.path()).unwrap();
        let files = all.filter(|entry| entry.as_ref().unwrap().path().is_file());
        assert_eq!(files.count(), count, "{name}");
    }
    assert!(std::fs::read_to_string(folder.path().join("a.html")).unwrap().contains("metronome"));
}

/// The packed manoeuvre drives the packed vehicle: the angles are those of excitation.csv, and the log of the run gives the
/// vehicle back.
#[test]
fn the_packed_manoeuvre_makes_the_log_that_identifies_the_vehicle() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    let sheet = "{data}/multibody/vehicle.toml";
    done(here, &format!("bicycle {sheet} -o car.json"));
    done(here, &format!("excite {sheet} --speed 15m/s --time 80s --max-rate 0.4rad/s -o drive"));
    let checked = "package car.json drive/excitation.json --ssp Drive.ssp --out fmu";
    done(here, checked);
    done(here, "check fmu/Excitation.fmu --run --strict");
    done(here, "simulate fmu/Drive.ssp --stop 82s -o run.csv");
    let file: Manoeuvre = document(&here.join("drive/excitation.json"));
    let table = here.join("run.csv");
    let driven = column(&table, "Excitation.steering_angle");
    let expected: Vec<f64> = file
        .schedule
        .iter()
        .flat_map(|block| (0..file.block_samples()).map(|k| file.steering_rad(block, k)))
        .collect();
    let count = expected.len();
    assert_eq!(count, 8000);
    assert_eq!(driven[..count], expected[..]);
    assert_eq!(*column(&table, "Excitation.finished").last().unwrap(), 1.0);
    assert!(column(&table, "Excitation.interruption").iter().all(|code| *code == 0.0));

    let channels =
        "--input-channel Excitation.steering_angle --output-channel BicyclePlant.yaw_rate";
    let units = "--unit Excitation.steering_angle=rad --unit BicyclePlant.yaw_rate=rad/s --unit Excitation.speed_reference=m/s --unit time=s";
    let found = run(
        here,
        &format!(
            "identify run.csv {channels} --speed-channel Excitation.speed_reference {units} --steering-ratio 1 --structure bicycle -o found.json"
        ),
    );
    assert_eq!(found.status.code(), Some(0), "{}", text_of(&found));
    // At one speed the steady gain is known, not wheelbase and understeer, or lag and inertia, apart.
    let [truth, found] = ["car.json", "found.json"].map(|name| {
        let car: Bicycle = document(&here.join(name));
        let parameters = bicycle_parameters(&car.vehicle);
        15.0 / (parameters.wheelbase() + parameters.understeer_gradient() * 225.0)
    });
    println!("steady gain: {truth}, found {found}");
    assert!((found / truth - 1.0).abs() < 0.01, "{found} {truth}");
    assert_eq!(read_json(&here.join("found.json"))["quality"]["grade"], "pass");
}

#[test]
fn an_error_that_is_not_reached_is_a_requirement_not_met() {
    let folder = tempfile::tempdir().unwrap();
    let line =
        "excite {data}/multibody/vehicle.toml --time 40s --noise 5deg/s --response-error 0.5%";
    let output = run(folder.path(), line);
    assert_eq!(output.status.code(), Some(1), "{}", text_of(&output));
    let text = text_of(&output);
    assert!(text.contains("required ±0.50 %: not met; "), "{text}");
}

#[test]
fn what_it_cannot_take_is_named_with_what_to_do() {
    let folder = tempfile::tempdir().unwrap();
    let sheet = "{data}/multibody/vehicle.toml";
    for (line, message, hint) in [
        (format!("excite {sheet} --road-width 1.5m"), "the vehicle is 2 m wide", "--vehicle-width"),
        (format!("excite {sheet} --speeds 20..10"), "must be the lower", "10..25"),
        (
            format!("excite {sheet} --time 20s"),
            "time: 20 s is out of range",
            "a value that is expected",
        ),
        (format!("excite {sheet} --band 0.2..2m/s"), "Hz", "--help"),
        (format!("excite {sheet} --max-rate 20"), "deg/s or rad/s", "--help"),
    ] {
        let output = run(folder.path(), &line);
        let text = text_of(&output);
        assert_eq!(output.status.code(), Some(2), "{line}: {text}");
        assert!(text.contains(message) && text.contains(hint), "{line}: {text}");
    }
    let plant = "identify {data}/multibody/drive.csv --input-channel steering_command_rad --steering-ratio 1 --structure state-space -o plant.json";
    assert!(run(folder.path(), plant).status.success());
    let output = run(folder.path(), "excite plant.json");
    let text = text_of(&output);
    assert_eq!(output.status.code(), Some(2), "{text}");
    assert!(text.contains("plant.json: ") && text.contains("--structure bicycle"), "{text}");
    // No file was begun.
    assert!(!folder.path().join("excitation").exists());
}
