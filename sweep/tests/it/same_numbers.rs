//! A row depends on the study and the run's index alone: not on threads, interruptions, the other
//! runs, or whether an instance is new.

use crate::support::{How, column, folder, prepare, results, run, run_with, study};
use std::fs;
use steerwright_host::{Archive, Coupling, Instance, System};
use steerwright_sweep::Error;

#[test]
fn threads_change_no_byte() {
    let Some(folder) = folder(|_, xml| xml) else { return };
    let (one, finished) = results(folder.path(), &study(60), 1);
    assert_eq!((finished.rows, finished.threads, finished.summary.errors), (60, 1, 0));
    for threads in [2, 7] {
        assert_eq!(results(folder.path(), &study(60), threads).0, one, "{threads} threads");
    }
    // The runs do differ.
    let rms = column(&one, "yaw_rms");
    assert_ne!(rms[0], rms[1]);
}

#[test]
fn an_interrupted_sweep_resumed_is_the_same_file() {
    // So many that the interrupt comes before the last one, however quick the machine is.
    const RUNS: usize = 5000;
    let Some(folder) = folder(|_, xml| xml) else { return };
    let (whole, _) = results(folder.path(), &study(RUNS), 1);
    let sweep = prepare(folder.path(), &study(RUNS)).unwrap();
    let out = folder.path().join("interrupted.csv");
    for (threads, cut) in [(1, 0), (2, 11), (3, 1)] {
        let _ = fs::remove_file(&out);
        let how = How { threads, stop_after: Some(7), ..How::default() };
        let first = run(&sweep, &out, how).unwrap();
        assert!((7..RUNS).contains(&first.rows), "{} rows", first.rows);
        let half = fs::read_to_string(&out).unwrap();
        assert!(half.ends_with('\n') && whole.starts_with(&half), "whole rows, in order");
        // What is there is not lost by forgetting --resume.
        let again = run(&sweep, &out, How { threads, ..How::default() }).unwrap_err();
        assert!(matches!(again, Error::Unfinished { rows, runs: RUNS, .. } if rows == first.rows));
        // A machine may die in the middle of a row.
        fs::write(&out, &half[..half.len() - cut]).unwrap();
        let rest = run(&sweep, &out, How { threads, resume: true, ..How::default() }).unwrap();
        assert_eq!(rest.rows, RUNS);
        assert_eq!(rest.resumed, first.rows - usize::from(cut > 0));
        assert_eq!(fs::read_to_string(&out).unwrap(), whole, "{threads} threads, {cut} bytes lost");
    }
    // The summary is of all rows, whoever made them.
    let resumed = run(&sweep, &out, How { threads: 1, resume: true, ..How::default() }).unwrap();
    assert_eq!(resumed.resumed, RUNS);
    assert_eq!(resumed.summary, results(folder.path(), &study(RUNS), 2).1.summary);
}

#[test]
fn a_changed_study_or_fmu_is_not_resumed() {
    let Some(folder) = folder(|_, xml| xml) else { return };
    let out = folder.path().join("results.csv");
    let sweep = prepare(folder.path(), &study(9)).unwrap();
    run(&sweep, &out, How { threads: 1, stop_after: Some(3), ..How::default() }).unwrap();
    let how = How { threads: 1, resume: true, ..How::default() };
    let refused = |text: &str| {
        let sweep = prepare(folder.path(), text).unwrap();
        let error = run(&sweep, &out, how).unwrap_err();
        assert!(matches!(error, Error::Resume { .. }), "{error}");
        assert!(!error.hint().is_empty());
    };
    refused(&study(9).replace("maximum = 3.0", "maximum = 3.1"));
    refused(&study(9).replace("yaw_rms", "yaw_rms_rad"));
    // Comments and layout are not the study.
    let commented = format!("# a remark\n\n{}", study(9));
    // The other FMU has the same variables and other numbers.
    let plant = folder.path().join("plant.fmu");
    let bytes = fs::read(&plant).unwrap();
    let other =
        crate::support::folder(|_, xml| xml.replace("start=\"1\"", "start=\"1.0\"")).unwrap();
    fs::copy(other.path().join("plant.fmu"), &plant).unwrap();
    refused(&study(9));
    fs::write(&plant, bytes).unwrap();
    let sweep = prepare(folder.path(), &commented).unwrap();
    assert_eq!(run(&sweep, &out, how).unwrap().rows, 9);
    fs::write(&out, "time,x\n0,1\n").unwrap();
    refused(&study(9));
}

#[test]
fn reset_instances_and_new_ones_give_the_same() {
    let Some(folder) = folder(|_, xml| xml) else { return };
    let (fresh, _) = results(folder.path(), &study(20), 2);
    let reset = study(20).replacen("runs", "instances = \"reset\"\nruns", 1);
    let (reset, _) = results(folder.path(), &reset, 2);
    for name in ["pid.gain", "yaw_rms", "steering_max", "settled"] {
        assert_eq!(column(&fresh, name), column(&reset, name), "{name}");
    }
}

#[test]
fn a_run_is_the_hosts_own_to_the_bit() {
    let Some(folder) = folder(|_, xml| xml) else { return };
    for (name, coupling) in [("gauss-seidel", Coupling::GaussSeidel), ("jacobi", Coupling::Jacobi)]
    {
        let text = study(3).replace("amplitude = 0.5", "amplitude = 0.0");
        let text = text.replace("amplitude = \"kick\"", "amplitude = 0.0");
        let text = text.replacen(
            "runs",
            &format!("coupling = \"{name}\"\nrecord = [\"pid.is_positive\"]\nruns"),
            1,
        );
        let sweep = prepare(folder.path(), &text).unwrap();
        let out = folder.path().join(format!("{name}.csv"));
        let into = folder.path().join(name);
        let how = How { threads: 2, ..How::default() };
        run_with(&sweep, &out, how, Some((into.clone(), vec![2]))).unwrap();
        let gain = &column(&fs::read_to_string(&out).unwrap(), "pid.gain")[2];

        let mut system = System::new();
        for name in ["plant", "path", "pid"] {
            let archive = Archive::open(folder.path().join(format!("{name}.fmu"))).unwrap();
            system.add(Instance::new(&archive, name).unwrap()).unwrap();
        }
        system.connect_by_name(&[]).unwrap();
        let gain = format!("pid.gain={gain}");
        for setting in ["path.gain=-1.5", "path.offset=0.3", "plant.offset=0.1", &gain] {
            system.set_text(setting).unwrap();
        }
        let recording = system.run(coupling, 0.0, 1.0, 0.01).unwrap();
        let trajectory = fs::read_to_string(into.join("run-2.csv")).unwrap();
        for name in ["plant.yaw", "path.yaw_reference", "pid.steering_angle", "pid.is_positive"] {
            let ours = crate::support::numbers(&trajectory, name);
            assert_eq!(ours, recording.column(name).unwrap(), "{name}");
            assert_eq!(ours.len(), 101);
        }
        assert!(!into.join("run-0.csv").exists());
    }
}
