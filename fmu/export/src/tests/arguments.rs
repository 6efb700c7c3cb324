//! Classes of arguments: a rejected call changes nothing.

use super::host::{DISCARD, ERROR, Host, OK, WARNING, call};
use super::probe::{COUNT, GAIN, LABEL, N, ON, U, Y};
use crate::calls::State;
use std::ffi::{CStr, c_char};
use std::ptr::{null, null_mut};

/// A host at a communication point whose call must fail and change nothing.
fn rejected(what: &str, call: impl FnOnce(&Host) -> i32) {
    let host = Host::in_state(State::StepComplete);
    let before = host.values();
    assert_eq!(call(&host), ERROR, "{what}");
    assert_eq!(host.values(), before, "{what}");
    assert_eq!(host.state(), State::Error, "{what}");
    let lines = host.take_lines();
    assert_eq!(lines.len(), 1, "{what}: {lines:?}");
    assert_eq!((lines[0].1, lines[0].2.as_str()), (ERROR, "logStatusError"), "{what}");
    assert_eq!(call!(host, reset()), OK, "{what}");
}

#[test]
fn nothing_changes_when_one_of_many_is_wrong() {
    // The first pair is valid each time.
    let pairs = |reference: u32, value: f64| {
        move |host: &Host| {
            call!(host, set_real([GAIN, reference].as_ptr(), 2, [7.0, value].as_ptr()))
        }
    };
    rejected("unknown reference", pairs(999, 1.0));
    rejected("largest reference", pairs(u32::MAX, 1.0));
    rejected("an Integer", pairs(N, 1.0));
    rejected("an output", pairs(Y, 1.0));
    rejected("NaN", pairs(U, f64::NAN));
    rejected("infinity", pairs(U, f64::INFINITY));
    rejected("minus infinity", pairs(U, f64::NEG_INFINITY));
    rejected("parameter above its maximum", pairs(GAIN, 100.1));
    rejected("parameter below its minimum", pairs(GAIN, -0.1));
    let integers = |value: i32| {
        move |host: &Host| call!(host, set_integer([N, N].as_ptr(), 2, [3, value].as_ptr()))
    };
    rejected("Integer above its maximum", integers(6));
    rejected("Integer below its minimum", integers(i32::MIN));
    for value in [2, -1, i32::MIN] {
        rejected("not a Boolean", move |host| {
            call!(host, set_boolean([ON, ON].as_ptr(), 2, [1, value].as_ptr()))
        });
    }
    rejected("not UTF-8", |host| {
        let texts = [c"good".as_ptr(), c"\xff".as_ptr()];
        call!(host, set_string([LABEL, LABEL].as_ptr(), 2, texts.as_ptr()))
    });
    rejected("NULL text", |host| {
        let texts = [c"good".as_ptr(), null()];
        call!(host, set_string([LABEL, LABEL].as_ptr(), 2, texts.as_ptr()))
    });
}

#[test]
fn null_arrays() {
    let (mut real, mut integer, mut text) = (0.0, 0, null::<c_char>());
    rejected("", |host| call!(host, set_real(null(), 1, &1.0)));
    rejected("", |host| call!(host, set_real(&GAIN, 1, null())));
    rejected("", |host| call!(host, set_integer(null(), 1, &1)));
    rejected("", |host| call!(host, set_integer(&N, 1, null())));
    rejected("", |host| call!(host, set_boolean(&ON, 1, null())));
    rejected("", |host| call!(host, set_string(&LABEL, 1, null())));
    rejected("", |host| call!(host, get_real(null(), 1, &mut real)));
    rejected("", |host| call!(host, get_real(&Y, 1, null_mut())));
    rejected("", |host| call!(host, get_integer(null(), 1, &mut integer)));
    rejected("", |host| call!(host, get_integer(&N, 1, null_mut())));
    rejected("", |host| call!(host, get_boolean(&ON, 1, null_mut())));
    rejected("", |host| call!(host, get_string(null(), 1, &mut text)));
    rejected("", |host| call!(host, get_string(&LABEL, 1, null_mut())));
    rejected("", |host| call!(host, get_real(&Y, usize::MAX, &mut real)));
    rejected("", |host| call!(host, get_real_status(2, null_mut())));
    rejected("", |host| call!(host, get_fmu_state(null_mut())));
    rejected("", |host| call!(host, set_fmu_state(null_mut())));
    rejected("", |host| call!(host, set_debug_logging(1, 1, null())));
    rejected("", |host| call!(host, set_debug_logging(1, 1, [null()].as_ptr())));
    rejected("", |host| call!(host, set_debug_logging(2, 0, null())));
}

