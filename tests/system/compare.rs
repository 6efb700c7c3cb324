//! `steerwright compare` end to end: its figures are those of the other commands, whatever the order
//! of the models, and bad input is rejected.

use crate::support::{self, chain, data, done, read_json, text_of};
use serde_json::Value;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Output;
use std::sync::OnceLock;
use steerwright_host::{Archive, Instance};

/// The chain's folder with a controller for the bicycle too, and a NonlinearVehicle.
fn folder() -> &'static Path {
    static FOLDER: OnceLock<PathBuf> = OnceLock::new();
    FOLDER.get_or_init(|| {
        let folder = chain().to_path_buf();
        for line in [
            "design bicycle.json -o pid-bicycle.json --robust off --max-rate 0.4rad/s",
            "package {data}/multibody/vehicle.json --out fmu",
        ] {
            done(&folder, line);
        }
        folder
    })
}

fn run(line: &str) -> Output {
    support::run(folder(), &format!("compare {line}"))
}

fn compared(line: &str) -> Value {
    let output = run(&format!("{line} --json"));
    assert!(output.status.success(), "{line}: {}", text_of(&output));
    serde_json::from_slice(&output.stdout).unwrap()
}

/// What each command line below begins with.
const BOTH: &str = "plant.json bicycle.json --pid pid.json --pid pid-bicycle.json";

fn run_of<'a>(compared: &'a Value, controller: &str, plant: &str) -> &'a Value {
    let all = compared["runs"].as_array().unwrap();
    all.iter().find(|r| r["controller"] == controller && r["plant"] == plant).unwrap()
}

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap_or_else(|| panic!("{value} is no number"))
}

/// The figures of a run.
fn figures(run: &Value) -> Vec<f64> {
    let keys = [
        "cross_track_rms_m",
        "cross_track_largest_m",
        "yaw_error_rms_rad",
        "yaw_error_largest_rad",
        "steering_rate_rms_radps",
        "steering_largest_rad",
    ];
    keys.iter().map(|k| number(&run[k])).collect()
}

#[test]
fn on_its_own_plant_a_controller_does_as_in_simulate() {
    let folder = folder();
    let line = "simulate fmu/IdentifiedPlant.fmu fmu/ReferencePath.fmu fmu/LateralPid.fmu \
                --set IdentifiedPlant.speed=15 -o own.csv --step 10ms --stop 19.8s";
    done(folder, line);
    let track =
        steerwright_report::Track::from_csv(&fs::read(folder.join("own.csv")).unwrap(), "own")
            .unwrap();
    let compared = compared(&format!("{BOTH} --path path.json --out own"));
    let own = run_of(&compared, "plant", "plant");
    assert_eq!(own["own_plant"], true);
    // The whole run, but for the last ticks: the road is 297.96 m long.
    let runs = fs::read(folder.join("own/runs/plant-on-plant.csv")).unwrap();
    let run = steerwright_report::Track::from_csv(&runs, "run").unwrap();
    assert!(run.x_m.len() > 1970);
    let both = track.x_m.len().min(run.x_m.len());
    assert!(both > 1970);
    assert_eq!(run.x_m[..both], track.x_m[..both]);
    assert_eq!(run.steering_rad[..both], track.steering_rad[..both]);
    let errors = run.errors();
    assert_eq!(number(&own["cross_track_rms_m"]), errors.cross_track_rms_m);
    assert!(errors.cross_track_rms_m > 1e-4 && errors.cross_track_rms_m < 0.02);
    // What was promised for the FMU loop is what happens in it.
    let step = &own["step"];
    let promised = &compared["controllers"][0]["predicted_step"];
    // But for what the integral still lacked of the plant's offset after ten seconds straight.
    for key in ["overshoot_percent", "settling_time_s", "rise_time_s"] {
        let apart = number(&step[key]) - number(&promised[key]);
        assert!(apart.abs() < 1e-4, "{key}: {apart}");
    }
    for file in ["fig5-road.svg", "fig6-7-plant.svg", "fig6-7-bicycle.svg", "steps.svg"] {
        assert!(fs::read_to_string(folder.join("own").join(file)).unwrap().ends_with("</svg>\n"));
    }
    let page = fs::read_to_string(folder.join("own/comparison.html")).unwrap();
    assert!(page.contains("Result</h2>") && !page.contains("is missing"));
    // What is listed is what is there.
    for file in compared["files"].as_array().unwrap() {
        let bytes = fs::read(folder.join("own").join(file["name"].as_str().unwrap())).unwrap();
        assert_eq!(file["sha256"], steerwright_formats::sha256_hex(&bytes), "{file}");
    }
    let table = fs::read_to_string(folder.join("own/results.csv")).unwrap();
    assert_eq!(table.lines().count(), 5);
    let row = table.lines().nth(1).unwrap();
    assert!(
        row.starts_with("plant,plant,true,met,,")
            && row.contains(&errors.cross_track_rms_m.to_string())
    );
}

