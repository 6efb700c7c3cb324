//! `steerwright sweep` over the packed FMUs: the study in the repository, its results, its exits.

use crate::support::{archives, column, demo, steerwright, text_of};
use std::fs;
use std::path::{Path, PathBuf};

const EXAMPLE: &str = include_str!("../../sweep/examples/lateral-loop.toml");

/// A study next to the archives.
fn study(name: &str, text: &str) -> PathBuf {
    let file = archives().join(name);
    fs::write(&file, text).unwrap();
    file
}

fn small(runs: usize, stop: &str) -> String {
    EXAMPLE
        .replace("runs = 200", &format!("runs = {runs}"))
        .replace("stop_s = 20.0", &format!("stop_s = {stop}"))
}

fn sweep(folder: &Path, study: &Path, more: &[&str]) -> std::process::Output {
    let mut arguments = vec!["sweep".as_ref(), study.as_os_str()];
    arguments.extend(more.iter().map(std::ffi::OsStr::new));
    steerwright(folder, &arguments)
}

#[test]
fn the_example_runs_and_its_summary_is_that_of_its_rows() {
    let folder = tempfile::tempdir().unwrap();
    let file = study("example.toml", &small(12, "8.0"));
    let one = sweep(
        folder.path(),
        &file,
        &["-o", "one.csv", "--threads", "1", "--json", "--trajectories", "of", "--of", "3"],
    );
    assert_eq!(one.status.code(), Some(0), "{}", text_of(&one));
    assert_eq!(
        sweep(folder.path(), &file, &["-o", "two.csv", "--threads", "2"]).status.code(),
        Some(0)
    );
    let table = fs::read_to_string(folder.path().join("one.csv")).unwrap();
    assert_eq!(table, fs::read_to_string(folder.path().join("two.csv")).unwrap());

    let summary: serde_json::Value = serde_json::from_slice(&one.stdout).unwrap();
    assert_eq!((&summary["rows"], &summary["errors"]), (&12.into(), &0.into()));
    let header = "run,speed,IdentifiedPlant.noise_seed,gust,cross_track_rms_m,cross_track_max_m,\
                  off_by_10_cm_s,yaw_error_rms_deg,saturated_s,passed,outcome,status,study";
    assert_eq!(table.lines().next(), Some(header));
    let metric = column(&folder.path().join("one.csv"), "cross_track_max_m");
    let largest = metric.iter().copied().fold(0.0, f64::max);
    assert_eq!(summary["metrics"][1]["maximum"].as_f64(), Some(largest));
    // The trajectory's own largest error is the metric of its run.
    let errors = column(&folder.path().join("of/run-3.csv"), "ReferencePath.cross_track_error");
    assert_eq!(errors.len(), 801);
    assert_eq!(errors.iter().fold(0.0, |most, e| e.abs().max(most)), metric[3]);
}

#[test]
fn the_same_reset_or_new_for_every_fmu_of_ours() {
    let folder = tempfile::tempdir().unwrap();
    let of = |plant: &str, instances: &str| {
        let text = small(6, "3.0")
            .replace("seed = 1 ", &format!("instances = \"{instances}\"\nseed = 1 "));
        // Only the identified plant has noise.
        let text = if plant == "IdentifiedPlant" {
            text
        } else {
            text.replace("\"IdentifiedPlant.noise_scale\" = 1.0\n", "")
                .replace("variables = [\"IdentifiedPlant.noise_seed\"]", "name = \"seed\"")
                .replace("IdentifiedPlant", plant)
        };
        let file = study(&format!("{plant}-{instances}.toml"), &text);
        let out = format!("{plant}-{instances}.csv");
        let output = sweep(folder.path(), &file, &["-o", &out]);
        assert!(matches!(output.status.code(), Some(0 | 1)), "{}", text_of(&output));
        let table = fs::read_to_string(folder.path().join(out)).unwrap();
        assert!(!table.contains(",error: "), "{table}");
        // All but the study's hash.
        table.lines().map(|l| l.rsplit_once(',').unwrap().0.to_owned()).collect::<Vec<_>>()
    };
    for plant in ["IdentifiedPlant", "BicyclePlant", "NonlinearVehicle"] {
        let reset = of(plant, "auto");
        assert_eq!(reset.len(), 7);
        assert_eq!(reset, of(plant, "fresh"), "{plant}");
    }
}

