//! `identify --structure single-track`, and the FMU that comes of it.

use crate::support::{column, data, done, read_json, run, text_of};
use std::f64::consts::TAU;
use std::fmt::Write;
use std::path::Path;
use steerwright_formats::{Document, Vehicle};
use steerwright_models::{NonlinearParameters, NonlinearVehicle};

const STEP_S: f64 = 0.01;
const COUNT: u32 = 12_000;

/// Speed (m/s) and steering angle (rad) at a time: from gentle to the limit of grip.
fn inputs(t: f64) -> [f64; 2] {
    let speed = 18.0 + 8.0 * (TAU * 0.021 * t).sin();
    let swings = [(0.11, 0.0), (0.27, 1.0), (0.61, 2.0), (1.13, 0.5)];
    let sum: f64 = swings.iter().map(|(hz, phase)| (TAU * hz * t + phase).sin()).sum();
    let size = 1.4 + 0.6 * (TAU * 0.013 * t).sin();
    [speed, size * sum * (2.58 / (speed * speed) + 0.0004)]
}

/// Drives the car of examples/drives; its yaw rates.
fn record(file: &Path) -> Vec<f64> {
    let mut parameters = NonlinearParameters::default();
    parameters.tyres.combined_slip = 1.0;
    let mut car = NonlinearVehicle::new(parameters).unwrap();
    (car.speed, car.steering_angle) = (inputs(0.0)[0], 0.0);
    car.start().unwrap();
    let mut text = String::from(
        "time_s,steering_angle_rad,yaw_rate_radps,speed_mps,lateral_acceleration_mps2,vy_mps\n",
    );
    let mut yaw_rates = Vec::new();
    for k in 0..COUNT {
        let t = STEP_S * f64::from(k);
        let [speed, steering] = inputs(t);
        (car.speed, car.steering_angle) = (speed, steering);
        yaw_rates.push(car.yaw_rate());
        let (rate, acceleration) = (car.yaw_rate(), car.lateral_acceleration());
        let velocity = car.lateral_velocity();
        let _ = writeln!(
            text,
            "{t:.2},{steering:.7},{rate:.7},{speed:.5},{acceleration:.5},{velocity:.5}"
        );
        car.step(STEP_S).unwrap();
    }
    std::fs::write(file, text).unwrap();
    yaw_rates
}

/// `100·(1 − ‖y − ŷ‖/‖y − mean y‖)`.
fn fit(y: &[f64], y_hat: &[f64]) -> f64 {
    let mean = y.iter().sum::<f64>() / y.len() as f64;
    let sums = y
        .iter()
        .zip(y_hat)
        .fold([0.0; 2], |[e, s], (y, y_hat)| [e + (y - y_hat).powi(2), s + (y - mean).powi(2)]);
    100.0 * (1.0 - (sums[0] / sums[1]).sqrt())
}

