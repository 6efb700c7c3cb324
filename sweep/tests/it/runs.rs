//! The effects of a study on a system, against a calculation by hand; runs that fail.

use crate::support::{How, LOOP, TOP, column, folder, numbers, prepare, results, run, study};
use std::fs;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Duration;

#[test]
fn disturbances_scales_and_renames_reach_the_inputs() {
    let Some(folder) = folder(|_, xml| xml) else { return };
    // x' = u + d: 0.5 from the free input, 2 for a second as a step, 0.4·0.5 as a gust's impulse.
    let text = r#"
seed = 1
runs = 1
step_s = 0.01
stop_s = 3.0
[[fmu]]
file = "plant.fmu"
name = "plant"
[[fmu]]
file = "path.fmu"
name = "copy"
rename = { yaw = "heading" }
[[connect]]
from = "plant.yaw"
to = "copy.yaw"
factor = 10.0
offset = 1.0
[set]
"plant.steering_angle" = "28.64788975654116 deg"
[[disturb]]
input = "plant.steering_angle"
shape = "step"
amplitude = 2.0
start_s = 2.0
[[disturb]]
input = "plant.steering_angle"
shape = "gust"
amplitude = 22.918311805232928
unit = "deg"
start_s = 1.0
duration_s = 1.0
[[metric]]
name = "yaw"
variable = "plant.yaw"
kind = "final"
[[metric]]
name = "copied"
variable = "copy.yaw_reference"
kind = "final"
[[metric]]
name = "input"
variable = "plant.steering_angle"
kind = "maximum"
[[metric]]
name = "yaw_deg"
variable = "plant.yaw"
unit = "deg"
kind = "final"
"#;
    let (table, _) = results(folder.path(), text, 1);
    let yaw = numbers(&table, "yaw")[0];
    assert!((yaw - (1.5 + 2.0 + 0.2)).abs() < 1e-9, "{yaw}");
    assert!((numbers(&table, "copied")[0] - (10.0 * yaw + 1.0)).abs() < 1e-9);
    assert!((numbers(&table, "input")[0] - 2.5).abs() < 1e-9);
    assert!((numbers(&table, "yaw_deg")[0] - yaw.to_degrees()).abs() < 1e-9);
    // Without the connection, the renamed input is wired to nothing; renamed alike, it is.
    let wired = text.replace(
        "[[connect]]\nfrom = \"plant.yaw\"\nto = \"copy.yaw\"\nfactor = 10.0\noffset = 1.0\n",
        "",
    );
    let (table, _) = results(folder.path(), &wired, 1);
    assert_eq!(numbers(&table, "copied")[0], 0.0);
    let wired =
        wired.replace("name = \"plant\"\n", "name = \"plant\"\nrename = { yaw = \"heading\" }\n");
    let (table, _) = results(folder.path(), &wired, 1);
    assert_eq!(numbers(&table, "copied")[0], numbers(&table, "yaw")[0]);
}

#[test]
fn a_grid_is_gone_through_with_all_its_draws() {
    let Some(folder) = folder(|_, xml| xml) else { return };
    let grid = r#"
[[vary]]
variables = ["path.gain"]
distribution = "grid"
values = [-1.0, -2.0]
[[vary]]
variables = ["plant.gain"]
distribution = "linspace"
minimum = 0.5
maximum = 1.5
count = 3
"#;
    let text = format!("{TOP}runs = 2\n{}{grid}", LOOP.replace("\"path.gain\" = -1.5\n", ""));
    let (table, finished) = results(folder.path(), &text, 2);
    assert_eq!(finished.rows, 12);
    let path = numbers(&table, "path.gain");
    assert_eq!(path[..6], [-1.0; 6]);
    assert_eq!(path[6..], [-2.0; 6]);
    let plant = numbers(&table, "plant.gain");
    assert_eq!(plant[..6], [0.5, 0.5, 1.0, 1.0, 1.5, 1.5]);
    let gains = numbers(&table, "pid.gain");
    assert!((1..12).all(|i| !gains[..i].contains(&gains[i])), "{gains:?}");
    // With shared draws, points differ by the grid alone.
    let shared = text.replacen("runs", "same_draws_on_grid = true\nruns", 1);
    let gains = numbers(&results(folder.path(), &shared, 2).0, "pid.gain");
    assert_ne!(gains[0], gains[1]);
    assert!(gains.chunks(2).all(|pair| pair == &gains[..2]), "{gains:?}");
}

#[test]
fn additions_to_a_study_leave_its_draws() {
    let Some(folder) = folder(|_, xml| xml) else { return };
    let (before, _) = results(folder.path(), &study(5), 1);
    let more = "[[vary]]\nvariables = [\"plant.gain\"]\ndistribution = \"log-uniform\"\n\
                minimum = 0.5\nmaximum = 2.0\n[[disturb]]";
    let (after, _) = results(folder.path(), &study(5).replacen("[[disturb]]", more, 1), 1);
    assert_eq!(column(&before, "pid.gain"), column(&after, "pid.gain"));
    assert_eq!(column(&before, "kick"), column(&after, "kick"));
    let (other_seed, _) = results(folder.path(), &study(5).replace("seed = 5", "seed = 6"), 1);
    assert_ne!(column(&before, "pid.gain"), column(&other_seed, "pid.gain"));
}