/// The road needs 4 m/s² at 15 m/s: below a friction of about 0.45 the car slides off it.
#[test]
fn what_explains_the_failures_is_named() {
    let folder = tempfile::tempdir().unwrap();
    let vary = "[[vary]]\nname = \"friction\"\nvariables = [\"NonlinearVehicle.friction_coefficient\"]\n\
                distribution = \"uniform\"\nminimum = 0.15\nmaximum = 1.0\n\n[[vary]]\nname = \"speed\"";
    let text = small(60, "16.0")
        .replace("\"IdentifiedPlant.noise_scale\" = 1.0\n", "")
        .replace("variables = [\"IdentifiedPlant.noise_seed\"]", "name = \"seed\"")
        .replace("IdentifiedPlant", "NonlinearVehicle")
        .replacen("[[vary]]\nname = \"speed\"", vary, 1);
    let file = study("friction.toml", &text);
    let output = sweep(folder.path(), &file, &["--json"]);
    assert_eq!(output.status.code(), Some(1), "{}", text_of(&output));
    let summary: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    let failures = &summary["failures"][0];
    let cause = &failures["causes"][0];
    assert_eq!(
        (&cause["condition"]["quantity"], &cause["condition"]["is"]),
        (&"friction".into(), &"below".into())
    );
    let threshold = cause["condition"]["value"].as_f64().unwrap();
    assert!((0.3..0.7).contains(&threshold), "{failures}");
    // Of the failures nearly all are there, and of the others nearly none.
    let count = |part: &str, key: &str| cause[part][key].as_u64().unwrap();
    assert!(count("with", "failed") > 5 && count("without", "failed") <= 1, "{failures}");
    let outcomes = summary["outcomes"].as_array().unwrap();
    let runs = |name: &str| {
        let found = outcomes.iter().find(|o| o["outcome"] == name);
        found.map_or(0, |o| o["runs"].as_u64().unwrap())
    };
    assert_eq!(runs("met"), summary["passed"]["passed"].as_u64().unwrap());
    assert!(runs("off-the-path") + runs("unstable") > 0, "{outcomes:?}");
    // The same in words, and row by row.
    let again = sweep(folder.path(), &file, &["--resume"]);
    let text = text_of(&again) + &String::from_utf8_lossy(&again.stdout);
    assert!(text.contains("have friction below ") && text.contains(" off the path"), "{text}");
    let table = fs::read_to_string(folder.path().join("results.csv")).unwrap();
    let lines = |name: &str| table.lines().filter(|l| l.contains(name)).count() as u64;
    assert_eq!(lines(",off the path,"), runs("off-the-path"));
    assert_eq!(lines(",met,"), runs("met"));
}

#[test]
fn a_package_is_swept_as_it_is_wired() {
    let folder = tempfile::tempdir().unwrap();
    let package = demo().folder.join("multibody/fmu/LateralLoop.ssp");
    let text = format!(
        "ssp = {package:?}\nseed = 1\nruns = 2\nstop_s = 2.0\n\
         [[vary]]\nvariables = [\"LateralPid.kp\"]\ndistribution = \"choice\"\nvalues = [0.5, 1.0]\n\
         [[metric]]\nname = \"x\"\nvariable = \"IdentifiedPlant.x\"\nkind = \"final\"\nat_least = 1e3\n"
    );
    let file = folder.path().join("study.toml");
    fs::write(&file, text).unwrap();
    let output = sweep(folder.path(), &file, &["--json"]);
    // Nobody drives a kilometre in 2 s: a requirement is not met.
    assert_eq!(output.status.code(), Some(1), "{}", text_of(&output));
    let summary: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    // The package's own speed, of the drive, held for 2 s.
    let x = summary["metrics"][0]["median"].as_f64().unwrap();
    assert!((29.0..31.0).contains(&x), "{x}");
    assert_eq!(summary["passed"]["passed"], 0);
    // The results are done: a second call overwrites them, a third resumes with nothing to do.
    assert_eq!(sweep(folder.path(), &file, &[]).status.code(), Some(1));
    assert_eq!(sweep(folder.path(), &file, &["--resume"]).status.code(), Some(1));
}

