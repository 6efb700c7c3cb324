//! Serialized FMU states, and everything that a state restores.

use super::host::{ERROR, OK, STATES, WARNING};
use super::plant::*;
use crate::access_rules::Leniency;
use crate::boundary as c;
use crate::calls::State;
use sha2::{Digest, Sha256};
use std::ffi::c_void;
use std::ptr::{null, null_mut};

/// A plant in the middle of a run, with everything that can be pending: a clipped input, a derivative,
/// a variable that was set, a stop time.
fn halfway() -> Rig {
    let rig = Rig::new();
    assert_eq!(on!(rig, setup_experiment(0, 0.0, 1.0, 1, 4.0)), OK);
    assert_eq!(on!(rig, enter_initialization_mode()), OK);
    assert_eq!(rig.set(X1, 0.3), OK);
    assert_eq!(on!(rig, exit_initialization_mode()), OK);
    for k in 0..5 {
        assert_eq!(rig.set(U, f64::from(k).sin()), OK);
        assert_eq!(on!(rig, do_step(1.0 + 0.1 * f64::from(k), 0.1, 1)), OK);
    }
    assert_eq!(rig.set(U, 2e3), WARNING);
    assert_eq!(on!(rig, set_real_input_derivatives(&U, 1, &1, &0.7)), OK);
    rig
}

/// The further run of the plant: statuses and bits of the outputs.
fn run(rig: &Rig) -> Vec<(i32, u64, u64)> {
    (5..15)
        .map(|k| {
            let status = on!(rig, do_step(1.0 + 0.1 * f64::from(k), 0.1, 1));
            let bits = (rig.real(Y).to_bits(), rig.real(Z).to_bits());
            // Clipped at every second step: a warning only the first time.
            let status = 10 * status + rig.set(U, f64::from(k % 2) * 2e3);
            (status, bits.0, bits.1)
        })
        .collect()
}

fn save(rig: &Rig) -> *mut c_void {
    let mut state = null_mut();
    assert_eq!(on!(rig, get_fmu_state(&mut state)), OK);
    state
}

fn free(rig: &Rig, mut state: *mut c_void) {
    assert_eq!(on!(rig, free_fmu_state(&mut state)), OK);
}

fn serialize(rig: &Rig, state: *mut c_void) -> Vec<u8> {
    let mut size = 0;
    assert_eq!(on!(rig, serialized_fmu_state_size(state, &mut size)), OK);
    let mut bytes = vec![0_u8; size];
    assert_eq!(on!(rig, serialize_fmu_state(state, bytes.as_mut_ptr().cast(), size)), OK);
    bytes
}

fn blob() -> Vec<u8> {
    let rig = halfway();
    let state = save(&rig);
    let bytes = serialize(&rig, state);
    free(&rig, state);
    bytes
}

/// The status and, if there is one, the state, which is freed.
fn load(rig: &Rig, bytes: &[u8]) -> i32 {
    let mut state = null_mut();
    let status = on!(rig, de_serialize_fmu_state(bytes.as_ptr().cast(), bytes.len(), &mut state));
    assert_eq!(state.is_null(), status != OK);
    free(rig, state);
    status
}

#[test]
fn another_instance_goes_on_with_the_same_bits() {
    let rig = halfway();
    let state = save(&rig);
    let bytes = serialize(&rig, state);
    let expected = run(&rig);
    // The same instance, from the state and from the bytes.
    assert_eq!(on!(rig, set_fmu_state(state)), OK);
    assert_eq!(run(&rig), expected);
    free(&rig, state);
    // New instances in any state, from the bytes; the clipped input is not logged again.
    for (start, _) in STATES {
        let other = Rig::in_state(start);
        let mut state = null_mut();
        let status =
            on!(other, de_serialize_fmu_state(bytes.as_ptr().cast(), bytes.len(), &mut state));
        assert_eq!(status, OK, "{start:?} {:?}", other.take_lines());
        assert_eq!(other.state(), start);
        assert_eq!(on!(other, set_fmu_state(state)), OK);
        assert_eq!(serialize(&other, state), bytes);
        assert_eq!(run(&other), expected, "{start:?}");
        // The experiment is restored too.
        assert_eq!(on!(other, do_step(2.5, 2.0, 1)), ERROR);
        assert!(other.take_lines().last().unwrap().3.contains("stop time 4"));
        free(&other, state);
    }
}

/// Outside a run: in each state of the machine.
#[test]
fn every_state_of_the_machine_is_restored() {
    for (state, _) in STATES {
        let rig = Rig::in_state(state);
        let saved = save(&rig);
        let bytes = serialize(&rig, saved);
        free(&rig, saved);
        let other = Rig::new();
        let mut loaded = null_mut();
        let status =
            on!(other, de_serialize_fmu_state(bytes.as_ptr().cast(), bytes.len(), &mut loaded));
        assert_eq!(status, OK);
        assert_eq!(on!(other, set_fmu_state(loaded)), OK);
        assert_eq!(other.state(), state);
        free(&other, loaded);
    }
}

