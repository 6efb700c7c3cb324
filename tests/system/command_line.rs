//! The subcommands one after the other, as a person or a script runs them.

use crate::support::{chain, column, read_json, run, text_of, words};
use serde_json::Value;
use std::path::Path;

/// Runs with `--json`: exit status 0, one JSON value on stdout, JSON lines on stderr.
fn json(folder: &Path, line: &str) -> Value {
    let output = run(folder, &format!("{line} --json"));
    assert_eq!(output.status.code(), Some(0), "{line}: {}", text_of(&output));
    for line in String::from_utf8(output.stderr).unwrap().lines() {
        assert!(serde_json::from_str::<Value>(line).is_ok_and(|v| v.is_object()), "{line}");
    }
    serde_json::from_slice(&output.stdout).unwrap()
}

#[test]
fn each_stage_prints_the_file_it_writes() {
    let folder = tempfile::tempdir().unwrap();
    for (line, file) in [
        ("identify {data}/multibody/drive.csv --input-channel steering_command_rad", "plant.json"),
        ("bicycle {data}/multibody/vehicle.toml", "bicycle.json"),
        ("design bicycle.json --max-rate 0.4rad/s", "pid.json"),
        ("design {chain}/plant.json --max-angle 20deg --steady-state-error 1.5%", "pid.json"),
        ("path --speed 54km/h --pid pid.json", "path.json"),
        ("path {data}/multibody/position.csv -o recorded.json", "recorded.json"),
    ] {
        let printed = json(folder.path(), line);
        assert_eq!(printed, read_json(&folder.path().join(file)), "{line}");
    }
    let pid = read_json(&folder.path().join("pid.json"));
    assert!((pid["limits"]["max_angle_rad"].as_f64().unwrap() - 20f64.to_radians()).abs() < 1e-12);
    assert_eq!(pid["specification"]["steady_state_error_percent"], 1.5);
    // A controller brings its feedforward to the path; the road fits the stated speed.
    let path = read_json(&folder.path().join("path.json"));
    assert_eq!(path["speed_mps"], 15.0);
    assert!(path["guidance"]["feedforward_gain_radm"].as_f64().unwrap() > 0.0);
}

/// Lines that every command prints its result with, in an order in which each has what it needs.
const EACH: [&str; 9] = [
    "identify {data}/multibody/drive.csv --input-channel steering_command_rad --order 2 --horizon 10",
    "identify {data}/multibody/drive.csv --input-channel steering_command_rad --structure bicycle",
    "accumulate {data}/multibody/drive.csv --input-channel steering_command_rad",
    "bicycle {data}/multibody/vehicle.toml",
    "path --pid {chain}/pid.json",
    "package {chain}/plant.json {chain}/path.json {chain}/pid.json --ssp Loop.ssp",
    "simulate Loop.ssp --stop 1s",
    "design {chain}/plant.json",
    "compare {chain}/plant.json {chain}/bicycle.json --pid {chain}/pid.json --road lane-change",
];

#[test]
#[ignore = "slow: cargo xtask test"]
fn results_go_to_stdout_in_tables_of_80_columns_and_the_rest_to_stderr() {
    let folder = tempfile::tempdir().unwrap();
    for line in EACH.into_iter().chain(["check IdentifiedPlant.fmu"]) {
        let output = run(folder.path(), line);
        let (stdout, stderr) =
            (String::from_utf8(output.stdout).unwrap(), String::from_utf8(output.stderr).unwrap());
        assert!(output.status.success(), "{line}: {stderr}");
        assert!(!stdout.trim().is_empty(), "{line}: no result on stdout");
        assert!(!stdout.contains("written to "), "{line}: {stdout}");
        let about = ["written to ", "warning: ", "progress: ", "no feedforward", "sideslip"];
        assert!(stderr.lines().all(|l| about.iter().any(|a| l.starts_with(a))), "{line}: {stderr}");
        // Nothing but plain text where no terminal is.
        assert!(!(stdout + &stderr).contains('\u{1b}'), "{line}");
        let output = run(folder.path(), line);
        let text = String::from_utf8(output.stdout).unwrap();
        let mut in_table = false;
        for row in text.lines() {
            in_table = row.starts_with('─') || in_table && !row.is_empty();
            assert!(!in_table || row.chars().count() <= 80, "{line}: {row}");
        }
    }
}

