//! Bad input: exit status 2, one error that names the place, one hint, and nothing written.
#![allow(clippy::unwrap_used)]

mod support;

use serde_json::{Value, json};
use std::collections::BTreeSet;
use std::fmt::Write;
use std::path::Path;
use support::{chain, data, steerwright, told, words};

/// Files to write, arguments, and what the error and its hint must say.
type Case<'a> = (&'a [(&'a str, &'a str)], &'a str, &'a [&'a str]);

fn names(folder: &Path) -> BTreeSet<String> {
    let entries = std::fs::read_dir(folder).unwrap();
    entries.map(|e| e.unwrap().file_name().to_string_lossy().into_owned()).collect()
}

fn refused((files, line, says): Case<'_>) {
    let folder = tempfile::tempdir().unwrap();
    for (name, content) in files {
        std::fs::write(folder.path().join(name), content).unwrap();
    }
    let before = names(folder.path());
    let output = steerwright(folder.path(), &words(line, chain()));
    let text = told(&output);
    assert_eq!(output.status.code(), Some(2), "{line}: {text}");
    assert!(output.stdout.is_empty(), "{line}: something on stdout");
    let starting = |word: &str| text.lines().filter(|l| l.starts_with(word)).count();
    assert_eq!((starting("error: "), starting("hint: ")), (1, 1), "{line}: {text}");
    assert!(text.starts_with("error: "), "{line}: {text}");
    for part in says {
        assert!(text.contains(part), "{line}: no `{part}` in: {text}");
    }
    assert!(text.lines().all(|l| l.chars().count() < 700), "{line}: {text}");
    assert_eq!(names(folder.path()), before, "{line}: something was written");
}

const HEADER: &str = "time_s,steering_angle_rad,yaw_rate_radps,speed_mps";

/// A log of 20 s at 100 Hz under a header; `edit` changes the cells of a row.
fn log(header: &str, edit: impl Fn(usize, &mut Vec<String>)) -> String {
    let mut text = format!("{header}\n");
    let mut yaw_rate = 0.0;
    for i in 0..2000 {
        let t = f64::from(i) * 0.01;
        let steering = 0.02 * (2.0 * (1.0 + 0.1 * t) * t).sin();
        yaw_rate += 0.05 * (5.0 * steering - yaw_rate);
        let mut row = vec![
            format!("{t:.2}"),
            format!("{steering:.6}"),
            format!("{yaw_rate:.6}"),
            "15".to_owned(),
        ];
        edit(i as usize, &mut row);
        if !row.is_empty() {
            let _ = writeln!(text, "{}", row.join(","));
        }
    }
    text
}

/// A log with one other cell, in line 502.
fn with_cell(column: usize, cell: &str) -> String {
    log(HEADER, |i, row| {
        if i == 500 {
            row[column] = cell.into();
        }
    })
}

#[test]
fn logs() {
    let good = log(HEADER, |_, _| {});
    let identify = "identify log.csv";
    for (content, says) in [
        ("", &["log.csv: the file is empty"] as &[_]),
        (&format!("{HEADER}\n"), &["log.csv: column `steering_angle_rad` has 0 values"]),
        (&format!("{HEADER}\n0,0,0,15\n"), &["has 1 values"]),
        ("\0\u{1}PK\n", &["log.csv:1: the file is not text"]),
        ("{\"schema\": 1}\n", &["which column is the steering?", "log.csv", "--input NAME"]),
        (
            &log("time_s,wheels_rad,yaw_rate_radps,speed_mps", |_, _| {}),
            &["which column is the steering?", "wheels_rad", "--input NAME"],
        ),
        (&with_cell(1, "oops"), &["log.csv:502: column `steering_angle_rad`: `oops`"]),
        (&with_cell(2, "inf"), &["log.csv:502: column `yaw_rate_radps`", "finite"]),
        (&with_cell(1, "1e300"), &["log.csv:502:", "1.000e300 rad"]),
        (&with_cell(3, "1e300"), &["log.csv:502:", "the speed would be"]),
        (&with_cell(0, "3.0"), &["log.csv:502: column `time_s`: time 3 s", "4.99 s"]),
        (&with_cell(0, "4.99"), &["log.csv:502: column `time_s`: time 4.99 s"]),
        (&with_cell(2, "1,2"), &["log.csv:502: the row has 5 cells, the header has 4"]),
        (&log(HEADER, |_, row| row[1] = "NaN".into()), &["has 0 values"]),
        (
            &log(HEADER, |i, row| {
                // Nothing between the gaps is long enough.
                if i % 100 < 60 {
                    row.clear();
                }
            }),
            &["log.csv:", "a gap of 0.61 s", "is too short", "--max-gap"],
        ),
        (&log(HEADER, |_, row| row[1] = "0.1".into()), &["the steering is 0.1 rad throughout"]),
        (&log(HEADER, |_, row| row[2] = "0".into()), &["the yaw rate is 0 rad/s throughout"]),
        // A steering wheel's degrees and a gyro's, both read as radians.
        (&log(HEADER, |_, row| row[1] += "e3"), &["more than a road wheel can turn", "--unit"]),
        (&log(HEADER, |_, row| row[2] += "e3"), &["rad/s (read as rad/s)", "deg/s would make it"]),
        (
            &log("time_s,steering,yaw_rate,speed", |_, _| {}),
            &["log.csv:1: column `steering`: the unit is not stated", "--unit steering=deg"],
        ),
        (
            &log("time,steer_rad,yaw_rate_radps,v_mps", |_, _| {}),
            &["log.csv:1: column `time`: the unit is not stated", "--unit time=s"],
        ),
        (
            &log("time_s,steering_wheel_rad,yaw_rate_radps,v_mps", |_, _| {}),
            &["log.csv: column `steering_wheel_rad`", "--steering-ratio 15"],
        ),
        (
            &log("time_s,steer_rad,steer_rad,v_mps", |_, _| {}),
            &["log.csv:1: the header names the column `steer_rad` twice"],
        ),
        // Seconds said to be nanoseconds.
        (&good.replace("time_s", "time_ns"), &["check the time column and its unit"]),
    ] {
        refused((&[("log.csv", content)], identify, says));
    }

    let later = log(HEADER, |i, row| row[0] = format!("{}", 1000.0 + i as f64 * 0.01));
    for (line, says) in [
        ("identify missing.csv", &["missing.csv: No such file"] as &[_]),
        ("identify .", &["error: .: "]),
        (
            "identify --drive a.csv,b.csv --input steering_angle_rad",
            &["in more than one file: a.csv, b.csv", "as in a.csv:steering_angle_rad"],
        ),
        (
            "identify a.csv b.csv --input a.csv:steering_angle_rad --output b.csv:yaw_rate_radps",
            &["the clocks do not overlap", "1000 to 1019.99 s"],
        ),
        ("identify a.csv a.csv", &["a.csv is the same recording as a.csv"]),
        (
            "identify a.csv b.csv speed.csv",
            &["a.csv, b.csv bring steering and yaw rate each", "--drive a.csv,speed.csv"],
        ),
        ("identify --drive a.csv,", &["'--drive <FILE,FILE…>'", "commas between them"]),
        ("identify", &["<LOG"]),
        (
            "identify a.csv --speed-window 20..30",
            &["within 20.0 to 30.0 m/s for 0.0 s only", "widen --speed-window"],
        ),
        ("identify a.csv --speed-window 60..50km/h", &["60 is not below 50km/h"]),
        ("identify a.csv --speed-window fast", &["'--speed-window <FROM..TO>'", "14..16"]),
        ("identify a.csv --speed-window 1e300..2e300", &["beyond any sensible value"]),
        ("identify a.csv --delay -1s", &["--delay: -1 s is out of range", "or auto"]),
        ("identify a.csv --delay 0.1", &["'--delay <TIME|auto>'", "(ms or s)"]),
        ("identify a.csv --detrend cubic", &["expected mean, linear or none"]),
        ("identify a.csv --input nosuch", &["no column `nosuch`", "a.csv"]),
        ("identify a.csv --input speed_mps", &["a.csv: column `speed_mps` is in m/s"]),
        ("identify a.csv --unit steering_angle_rad=furlong", &["`furlong` is not a unit"]),
        ("identify a.csv --unit speed_mps=furlong", &["`furlong` is not a unit"]),
        ("identify a.csv --unit nosuch=deg", &["a unit is given for `nosuch`"]),
        ("identify a.csv --order 99", &["--order: 99 is out of range", "1 to 32"]),
        ("identify a.csv --max-order 99", &["--max-order: 99", "1 to 32"]),
        ("identify a.csv --horizon 1", &["--horizon: 1 is out of range", "2 to 200"]),
        ("identify a.csv --horizon 5 --order 5", &["needs a horizon above it", "--horizon 7"]),
        ("identify a.csv --hold-out 95%", &["--hold-out: 95% is out of range", "10% to 90%"]),
        ("identify a.csv --hold-out -5%", &["--hold-out: -5% is out of range"]),
        ("identify a.csv --hold-out 0.5", &["'--hold-out <SHARE>'", "(%)"]),
        ("identify a.csv --steering-ratio 0", &["--steering-ratio: 0.0 is out of range"]),
        ("identify a.csv --window 1s..2s", &["samples of 0.04 s are too few"]),
        ("identify a.csv --window 90s..99s", &["the window covers 90 to 99 s, the log 0 to 19.99"]),
        ("identify a.csv --window 9s..5s", &["9 s is not before 5 s"]),
        ("identify a.csv --sample-time 1ms", &["the log's own 0.01 s", "--sample-time 0.01s"]),
        ("identify a.csv --max-gap 1e300s", &["`1e300` is beyond any sensible value"]),
        ("identify a.csv --order 1 -o .", &["error: .: this is a folder"]),
        ("identify a.csv --order 1 -o a.csv/p.json", &["a.csv: this is a file, not a folder"]),
    ] {
        let speed = log("time_s,a_1,b_1,speed_mps", |_, _| {});
        refused((&[("a.csv", &good), ("b.csv", &later), ("speed.csv", &speed)], line, says));
    }
}

/// What is no reason to refuse a log: it is done, and told.
#[test]
fn logs_that_are_mended() {
    let gap = |i: usize, row: &mut Vec<String>| {
        if (900..1000).contains(&i) {
            row.clear();
        }
    };
    let wild = |i: usize, row: &mut Vec<String>| {
        if i == 1999 {
            row[0] = "1e300".into();
        }
    };
    let later = |i: usize, row: &mut Vec<String>| row[0] = format!("{}", 1000 + 10 * i);
    let other = log(HEADER, later).replace("time_s", "t_ms");
    for (first, arguments, says) in [
        (log(HEADER, gap), "", &["a.csv:902:", "nothing from 8.99 s to 10 s: the drive is split"]),
        (log(HEADER, wild), "", &["a.csv:2001:", "to 1.000e300 s"]),
        (log(HEADER, |_, _| {}), "other.csv", &["a.csv:steering_angle_rad", "other.csv:"]),
        (log(HEADER, |_, _| {}), "--speed-window 50..60km/h", &["13.9 to 16.7 m/s", "1 stretch"]),
        (
            log(HEADER, |_, _| {}),
            "--window 1s..8s --window 9s..19s --detrend linear",
            &["model", ""],
        ),
    ] {
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join("a.csv"), first).unwrap();
        std::fs::write(folder.path().join("other.csv"), &other).unwrap();
        let line = format!("identify a.csv {arguments} --order 1 --horizon 10");
        let output = steerwright(folder.path(), &words(&line, chain()));
        let text = told(&output);
        assert_eq!(output.status.code(), Some(0), "{line}: {text}");
        for part in says {
            assert!(text.contains(part), "{line}: no `{part}` in: {text}");
        }
        let plant = std::fs::read_to_string(folder.path().join("plant.json")).unwrap();
        assert!(plant.contains("\"input_delay_s\": 0"), "{line}");
    }
}