#[test]
fn a_run_is_that_of_simulate_to_the_bit() {
    let folder = tempfile::tempdir().unwrap();
    for coupling in ["gauss-seidel", "jacobi"] {
        let text = format!(
            "seed = 1\nruns = 1\nstep_s = 0.01\nstop_s = 6.0\nmaster = {coupling:?}\n\
             record = [\"IdentifiedPlant.yaw_rate\", \"LateralPid.saturated\"]\n\
             fmu = [{{ file = \"IdentifiedPlant.fmu\" }}, {{ file = \"ReferencePath.fmu\" }}, \
             {{ file = \"LateralPid.fmu\" }}]\n"
        );
        let file = study(&format!("{coupling}.toml"), &text);
        let swept = sweep(folder.path(), &file, &["--trajectories", ".", "--of", "0"]);
        assert_eq!(swept.status.code(), Some(0), "{}", text_of(&swept));
        let line = format!(
            "simulate {{chain}}/IdentifiedPlant.fmu {{chain}}/ReferencePath.fmu \
             {{chain}}/LateralPid.fmu --step 10ms --stop 6s --coupling {coupling}"
        );
        let simulated = steerwright(folder.path(), &crate::support::words(&line, archives()));
        assert_eq!(simulated.status.code(), Some(0), "{}", text_of(&simulated));
        let recorded = |file: &str, name| column(&folder.path().join(file), name);
        for name in [
            "time",
            "IdentifiedPlant.y",
            "IdentifiedPlant.yaw_rate",
            "ReferencePath.yaw_reference",
            "LateralPid.steering_angle",
            "LateralPid.saturated",
        ] {
            let ours = recorded("run-0.csv", name);
            assert_eq!(ours.len(), 601);
            assert_eq!(ours, recorded("result.csv", name), "{coupling}: {name}");
        }
    }
}

/// A plant that aborts where its misbehaviour is 9, and ends fatally where it is 3.
const CRASHING: &str = r#"
seed = 3
runs = 30
step_s = 0.01
stop_s = 0.5
fmu = [{ file = "crashing.fmu", name = "plant" }]
[[vary]]
variables = ["plant.misbehaviour"]
distribution = "choice"
values = [0, 3, 9]
weights = [8, 1, 1]
[[vary]]
variables = ["plant.u"]
distribution = "uniform"
minimum = 0.0
maximum = 1.0
[[metric]]
name = "y"
variable = "plant.y"
kind = "final"
"#;

/// Run 1 of 3 hangs in its first step.
const HANGING: &str = r#"
seed = 3
runs = 1
step_s = 0.01
stop_s = 0.5
fmu = [{ file = "crashing.fmu", name = "plant" }]
[[vary]]
variables = ["plant.misbehaviour"]
distribution = "grid"
values = [0, 10, 0]
[[metric]]
name = "y"
variable = "plant.y"
kind = "final"
"#;