#[test]
fn with_json_an_error_is_json_too() {
    let folder = tempfile::tempdir().unwrap();
    for (line, status, says) in [
        ("identify missing.csv --json", 2, "missing.csv: No such file"),
        (
            "--json design plant.json --max-angle 22",
            2,
            "invalid value '22' for '--max-angle <ANGLE>'",
        ),
        ("package --json", 2, "required arguments were not provided"),
        ("check missing.fmu --json", 2, "missing.fmu"),
    ] {
        let output = run(folder.path(), line);
        assert_eq!(output.status.code(), Some(status), "{line}");
        let text = String::from_utf8(output.stderr).unwrap();
        let error: Value = serde_json::from_str(text.lines().last().unwrap()).unwrap();
        let error = &error["error"];
        assert!(error["message"].as_str().unwrap().contains(says), "{line}: {error}");
        assert!(!error["message"].as_str().unwrap().starts_with("error"), "{line}: {error}");
        assert!(!error["hint"].as_str().unwrap().is_empty(), "{line}: {error}");
        assert_eq!(error["exit_status"], status, "{line}");
    }
}

#[test]
fn colour_is_for_terminals_and_no_color_takes_it_away() {
    let folder = tempfile::tempdir().unwrap();
    let line = "identify {data}/multibody/drive.csv --input-channel steering_command_rad --order 2";
    let coloured = |line: &str, variables: &[(&str, &str)]| {
        let mut command = std::process::Command::new(env!("CARGO_BIN_EXE_steerwright"));
        command.args(words(line, chain())).current_dir(folder.path());
        command.envs(variables.iter().copied()).output().unwrap()
    };
    let forced = [("CLICOLOR_FORCE", "1")];
    let text = String::from_utf8(coloured(line, &forced).stdout).unwrap();
    let quality = text.lines().find(|l| l.contains("quality pass")).unwrap();
    assert!(quality.contains("\u{1b}["), "{quality}");
    let text = String::from_utf8(coloured("identify missing.csv", &forced).stderr).unwrap();
    assert!(text.contains("\u{1b}[") && text.contains("error"), "{text}");
    let without = [("NO_COLOR", "1")];
    for line in [line, "identify missing.csv", "identify"] {
        let output = coloured(line, &without);
        let text = [output.stdout, output.stderr].concat();
        assert!(!text.contains(&0x1b), "{line}");
    }
}

#[test]
fn help_completions_and_man_pages_come_from_the_same_definitions() {
    let folder = tempfile::tempdir().unwrap();
    let printed = |line: &str| {
        let output = run(folder.path(), line);
        assert!(
            output.status.success() && output.stderr.is_empty(),
            "{line}: {}",
            text_of(&output)
        );
        String::from_utf8(output.stdout).unwrap()
    };
    assert!(printed("help").contains("identify"));
    assert_eq!(printed("help design"), printed("design --help"));
    for shell in ["bash", "zsh", "fish", "elvish", "powershell"] {
        let script = printed(&format!("completions {shell}"));
        assert!(script.contains("max-angle") && script.contains("force"), "{shell}");
    }
    assert!(printed("man").contains(".TH steerwright 1"));
    let page = printed("man design");
    assert!(page.contains(".TH steerwright-design 1"), "{page}");
    assert!(page.contains("\\-\\-max\\-angle") && page.contains("\\-\\-force"), "{page}");
    for _ in 0..2 {
        assert!(run(folder.path(), "man --out pages").status.success());
    }
    let pages = std::fs::read_dir(folder.path().join("pages")).unwrap().count();
    assert!(pages > 12, "{pages}");
    let output = run(folder.path(), "man nothing");
    assert_eq!(output.status.code(), Some(2));
    assert!(text_of(&output).contains("the commands are demo, build"), "{}", text_of(&output));
}