/// A controller that was designed for an actuator before its model is verified and compared with it.
#[test]
fn an_actuator_that_was_stated_is_before_the_model() {
    let folder = folder();
    // A vehicle with hardly a lag of its own.
    let vehicle = fs::read_to_string(data().join("multibody/vehicle.toml")).unwrap();
    let vehicle = vehicle.replace("time_constant_s = 0.05", "time_constant_s = 1e-4");
    fs::write(folder.join("body.toml"), vehicle).unwrap();
    done(folder, "bicycle body.toml -o body.json");
    let limits = "--robust off --max-rate 0.4rad/s";
    done(folder, &format!("design body.json -o pid-body.json {limits}"));
    for (model, other) in [("plant", "body"), ("body", "plant")] {
        let actuator = "--actuator-lag 80ms --actuator-delay 20ms";
        // A requirement that is not met is no fault here.
        support::run(folder, &format!("design {model}.json -o with.json {limits} {actuator}"));
        let document = read_json(&folder.join("with.json"));
        let verified = &document["evidence"]["fmu_loops"][0];
        let others = if other == "plant" { "pid.json" } else { "pid-body.json" };
        let line = format!("plant.json body.json --pid with.json --pid {others} --path path.json");
        let compared = compared(&line);
        let run = run_of(&compared, model, model);
        for key in ["overshoot_percent", "settling_time_s", "rise_time_s"] {
            let promised = number(&document["evidence"]["step"][key]);
            // Overshoot in percent, times in seconds.
            for step in [&verified["step"], &verified["predicted"], &run["step"]] {
                let apart = (number(&step[key]) - promised).abs();
                assert!(apart < 0.03, "{model}, {key}: {promised}, {step}");
            }
        }
        let margin = number(&document["evidence"]["margins"]["modulus_margin"]);
        assert!((number(&run["modulus_margin"]) - margin).abs() < 1e-6, "{model}: {run}");
    }
    // In a package the plant is behind it, too; alone it is the model, and that is said.
    let files = "package body.json with.json path.json --json";
    let fmu_of = |output: &Output| -> Value {
        let printed: Vec<Value> = serde_json::from_slice(&output.stdout).unwrap();
        printed.into_iter().find(|fmu| fmu["fmu"] == "BicyclePlant").unwrap()
    };
    support::run(
        folder,
        &format!("design body.json -o with.json {limits} --actuator-lag 80ms --force"),
    );
    let alone = done(folder, &format!("{files} --out alone"));
    assert!(text_of(&alone).contains("body.json is packed without the controller's actuator"));
    let inside = done(folder, &format!("{files} --out inside --ssp Loop.ssp"));
    assert!(fmu_of(&alone)["actuator"].is_null());
    assert_eq!(fmu_of(&inside)["actuator"]["time_constant_s"], 0.08);
    for (place, lag) in [("alone", 1e-4), ("inside", 0.0801)] {
        let archive = Archive::open(folder.join(place).join("BicyclePlant.fmu")).unwrap();
        let mut unit = Instance::new(&archive, place).unwrap();
        unit.setup_experiment(0.0, None, None).unwrap();
        unit.enter_initialization_mode().unwrap();
        let start = unit.real("actuator_time_constant").unwrap();
        assert!((start - lag).abs() < 1e-12, "{place}: {start}");
    }
}