#[test]
fn every_bit_counts() {
    let bytes = blob();
    assert_eq!(load(&Rig::new(), &bytes), OK);
    for bit in 0..8 * bytes.len() {
        let mut damaged = bytes.clone();
        damaged[bit / 8] ^= 1 << (bit % 8);
        let rig = Rig::new();
        assert_eq!(load(&rig, &damaged), ERROR, "bit {bit}");
        let lines = rig.take_lines();
        assert_eq!(lines.len(), 1, "{lines:?}");
        assert!(lines[0].3.starts_with("fmi2DeSerializeFMUstate: the "), "{lines:?}");
    }
}

#[test]
fn too_short_and_too_long() {
    let bytes = blob();
    for length in 0..bytes.len() {
        assert_eq!(load(&Rig::new(), &bytes[..length]), ERROR, "{length}");
    }
    for extra in [1, 4, 32, 1000] {
        let mut longer = bytes.clone();
        longer.extend(std::iter::repeat_n(0, extra));
        assert_eq!(load(&Rig::new(), &longer), ERROR, "{extra}");
    }
    assert_eq!(load(&Rig::new(), &[0xff; 4096]), ERROR);
}

/// Replaces bytes and corrects the checksum.
fn forged(change: impl Fn(&mut Vec<u8>)) -> Vec<u8> {
    let mut bytes = blob();
    bytes.truncate(bytes.len() - 32);
    change(&mut bytes);
    let digest = Sha256::digest(&bytes);
    bytes.extend(&digest[..]);
    bytes
}

/// Each field is checked even if the checksum is correct. Offsets after magic 8, version 4 and GUID
/// 4 + 36.
#[test]
fn foreign_and_forged_states_are_distinguished() {
    const STATE: usize = 52;
    const TIME: usize = STATE + 1 + 9 + 9;
    let reason = |bytes: &[u8]| {
        let rig = Rig::new();
        assert_eq!(load(&rig, bytes), ERROR);
        rig.take_lines().remove(0).3
    };
    assert_eq!(load(&Rig::new(), &forged(|_| {})), OK);
    assert!(reason(b"{\"json\": true}").contains("not a serialized FMU state"));
    assert!(reason(&forged(|b| b[8] = 2)).contains("version 2"));
    assert!(reason(&forged(|b| b[20] ^= 1)).contains("of another FMU"));
    for change in [
        (|b| b[STATE] = 5) as fn(&mut Vec<u8>), // fatal
        |b| b[STATE] = 77,                      // not a state
        |b| b[STATE + 1] = 2,                   // not a flag
        |b| b[TIME..TIME + 8].copy_from_slice(&f64::NAN.to_le_bytes()),
        |b| b[TIME + 8] = 9, // not a flag
        |b| b[TIME + 9..TIME + 13].copy_from_slice(&u32::MAX.to_le_bytes()), // a long list
        |b| b[TIME + 13] = 4, // not an input
        |b| b[TIME + 21] = 9, // derivative of a discrete input
        |b| b.push(0),
    ] {
        let reason = reason(&forged(change));
        assert!(reason.contains("has invalid values"), "{reason}");
    }
    // The unit checks its own bytes.
    let unit = |b: &mut Vec<u8>| {
        let at = b.len() - 64;
        b[at..at + 4].copy_from_slice(&59_u32.to_le_bytes());
        b.pop();
    };
    assert!(reason(&forged(unit)).ends_with("59 bytes instead of 60"));
}

