//! `steerwright simulate` with FMUs as other tools write them: names with dots, start times, FMUs that
//! end the simulation or fail in it.

use crate::crashing::{Behaviour, binary_path, library, xml, zip_of};
use crate::support::{column, steerwright, text_of};
use std::path::Path;

/// Writes an archive of an integrator from 0 to 1 s by steps of 0.1 s, with changes of its XML.
fn integrator(folder: &Path, file: &str, changes: &[(&str, &str)]) -> Option<()> {
    let mut text = xml(("u", ""), ("y", "")).replace(
        "<ModelVariables>",
        r#"<DefaultExperiment startTime="0" stopTime="1" stepSize="0.1"/><ModelVariables>"#,
    );
    for (from, to) in changes {
        assert!(text.contains(from), "{from}");
        text = text.replace(from, to);
    }
    // One character, one byte.
    let bytes: Vec<u8> = text.chars().map(|c| u8::try_from(u32::from(c)).unwrap()).collect();
    let files =
        [("modelDescription.xml", &*bytes), (&binary_path(), library(Behaviour::Integrator)?)];
    std::fs::write(folder.join(file), zip_of(&files)).unwrap();
    Some(())
}

/// Runs a line of `steerwright`; its status and what it printed.
fn run(folder: &Path, line: &str) -> (Option<i32>, String) {
    let words: Vec<&str> = line.split_whitespace().collect();
    let output = steerwright(folder, &words);
    (output.status.code(), text_of(&output))
}

#[test]
fn a_model_name_with_dots_leaves_the_name_of_the_file() {
    let folder = tempfile::tempdir().unwrap();
    let dotted = [("modelName=\"Test\"", "modelName=\"Plants.Car\"")];
    let Some(()) = integrator(folder.path(), "Car.fmu", &dotted) else { return };
    let (status, text) = run(folder.path(), "simulate Car.fmu --set Car.u=1");
    assert_eq!(status, Some(0), "{text}");
    assert_eq!(column(&folder.path().join("result.csv"), "Car.y").len(), 11);

    let twice = "simulate front=Car.fmu rear=Car.fmu --set rear.u=1 -o two.csv";
    let (status, text) = run(folder.path(), twice);
    assert_eq!(status, Some(0), "{text}");
    let last = |name: &str| column(&folder.path().join("two.csv"), name)[10];
    assert_eq!(last("front.y"), 0.0);
    assert!((last("rear.y") - 1.0).abs() < 1e-12);
    let (status, text) = run(folder.path(), "simulate Car.fmu Car.fmu");
    assert!(status == Some(2) && text.contains("front=A.fmu rear=A.fmu"), "{text}");
    let (status, text) = run(folder.path(), "simulate a.b=Car.fmu");
    assert!(status == Some(2) && text.contains("\"a.b\" cannot be the name"), "{text}");
    // The output is never a file that is read, under whatever name of its unit.
    let (status, text) = run(folder.path(), "simulate car=Car.fmu -o Car.fmu --force");
    assert!(status == Some(2) && text.contains("this output is also an input"), "{text}");
    // A file whose name has the sign.
    std::fs::rename(folder.path().join("Car.fmu"), folder.path().join("a=b.fmu")).unwrap();
    let (status, text) = run(folder.path(), "simulate a=b.fmu car=a=b.fmu -o result.csv --force");
    assert_eq!(status, Some(0), "{text}");
    assert!(text.contains("a=b.y") && text.contains("car.y"), "{text}");
}

#[test]
fn the_recommended_start_time_is_the_start() {
    let folder = tempfile::tempdir().unwrap();
    let late = [("startTime=\"0\" stopTime=\"1\"", "startTime=\"100\" stopTime=\"101\"")];
    let Some(()) = integrator(folder.path(), "Late.fmu", &late) else { return };
    let times = |line: &str| {
        let (status, text) = run(folder.path(), &format!("simulate {line} -o times.csv --force"));
        assert_eq!(status, Some(0), "{text}");
        let times = column(&folder.path().join("times.csv"), "time");
        (times[0], times[times.len() - 1], times.len(), text)
    };
    let (first, last, rows, _) = times("Late.fmu");
    assert_eq!((first, last, rows), (100.0, 101.0, 11));
    let (first, last, rows, _) = times("Late.fmu --start 100.5s");
    assert_eq!((first, last, rows), (100.5, 101.0, 6));
    let (first, last, rows, _) = times("Late.fmu --start -1s --stop 0s");
    assert_eq!((first, last, rows), (-1.0, 0.0, 11));
    let (status, text) = run(folder.path(), "simulate Late.fmu --stop 1s");
    assert!(status == Some(2) && text.contains("start 100 s, step 0.1 s and stop 1 s"), "{text}");

    integrator(folder.path(), "Early.fmu", &[]).unwrap();
    let (first, last, rows, text) = times("late=Late.fmu early=Early.fmu");
    assert_eq!((first, last, rows), (0.0, 101.0, 1011));
    assert!(text.contains("the FMUs recommend start times from 0 s to 100 s"), "{text}");
}

