//! Faulty binaries are found under the right rule, and none crashes the checker.
#![allow(clippy::unwrap_used, clippy::panic)]

use crate::corpus;

use corpus::{Files, base};
use std::path::PathBuf;
use std::time::{Duration, Instant};
use steerwright_checker::run::{Command, supervise};
use steerwright_checker::{Finding, Severity};

/// The program of the child process, an example that cargo builds with the tests.
fn command() -> Command {
    let mut path: PathBuf = std::env::current_exe().unwrap();
    path.pop();
    path.pop();
    let program = path.join("examples").join(format!("check{}", std::env::consts::EXE_SUFFIX));
    assert!(program.exists(), "first run `cargo build -p steerwright-checker --example check`");
    Command { program, arguments: Vec::new(), option: "--run-child".into() }
}

fn findings(files: &Files) -> Vec<Finding> {
    findings_within(files, Duration::from_secs(60))
}

fn findings_within(files: &Files, time_limit: Duration) -> Vec<Finding> {
    let folder = tempfile::tempdir().unwrap();
    let fmu = folder.path().join("Base.fmu");
    std::fs::write(&fmu, files.zip()).unwrap();
    let report = steerwright_checker::check_file(&fmu).unwrap();
    supervise(&command(), &fmu, &report, time_limit).unwrap()
}

/// The base with a fault and an experiment of 1,000 steps to 10 s.
fn faulty_late(fault: &str) -> Files {
    let mut files = faulty(fault);
    files.replace(r#"stopTime="1" stepSize="0.125""#, r#"stopTime="10" stepSize="0.01""#);
    files
}

/// The time that the note of the span states.
fn span(findings: &[Finding]) -> &str {
    let mut spans = findings.iter().filter(|f| f.rule == "run-span").map(|f| f.message.as_str());
    let span = spans.next().unwrap_or_default();
    assert_eq!(spans.next(), None);
    span
}

fn rules(findings: &[Finding]) -> Vec<&'static str> {
    let mut rules: Vec<_> =
        findings.iter().filter(|f| f.severity > Severity::Note).map(|f| f.rule).collect();
    rules.dedup();
    rules
}

