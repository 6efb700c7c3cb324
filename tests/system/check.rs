//! `steerwright check` before our own archives, and its exit statuses.

use crate::support::{archives, demo, steerwright, text_of};
use std::path::PathBuf;

/// Every archive that the demo wrote, the nonlinear vehicle and the pose estimator.
fn every_archive() -> Vec<PathBuf> {
    let mut found: Vec<PathBuf> =
        ["NonlinearVehicle.fmu", "PoseEstimator.fmu"].map(|name| archives().join(name)).into();
    for drive in std::fs::read_dir(&demo().folder).unwrap().flatten() {
        for folder in std::fs::read_dir(drive.path()).into_iter().flatten().flatten() {
            for file in std::fs::read_dir(folder.path()).into_iter().flatten().flatten() {
                found.extend(Some(file.path()).filter(|p| p.extension() == Some("fmu".as_ref())));
            }
        }
    }
    found.sort();
    found
}

#[test]
fn our_archives_break_no_rule_at_rest_or_at_work() {
    let archives = every_archive();
    assert!(archives.len() >= 9, "{archives:?}");
    let mut arguments = vec!["check".into(), "--run".into(), "--json".into()];
    arguments.extend(archives.iter().map(|path| path.display().to_string()));
    let output = steerwright(&demo().folder, &arguments);
    assert_eq!(output.status.code(), Some(0), "{}", text_of(&output));
    let reports: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    let reports = reports.as_array().unwrap();
    assert_eq!(reports.len(), archives.len());
    for report in reports {
        assert_eq!(report["errors"], 0, "{report:#}");
        let findings = report["findings"].as_array().unwrap();
        // The whole experiment was run.
        let span = findings.iter().find(|f| f["rule"] == "run-span").unwrap();
        assert!(
            span["message"].as_str().unwrap().ends_with("the whole DefaultExperiment"),
            "{span}"
        );
        // The reference run that the archive brings was replayed.
        assert!(findings.iter().any(|f| f["rule"] == "run-reference-difference"), "{report:#}");
        for finding in findings {
            // What a run adds is notes at most, and no run was left out.
            let rule = finding["rule"].as_str().unwrap();
            let is_expected = matches!(rule, "run-reference-difference" | "run-span");
            assert!(!rule.starts_with("run-") || is_expected, "{finding:#}");
        }
    }
}

#[test]
fn exit_statuses_distinguish_errors_from_unreadable_files() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("text.fmu"), "no archive").unwrap();
    let output = steerwright(folder.path(), &["check", "text.fmu"]);
    assert_eq!(output.status.code(), Some(1));
    let text = text_of(&output);
    assert!(text.contains("error: archive: ") && text.contains("[zip-unreadable, FMI 2.0.5, 2.3]"));
    assert!(text.contains("hint: "), "{text}");
    assert!(output.stderr.is_empty(), "findings are a result");

    let output = steerwright(folder.path(), &["check", "--run", "text.fmu"]);
    assert!(text_of(&output).contains("run-skipped"), "{}", text_of(&output));

    for arguments in [&["check", "none.fmu"][..], &["check", "."], &["check"]] {
        let output = steerwright(folder.path(), arguments);
        assert_eq!(output.status.code(), Some(2), "{arguments:?}");
        assert!(text_of(&output).contains("hint: "), "{}", text_of(&output));
    }
    // Bad usage, not an FMU that hangs.
    for time in ["0s", "0ms"] {
        let output =
            steerwright(folder.path(), &["check", "--run", "--time-limit", time, "text.fmu"]);
        assert_eq!(output.status.code(), Some(2), "{}", text_of(&output));
    }

    // The readable file is reported, before and after an unreadable one.
    for files in [["text.fmu", "none.fmu"], ["none.fmu", "text.fmu"]] {
        let output = steerwright(folder.path(), &[&["check", "--json"], &files[..]].concat());
        assert_eq!(output.status.code(), Some(2));
        assert!(text_of(&output).contains("none.fmu: "), "{}", text_of(&output));
        let reports: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
        assert_eq!(reports.as_array().unwrap().len(), 1);
        assert_eq!(reports[0]["archive"], "text.fmu");
    }
}