#[test]
fn an_fmu_that_ends_the_simulation_is_a_success_with_its_rows() {
    let folder = tempfile::tempdir().unwrap();
    let Some(()) = integrator(folder.path(), "Ends.fmu", &[]) else { return };
    let line = "simulate Ends.fmu --set Test.misbehaviour=12 --set Test.u=1";
    let (status, text) = run(folder.path(), line);
    assert_eq!(status, Some(0), "{text}");
    assert!(text.contains("Test: the FMU ended the simulation at t = 0.525 s"), "{text}");
    let file = folder.path().join("result.csv");
    let (times, y) = (column(&file, "time"), column(&file, "Test.y"));
    assert_eq!((times.len(), times[6]), (7, 0.525));
    assert!((y[6] - 0.525).abs() < 1e-12);
}

#[test]
fn a_run_that_fails_leaves_its_rows_and_names_the_time() {
    let folder = tempfile::tempdir().unwrap();
    let Some(()) = integrator(folder.path(), "Fails.fmu", &[]) else { return };
    let (status, text) = run(folder.path(), "simulate Fails.fmu --set Test.misbehaviour=13");
    assert_eq!(status, Some(2), "{text}");
    let failed = "the run failed after t = 0.5 s; result.csv has its 6 rows: Test: fmi2DoStep \
                  returned error at t = 0.5 s";
    assert!(text.contains(failed) && text.contains("broken at last"), "{text}");
    assert_eq!(column(&folder.path().join("result.csv"), "time").len(), 6);
}

#[test]
fn an_fmu_that_ends_the_process_is_no_success() {
    let folder = tempfile::tempdir().unwrap();
    let Some(()) = integrator(folder.path(), "Exits.fmu", &[]) else { return };
    let (status, text) = run(folder.path(), "simulate Exits.fmu --set Test.misbehaviour=14");
    assert_eq!(status, Some(2), "{text}");
    assert!(
        text.contains("error: the process that runs the FMUs ended with exit status: 0"),
        "{text}"
    );
    assert!(text.contains("result.csv has its 1 row until t = 0 s"), "{text}");
    assert_eq!(column(&folder.path().join("result.csv"), "time"), [0.0]);
    let (status, text) = run(folder.path(), "simulate Exits.fmu --set Test.misbehaviour=9");
    assert_eq!(status, Some(2), "{text}");
    let signal = "ended with signal SIGABRT before the command was done";
    assert!(!cfg!(unix) || text.contains(signal), "{text}");
}

#[test]
fn an_fmu_that_crashes_leaves_the_rows_of_the_run() {
    let folder = tempfile::tempdir().unwrap();
    let Some(()) = integrator(folder.path(), "Crashes.fmu", &[]) else { return };
    let line = "simulate Crashes.fmu --set Test.misbehaviour=16 --set Test.u=1";
    let (status, text) = run(folder.path(), line);
    assert_eq!(status, Some(2), "{text}");
    assert!(text.contains("; result.csv has its 6 rows until t = 0.5 s"), "{text}");
    let file = folder.path().join("result.csv");
    let (times, y) = (column(&file, "time"), column(&file, "Test.y"));
    assert_eq!((times.len(), times[5]), (6, 0.5));
    assert!((y[5] - 0.5).abs() < 1e-12);
    // By the rules of all outputs: what is no recording of these variables is not written over.
    std::fs::write(&file, "my notes").unwrap();
    let (status, text) = run(folder.path(), line);
    assert_eq!(status, Some(2), "{text}");
    assert_eq!(std::fs::read_to_string(&file).unwrap(), "my notes");
}

#[cfg(unix)]
#[test]
fn inputs_come_from_standard_input() {
    let folder = tempfile::tempdir().unwrap();
    let Some(()) = integrator(folder.path(), "Exits.fmu", &[]) else { return };
    std::fs::write(folder.path().join("u.csv"), "time,u\n0,2\n").unwrap();
    let run = |line: &str| {
        let output = std::process::Command::new(env!("CARGO_BIN_EXE_steerwright"))
            .args(line.split_whitespace())
            .current_dir(folder.path())
            .stdin(std::fs::File::open(folder.path().join("u.csv")).unwrap())
            .output()
            .unwrap();
        (output.status.code(), text_of(&output))
    };
    let (status, text) = run("simulate Exits.fmu --input /dev/stdin");
    assert_eq!(status, Some(0), "{text}");
    let last = column(&folder.path().join("result.csv"), "Test.y").pop().unwrap();
    assert!((last - 2.0).abs() < 1e-9, "{last}");
    // Also then the FMUs run in a process of their own.
    let (status, text) =
        run("simulate Exits.fmu --input /dev/stdin --force --set Test.misbehaviour=14");
    assert_eq!(status, Some(2), "{text}");
}

#[test]
fn breaches_that_are_tolerated_are_warnings() {
    let folder = tempfile::tempdir().unwrap();
    let latin = [("UTF-8", "ISO-8859-1"), ("name=\"gain\"", "name=\"Verstärkung\"")];
    let Some(()) = integrator(folder.path(), "Latin.fmu", &latin) else { return };
    let (status, text) = run(folder.path(), "simulate Latin.fmu --set Test.Verstärkung=2");
    assert_eq!(status, Some(0), "{text}");
    assert!(text.contains("warning: Latin.fmu: modelDescription.xml is in ISO-8859-1"), "{text}");
}