#[cfg(unix)]
#[test]
fn what_takes_longer_than_two_seconds_is_reported_on_stderr() {
    let folder = tempfile::tempdir().unwrap();
    let fifo = folder.path().join("log.csv");
    assert!(std::process::Command::new("mkfifo").arg(&fifo).status().unwrap().success());
    let mut child = std::process::Command::new(env!("CARGO_BIN_EXE_steerwright"))
        .args(["identify", "log.csv"])
        .current_dir(folder.path())
        .stderr(std::process::Stdio::piped())
        .spawn()
        .unwrap();
    let file = std::fs::OpenOptions::new().write(true).open(fifo).unwrap();
    let mut lines = std::io::BufRead::lines(std::io::BufReader::new(child.stderr.take().unwrap()));
    // The log ends when its reading was reported, however long that takes.
    let first = lines.next().unwrap().unwrap();
    assert!(first.starts_with("progress: reading the log, "), "{first}");
    drop(file);
    let rest: Vec<String> = lines.map(Result::unwrap).collect();
    assert!(rest.iter().any(|line| line.starts_with("error: ")), "{rest:?}");
    assert_eq!(child.wait().unwrap().code(), Some(2));
}

#[test]
fn three_files_with_a_clock_each_become_a_recorded_road_and_a_controller() {
    let folder = tempfile::tempdir().unwrap();
    let logs = ["steering_wheel_angle", "speed", "gyro"];
    let logs = logs.map(|name| format!("{{data}}/comma2k19/{name}.csv")).join(" ");
    let mapping = "--input-channel steering_wheel_angle_deg --steering-ratio 16.88";
    // The value of an option may begin with a minus, with and without an equals sign.
    for sign in ["--output-channel=-gyro_down_radps", "--output-channel -gyro_down_radps"] {
        let line = format!("identify {logs} {mapping} {sign} --traces traces.csv --max-order 4");
        // The driver barely steers: identified, and failed validation.
        let output = run(folder.path(), &format!("{line} --json"));
        assert_eq!(output.status.code(), Some(1), "{}", text_of(&output));
        let plant: Value = serde_json::from_slice(&output.stdout).unwrap();
        assert_eq!(plant["steering_ratio"], 16.88);
        assert_eq!(plant["evidence"]["channels"].as_array().unwrap().len(), 3);
        assert_eq!(plant["evidence"]["order_table"].as_array().unwrap().len(), 4);
        assert_eq!(plant["quality"]["grade"], "fail");
        let traces = std::fs::read_to_string(folder.path().join("traces.csv")).unwrap();
        let samples = |part: &str| plant["evidence"][part].as_u64().unwrap() as usize;
        let rows = samples("estimation_samples") + samples("validation_samples");
        assert_eq!(traces.lines().count(), 1 + rows);
    }
    let pid = json(folder.path(), "design plant.json --accept-untrusted --max-rate 400deg/s");
    // The default limit is 22° at the road wheel, here in the steering wheel's degrees.
    let limit = pid["limits"]["max_angle_rad"].as_f64().unwrap();
    assert!((limit - 16.88 * 22f64.to_radians()).abs() < 1e-9, "{limit}");
    let path = json(folder.path(), "path {data}/comma2k19/gnss_pose.csv --pid pid.json");
    let last = path["points"].as_array().unwrap().last().unwrap();
    assert!((1000.0..1030.0).contains(&last[0].as_f64().unwrap()), "{last}");
}