/// One run in three or so misbehaves: discards its step, errs, gives NaN.
const MISBEHAVING: &str = r#"
[[vary]]
variables = ["plant.misbehaviour"]
distribution = "choice"
values = [0, 1, 2, 7]
weights = [6, 1, 1, 1]
"#;

#[test]
fn a_run_that_goes_wrong_is_a_row_and_leaves_the_others_alone() {
    let Some(folder) = folder(|_, xml| xml) else { return };
    let (good, _) = results(folder.path(), &study(40), 1);
    for instances in ["fresh", "reset"] {
        let text = format!("{}{MISBEHAVING}", study(40));
        let text = text.replacen("runs", &format!("instances = \"{instances}\"\nruns"), 1);
        let (table, finished) = results(folder.path(), &text, 2);
        assert_eq!(results(folder.path(), &text, 1).0, table);
        let status = column(&table, "status");
        let kinds = numbers(&table, "plant.misbehaviour");
        for run in 0..40 {
            let expected = match kinds[run] as i32 {
                0 => "ok",
                1 => {
                    "error: plant: fmi2DoStep returned discard at t = 0 s, step 0.01 s; \
                      [discard, logStatusError] the step is too long"
                }
                2 => {
                    "error: plant: fmi2DoStep returned error at t = 0 s, step 0.01 s; \
                      [error, logStatusError] the model is broken: 100 %d"
                }
                _ => "error: plant.yaw is NaN at t = 0.01 s",
            };
            assert_eq!(status[run], expected);
            let same = column(&table, "yaw_rms")[run] == column(&good, "yaw_rms")[run];
            assert_eq!(same, kinds[run] == 0.0, "run {run}");
        }
        let errors = status.iter().filter(|s| *s != "ok").count();
        assert!((5..25).contains(&errors) && finished.summary.errors == errors);
        assert!(!finished.summary.all_passed());
        assert_eq!(finished.summary.metrics[0].count, 40 - errors);
    }
}

#[test]
fn a_fatal_end_keeps_the_rows_before_it_and_lets_others_go_on() {
    let Some(folder) = folder(|_, xml| xml) else { return };
    let text = format!("{}{MISBEHAVING}", study(40)).replace(
        "values = [0, 1, 2, 7]\nweights = [6, 1, 1, 1]",
        "values = [0, 3]\nweights = [9, 1]",
    );
    let out = folder.path().join("results.csv");
    let mut calls = 0;
    // Each call is a new process to the FMUs: their archives are extracted and loaded again.
    loop {
        let sweep = prepare(folder.path(), &text).unwrap();
        let finished =
            run(&sweep, &out, How { threads: 2, resume: true, ..How::default() }).unwrap();
        calls += 1;
        if finished.rows == 40 {
            break;
        }
        assert!(finished.fatal.is_some() && calls < 40);
    }
    let table = fs::read_to_string(&out).unwrap();
    let kinds = numbers(&table, "plant.misbehaviour");
    assert!(calls > 1 && kinds.contains(&3.0));
    for (kind, status) in kinds.iter().zip(column(&table, "status")) {
        assert_eq!(status == "ok", *kind == 0.0, "{status}");
    }
}

/// The run in which the FMU hangs, once it was reported; none before.
static HANGING: AtomicUsize = AtomicUsize::new(usize::MAX);

#[test]
fn an_fmu_that_does_not_return_is_reported_and_the_rows_before_it_are_kept() {
    let Some(folder) = folder(|_, xml| xml) else { return };
    let hangs = "[[vary]]\nvariables = [\"plant.misbehaviour\"]\n\
                 distribution = \"grid\"\nvalues = [0, 10]\n";
    let text = format!("{}{hangs}", study(1));
    let out = folder.path().join("results.csv");
    let sweep = prepare(folder.path(), &text).unwrap();
    let how = How {
        threads: 1,
        timeout: Some(Duration::from_millis(1500)),
        hung: &|run, rows| {
            // Run 1 hangs, after the row of run 0.
            assert_eq!(rows, 1);
            HANGING.store(run, Ordering::Relaxed);
        },
        ..How::default()
    };
    run(&sweep, &out, how).unwrap();
    assert_eq!(HANGING.load(Ordering::Relaxed), 1);
    // It came back after all, later than it may: between two steps that is seen.
    let table = fs::read_to_string(&out).unwrap();
    assert_eq!(column(&table, "status"), ["ok", "error: the run takes longer than 1.5 s"]);
}

#[test]
fn an_fmu_that_allows_one_instance_gets_one_thread() {
    let once = "canGetAndSetFMUstate=\"true\" canBeInstantiatedOnlyOncePerProcess=\"true\"";
    let edit = |_: &str, xml: String| xml.replace("canGetAndSetFMUstate=\"true\"", once);
    let Some(folder) = folder(edit) else { return };
    let (_, finished) = results(folder.path(), &study(4), 4);
    assert_eq!((finished.rows, finished.threads, finished.summary.errors), (4, 1, 0));
}
