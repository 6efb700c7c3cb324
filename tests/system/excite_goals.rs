//! `excite --goal`: understeer gradient and tyre limit from the command line, from the design to the model of the recording of
//! another car than that of the design.

use crate::excite::{Random, resampled};
use crate::support::{document, read_json, run, text_of};
use std::fmt::Write;
use std::path::Path;
use steerwright_formats::{Document, Manoeuvre, ManoeuvreGoal, Vehicle};
use steerwright_models::NonlinearVehicle;
use steerwright_models::files::nonlinear_parameters;

const DT: f64 = 0.01;
const NOISE: f64 = 0.0015;
const SHEET: &str = "{data}/multibody/vehicle.json";

/// The log of a vehicle that is steered and driven as a table states, with noise.
fn record(vehicle: &Vehicle, table: &Path, seed: u64) -> String {
    let [steering, speed] = ["steering_rad", "speed_mps"].map(|name| resampled(table, name));
    let mut plant = NonlinearVehicle::new(nonlinear_parameters(vehicle)).unwrap();
    plant.speed = speed[0];
    plant.start().unwrap();
    let mut random = Random(seed);
    let mut text = String::from("time_s,steering_rad,yaw_rate_radps,speed_mps\n");
    for (k, (angle, speed)) in steering.iter().zip(&speed).enumerate() {
        let yaw_rate = plant.yaw_rate() + NOISE * random.normal();
        writeln!(text, "{:.2},{angle:.7},{yaw_rate:.7},{speed:.4}", k as f64 * DT).unwrap();
        (plant.steering_angle, plant.speed) = (*angle, *speed);
        plant.step(DT).unwrap();
    }
    text
}

/// The car of the data sheet with tyres that have no sensitivity to load, which the identification leaves out.
fn sheet() -> Vehicle {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/examples/drives/multibody/vehicle.json");
    let mut vehicle: Vehicle = document(Path::new(folder));
    vehicle.tyres.friction_load_sensitivity = 0.0;
    vehicle.tyres.stiffness_load_sensitivity = 0.0;
    vehicle
}

#[test]
fn the_recording_of_a_tyre_limit_determines_the_friction_of_another_car() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    let designed = sheet();
    std::fs::write(at("sheet.json"), designed.to_json()).unwrap();
    let mut car = designed;
    car.tyres.friction_coefficient *= 0.94;
    car.tyres.cornering_stiffness_front_npr *= 1.04;
    let options = "--goal tyre-limit --speed 20m/s --time 80s --max-lateral-acceleration 7m/s2 --noise 0.0015rad/s --friction-error 20% --uncertainty 5%";
    let output = run(folder.path(), &format!("excite sheet.json {options} -o drive"));
    println!("{}", text_of(&output));
    assert_eq!(output.status.code(), Some(0), "{}", text_of(&output));
    assert!(text_of(&output).contains("--structure single-track"), "{}", text_of(&output));
    let manoeuvre: Manoeuvre = document(&at("drive/excitation.json"));
    assert_eq!(manoeuvre.purpose.goal, ManoeuvreGoal::TyreLimit);
    let page = std::fs::read_to_string(at("drive/excitation.html")).unwrap();
    assert!(page.contains("Friction coefficients of"), "no friction on the page");
    std::fs::write(at("log.csv"), record(&car, &at("drive/excitation.csv"), 1)).unwrap();
    let ratio = car.actuator.steering_ratio;
    let found = run(
        folder.path(),
        &format!(
            "identify log.csv --steering-ratio {ratio} --structure single-track -o found.json"
        ),
    );
    println!("{}", text_of(&found));
    let found: Vehicle = document(&at("found.json"));
    let stated = |name: &str| {
        let own = manoeuvre.expected.parameters.iter().find(|p| p.name == name).unwrap();
        own.standard_error / own.value
    };
    let (a, b) = (&found.tyres, &car.tyres);
    for (name, error) in [
        ("friction_coefficient_front", a.friction_coefficient / b.friction_coefficient - 1.0),
        (
            "friction_coefficient_rear",
            a.friction_coefficient * a.friction_balance_rear
                / (b.friction_coefficient * b.friction_balance_rear)
                - 1.0,
        ),
    ] {
        println!("{name}: {error} of {}", stated(name));
        assert!(error.abs() < 4.0 * stated(name), "{name}: {error} of {}", stated(name));
    }
    assert!(found.evidence.unwrap().yaw_rate_noise_density.unwrap() > 0.0);
}

#[test]
fn the_understeer_gradient_is_driven_at_two_speeds() {
    let folder = tempfile::tempdir().unwrap();
    let sheet = "excite {data}/multibody/vehicle.toml --goal understeer --time 80s";
    let output = run(folder.path(), &format!("{sheet} --speeds 10..25 --understeer-error 1deg/g"));
    let text = text_of(&output);
    assert_eq!(output.status.code(), Some(0), "{text}");
    assert!(text.contains("understeer gradient of") && text.contains("deg/g: met"), "{text}");
    assert!(text.contains("--structure bicycle --validation-place end"), "{text}");
    let file = &read_json(&folder.path().join("excitation/excitation.json"));
    assert_eq!(file["purpose"]["goal"], "understeer");
    assert_eq!(file["signals"].as_array().unwrap().len(), 2);
    let output =
        run(folder.path(), &format!("{sheet} --speed 15m/s --understeer-error 0.01deg/g --force"));
    let text = text_of(&output);
    assert_eq!(output.status.code(), Some(1), "{text}");
    assert!(text.contains("state two with --speeds"), "{text}");
    assert!(text.contains("deg/g: not met"), "{text}");
}

#[test]
fn a_goal_that_does_not_fit_is_named_with_what_to_do() {
    let folder = tempfile::tempdir().unwrap();
    for (options, message, hint) in [
        (
            "--goal tyre-limit",
            "lateral acceleration must be stated",
            "--max-lateral-acceleration 7",
        ),
        ("--goal understeer --friction-error 5%", "--friction-error", "--goal tyre-limit"),
        ("--response-error 5% --goal understeer", "--response-error", "leave --response-error out"),
        ("--understeer-error 5%", "deg/g or rad.s2/m", "--help"),
        ("--goal grip", "tyre-limit", "--help"),
    ] {
        let output = run(folder.path(), &format!("excite {SHEET} {options}"));
        let text = text_of(&output);
        assert_eq!(output.status.code(), Some(2), "{options}: {text}");
        assert!(text.contains(message) && text.contains(hint), "{options}: {text}");
    }
    // A gentle drive leaves the friction to its prior, and a required error unmet.
    let gentle =
        "--goal tyre-limit --time 40s --max-lateral-acceleration 1m/s2 --friction-error 2%";
    let output = run(folder.path(), &format!("excite {SHEET} {gentle}"));
    let text = text_of(&output);
    assert_eq!(output.status.code(), Some(1), "{text}");
    assert!(text.contains("required ±2.00 %: not met"), "{text}");
    assert!(text.contains("hardly determines the friction"), "{text}");
}

#[test]
fn a_time_that_is_not_used_is_named() {
    let folder = tempfile::tempdir().unwrap();
    for (time, is_named) in [("60s", true), ("80s", false)] {
        let line = format!("excite {{data}}/multibody/vehicle.toml --time {time} -o {time}");
        let text = text_of(&run(folder.path(), &line));
        assert_eq!(text.contains("40 s of the 60 s are used"), is_named, "{text}");
    }
}
