//! A panic in any callback is fatal and logged, prints nothing to stderr, and spares other instances.

use super::host::{ERROR, FATAL, Host, OK, call};
use super::probe::*;
use crate::calls::State;
use std::ptr::null_mut;

/// The instance is unusable and can still be freed; one line with `text` was logged.
fn unusable(host: Host, status: i32, function: &str, text: &str) {
    assert_eq!(status, FATAL, "{text}");
    assert_eq!(host.state(), State::Fatal);
    let lines = host.take_lines();
    assert_eq!(lines.len(), 1, "{lines:?}");
    let (name, status, category, message) = &lines[0];
    assert_eq!((name.as_str(), *status, category.as_str()), ("probe", FATAL, "logStatusFatal"));
    assert!(message.starts_with(function) && message.ends_with(text), "{message}");
    assert_eq!(host.do_step(0.0, 1.0), FATAL);
    assert_eq!(host.take_lines(), []);
}

#[test]
fn in_every_callback() {
    let bystander = Host::in_state(State::StepComplete);
    let at = |state, fault| {
        let host = Host::in_state(state);
        assert_eq!(host.set_integer(FAULT, fault), OK);
        host
    };
    let host = at(State::Initialization, PANIC_IN_EXIT);
    let status = call!(host, exit_initialization_mode());
    unusable(host, status, "fmi2ExitInitializationMode", "exit");

    let host = at(State::StepComplete, PANIC_IN_STEP);
    let status = host.do_step(0.0, 0.1);
    unusable(host, status, "fmi2DoStep", "step 1");

    let host = at(State::StepComplete, PANIC_IN_GET);
    let status = call!(host, get_real(&Y, 1, &mut 0.0));
    unusable(host, status, "fmi2GetReal", "get");

    let host = Host::in_state(State::StepComplete);
    let status = host.set_integer(FAULT, PANIC_IN_SET);
    unusable(host, status, "fmi2SetInteger", "set");

    let host = at(State::StepComplete, PANIC_IN_CLONE);
    let mut state = null_mut();
    let status = call!(host, get_fmu_state(&mut state));
    assert!(state.is_null());
    unusable(host, status, "fmi2GetFMUstate", "clone");

    let host = at(State::StepComplete, PANIC_IN_DROP);
    let status = call!(host, reset());
    // The old unit is dropped; the instance is unusable.
    unusable(host, status, "fmi2Reset", "drop");

    // Freeing an instance whose destructor panics.
    drop(at(State::StepComplete, PANIC_IN_DROP));

    assert_eq!(bystander.do_step(0.0, 0.1), OK);
}

#[test]
fn an_error_is_not_a_panic() {
    let host = Host::in_state(State::Initialization);
    assert_eq!(host.set_integer(FAULT, ERROR_IN_EXIT), OK);
    assert_eq!(call!(host, exit_initialization_mode()), ERROR);
    assert_eq!(host.state(), State::Error);
    assert_eq!(call!(host, reset()), OK);
}

/// Runs itself as a process with a panicking instance and checks its stderr.
#[test]
fn nothing_appears_on_stderr() {
    if std::env::var_os("FMI2_EXPORT_PANIC").is_some() {
        let host = Host::in_state(State::StepComplete);
        assert_eq!(host.set_integer(FAULT, PANIC_IN_STEP), OK);
        assert_eq!(host.do_step(0.0, 0.1), FATAL);
        return;
    }
    let output = std::process::Command::new(std::env::current_exe().unwrap())
        .args(["--exact", "tests::panics::nothing_appears_on_stderr", "--nocapture"])
        .env("FMI2_EXPORT_PANIC", "1")
        .output()
        .unwrap();
    assert!(output.status.success());
    assert_eq!(String::from_utf8_lossy(&output.stderr), "");
}

/// Panics outside the layer are reported as usual.
#[test]
fn other_panics_are_still_reported() {
    if std::env::var_os("FMI2_EXPORT_PANIC").is_some() {
        let _host = Host::new(false);
        let _ = std::panic::catch_unwind(|| panic!("reported"));
        return;
    }
    let output = std::process::Command::new(std::env::current_exe().unwrap())
        .args(["--exact", "tests::panics::other_panics_are_still_reported", "--nocapture"])
        .env("FMI2_EXPORT_PANIC", "1")
        .output()
        .unwrap();
    assert!(String::from_utf8_lossy(&output.stderr).contains("reported"));
}
