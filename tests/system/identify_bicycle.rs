//! `identify --structure bicycle`, and the FMU that comes of it.

use crate::support::{column, done, read_json, run, text_of};
use serde_json::Value;
use std::fmt::Write;
use steerwright_formats::Structure;

const LOG: &str =
    "{data}/multibody/drive.csv --input-channel steering_command_rad --steering-ratio 1";

#[test]
fn the_bicycle_is_identified_packed_and_follows_its_traces() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    let output = run(
        folder.path(),
        &format!("identify {LOG} --structure bicycle --mass 1093 --traces traces.csv --json"),
    );
    assert!(output.status.success(), "{}", text_of(&output));
    let printed: Value = serde_json::from_slice(&output.stdout).unwrap();
    let file = read_json(&at("bicycle.json"));
    assert_eq!(printed, file);
    assert_eq!(file["vehicle"]["mass_kg"], 1093.0);
    let summary = file["quality"]["summary"].as_str().unwrap();
    assert!(summary.contains("the only speed driven"), "{summary}");
    let text = text_of(&run(folder.path(), &format!("identify {LOG} --structure bicycle")));
    assert!(text.contains("understeer gradient"), "{text}");

    // The same steering through the FMU, from a straight start, at the speed that was held.
    let [time, steering, traced] = ["time_s", "steering_rad", "simulated_yaw_rate_radps"]
        .map(|name| column(&at("traces.csv"), name));
    let evidence = &file["evidence"];
    let number = |key: &str| evidence[key].as_f64().unwrap();
    let mut drive = String::from("time,steering_angle,speed\n");
    for (t, angle) in time.iter().zip(&steering) {
        let angle = angle - number("steering_offset_rad");
        let _ = writeln!(drive, "{:.6},{angle},15", t - time[0]);
    }
    std::fs::write(at("drive.csv"), drive).unwrap();
    for line in [
        "design bicycle.json",
        "package bicycle.json",
        "simulate BicyclePlant.fmu --input drive.csv --step 20ms --stop 40s -o simulated.csv",
    ] {
        done(folder.path(), line);
    }
    let simulated = column(&at("simulated.csv"), "BicyclePlant.yaw_rate");
    for ((time, traced), got) in time.iter().zip(&traced).zip(&simulated) {
        let expected = traced - number("yaw_rate_offset_radps");
        // The recorded speed is held to 0.03 m/s, and read with noise.
        assert!((got - expected).abs() < 2e-3, "{time}: {got} {expected}");
    }
}

#[test]
fn options_outside_the_structure_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let wheel = "{data}/comma2k19/steering_wheel_angle.csv {data}/comma2k19/gyro.csv --steering-ratio 16 --output-channel=-gyro_down_radps";
    let structures = "tricycle".parse::<Structure>().unwrap_err().or("auto").expected();
    for (line, problem) in [
        (format!("identify {wheel} --structure bicycle"), "needs the speed"),
        (format!("identify {LOG} --structure bicycle --order 3"), "--order is an option of"),
        (format!("identify {LOG} --structure state-space --mass 1000"), "--mass is an option of"),
        (format!("identify {LOG} --structure bicycle --mass 0"), "--mass"),
        (format!("identify {LOG} --structure tricycle"), &*structures),
    ] {
        let output = run(folder.path(), &line);
        let text = text_of(&output);
        assert_eq!(output.status.code(), Some(2), "{line}: {text}");
        assert!(text.contains(problem) && text.contains("hint:"), "{line}: {text}");
    }
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0, "nothing is written");
}