/// The base with a fault of its binary, which the GUID selects.
fn faulty(fault: &str) -> Files {
    let mut files = base();
    files.replace(r#"guid="base""#, &format!("guid=\"base-{fault}\""));
    files
}

#[test]
fn the_good_binary_passes() {
    let found = findings(&base());
    assert_eq!(found.len(), 1, "{found:?}");
    assert_eq!(
        span(&found),
        "ran from 0 s to 1 s in 8 steps of 0.125 s: the whole DefaultExperiment"
    );
}

#[test]
fn each_fault_of_a_binary_is_found_under_its_rule() {
    for (fault, rule) in [
        ("crash", "run-crash"),
        ("null", "run-crash"),
        ("any-guid", "run-guid"),
        ("refuse", "run-instantiate"),
        ("start", "run-start"),
        ("nan", "run-value"),
        ("reset", "run-reset"),
        ("state", "run-state"),
        ("serialize", "run-call"),
        ("initialization", "run-call"),
        ("step", "run-call"),
        ("log", "run-log-category"),
        // A different start value, also after a reset.
        ("gain", "run-start"),
        ("chance", "run-nondeterministic"),
        ("global", "run-instances"),
        ("step-size", "run-step-size"),
        ("dependency", "run-dependency"),
        ("path", "run-instantiate"),
    ] {
        let found = findings(&faulty(fault));
        assert_eq!(rules(&found), [rule], "{fault}: {found:#?}");
    }
}

/// The experiment is run to its stop time, and what happens late in it is reported with its time.
#[test]
fn faults_late_in_the_experiment_are_found() {
    let found = findings(&faulty_late(""));
    let whole = "ran from 0 s to 10 s in 1000 steps of 0.01 s: the whole DefaultExperiment";
    assert_eq!((rules(&found), span(&found)), (vec![], whole));
    for (fault, rule, message) in [
        ("late", "run-crash", "in fmi2DoStep from t = 6 s"),
        ("error-late", "run-call", "whole: fmi2DoStep returned error at t = 6 s"),
        ("nan-late", "run-value", "`y[1]` is NaN at t = 6 s"),
    ] {
        let found = findings(&faulty_late(fault));
        assert_eq!(rules(&found), [rule], "{fault}: {found:#?}");
        assert!(found.iter().any(|f| f.message.contains(message)), "{fault}: {found:#?}");
    }
    let found = findings_within(&faulty_late("hang-late"), Duration::from_secs(3));
    assert_eq!(rules(&found), ["run-hang"]);
    assert!(found[0].message.contains("in fmi2DoStep from t = 6 s"), "{found:?}");
}

#[test]
fn a_long_experiment_ends_within_the_time_limit_and_its_span_is_stated() {
    let mut files = base();
    files.replace(r#"stopTime="1""#, r#"stopTime="1e8""#);
    let start = Instant::now();
    let found = findings_within(&files, Duration::from_secs(4));
    assert!(start.elapsed() < Duration::from_secs(4));
    assert_eq!(rules(&found), [""; 0], "{found:?}");
    let cut = "the time limit ends the run, the stop time is after 800000000 steps";
    assert!(
        span(&found).starts_with("ran from 0 s to ") && span(&found).ends_with(cut),
        "{found:?}"
    );
    let mut files = base();
    files.replace(r#" stopTime="1""#, "");
    let found = findings(&files);
    let open = "ran from 0 s to 12.5 s in 100 steps of 0.125 s: DefaultExperiment has no stop time";
    assert_eq!(span(&found), open);
}

/// The encoding is a breach, the description is read all the same.
#[test]
fn an_archive_in_latin_1_is_run() {
    let mut files = faulty("crash");
    files.replace("UTF-8", "ISO-8859-1");
    assert_eq!(rules(&findings(&files)), ["run-crash"]);
    files.replace("logAll", "logüAll");
    let xml = files.get("modelDescription.xml");
    let text = String::from_utf8(xml.clone()).unwrap();
    *xml = text.chars().map(|c| u8::try_from(u32::from(c)).unwrap()).collect();
    assert_eq!(rules(&findings(&files)), ["run-crash"]);
    let report = steerwright_checker::check(&files.zip(), "Base.fmu");
    assert_eq!(rules(&report.findings), ["xml-encoding"]);
}

#[test]
fn a_dot_in_a_path_is_a_warning_and_the_archive_is_run() {
    let mut files = faulty("crash");
    files.add("./", b"");
    for name in ["modelDescription.xml", "resources/data.txt"] {
        files.rename(name, &format!("./{name}"));
    }
    assert_eq!(rules(&findings(&files)), ["run-crash"]);
    let report = steerwright_checker::check(&files.zip(), "Base.fmu");
    assert_eq!(rules(&report.findings), ["zip-dot-name"], "{:?}", report.findings);
    assert_eq!((report.errors, report.warnings), (0, 3));
    files.add("resources/./data.txt", b"another");
    let report = steerwright_checker::check(&files.zip(), "Base.fmu");
    assert!(rules(&report.findings).contains(&"zip-duplicate"), "{:?}", report.findings);
}

#[test]
fn an_identifier_that_is_no_c_identifier_is_a_warning_and_the_archive_is_run() {
    let mut files = faulty("crash");
    files.replace(r#"modelIdentifier="Base""#, r#"modelIdentifier="1-Base""#);
    let name = corpus::binary_name();
    files.rename(&name, &name.replace("Base", "1-Base"));
    assert_eq!(rules(&findings(&files)), ["run-crash"]);
    let report = steerwright_checker::check(&files.zip(), "Base.fmu");
    assert_eq!((report.errors, report.warnings), (0, 1), "{:?}", report.findings);
    let mut files = base();
    files.replace(r#"modelIdentifier="Base""#, r#"modelIdentifier="../Base""#);
    let report = steerwright_checker::check(&files.zip(), "Base.fmu");
    assert!(rules(&report.findings).contains(&"model-identifier-path"), "{:?}", report.findings);
}

#[test]
fn findings_name_the_binary_and_no_temporary_folder() {
    let mut files = with_reference("time,x\n0,0\n");
    files.replace(r#"guid="base""#, r#"guid="base-path""#);
    // One cause, one finding: the reference is not replayed.
    let [found] = findings(&files).try_into().unwrap();
    assert_eq!(found.location.entry, Some(corpus::binary_name()));
    assert!(
        found.message.ends_with(" resources") || found.message.ends_with("]resources"),
        "{}",
        found.message
    );
    let temporary = std::env::temp_dir();
    assert!(!found.message.contains(&*temporary.to_string_lossy()), "{}", found.message);
    let found = findings(&faulty("crash"));
    assert_eq!(found[0].location.entry, Some(corpus::binary_name()));
}

/// Each run reads the derivatives, but a wrong one is one finding.
#[test]
fn a_fault_in_every_run_is_reported_once() {
    let found = findings(&faulty("derivative"));
    assert_eq!(rules(&found), ["run-value"], "{found:#?}");
    let messages: Vec<_> = found.iter().map(|f| f.message.as_str()).collect();
    assert_eq!(messages, ["`derivative of y[2] by x` is NaN", span(&found)]);
}

/// Differences of single precision and output are notes, not violations.
#[test]
fn rounding_and_output_are_notes() {
    for (fault, rule) in [
        ("rounded", "run-start-rounding"),
        #[cfg(all(target_os = "linux", target_arch = "x86_64"))]
        ("output", "run-output"),
    ] {
        let found = findings(&faulty(fault));
        let notes = found.iter().filter(|f| f.rule != "run-span").map(|f| (f.rule, f.severity));
        assert_eq!(notes.collect::<Vec<_>>(), [(rule, Severity::Note)], "{fault}: {found:#?}");
        assert!(span(&found).ends_with("the whole DefaultExperiment"), "{fault}: {found:#?}");
    }
}

/// Steps may be discarded (table 4.2.4); calls that the host then rejects are not faults of the FMU.
#[test]
fn discarded_steps_are_no_fault() {
    let found = findings(&faulty("discard"));
    assert_eq!(found.len(), 1, "{found:?}");
    let ended = "ran from 0 s to 0.375 s in 3 steps of 0.125 s: the FMU discards the next step or ends \
                 the simulation";
    assert_eq!(span(&found), ended);
}

#[test]
fn a_crash_is_reported_with_the_call() {
    let found = findings(&faulty("crash"));
    assert!(found[0].message.contains("in fmi2DoStep"), "{found:?}");
    let found = findings(&faulty("null"));
    assert!(found[0].message.contains("fmi2FreeInstance(NULL)"), "{found:?}");
}

#[test]
fn a_binary_that_hangs_is_ended() {
    let start = Instant::now();
    let found = findings_within(&faulty("hang"), Duration::from_secs(1));
    assert_eq!(rules(&found), ["run-hang"]);
    assert!(start.elapsed() < Duration::from_secs(20));
}

/// The base with a reference; `result` is the table.
fn with_reference(result: &str) -> Files {
    let mut files = base();
    let reference = r#"{"schema": "steerwright/reference/1", "input": "in.csv", "result": "out.csv",
        "start_time": 0.0, "stop_time": 1.0, "step_size": 0.25, "absolute_tolerance": 1e-9}"#;
    let folder = "extra/io.github.steerwright/reference";
    files.add(&format!("{folder}/reference.json"), reference.as_bytes());
    // Constant until the next row: 1 m/s for half a second, then 2 m/s.
    files.add(&format!("{folder}/in.csv"), b"time,u,gain\n0,1,3\n0.5,2,3\n");
    files.add(&format!("{folder}/out.csv"), result.as_bytes());
    files
}

#[test]
fn references_are_replayed() {
    // x is the integral of the input, y[1] is 3 x.
    let good = "time,x,y[1],moving\n0,0,0,1\n0.25,0.25,0.75,1\n0.5,0.5,1.5,1\n1,1.5,4.5,1\n";
    let found = findings(&with_reference(good));
    assert_eq!(rules(&found), [""; 0], "{found:?}");
    assert_eq!(found[0].rule, "run-reference-difference");

    let bad = good.replace("1,1.5,4.5", "1,1.5,4.6");
    let found = findings(&with_reference(&bad));
    assert_eq!(rules(&found), ["run-reference"], "{found:?}");
    assert!(found.iter().any(|f| f.message.contains("`y[1]` at 1 s")), "{found:?}");

    let off = format!("{good}1.1,2,2,1\n");
    assert_eq!(rules(&findings(&with_reference(&off))), ["run-reference"]);

    let mut strange = with_reference(good);
    *strange.get("extra/io.github.steerwright/reference/out.csv") = b"t,x\n0,0\n".to_vec();
    assert_eq!(rules(&findings(&strange)), ["run-reference-form"]);
}

#[test]
fn an_unsafe_archive_is_not_run() {
    let mut files = base();
    files.rename("resources/data.txt", "../data.txt");
    let found = findings(&files);
    assert_eq!(found.iter().map(|f| f.rule).collect::<Vec<_>>(), ["run-skipped"]);
}