/// A specialist's details are printed with `--verbose` in addition to everything else.
#[test]
#[ignore = "slow: cargo xtask test"]
fn a_page_begins_with_the_verdict_and_the_next_command() {
    let folder = tempfile::tempdir().unwrap();
    for (line, verdict, next, detail) in [
        (
            "identify {data}/multibody/drive.csv --input-channel steering_command_rad -o plant.json",
            "quality pass: The fit on validation data is",
            "fit to design on; next: steerwright design plant.json",
            "singular value",
        ),
        (
            "design plant.json --robust off -o pid.json",
            "every requirement is met",
            "; next: steerwright package plant.json pid.json",
            "Steps of other heights",
        ),
    ] {
        let page = |line: &str| String::from_utf8(run(folder.path(), line).stdout).expect("text");
        let (brief, full) = (page(line), page(&format!("{line} --verbose")));
        let first = brief.lines().next().unwrap_or_default();
        assert!(first.starts_with(verdict) && first.ends_with(next), "{brief}");
        assert!(full.contains(detail) && !brief.contains(detail), "{full}");
        let full: Vec<&str> = full.lines().collect();
        assert!(brief.lines().all(|line| full.contains(&line)), "{brief}");
    }
}

#[test]
#[ignore = "slow: cargo xtask test"]
fn an_infeasible_specification_ends_with_status_1_and_the_controller_is_written() {
    let folder = tempfile::tempdir().unwrap();
    let output = run(folder.path(), "design {chain}/plant.json --settling 0.1s");
    assert_eq!(output.status.code(), Some(1), "{}", text_of(&output));
    assert!(
        text_of(&output).contains("not every requirement is met: settling time"),
        "{}",
        text_of(&output)
    );
    let output = run(folder.path(), "design {chain}/plant.json --settling 0.1s --json");
    assert_eq!(output.status.code(), Some(1), "{}", text_of(&output));
    let printed: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(printed, read_json(&folder.path().join("pid.json")));
    assert_eq!(printed["evidence"]["met"], false);
}

const LOOP: &str =
    "{chain}/fmu/IdentifiedPlant.fmu {chain}/fmu/ReferencePath.fmu {chain}/fmu/LateralPid.fmu";

#[test]
fn packed_files_run_as_a_loop() {
    let folder = tempfile::tempdir().unwrap();
    let done = json(folder.path(), &format!("simulate {LOOP}"));
    assert_eq!(done["connections"].as_array().unwrap().len(), 7, "{done}");
    // What is recommended is the controller's sample time.
    assert_eq!((done["steps"].as_u64(), done["step_s"].as_f64()), (Some(1000), Some(0.01)));
    let recorded = |name| column(&folder.path().join("result.csv"), name);
    let errors = recorded("ReferencePath.cross_track_error");
    assert_eq!(errors.len(), 1001);
    assert!(errors.iter().all(|e| e.abs() < 0.5), "it leaves the road");
    assert!(recorded("IdentifiedPlant.y").iter().any(|y| *y > 3.0), "it does not change lanes");

    let jacobi = json(
        folder.path(),
        &format!("simulate {LOOP} --coupling jacobi --step 5ms --stop 2s -o jacobi.csv"),
    );
    assert_eq!(jacobi["steps"], 400);
    assert_eq!(column(&folder.path().join("jacobi.csv"), "time").len(), 401);
}

#[test]
fn parameters_are_set_and_free_inputs_are_fed() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("in.csv"), "time,speed\n0,15\n5,12\n").unwrap();
    let line = format!("simulate {LOOP} --input in.csv --set LateralPid.enabled=false");
    let done = json(folder.path(), &line);
    assert_eq!(done["last"]["LateralPid.enabled"], 0.0);
    assert_eq!(done["last"]["IdentifiedPlant.speed"], 12.0);
    // Both FMUs with a speed are driven by the column: 5 s at 15 m/s and 5 s at 12 m/s.
    let x = done["last"]["IdentifiedPlant.x"].as_f64().unwrap();
    assert!((x - 135.0).abs() < 1.0, "{x}");

    // Warnings of an FMU are printed.
    let done = json(folder.path(), &format!("simulate {LOOP} --step 100ms --stop 1s"));
    assert!(done["warnings"][0].as_str().unwrap().starts_with("LateralPid: "), "{done}");
}