#[test]
fn isolated_a_crash_is_the_row_of_its_run() {
    use crate::crashing::{Behaviour, binary_path, library, xml, zip_of};
    let folder = tempfile::tempdir().unwrap();
    let Some(library) = library(Behaviour::Integrator) else { return };
    let described = xml(("u", ""), ("y", ""));
    let files = [("modelDescription.xml", described.as_bytes()), (&binary_path(), library)];
    fs::write(folder.path().join("crashing.fmu"), zip_of(&files)).unwrap();
    let file = folder.path().join("study.toml");
    fs::write(&file, CRASHING).unwrap();
    let mut tables = Vec::new();
    for threads in ["1", "2"] {
        let out = format!("{threads}.csv");
        let how =
            ["--isolate", "--threads", threads, "-o", &out, "--trajectories", "of", "--of", "0"];
        let output = sweep(folder.path(), &file, &how);
        assert_eq!(output.status.code(), Some(1), "{}", text_of(&output));
        tables.push(fs::read_to_string(folder.path().join(out)).unwrap());
    }
    assert_eq!(tables[0], tables[1]);
    assert_eq!(tables[0].lines().count(), 31);
    let mut seen = [0; 3];
    for row in tables[0].lines().skip(1) {
        let cells: Vec<&str> = row.split(',').collect();
        match cells[1] {
            "0" => {
                seen[0] += 1;
                // x' = u over half a second.
                let (u, y): (f64, f64) = (cells[2].parse().unwrap(), cells[3].parse().unwrap());
                assert!(
                    (y - 0.5 * u).abs() < 1e-12 && cells[4] == "met" && cells[5] == "ok",
                    "{row}"
                );
            }
            "3" => {
                seen[1] += 1;
                assert!(row.contains("fmi2DoStep returned fatal"), "{row}");
            }
            _ => {
                seen[2] += 1;
                assert!(row.contains("error: the process ended: "), "{row}");
            }
        }
    }
    assert!(seen.iter().all(|count| *count > 0), "{seen:?}");
    assert!(folder.path().join("of/run-0.csv").is_file());
    // One that hangs for some seconds ends its run alone, or the sweep.
    let hanging = folder.path().join("hanging.toml");
    fs::write(&hanging, HANGING).unwrap();
    let patient = ["--timeout", "1s", "--threads", "1"];
    let apart = [&patient[..], &["--isolate", "-o", "apart.csv"]].concat();
    let output = sweep(folder.path(), &hanging, &apart);
    assert_eq!(output.status.code(), Some(1), "{}", text_of(&output));
    let table = fs::read_to_string(folder.path().join("apart.csv")).unwrap();
    let rows: Vec<&str> = table.lines().skip(1).collect();
    assert!(rows[0].contains(",ok,") && rows[2].contains(",ok,"), "{table}");
    assert!(rows[1].contains("error: the run takes longer than 1 s"), "{table}");
    let here = [&patient[..], &["-o", "hung.csv"]].concat();
    let output = sweep(folder.path(), &hanging, &here);
    assert_eq!(output.status.code(), Some(2), "{}", text_of(&output));
    let text = text_of(&output);
    assert!(text.contains("error: run 1 hangs") && text.contains("holds 1 of 3 runs"), "{text}");
    let more = ["--resume", "--isolate", "--timeout", "1s", "-o", "hung.csv"];
    assert_eq!(sweep(folder.path(), &hanging, &more).status.code(), Some(1));
    assert_eq!(fs::read_to_string(folder.path().join("hung.csv")).unwrap(), table);
    // In one process, the rows before the crash are kept.
    let output = sweep(folder.path(), &file, &["-o", "here.csv", "--threads", "1"]);
    assert_eq!(output.status.code(), Some(2), "{}", text_of(&output));
    let here = fs::read_to_string(folder.path().join("here.csv")).unwrap();
    assert!(tables[0].starts_with(&here) && here.ends_with('\n'));
    // Also where an FMU ends the process as if all were done.
    let exiting = folder.path().join("exiting.toml");
    fs::write(&exiting, HANGING.replace("[0, 10, 0]", "[0, 14, 0]")).unwrap();
    let output = sweep(folder.path(), &exiting, &["-o", "exited.csv", "--threads", "1"]);
    let text = text_of(&output);
    assert_eq!(output.status.code(), Some(2), "{text}");
    assert!(text.contains("ended with exit status: 0 before the command was done"), "{text}");
    assert!(text.contains("exited.csv has the runs that were done"), "{text}");
    let table = fs::read_to_string(folder.path().join("exited.csv")).unwrap();
    // The row of the run before may not be written yet.
    assert!((1..=2).contains(&table.lines().count()), "{table}");
    // In the first step there are no results yet, and none of before are taken for them.
    fs::write(&exiting, HANGING.replace("[0, 10, 0]", "[14, 14, 14]")).unwrap();
    for _ in 0..2 {
        let output = sweep(folder.path(), &exiting, &["-o", "none.csv", "--force"]);
        let text = text_of(&output);
        assert_eq!(output.status.code(), Some(2), "{text}");
        assert!(text.contains("before the command was done\n"), "{text}");
    }
    fs::write(&exiting, HANGING.replace("[0, 10, 0]", "[0, 14, 0]")).unwrap();
    let more = ["--resume", "--isolate", "-o", "exited.csv"];
    assert_eq!(sweep(folder.path(), &exiting, &more).status.code(), Some(1));
    let table = fs::read_to_string(folder.path().join("exited.csv")).unwrap();
    assert_eq!(table.lines().count(), 4, "{table}");
    assert!(table.contains("error: the process ended: "), "{table}");
}

