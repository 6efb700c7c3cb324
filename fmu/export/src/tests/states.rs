//! FMU states.

use super::host::{ERROR, Host, OK, call};
use super::probe::{GAIN, U, Y};
use crate::calls::State;
use std::ptr::null_mut;

/// Makes ten steps from a time; returns the bits of the output after each.
fn run(host: &Host, from: i32) -> Vec<u64> {
    (0..10)
        .map(|k| {
            assert_eq!(host.set_real(U, f64::from(k).sin()), OK);
            assert_eq!(host.do_step(f64::from(from + k) * 0.1, 0.1), OK);
            host.real(Y).to_bits()
        })
        .collect()
}

#[test]
fn saved_run_restored_run_gives_the_same_bits() {
    let host = Host::in_state(State::StepComplete);
    run(&host, 0);
    let mut state = null_mut();
    assert_eq!(call!(host, get_fmu_state(&mut state)), OK);
    let first = run(&host, 10);
    assert_eq!(host.set_real(GAIN, 50.0), OK);
    assert_ne!(run(&host, 20), first);
    assert_eq!(call!(host, set_fmu_state(state)), OK);
    assert_eq!(run(&host, 10), first);
    // And in another instance, which is in another state.
    let other = Host::new(false);
    assert_eq!(call!(other, set_fmu_state(state)), OK);
    assert_eq!(other.state(), State::StepComplete);
    assert_eq!(run(&other, 10), first);
    assert_eq!(call!(other, free_fmu_state(&mut state)), OK);
    assert!(state.is_null());
}

#[test]
fn an_fmu_state_has_the_state_of_the_machine() {
    for state in [State::Instantiated, State::Initialization, State::StepComplete] {
        let host = Host::in_state(state);
        let mut saved = null_mut();
        assert_eq!(call!(host, get_fmu_state(&mut saved)), OK);
        assert_eq!(call!(host, cancel_step()), ERROR);
        assert_eq!(host.state(), State::Error);
        assert_eq!(call!(host, set_fmu_state(saved)), OK);
        assert_eq!(host.state(), state);
        assert_eq!(call!(host, free_fmu_state(&mut saved)), OK);
    }
}

#[test]
fn an_existing_state_is_overwritten() {
    let host = Host::in_state(State::StepComplete);
    let mut state = null_mut();
    assert_eq!(call!(host, get_fmu_state(&mut state)), OK);
    let address = state;
    assert_eq!(host.set_real(GAIN, 7.0), OK);
    assert_eq!(call!(host, get_fmu_state(&mut state)), OK);
    assert_eq!(state, address);
    assert_eq!(host.set_real(GAIN, 8.0), OK);
    assert_eq!(call!(host, set_fmu_state(state)), OK);
    assert_eq!(host.real(GAIN), 7.0);
    assert_eq!(call!(host, free_fmu_state(&mut state)), OK);
}

#[test]
fn freeing_null_is_ignored() {
    let host = Host::in_state(State::StepComplete);
    assert_eq!(call!(host, free_fmu_state(null_mut())), OK);
    let mut state = null_mut();
    assert_eq!(call!(host, free_fmu_state(&mut state)), OK);
}

#[test]
fn invalid_state_pointers_are_errors() {
    let host = Host::in_state(State::StepComplete);
    let mut state = null_mut();
    assert_eq!(call!(host, get_fmu_state(&mut state)), OK);
    let mut copy = state;
    assert_eq!(call!(host, free_fmu_state(&mut state)), OK);
    // Freed twice, set after it was freed, overwritten after it was freed, not a state.
    assert_eq!(call!(host, free_fmu_state(&mut copy)), ERROR);
    assert_eq!(call!(host, set_fmu_state(copy)), ERROR);
    assert_eq!(call!(host, get_fmu_state(&mut copy)), ERROR);
    assert_eq!(call!(host, set_fmu_state(host.component)), ERROR);
}