#[test]
fn pointers_and_sizes() {
    let rig = halfway();
    let state = save(&rig);
    let bytes = serialize(&rig, state);
    let needed = bytes.len();
    let retry = |status: i32, what: &str| {
        assert_eq!(status, ERROR, "{what}");
        assert_eq!(on!(rig, set_fmu_state(state)), OK);
    };
    let mut buffer = vec![0x55_u8; needed + 9];
    let pointer = buffer.as_mut_ptr().cast();
    for size in [0, 1, needed - 1] {
        retry(on!(rig, serialize_fmu_state(state, pointer, size)), "too small");
        assert!(buffer.iter().all(|byte| *byte == 0x55));
    }
    assert_eq!(on!(rig, serialize_fmu_state(state, pointer, needed + 9)), OK);
    assert_eq!(buffer[..needed], bytes);
    assert_eq!(buffer[needed..], [0x55; 9]);
    let mut size = 0;
    retry(on!(rig, serialized_fmu_state_size(null_mut(), &mut size)), "no state");
    retry(on!(rig, serialized_fmu_state_size(state, null_mut())), "no size");
    retry(on!(rig, serialize_fmu_state(null_mut(), pointer, needed)), "no state");
    retry(on!(rig, serialize_fmu_state(state, null_mut(), needed)), "no buffer");
    retry(on!(rig, serialize_fmu_state(rig.component, pointer, needed)), "not a state");
    let mut other = null_mut();
    retry(on!(rig, de_serialize_fmu_state(null(), needed, &mut other)), "no bytes");
    retry(on!(rig, de_serialize_fmu_state(bytes.as_ptr().cast(), 0, &mut other)), "no bytes");
    retry(on!(rig, de_serialize_fmu_state(bytes.as_ptr().cast(), needed, null_mut())), "no slot");
    assert!(other.is_null());
    // A slot with a state receives a new one; the old one stays alive.
    let mut slot = state;
    assert_eq!(on!(rig, de_serialize_fmu_state(bytes.as_ptr().cast(), needed, &mut slot)), OK);
    assert_ne!(slot, state);
    // So does an uninitialized slot.
    let mut wild = std::ptr::without_provenance_mut::<c_void>(0xdead_beef);
    assert_eq!(on!(rig, de_serialize_fmu_state(bytes.as_ptr().cast(), needed, &mut wild)), OK);
    for state in [state, slot, wild] {
        assert_eq!(on!(rig, set_fmu_state(state)), OK);
        free(&rig, state);
    }
    // A state that was freed.
    let freed = state;
    assert_eq!(on!(rig, serialized_fmu_state_size(freed, &mut size)), ERROR);
}

/// A failed load does not change the slot.
#[test]
fn invalid_bytes_create_no_state() {
    let rig = halfway();
    let state = save(&rig);
    let mut slot = state;
    assert_eq!(on!(rig, de_serialize_fmu_state([1_i8; 9].as_ptr().cast(), 9, &mut slot)), ERROR);
    assert_eq!(slot, state);
    free(&rig, state);
}

/// A state restores the list of clipped inputs: clipping after it returns the same status again.
#[test]
fn a_warning_after_the_state_is_returned_again() {
    let rig = Rig::in_state(State::StepComplete);
    let state = save(&rig);
    assert_eq!(rig.set(U, 2e3), WARNING);
    assert_eq!(rig.set(U, 2e3), OK);
    assert_eq!(on!(rig, set_fmu_state(state)), OK);
    assert_eq!(rig.set(U, 2e3), WARNING);
    free(&rig, state);
    // Restoring a state repeatedly does not flood the log.
    assert_eq!(rig.take_lines().len(), 1);
}

#[test]
fn a_reset_instance_is_a_fresh_one_to_the_last_bit() {
    let fingerprint = |rig: &Rig| {
        let state = save(rig);
        let bytes = serialize(rig, state);
        free(rig, state);
        bytes
    };
    let fresh = Rig::new();
    let rig = halfway();
    assert_ne!(fingerprint(&rig), fingerprint(&fresh));
    let log = |rig: &Rig| {
        // Debug lines, once each: an early input, any variable in M, a read after setting.
        assert_eq!(rig.set(U, 0.0), OK);
        assert_eq!(on!(rig, setup_experiment(0, 0.0, 0.0, 0, 0.0)), OK);
        assert_eq!(on!(rig, enter_initialization_mode()), OK);
        rig.real(U);
        assert_eq!(on!(rig, exit_initialization_mode()), OK);
        assert_eq!(rig.set(U, 0.0), OK);
        rig.real(U);
        assert_eq!(rig.set(U, 2e3), WARNING);
        rig.take_lines().into_iter().map(|line| line.3).collect::<Vec<_>>()
    };
    assert_eq!(on!(rig, reset()), OK);
    assert_eq!(fingerprint(&rig), fingerprint(&fresh));
    let loud = Rig::instantiated(true);
    let first = log(&loud);
    assert_eq!(first.len(), 4, "{first:?}");
    assert!(Leniency::ALL.iter().all(|leniency| first.iter().any(|l| l == leniency.text())));
    assert_eq!(on!(loud, reset()), OK);
    assert_eq!(log(&loud), first);
    // The log settings are restored too.
    assert_eq!(on!(loud, reset()), OK);
    assert_eq!(on!(loud, set_debug_logging(0, 0, null())), OK);
    assert_eq!(on!(loud, reset()), OK);
    assert_eq!(log(&loud), first);
}

#[test]
fn every_state_is_freed() {
    let rig = halfway();
    let state = save(&rig);
    let bytes = serialize(&rig, state);
    for _ in 0..100 {
        assert_eq!(load(&rig, &bytes), OK);
    }
    free(&rig, state);
    // SAFETY: a live instance; the state is freed already and only its address is looked up.
    assert_eq!(unsafe { c::set_fmu_state::<Plant>(rig.component, state) }, ERROR);
}