#[test]
fn the_vehicle_is_identified_packed_and_follows_the_car() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    let measured = record(&at("drive.csv"));
    let output =
        run(folder.path(), "identify drive.csv --structure single-track --traces traces.csv");
    let text = text_of(&output);
    assert!(output.status.success(), "{text}");
    for part in ["steering ratio", "lateral acceleration, lateral velocity", "moved"] {
        assert!(text.contains(part), "{part}: {text}");
    }
    let vehicle =
        Vehicle::from_json(&std::fs::read_to_string(at("vehicle.json")).unwrap(), "it").unwrap();
    let evidence = vehicle.evidence.unwrap();
    let validation = evidence.validation.unwrap();
    assert!(validation.yaw_rate > 97.0, "{validation:?}");
    assert!(evidence.lateral_acceleration_mps2 > 5.0, "{}", evidence.lateral_acceleration_mps2);
    // The car's own numbers; its axles have roll and load transfer, which the model's have not.
    let known = NonlinearParameters::default();
    let wheelbase = known.body.distance_front_m + known.body.distance_rear_m;
    for (name, truth, tolerance) in [
        ("wheelbase", wheelbase, 0.01),
        ("front_share", known.body.distance_rear_m / wheelbase, 0.03),
        ("actuator_time_constant", known.actuator.time_constant_s, 0.1),
    ] {
        let found = evidence.parameters.iter().find(|p| p.name == name).unwrap();
        assert!((found.value / truth - 1.0).abs() < tolerance, "{name}: {found:?}, {truth}");
        assert!(found.is_determined, "{name}: {found:?}");
    }
    let validated = column(&at("traces.csv"), "simulated_yaw_rate_radps");
    let first = (column(&at("traces.csv"), "time_s")[0] / STEP_S).round() as usize;
    assert!(validated.len() > 11_900 && first < 100, "{}, {first}", validated.len());

    // In gentle driving it is a bicycle, on which a controller is designed over its uncertainty.
    done(folder.path(), "design vehicle.json");
    let pid = read_json(&at("pid.json"));
    assert_eq!(pid["designed_for"]["model"], "bicycle");
    assert_eq!(
        pid["designed_for"]["quality"]["grade"], "pass",
        "{}",
        pid["designed_for"]["quality"]
    );
    assert!(pid["evidence"]["robustness"].is_object(), "{}", pid["evidence"]);

    // The packed vehicle on the same drive is the model that was validated.
    let mut drive = String::from("time,steering_angle,speed\n");
    for k in 0..COUNT {
        let t = STEP_S * f64::from(k);
        // Held over a step: what the model takes for a line is that of the step's middle.
        let [speed, steering] = inputs(t + 0.5 * STEP_S);
        let _ = writeln!(drive, "{t:.2},{steering},{speed}");
    }
    std::fs::write(at("inputs.csv"), drive).unwrap();
    done(folder.path(), "package vehicle.json");
    done(
        folder.path(),
        "simulate NonlinearVehicle.fmu --input inputs.csv --step 10ms --stop 119.99s -o simulated.csv",
    );
    let simulated = column(&at("simulated.csv"), "NonlinearVehicle.yaw_rate");
    assert_eq!(simulated.len(), measured.len());
    // Without what the initial states of both halves leave.
    let part = 6300..11_900;
    let delivered = fit(&measured[part.clone()], &simulated[part.clone()]);
    let stated = fit(&measured[part.clone()], &validated[part.start - first..part.end - first]);
    assert!((delivered - stated).abs() < 0.1, "{delivered} {stated}");

    // Compared, it is that vehicle too, up to the limit of its grip, where the bicycle is none.
    done(folder.path(), "identify drive.csv --structure bicycle -o bicycle.json");
    let output = run(folder.path(), "compare vehicle.json bicycle.json --log drive.csv --json");
    let compared: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    let fits = [0, 1].map(|k: usize| {
        compared["models"][k]["held_out"]["fit_percent"].as_f64().unwrap_or_else(|| {
            panic!("{}", text_of(&output));
        })
    });
    println!("{fits:?}");
    assert!(fits[0] > 95.0 && fits[0] > fits[1] + 1.0, "{fits:?}");
}

#[test]
fn a_vehicle_written_by_hand_is_kept() {
    let folder = tempfile::tempdir().unwrap();
    let own = folder.path().join("vehicle.json");
    std::fs::copy(data().join("multibody/vehicle.json"), &own).unwrap();
    let before = read_json(&own);
    let line = "identify {data}/multibody/drive.csv --input-channel steering_command_rad --steering-ratio 1 --structure single-track";
    let output = run(folder.path(), line);
    let text = text_of(&output);
    assert_eq!(output.status.code(), Some(2), "{text}");
    assert!(text.contains("vehicle.json") && text.contains("--force"), "{text}");
    assert_eq!(read_json(&own), before);
}

#[test]
fn channels_of_other_axes_or_units_are_named() {
    let folder = tempfile::tempdir().unwrap();
    let log = "identify {data}/multibody/drive.csv --input-channel steering_command_rad --steering-ratio 1 --structure single-track";
    for (options, problem) in [
        ("--output-channel=-yaw_rate_radps", "opposite sign to the steering"),
        ("--channel lateral_acceleration=-lateral_acceleration_mps2", "opposite sign to yaw rate"),
        ("--unit lateral_acceleration_mps2=g", "times yaw rate times speed"),
        ("--prior tyre=1,0", "one of cornering_stiffness_front_per_load"),
        ("--prior wheelbase=2.6", "NAME=MEAN,DEVIATION"),
        ("--prior wheelbase=-1,1", "prior: wheelbase=-1,1"),
        ("--front-share 45% --prior front_share=0.4,0", "state the same parameter"),
        ("--front-share 95%", "expected 20 to 80 %"),
        ("--channel roll=steering_angle_rad", "one of lateral_acceleration"),
        ("--order 3", "--order is an option of the structure state-space"),
    ] {
        let output = run(folder.path(), &format!("{log} {options}"));
        let text = text_of(&output);
        assert_eq!(output.status.code(), Some(2), "{options}: {text}");
        assert!(text.contains(problem) && text.contains("hint:"), "{options}: {text}");
    }
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0, "nothing is written");
}