#[test]
fn the_order_of_the_models_is_the_order_of_the_table_and_nothing_else() {
    let truth = "--truth fmu/NonlinearVehicle.fmu";
    let one = compared(&format!("{BOTH} {truth}"));
    let other =
        compared(&format!("bicycle.json plant.json --pid pid.json --pid pid-bicycle.json {truth}"));
    let names = |v: &Value| -> Vec<String> {
        let all = v["controllers"].as_array().unwrap();
        all.iter().map(|c| c["name"].as_str().unwrap().to_owned()).collect()
    };
    assert_eq!(names(&one), ["plant", "bicycle"]);
    assert_eq!(names(&other), ["bicycle", "plant"]);
    let truth = "truth (NonlinearVehicle)";
    for controller in ["plant", "bicycle"] {
        for plant in ["plant", "bicycle", truth] {
            assert_eq!(
                run_of(&one, controller, plant),
                run_of(&other, controller, plant),
                "{controller} on {plant}"
            );
        }
    }
    assert_eq!(one["verdict"]["tracks_best"], other["verdict"]["tracks_best"]);
    assert_eq!(one["road"], other["road"]);
    assert_eq!(one["verdict"]["judged_on"], truth);
    // The sideslip that is read in a turn is that of the bicycle's steady state; an identified plant
    // has none.
    let plant = |name: &str| {
        let all = one["plants"].as_array().unwrap();
        all.iter().find(|p| p["name"] == name).unwrap().clone()
    };
    assert_eq!(number(&plant("plant")["sideslip_per_yaw_rate_s"]), 0.0);
    // β/r = L_r/v − m·L_f·v/(L·C_r), vehicle.toml at 15 m/s.
    let (m, lf, lr, cr, v) = (1093.2952, 1.1561957, 1.4227171, 105_400.27, 15.0);
    let expected = lr / v - m * lf * v / ((lf + lr) * cr);
    let read = number(&plant("bicycle")["sideslip_per_yaw_rate_s"]);
    assert!((read - expected).abs() < 1e-5, "{read} {expected}");
    // What it leads a change by: (J − m·L_f·v·S)/(L·C_r).
    let lead = number(&plant("bicycle")["sideslip_per_yaw_acceleration_s2"]);
    let j = 1791.5995;
    let expected_lead = (j - m * lf * v * expected) / ((lf + lr) * cr);
    assert!((lead - expected_lead).abs() < 2e-5, "{lead} {expected_lead}");
    assert_eq!(number(&plant("plant")["sideslip_per_yaw_acceleration_s2"]), 0.0);
    let nonlinear = number(&plant(truth)["sideslip_per_yaw_rate_s"]);
    assert!((nonlinear - expected).abs() < 5e-4, "{nonlinear} {expected}");
    // Without both the look-ahead of 15 m would turn 0.38° of sideslip into 0.1 m in the bends.
    let rms = number(&run_of(&one, "bicycle", "bicycle")["cross_track_rms_m"]);
    assert!(rms < 0.004, "{rms}");
}

#[test]
fn a_truth_that_is_a_model_gives_that_model_s_figures() {
    let one = compared(&format!("{BOTH} --truth fmu/IdentifiedPlant.fmu"));
    for controller in ["plant", "bicycle"] {
        let on_model = figures(run_of(&one, controller, "plant"));
        let on_truth = figures(run_of(&one, controller, "truth (IdentifiedPlant)"));
        for (a, b) in on_model.iter().zip(&on_truth) {
            assert!((a - b).abs() <= 1e-9 * a.abs(), "{controller}: {a} {b}");
        }
        let step = |plant| run_of(&one, controller, plant)["step"].clone();
        assert_eq!(step("plant"), step("truth (IdentifiedPlant)"));
    }
    // From its file it is the same.
    let from_file = compared(&format!("{BOTH} --truth plant.json"));
    assert_eq!(one["runs"], from_file["runs"]);
}

/// The drive's fits are those of the identification and of the demo, and the yaw that each model makes
/// of the steering stays with the measured one.
#[test]
fn models_are_validated_on_the_end_of_the_drive() {
    let log = "--log {data}/multibody/drive.csv --input-channel steering_command_rad";
    let one = compared(&format!("{BOTH} {log} --road lane-change --out drive"));
    let plant = read_json(&folder().join("plant.json"));
    let fit = |k: usize| number(&one["models"][k]["held_out"]["fit_percent"]);
    assert!((fit(0) - number(&plant["evidence"]["fit"]["validation"])).abs() < 1e-6);
    assert!(fit(0) > fit(1) + 0.5 && fit(1) > 97.0, "{} {}", fit(0), fit(1));
    for k in 0..2 {
        let on = &one["models"][k]["held_out"];
        // VAF is 1 − the error's variance over the signal's; a fit of f leaves at most (1 − f)².
        let least = 100.0 * (1.0 - (1.0 - fit(k) / 100.0).powi(2));
        assert!(number(&on["variance_accounted_for_percent"]) >= least - 1e-9);
        assert!(number(&on["yaw_error_rms_rad"]).to_degrees() < 1.0);
    }
    let sources = one["sources"].as_array().unwrap();
    let drive =
        steerwright_formats::sha256_hex(&fs::read(data().join("multibody/drive.csv")).unwrap());
    assert!(sources.iter().any(|s| s["sha256"] == drive.as_str()), "{sources:?}");
    let svg = fs::read_to_string(folder().join("drive/fig3-drive.svg")).unwrap();
    assert!(svg.contains("plant (fit 9"));
    assert_eq!(one["road"]["name"], "double lane change");
    // No path of this machine is in what is written.
    let page = fs::read_to_string(folder().join("drive/comparison.html")).unwrap();
    assert!(!page.contains(&folder().display().to_string()));
}