#[test]
fn every_command_has_help_and_bad_usage_a_hint() {
    let folder = tempfile::tempdir().unwrap();
    for command in ["identify", "bicycle", "design", "path", "package", "simulate", "check", "man"]
    {
        let help = run(folder.path(), &format!("{command} --help"));
        let text = String::from_utf8(help.stdout).unwrap();
        assert!(help.status.success() && help.stderr.is_empty(), "{command}");
        assert!(text.contains("Usage: ") && text.contains("--json"), "{text}");
        assert!(text.lines().all(|l| l.chars().count() <= 100), "{text}");
    }
    let output = run(folder.path(), "design plant.json --max-angle 22");
    assert_eq!(output.status.code(), Some(2));
    let text = text_of(&output);
    assert!(text.contains("(deg or rad)") && text.contains("\nhint: --help"), "{text}");
}

#[test]
#[ignore = "slow: cargo xtask test"]
fn build_does_in_one_command_what_the_stages_do_one_by_one() {
    let folder = tempfile::tempdir().unwrap();
    let built = json(
        folder.path(),
        "build {data}/multibody/drive.csv --input-channel steering_command_rad \
         --vehicle {data}/multibody/vehicle.toml --track {data}/multibody/position.csv",
    );
    for file in ["plant.json", "pid.json"] {
        let (built, staged) =
            (read_json(&folder.path().join("out").join(file)), read_json(&chain().join(file)));
        for key in ["discrete", "operating_point", "gains", "limits"] {
            assert_eq!(built[key], staged[key], "{file}: {key}");
        }
    }
    assert_eq!(built["controllers"].as_array().unwrap().len(), 2);
    assert!(folder.path().join("out/report.html").is_file());
    // A controller that cannot meet its specification: the work is done, exit status 1.
    let line = "build {data}/multibody/drive.csv --input-channel steering_command_rad --settling 0.1s --out b";
    let output = run(folder.path(), line);
    assert_eq!(output.status.code(), Some(1), "{}", text_of(&output));
    assert!(text_of(&output).contains("not met: settling"), "{}", text_of(&output));
}

#[test]
fn a_bicycle_is_built_as_a_plant_is_next_to_that_of_the_data_sheet() {
    let folder = tempfile::tempdir().unwrap();
    let built = json(
        folder.path(),
        "build {data}/multibody/drive.csv --input-channel steering_command_rad --robust off \
         --structure bicycle --vehicle {data}/multibody/vehicle.toml",
    );
    assert_eq!(built["structure"], "bicycle");
    assert_eq!(built["controllers"].as_array().unwrap().len(), 2);
    let out = folder.path().join("out");
    let bicycle = read_json(&out.join("bicycle.json"));
    assert_eq!(built["held_out_fit_percent"], bicycle["evidence"]["validation_fit"]);
    assert!(read_json(&out.join("bicycle-from-data.json"))["evidence"].is_null());
    for file in ["fmu/BicyclePlant.fmu", "fmu-from-bicycle/BicyclePlant.fmu", "report.html"] {
        assert!(out.join(file).is_file(), "{file}");
    }
    let line = "identify {data}/multibody/drive.csv --input-channel steering_command_rad \
                --structure bicycle --report bicycle.html --plots figures";
    assert_eq!(run(folder.path(), line).status.code(), Some(0));
    let page = std::fs::read_to_string(folder.path().join("bicycle.html")).unwrap();
    assert!(page.contains("identified bicycle") && page.contains("95 % band"), "{page}");
    assert!(folder.path().join("figures/comparison.svg").is_file());
    // The same model as `identify` alone.
    assert_eq!(read_json(&folder.path().join("bicycle.json"))["vehicle"], bicycle["vehicle"]);
}