#[test]
fn vehicle_data() {
    let good = std::fs::read_to_string(support::data().join("multibody/vehicle.toml")).unwrap();
    for (from, to, says) in [
        ("mass_kg = 1093.2952", "mass_kg = -5", &["v.toml:5:11: mass_kg: -5"] as &[_]),
        ("mass_kg = 1093.2952", "mass_kg = nan", &["v.toml:5:11: mass_kg: NaN"]),
        ("mass_kg = 1093.2952", "mass_kg = \"heavy\"", &["v.toml:5:11:", "string"]),
        ("mass_kg = 1093.2952", "", &["v.toml:1:1: missing field `mass_kg`"]),
        (
            "mass_kg",
            "mas_kg",
            &["v.toml:5:1: unknown field `mas_kg`", "the keys are name, mass_kg"],
        ),
        ("= 1791.5995", "= 1e-300", &["v.toml: the model's fastest rate"]),
    ] {
        assert!(good.contains(from));
        refused((&[("v.toml", &good.replace(from, to))], "bicycle v.toml", says));
    }
    refused((&[], "bicycle v.toml", &["v.toml: No such file"]));
}

#[test]
fn tracks() {
    for (content, arguments, says) in [
        ("", "", &["t.csv:1:1: no columns x_m and y_m"] as &[_]),
        ("a,b\n1,2\n", "", &["t.csv:1:1:", "there are: a, b"]),
        ("x_m,y_m\n1,2\n", "", &["t.csv: 1 distinct points", "at least 4"]),
        ("x_m,y_m\n1,2\n1,2\n1,2\n1,2\n1,2\n", "", &["t.csv: 1 distinct points"]),
        ("x_m,y_m\n0,0\n1,NaN\n", "", &["t.csv:3:3: y_m is `NaN`, not a number"]),
        ("x_m,y_m\n0,0\n1\n", "", &["t.csv:3:3: the row has no y_m"]),
        ("x_m,y_m\n0,0\n1,1e300\n", "", &["t.csv:3:3: y_m is 1e300"]),
        ("x_m,y_m\n0,0\n1e7,0\n2e7,0\n3e7,0\n4e7,0\n", "", &["length of the path is 40000000"]),
        ("x_m,y_m\n0,0\n1,0\n2,0\n3,0\n4,0\n", "--closed", &["t.csv: the curvature reaches inf"]),
        ("x_m,y_m\n0,0\n1,0\n2,0\n3,0\n", "--speed 0m/s", &["speed is 0"]),
        ("x_m,y_m\n", "--pid {chain}/plant.json", &["t.csv: 0 distinct points"]),
    ] {
        refused((&[("t.csv", content)], &format!("path t.csv {arguments}"), says));
    }
    for (line, says) in [
        ("path --speed 1m/s", &["double lane change: a curvature of 4.0000 1/m"] as &[_]),
        ("path --speed 1e5m/s", &["speed is 100000: it must be at most 150 m/s"]),
        ("path --lateral-acceleration 1e-6m/s2", &["it must be at least 0.1 m/s2"]),
        ("path --lateral-acceleration 1e6m/s2", &["it must be at most 50 m/s2"]),
        ("path --speed 20", &["'--speed <SPEED>'", "(m/s or km/h)"]),
        (
            "path --pid {chain}/plant.json",
            &["`steerwright/plant/1` stands here", "steerwright/pid/1"],
        ),
    ] {
        refused((&[], line, says));
    }
}