/// However the runs are shared out, FMUs are instantiated before the first one.
#[test]
fn an_fmu_that_ends_the_process_or_hangs_before_the_first_run_is_an_error() {
    use crate::crashing::{Behaviour, binary_path, library, xml, zip_of};
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("study.toml");
    fs::write(&file, CRASHING).unwrap();
    let described = xml(("u", ""), ("y", ""));
    for (behaviour, expected) in [
        (Behaviour::EndsLoaded, "ended with exit status: 0 before the command was done"),
        (Behaviour::EndsInstantiated, "ended with exit status: 0 before the command was done"),
        (Behaviour::Uninstantiable, "an FMU does not return within 1 s, before the first run"),
    ] {
        let Some(library) = library(behaviour) else { return };
        let files = [("modelDescription.xml", described.as_bytes()), (&binary_path(), library)];
        fs::write(folder.path().join("crashing.fmu"), zip_of(&files)).unwrap();
        let of_all =
            [&["--isolate"][..], &["--shard", "0/2"], &["--shard", "0/2", "--isolate"], &[]];
        for more in of_all {
            let output = sweep(folder.path(), &file, &[more, &["--timeout", "1s"]].concat());
            let text = text_of(&output);
            assert_eq!(output.status.code(), Some(2), "{more:?}: {text}");
            assert!(text.contains(expected), "{more:?}: {text}");
        }
        let piece = folder.path().join("piece.csv");
        fs::write(&piece, "").unwrap();
        let words = ["sweep", "merge", "study.toml", "piece.csv"].map(std::ffi::OsStr::new);
        if !expected.contains("return") {
            let output = steerwright(folder.path(), &words);
            assert_eq!(output.status.code(), Some(2), "{}", text_of(&output));
            assert!(text_of(&output).contains(expected), "{}", text_of(&output));
        }
    }
    let mut left: Vec<_> =
        fs::read_dir(folder.path()).unwrap().map(|e| e.unwrap().file_name()).collect();
    left.sort();
    assert_eq!(left, ["crashing.fmu", "piece.csv", "study.toml"]);
}

#[cfg(unix)]
#[test]
fn an_interrupt_ends_cleanly_and_is_resumed() {
    /// So many that they are not over before the signal comes.
    const RUNS: usize = 400;
    let folder = tempfile::tempdir().unwrap();
    let file = study("long.toml", &small(RUNS, "20.0"));
    let whole = sweep(folder.path(), &file, &["-o", "whole.csv"]);
    assert_eq!(whole.status.code(), Some(0), "{}", text_of(&whole));
    for isolate in [&[][..], &["--isolate"][..]] {
        let out = folder.path().join("cut.csv");
        let _ = fs::remove_file(&out);
        let child = std::process::Command::new(env!("CARGO_BIN_EXE_steerwright"))
            .arg("sweep")
            .arg(&file)
            .args(["--threads", "1", "--force", "-o"])
            .arg(&out)
            .args(isolate)
            .stderr(std::process::Stdio::piped())
            .spawn()
            .unwrap();
        // The first rows are there: it is at work.
        let rows = || fs::read_to_string(&out).map_or(0, |text| text.lines().count());
        while rows() < 4 {
            std::thread::sleep(std::time::Duration::from_millis(2));
        }
        let interrupt = ["-INT".to_owned(), child.id().to_string()];
        assert!(std::process::Command::new("kill").args(interrupt).status().unwrap().success());
        let ended = child.wait_with_output().unwrap();
        assert_eq!(ended.status.code(), Some(2));
        let text = String::from_utf8_lossy(&ended.stderr).into_owned();
        assert!(text.contains("interrupted: ") && text.contains("--resume"), "{text}");
        assert!((4..RUNS).contains(&rows()));
        let mut more = vec!["--resume", "-o", "cut.csv"];
        more.extend(isolate);
        assert_eq!(sweep(folder.path(), &file, &more).status.code(), Some(0));
        let same = fs::read(&out).unwrap() == fs::read(folder.path().join("whole.csv")).unwrap();
        assert!(same, "{isolate:?}");
    }
}

#[test]
fn bad_studies_are_bad_input() {
    let folder = tempfile::tempdir().unwrap();
    for (from, to, says) in [
        (
            "noise_seed\"]",
            "noise_sed\"]",
            "bad.toml:49:14: IdentifiedPlant has no variable \"noise_sed\"; near it: noise_seed",
        ),
        ("maximum = 60.0", "maximum = 40.0", "minimum 48 is not below maximum 40"),
        (
            "standard_deviation = 2.0\nminimum = 48.0",
            "standard_deviation = 20.0\nminimum = -5.0",
            "beyond its minimum 0",
        ),
        ("IdentifiedPlant.fmu", "Missing.fmu", "Missing.fmu"),
    ] {
        let text = small(2, "1.0");
        assert!(text.contains(from));
        let file = study("bad.toml", &text.replace(from, to));
        let output = sweep(folder.path(), &file, &[]);
        assert_eq!(output.status.code(), Some(2));
        let text = text_of(&output);
        assert!(text.contains(says) && text.contains("\nhint: "), "{text}");
        assert!(!folder.path().join("results.csv").exists());
    }
}
