//! Lines that are repeated at every step do not flood the log.

use super::host::{Host, OK, WARNING, call};
use super::probe::{FAULT, U, WARNING_IN_STEP, Y};
use crate::calls::State;
use std::ptr::null;

#[test]
fn a_unit_that_warns_at_every_step_does_not_flood() {
    let host = Host::in_state(State::StepComplete);
    assert_eq!(host.set_integer(FAULT, WARNING_IN_STEP), OK);
    for k in 0..2000 {
        // The status is a warning each time.
        assert_eq!(host.do_step(f64::from(k), 1.0), WARNING);
    }
    let texts: Vec<String> = host.take_lines().into_iter().map(|line| line.3).collect();
    assert_eq!(texts.len(), 4, "{texts:?}");
    assert_eq!(texts[0], "too fast");
    for (text, number) in texts[1..].iter().zip(["no. 10 ", "no. 100 ", "no. 1000 "]) {
        assert!(text.starts_with("too fast") && text.contains(number), "{text}");
    }
    // A reset clears the counts.
    assert_eq!(call!(host, reset()), OK);
    assert_eq!(call!(host, setup_experiment(0, 0.0, 0.0, 0, 0.0)), OK);
    assert_eq!(call!(host, enter_initialization_mode()), OK);
    assert_eq!(host.set_integer(FAULT, WARNING_IN_STEP), OK);
    assert_eq!(call!(host, exit_initialization_mode()), OK);
    assert_eq!(host.do_step(0.0, 1.0), WARNING);
    assert_eq!(host.take_lines().len(), 1);
}

/// Lines of disabled categories are not counted: logging enabled later starts with the first line.
#[test]
fn lines_of_disabled_categories_are_not_counted() {
    let host = Host::in_state(State::StepComplete);
    assert_eq!(call!(host, set_debug_logging(0, 1, [c"logStatusWarning".as_ptr()].as_ptr())), OK);
    assert_eq!(host.set_integer(FAULT, WARNING_IN_STEP), OK);
    assert_eq!(host.do_step(0.0, 1.0), WARNING);
    assert_eq!(host.take_lines(), []);
    assert_eq!(call!(host, set_debug_logging(1, 0, null())), OK);
    assert_eq!(host.do_step(1.0, 1.0), WARNING);
    assert_eq!(host.take_lines()[0].3, "too fast");
}

/// Reading after setting, with no step between: accepted with fresh values and one debug line.
#[test]
fn reading_after_setting_is_noted_once() {
    let host = Host::in_state(State::StepComplete);
    call!(host, set_debug_logging(1, 0, null()));
    assert_eq!(host.real(Y), 0.0);
    assert_eq!(host.take_lines(), []);
    assert_eq!(host.set_real(U, 3.0), OK);
    assert_eq!(host.do_step(0.0, 0.5), OK);
    assert_eq!(host.real(Y), 3.0);
    assert_eq!(host.take_lines(), []);
    // A call that sets no variable does not count.
    assert_eq!(call!(host, set_real(null(), 0, null())), OK);
    assert_eq!(host.real(U), 3.0);
    assert_eq!(host.take_lines(), []);
    assert_eq!(host.set_real(U, 2.0), OK);
    assert_eq!(host.real(U), 2.0);
    let lines = host.take_lines();
    assert_eq!((lines.len(), lines[0].1, lines[0].2.as_str()), (1, OK, "logEvents"), "{lines:?}");
    assert_eq!(host.real(U), 2.0);
    assert_eq!(host.take_lines(), []);
}
