//! The reference run in an archive: its form, and that it says something about the model.
#![allow(clippy::unwrap_used, clippy::panic)]

use crate::support;

use model_description::Causality;
use std::collections::BTreeMap;
use steerwright_packaging::Fmu;
use support::{document, files, packed, text};

const FOLDER: &str = "extra/io.github.steerwright/reference";

/// A CSV file's columns by name.
fn columns(text: &str) -> BTreeMap<String, Vec<f64>> {
    let mut reader = csv::Reader::from_reader(text.as_bytes());
    let names: Vec<String> = reader.headers().unwrap().iter().map(str::to_owned).collect();
    assert_eq!(names[0], "time");
    let mut columns: BTreeMap<String, Vec<f64>> = BTreeMap::new();
    for record in reader.records() {
        for (name, field) in names.iter().zip(record.unwrap().iter()) {
            columns.entry(name.clone()).or_default().push(field.parse().unwrap());
        }
    }
    columns
}

struct Run {
    about: serde_json::Value,
    input: BTreeMap<String, Vec<f64>>,
    result: BTreeMap<String, Vec<f64>>,
}

fn run(fmu: Fmu, step: Option<f64>) -> Run {
    let packed =
        steerwright_packaging::package(&document(fmu), "d.json", support::LINUX, step, None)
            .unwrap();
    let files = files(&packed);
    let about: serde_json::Value =
        serde_json::from_str(&text(&files, &format!("{FOLDER}/reference.json"))).unwrap();
    let file =
        |key: &str| columns(&text(&files, &format!("{FOLDER}/{}", about[key].as_str().unwrap())));
    Run { input: file("input"), result: file("result"), about }
}

#[test]
fn the_files_name_every_input_and_output() {
    for fmu in Fmu::ALL {
        let description = packed(fmu).description;
        let run = run(fmu, None);
        for (causality, file) in [(Causality::Input, &run.input), (Causality::Output, &run.result)]
        {
            let mut names: Vec<&str> = description
                .variables
                .iter()
                .filter(|v| v.causality == causality)
                .map(|v| v.name.as_str())
                .chain(["time"])
                .collect();
            names.sort_unstable();
            assert_eq!(file.keys().map(String::as_str).collect::<Vec<_>>(), names, "{fmu:?}");
            // Everything moves: a variable that stands still proves little.
            let still: Vec<&String> = file
                .iter()
                .filter(|(_, values)| values.iter().all(|v| *v == values[0]))
                .map(|(name, _)| name)
                .collect();
            // The road's end is out of reach in ten seconds, its curvature constant, and no limit
            // need act. The response of the speed has one command, and no gears; the manoeuvre one speed, and no end
            // after an interruption.
            let allowed = [
                "finished",
                "curvature",
                "speed",
                "speed_reference",
                "saturated",
                "steering_feedforward",
                "acceleration_command",
                "gear",
            ];
            assert!(still.iter().all(|n| allowed.contains(&n.as_str())), "{fmu:?}: {still:?}");
        }
    }
}

#[test]
fn times_are_communication_points_from_start_to_stop() {
    for (step, stop) in
        [(0.01_f64, 10.0_f64), (0.02, 10.0), (0.3, 9.9), (25.0, 25.0), (1e-4, 1.0), (1e-12, 1e-8)]
    {
        for fmu in Fmu::ALL {
            let run = run(fmu, Some(step));
            assert_eq!(run.about["schema"], "steerwright/reference/1");
            assert_eq!(run.about["start_time"], 0.0);
            assert_eq!(run.about["step_size"], step);
            // A hundred samples at least of what may be slower than vehicles.
            let stop = if fmu == Fmu::MultivariablePlant { stop.max(100.0 * step) } else { stop };
            assert_eq!(run.about["stop_time"], stop);
            assert!(run.about["absolute_tolerance"].as_f64().unwrap() >= 1e-9);
            let results = &run.result["time"];
            assert_eq!((results[0], results[results.len() - 1]), (0.0, stop));
            for times in [results, &run.input["time"]] {
                assert!(times.len() <= 1001 && times[0] == 0.0, "{}", times.len());
                assert!(times.is_sorted_by(|a, b| a < b));
                for time in times {
                    let steps = time / step;
                    assert!((steps - steps.round()).abs() < 0.1, "{time} is between steps");
                }
            }
        }
    }
}