/// The truth's actuator does 0.4 rad/s: a design that ignores it commands many times that, and misses
/// the specification.
#[cfg(unix)]
#[test]
fn a_truth_that_ends_the_process_is_no_success() {
    use crate::crashing::{Behaviour, library, zip_of};
    use std::io::Read;
    let Some(library) = library(Behaviour::EndsLoaded) else { return };
    let place = tempfile::tempdir().unwrap();
    let vehicle = fs::File::open(folder().join("fmu/NonlinearVehicle.fmu")).unwrap();
    let mut archive = zip::ZipArchive::new(vehicle).unwrap();
    let mut files = Vec::new();
    for i in 0..archive.len() {
        let mut entry = archive.by_index(i).unwrap();
        let mut bytes = Vec::new();
        entry.read_to_end(&mut bytes).unwrap();
        let name = entry.name().unwrap().into_owned();
        if name.starts_with("binaries/") && entry.is_file() {
            bytes = library.to_vec();
        }
        files.push((name, bytes));
    }
    let files: Vec<(&str, &[u8])> = files.iter().map(|(name, bytes)| (&**name, &**bytes)).collect();
    let exits = place.path().join("Exits.fmu");
    fs::write(&exits, zip_of(&files)).unwrap();
    let output = run(&format!("{BOTH} --truth {}", exits.display()));
    let text = text_of(&output);
    assert_eq!(output.status.code(), Some(2), "{text}");
    assert!(text.contains("ended with exit status: 0 before the command was done"), "{text}");
}

#[test]
fn controllers_keep_to_the_limits_that_the_truth_states() {
    let line = "plant.json bicycle.json --robust off --road lane-change \
                --truth {data}/multibody/vehicle.json";
    let one = compared(line);
    for controller in one["controllers"].as_array().unwrap() {
        assert_eq!(number(&controller["limits"]["max_rate_radps"]), 0.4, "{controller}");
        let run = run_of(&one, controller["name"].as_str().unwrap(), "truth (NonlinearVehicle)");
        // What is still missed is the model's error, not the actuator's.
        assert_eq!(run["cause"], Value::Null, "{run}");
    }
    assert_eq!(run_of(&one, "plant", "truth (NonlinearVehicle)")["outcome"], "met");
    let remarks = one["remarks"].to_string();
    assert!(remarks.contains("the truth's steering limit of 22.9 deg/s"), "{remarks}");
    let first = one["verdict"]["sentences"][0].as_str().unwrap();
    assert!(
        first.starts_with("The controller of plant meets the specification on truth"),
        "{first}"
    );
}

/// A controller designed without the limit misses, and the report names the limit.
#[test]
fn a_missed_specification_is_reported_with_the_cause() {
    let folder = folder();
    for model in ["plant", "bicycle"] {
        let line = format!(
            "design {model}.json -o fast-{model}.json --robust off --max-rate 1500deg/s \
             --max-lateral-acceleration 100m/s2"
        );
        done(folder, &line);
    }
    let output = run("plant.json bicycle.json --pid fast-plant.json --pid fast-bicycle.json \
                      --road lane-change --truth {data}/multibody/vehicle.json");
    let text = text_of(&output) + &String::from_utf8_lossy(&output.stdout);
    let sentence = text.lines().find(|l| l.contains("misses the specification on truth")).unwrap();
    assert!(sentence.contains("(at most "), "{sentence}");
    assert!(sentence.contains("of steering, the actuator does 22.9 deg/s"), "{sentence}");
    // What matters comes before the tables.
    let place = |what: &str| text.find(what).unwrap_or_else(|| panic!("{what} in {text}"));
    assert!(place("specification on truth") < place("controller of  "));
}