#[test]
fn zero_length_needs_no_array() {
    let host = Host::in_state(State::StepComplete);
    assert_eq!(call!(host, set_real(null(), 0, null())), OK);
    assert_eq!(call!(host, set_string(null(), 0, null())), OK);
    assert_eq!(call!(host, get_real(null(), 0, null_mut())), OK);
    assert_eq!(call!(host, get_string(null(), 0, null_mut())), OK);
}

#[test]
fn null_component() {
    let null = Host::null();
    for call in crate::calls::Call::ALL.iter().filter(|call| call.name() != "fmi2Instantiate") {
        let needs_none = ["fmi2GetTypesPlatform", "fmi2GetVersion", "fmi2FreeInstance"];
        let expected = if needs_none.contains(&call.name()) { OK } else { ERROR };
        assert_eq!(null.make(*call), expected, "{}", call.name());
    }
    // Freeing a null component is ignored.
}

#[test]
fn a_failed_read_writes_nothing() {
    let host = Host::in_state(State::StepComplete);
    let mut values = [1.25, 1.25];
    assert_eq!(call!(host, get_real([Y, 999].as_ptr(), 2, values.as_mut_ptr())), ERROR);
    assert_eq!(values, [1.25, 1.25]);
}

#[test]
fn inputs_are_clipped_with_one_warning_each() {
    let host = Host::in_state(State::StepComplete);
    assert_eq!(host.set_real(U, 11.0), WARNING);
    assert_eq!(host.real(U), 10.0);
    assert_eq!(host.set_real(U, -1e300), OK);
    assert_eq!(host.real(U), -10.0);
    assert_eq!(host.set_integer(COUNT, -1), WARNING);
    assert_eq!(host.integer(COUNT), 0);
    assert_eq!(host.set_integer(COUNT, i32::MAX), OK);
    assert_eq!(host.integer(COUNT), 9);
    let lines = host.take_lines();
    assert_eq!(lines.len(), 2, "{lines:?}");
    assert!(lines.iter().all(|line| line.1 == WARNING && line.2 == "logStatusWarning"));
    // The limit itself is valid.
    assert_eq!(Host::in_state(State::StepComplete).set_real(U, 10.0), OK);
}

#[test]
fn values_are_read_as_they_were_set() {
    let host = Host::in_state(State::StepComplete);
    let references = [U, GAIN];
    assert_eq!(call!(host, set_real(references.as_ptr(), 2, [0.1 + 0.2, 1e-300].as_ptr())), OK);
    let mut values = [0.0; 2];
    assert_eq!(call!(host, get_real(references.as_ptr(), 2, values.as_mut_ptr())), OK);
    assert_eq!(values, [0.1 + 0.2, 1e-300]);
    assert_eq!(host.set_boolean(ON, 1), OK);
    let mut on = 7;
    assert_eq!(call!(host, get_boolean(&ON, 1, &mut on)), OK);
    assert_eq!(on, 1);
    let text = c"gr\xc3\xbc\xc3\x9fe %s";
    assert_eq!(call!(host, set_string(&LABEL, 1, &text.as_ptr())), OK);
    let mut back = [null(); 2];
    assert_eq!(call!(host, get_string([LABEL, LABEL].as_ptr(), 2, back.as_mut_ptr())), OK);
    for back in back {
        // SAFETY: a string of the instance, alive until the next call.
        assert_eq!(unsafe { CStr::from_ptr(back) }, text);
    }
}

#[test]
fn statuses() {
    let host = Host::in_state(State::StepComplete);
    assert_eq!(host.do_step(0.0, 0.25), OK);
    let (mut real, mut integer) = (0.0, 7);
    assert_eq!(call!(host, get_real_status(2, &mut real)), OK);
    assert_eq!(real, 0.25);
    assert_eq!(call!(host, get_boolean_status(3, &mut integer)), OK);
    assert_eq!(integer, 0);
    for kind in [-1, 0, 1, 3, 4, i32::MAX] {
        assert_eq!(call!(host, get_real_status(kind, &mut real)), DISCARD, "{kind}");
    }
    assert_eq!(call!(host, get_boolean_status(2, &mut integer)), DISCARD);
    assert_eq!(call!(host, get_status(99, &mut integer)), DISCARD);
    assert_eq!(host.state(), State::StepComplete);
}