/// The estimate stays on the drive of the scenario, whose truth is two arcs, through the outlier and
/// the time without fixes, and says how far off it is.
#[test]
fn the_estimator_stays_on_the_drive() {
    let run = run(Fmu::PoseEstimator, None);
    let result = &run.result;
    let radius = 15.0 / 0.2;
    for (i, time) in result["time"].iter().enumerate().filter(|(_, time)| **time > 1.0) {
        // Inputs are set when a step has ended: all are a step late, and so is the estimate.
        let t = time - 0.01;
        let (left, right) = (0.2 * t.min(5.0), 0.2 * (t - 5.0).max(0.0));
        let yaw = left - right;
        let x = radius * (2.0 * left.sin() - yaw.sin());
        let y = radius * (1.0 - 2.0 * left.cos() + yaw.cos());
        let away = (result["x"][i] - x).hypot(result["y"][i] - y);
        assert!(away < 3.0 * result["position_std"][i] && away < 0.3, "{t} s: {away} m");
        assert!((result["yaw"][i] - yaw).abs() < 0.02, "{t} s");
    }
    // Fixes come in, stay away and come back.
    let std = |t: f64| {
        let i = result["time"].iter().position(|time| (time - t).abs() < 0.011).unwrap();
        result["position_std"][i]
    };
    let stds = [0.05, 3.9, 7.9, 8.5].map(std);
    assert!(stds[0] > 0.9 && stds[1] < 0.05, "{stds:?}");
    assert!(stds[2] > 2.0 * stds[1] && stds[3] < 0.6 * stds[2], "{stds:?}");
}

/// Against the equation of the plant, solved apart: ẋ = −5 x + 5 (u − offset), r = x, ψ̇ = r.
#[test]
fn the_plant_answers_its_inputs() {
    let run = run(Fmu::IdentifiedPlant, Some(0.01));
    let (input, result) = (&run.input, &run.result);
    let (mut rate, mut yaw, mut row) = (0.0, 0.0, 0);
    let mut compared = 0;
    for k in 0..=1000_u32 {
        let time = f64::from(k) * 0.01;
        if let Some(i) = result["time"].iter().position(|t| (t - time).abs() < 1e-6) {
            assert!((result["yaw_rate"][i] - rate).abs() < 1e-9, "{time} s");
            assert!((result["yaw"][i] - yaw).abs() < 1e-9, "{time} s");
            compared += 1;
        }
        while input["time"].get(row + 1).is_some_and(|t| *t < time + 1e-6) {
            row += 1;
        }
        let steady = input["steering_angle"][row] - 0.01;
        let decay = (-0.05_f64).exp();
        yaw += steady * 0.01 + (rate - steady) * (1.0 - decay) / 5.0;
        rate = steady + (rate - steady) * decay;
    }
    assert!(compared > 400, "{compared}");
    // As much as the drive steered: one standard deviation at the road wheel, times the ratio.
    let largest = input["steering_angle"].iter().fold(0.0_f64, |m, v| m.max((v - 0.01).abs()));
    assert!((largest - 0.06).abs() < 1e-9, "{largest}");
}

#[test]
fn the_path_is_driven_with_a_small_offset() {
    let run = run(Fmu::ReferencePath, None);
    let largest = run.result["cross_track_error"].iter().fold(0.0_f64, |m, v| m.max(v.abs()));
    assert!((0.2..0.3).contains(&largest), "{largest}");
    let end = run.result["distance"].last().unwrap();
    assert!((end - 100.0).abs() < 1.0, "{end}");
}

#[test]
fn the_controller_is_seen_disabled() {
    let run = run(Fmu::LateralPid, None);
    assert!(run.input["enabled"].contains(&0.0) && run.input["enabled"].contains(&1.0));
}