/// A bend that needs more than μ·g = 10.3 m/s² throws the car off the road; the controllers steer for no
/// more than 6 m/s², so that a linear model leaves it, too.
#[test]
fn a_controller_off_the_path_is_reported_with_status_1() {
    let line = "--truth fmu/NonlinearVehicle.fmu --lateral-acceleration 12m/s2";
    let output = run(&format!("{BOTH} {line} --json"));
    assert_eq!(output.status.code(), Some(1), "{}", text_of(&output));
    let lost: Value = serde_json::from_slice(&output.stdout).unwrap();
    for controller in ["plant", "bicycle"] {
        let run = run_of(&lost, controller, "truth (NonlinearVehicle)");
        let at = number(&run["off_path_at_m"]);
        // The first bend begins after 30 m.
        assert!(at > 30.0 && at < 200.0 && number(&run["cross_track_largest_m"]) > 1.75, "{run}");
        let linear = number(&run_of(&lost, controller, "bicycle")["off_path_at_m"]);
        assert!(linear > 30.0, "{linear}");
    }
    assert_eq!(lost["verdict"]["tracks_best"], Value::Null);
    let text = text_of(&output);
    let text = text + &String::from_utf8_lossy(&run(&format!("{BOTH} {line}")).stdout);
    let off = "is off the path on truth (NonlinearVehicle) after";
    let unstable = "is unstable on truth (NonlinearVehicle) after";
    assert!(text.contains(off) || text.contains(unstable), "{text}");
    assert!(text.contains("remark: the road needs up to 12.0 m/s²"), "{text}");
}

#[test]
fn files_that_cannot_be_compared_are_rejected() {
    let folder = folder();
    let change = |file: &str, out: &str, edit: &dyn Fn(&mut Value)| {
        let mut json = read_json(&folder.join(file));
        edit(&mut json);
        fs::write(folder.join(out), json.to_string()).unwrap();
    };
    change("plant.json", "wheel.json", &|p| p["steering_ratio"] = 15.0.into());
    change("plant.json", "slow.json", &|p| p["operating_point"]["speed_mps"] = 8.0.into());
    change("plant.json", "other.json", &|p| p["name"] = "another".into());
    change("pid-bicycle.json", "coarse.json", &|p| p["sample_time_s"] = 0.02.into());
    change("path.json", "tight.json", &|p| {
        for point in p["points"].as_array_mut().unwrap() {
            point[4] = 0.3.into();
        }
    });
    // A vehicle whose steering angle is that of a steering wheel.
    let mut json = read_json(&data().join("multibody/vehicle.json"));
    json["actuator"]["steering_ratio"] = 16.0.into();
    fs::write(folder.join("vehicle-wheel.json"), json.to_string()).unwrap();
    fs::write(folder.join("nan.json"), "{\"schema\": \"steerwright/plant/1\", \"name\": NaN}")
        .unwrap();
    for (line, expected) in [
        ("plant.json --pid pid.json", "nothing to compare"),
        ("plant.json missing.json", "missing.json: No such file"),
        ("plant.json nan.json", "nan.json:1:"),
        ("plant.json wheel.json", "wheel.json has a steering ratio of 15"),
        ("plant.json slow.json", "the models are of speeds from 8.00 to 14.99 m/s"),
        ("plant.json slow.json --road-speed 15m/s", "slow.json is of 8.00 m/s"),
        (
            "plant.json bicycle.json --pid pid.json --pid coarse.json",
            "a sample time of 0.02 s, that of plant of 0.01 s",
        ),
        (
            "other.json bicycle.json --pid pid.json",
            "pid.json: designed on a model that is not compared",
        ),
        (
            "plant.json bicycle.json --pid pid.json --pid pid-bicycle.json --path tight.json",
            "the road's radius of 3.3 m needs",
        ),
        (
            "plant.json bicycle.json --pid pid.json --pid pid-bicycle.json --truth fmu/ReferencePath.fmu",
            "as the truth it lacks input steering_angle (rad), output x (m)",
        ),
        (
            "plant.json bicycle.json --pid pid.json --pid pid-bicycle.json --truth vehicle-wheel.json",
            "is that of a steering wheel to a road wheel",
        ),
        (
            "plant.json bicycle.json --pid pid.json --pid pid-bicycle.json --truth pid.json",
            "which is no vehicle",
        ),
        ("plant.json bicycle.json --truth nothing.fmu", "nothing.fmu: No such file"),
        (
            "plant.json bicycle.json --log {data}/multibody/drive.csv --input-channel steering_command_rad --steering-ratio 15",
            "it has a steering ratio of 1, the log of 15",
        ),
    ] {
        let output = run(line);
        let text = text_of(&output);
        assert_eq!(output.status.code(), Some(2), "{line}: {text}");
        assert!(text.contains(expected) && text.contains("\nhint: "), "{line}: {text}");
    }
}