/// A file of the chain, changed.
fn edited(file: &str, edit: impl Fn(&mut Value)) -> String {
    let text = std::fs::read_to_string(chain().join(file)).unwrap();
    let mut value = serde_json::from_str(&text).unwrap();
    edit(&mut value);
    value.to_string()
}

#[test]
fn documents() {
    let plant = |edit: fn(&mut Value)| edited("plant.json", edit);
    let pid = |edit: fn(&mut Value)| edited("pid.json", edit);
    let path = |edit: fn(&mut Value)| edited("path.json", edit);
    let example = data().join("multibody/vehicle.json").display().to_string();
    let vehicle = |edit: fn(&mut Value)| edited(&example, edit);
    let not_json = plant(|_| ()).replacen("\"A\":[[", "\"A\":[[NaN, ", 1);
    for (content, command, says) in [
        (plant(|p| p["schema"] = json!("steerwright/plant/2")), "design", &["plant/2"] as &[_]),
        (plant(|p| p["discrete"]["A"] = json!([[1, 2]])), "design", &["at `discrete.A`", "1 by 2"]),
        (plant(|p| p["discrete"]["B"] = json!([[1], []])), "design", &["at `discrete.B`"]),
        (not_json.clone(), "design", &["f.json:1:", "at `discrete.A[0][0]`"]),
        (not_json, "package", &["f.json:1:"]),
        (plant(|p| p["steering_ratio"] = json!(0)), "design", &["f.json: at `steering_ratio`"]),
        (plant(|p| p["extra"] = json!(1)), "design", &["at `extra`: unknown field"]),
        (
            plant(|p| {
                p["discrete"]["A"][0][0] = json!(1.5);
                p.as_object_mut().unwrap().remove("continuous");
            }),
            "design",
            &["f.json: ", "unstable"],
        ),
        (
            plant(|p| {
                for (model, input) in [("discrete", "B"), ("continuous", "G")] {
                    for row in p[model][input].as_array_mut().unwrap() {
                        row[0] = json!(-row[0].as_f64().unwrap());
                    }
                }
            }),
            "design",
            &["f.json: ", "steady-state gain", "check the signs"],
        ),
        (
            edited("bicycle.json", |b| b["schema"] = json!("steerwright/bicycle/9")),
            "design",
            &["expected `steerwright/bicycle/1`"],
        ),
        (pid(|_| ()), "design", &["`steerwright/pid/1` stands here"]),
        (pid(|p| p["sample_time_s"] = json!(-0.01)), "package", &["at `sample_time_s`: -0.01"]),
        (pid(|p| p["gains"]["kp"] = json!(-1)), "package", &["at `gains.kp`: -1"]),
        (vehicle(|_| ()), "design", &["`steerwright/vehicle/1` stands here"]),
        (
            vehicle(|v| v["tyres"]["shape_factor"] = json!(3)),
            "package",
            &["at `tyres.shape_factor`: 3"],
        ),
        (
            vehicle(|v| v["body"]["track_width_m"] = json!(1e6)),
            "package",
            &["the track width is 1000000"],
        ),
        (path(|p| p["points"] = json!([[0, 0, 0, 0, 0]])), "package", &["at `points`: 1 points"]),
        (path(|p| p["points"][5][0] = json!(0)), "package", &["at `points[5][0]`"]),
        (path(|p| p["schema"] = json!("steerwright/x/1")), "package", &["`steerwright/x/1`"]),
        ("time,x\n".to_owned(), "package", &["f.json:1:"]),
        ("[]".to_owned(), "package", &["f.json: no FMU is made from"]),
    ] {
        refused((&[("f.json", &content)], &format!("{command} f.json"), says));
    }
    let two = "package {chain}/plant.json f.json";
    refused((&[("f.json", &plant(|_| ()))], two, &["both make IdentifiedPlant.fmu"]));
    for (content, says) in [
        ("settling = \"1s\"\nsetling = \"1s\"\n", &["s.toml:2:1: `setling` is no requirement"]),
        ("settling = \"1\"\n", &["s.toml:1:12: settling: a number with its unit (ms or s)"]),
        ("settling = 1\n", &["s.toml:1:12: settling: a number with its unit"]),
        ("overshoot = [1]\n", &["s.toml:1:13: overshoot: a text with a unit"]),
        ("disk-margin = 3\n", &["s.toml:1:15: disk-margin: disk margin is 3"]),
        (
            "settling = \"1s\"\n  rise-time = \"2s\"\n",
            &["s.toml:2:15: rise-time: a rise time of up to 2 s contradicts"],
        ),
        ("settling = \"1s\"\nsettling = \"2s\"\n", &["s.toml:2:1:"]),
        ("", &["s.toml:1:1: nothing is asked for"]),
    ] as [(&str, &[&str]); 8]
    {
        let line = "design {chain}/plant.json --requirements s.toml";
        refused((&[("s.toml", content)], line, says));
    }
    for (line, says) in [
        ("design {chain}/plant.json --settling 0s", &["settling time is 0"] as &[_]),
        ("design {chain}/plant.json --overshoot -1%", &["overshoot is -1"]),
        ("design {chain}/plant.json --max-angle 22", &["'--max-angle <ANGLE>'", "(deg or rad)"]),
        ("design {chain}/plant.json --modulus-margin 2", &["modulus margin is 2"]),
        ("design {chain}/plant.json --settling 30ms", &["fewer than 4 samples"]),
        ("design {chain}/plant.json --gain-margin 6", &["'--gain-margin <GAIN>'", "(dB)"]),
        (
            "design {chain}/plant.json --rise-time 2s",
            &["a rise time of up to 2 s contradicts a settling time of at most 1 s"],
        ),
        ("package {chain}/plant.json --step 0s", &["the step size is 0"]),
        ("package missing.json", &["missing.json: No such file"]),
    ] {
        refused((&[], line, says));
    }
}

#[test]
fn simulations() {
    let all = ["IdentifiedPlant", "ReferencePath", "LateralPid"];
    let all = all.map(|name| format!("{{chain}}/fmu/{name}.fmu")).join(" ");
    let with = |arguments: &str| format!("simulate {all} {arguments}");
    for (content, arguments, says) in [
        ("time,speed\n", "--input f", &["f: it has no rows"] as &[_]),
        ("time,sped\n0,1\n", "--input f", &["column \"sped\" names no input", "speed"]),
        ("t,speed\n0,1\n", "--input f", &["the first column is \"t\""]),
        ("time,speed\n0,x\n", "--input f", &["f: line 2, column \"speed\": \"x\""]),
        ("time,speed\n0,NaN\n", "--input f", &["f: line 2, column \"speed\""]),
        ("time,speed\n0\n", "--input f", &["f: line 2: the row has 1 cells"]),
        ("time,speed\n0,1\n0,2\n", "--input f", &["f: line 3: time 0 s does not come after"]),
        ("time,speed\n1,1\n", "--input f", &["f: starts at 1 s"]),
        ("time,yaw\n0,1\n", "--input f", &["it is fed by"]),
        ("", "f", &["f: not a readable zip archive"]),
        ("", "{chain}/fmu/BicyclePlant.fmu", &["could be connected to any of", "leave out"]),
        ("", "{chain}/fmu/LateralPid.fmu", &["two instances are named \"LateralPid\""]),
        ("", "--set LateralPid.kpp=1", &["no variable \"kpp\"; near it: kp"]),
        ("", "--set Pid.kp=1", &["no instance \"Pid\"; it has IdentifiedPlant"]),
        ("", "--set LateralPid.kp", &["not of the form"]),
        ("", "--set LateralPid.kp=x", &["LateralPid.kp: \"x\""]),
        ("", "--set LateralPid.kp=-1", &["`kp` cannot be -1"]),
        ("", "--set LateralPid.yaw=1", &["fed by IdentifiedPlant.yaw"]),
        ("", "--step 0s", &["step 0 s"]),
        ("", "--step 30ms --stop 1s", &["not a whole number of steps"]),
        ("", "--stop 1e12s", &["more than 100 million steps"]),
        ("", "--master foo", &["[possible values: gauss-seidel, jacobi]"]),
        ("", "-o f/result.csv", &["f: this is a file, not a folder"]),
        ("", "-o .", &[".: this is a folder"]),
    ] {
        refused((&[("f", content)], &with(arguments), says));
    }
    refused((&[], "simulate missing.fmu", &["missing.fmu: No such file"]));
}
