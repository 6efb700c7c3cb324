//! FMU states: pointers that are none, and serialized states that are damaged.

use super::Case;
use crate::api::{ERROR, OK, State, Status};
use crate::samples::Sample;
use crate::unit::Unit;
use std::ffi::c_char;
use std::ptr::{null, null_mut};

/// Somewhere that is no FMU state.
static ELSEWHERE: [u64; 64] = [0; 64];

fn elsewhere() -> State {
    ELSEWHERE.as_ptr().cast_mut().cast()
}

pub(super) fn cases(sample: &Sample) -> Vec<Case<'_>> {
    let mut cases = vec![
        Case::new("fmi2GetFMUstate", "new", OK, |unit| {
            let state = unit.save();
            unit.free(state);
            OK
        }),
        Case::new("fmi2GetFMUstate", "reused", OK, |unit| {
            let mut state = unit.save();
            let first = state;
            // SAFETY: a live instance and state.
            let status = unsafe { (unit.api.get_fmu_state)(unit.component, &mut state) };
            assert_eq!(state, first);
            unit.free(state);
            status
        }),
        Case::new("fmi2GetFMUstate", "NULL", ERROR, |unit| {
            // SAFETY: a live instance; null is refused.
            unsafe { (unit.api.get_fmu_state)(unit.component, null_mut()) }
        }),
        Case::new("fmi2GetFMUstate", "into something else", ERROR, |unit| {
            let mut state = elsewhere();
            // SAFETY: a live instance; what is no state is refused, and not written to.
            let status = unsafe { (unit.api.get_fmu_state)(unit.component, &mut state) };
            assert_eq!(state, elsewhere());
            status
        }),
        Case::new("fmi2SetFMUstate", "", OK, |unit| {
            let state = unit.save();
            let status = unit.restore(state);
            unit.free(state);
            status
        }),
        Case::new("fmi2SetFMUstate", "NULL", ERROR, |unit| unit.restore(null_mut())),
        Case::new("fmi2SetFMUstate", "something else", ERROR, |unit| unit.restore(elsewhere())),
        Case::new("fmi2SetFMUstate", "freed", ERROR, |unit| {
            let state = unit.save();
            unit.free(state);
            unit.restore(state)
        }),
        Case::new("fmi2FreeFMUstate", "NULL", OK, |unit| {
            // SAFETY: a live instance; null is ignored.
            unsafe { (unit.api.free_fmu_state)(unit.component, null_mut()) }
        }),
        Case::new("fmi2FreeFMUstate", "a NULL state", OK, |unit| {
            // SAFETY: a live instance, a pointer to null.
            unsafe { (unit.api.free_fmu_state)(unit.component, &mut null_mut()) }
        }),
        Case::new("fmi2FreeFMUstate", "something else", ERROR, |unit| {
            // SAFETY: a live instance; what is no state is refused.
            unsafe { (unit.api.free_fmu_state)(unit.component, &mut elsewhere()) }
        }),
        Case::new("fmi2FreeFMUstate", "twice", ERROR, |unit| {
            let mut state = unit.save();
            unit.free(state);
            // SAFETY: a live instance; what is no state any more is refused.
            unsafe { (unit.api.free_fmu_state)(unit.component, &mut state) }
        }),
    ];
    // What is not supported is refused whatever the arguments, as the XML states.
    let serializes = sample.flags().can_serialize_fmu_state;
    let supported = if serializes { OK } else { ERROR };
    cases.push(Case::new("fmi2SerializedFMUstateSize", "", supported, |unit| {
        let state = unit.save();
        let status = size(unit, state, &mut 0);
        unit.free(state);
        status
    }));
    cases.push(Case::new("fmi2SerializedFMUstateSize", "NULL state", ERROR, |unit| {
        size(unit, null_mut(), &mut 0)
    }));
    cases.push(Case::new("fmi2SerializedFMUstateSize", "something else", ERROR, |unit| {
        size(unit, elsewhere(), &mut 0)
    }));
    cases.push(Case::new("fmi2SerializedFMUstateSize", "NULL size", ERROR, |unit| {
        let state = unit.save();
        let status = size(unit, state, null_mut());
        // In the error state this is legal still.
        unit.free(state);
        status
    }));
    cases.extend(serialize(supported));
    cases.extend(deserialize(sample, supported));
    cases
}

fn size(unit: &Unit<'_>, state: State, size: *mut usize) -> Status {
    // SAFETY: a live instance; states and pointers that are none are refused.
    unsafe { (unit.api.serialized_fmu_state_size)(unit.component, state, size) }
}

fn serialize<'s>(supported: Status) -> Vec<Case<'s>> {
    let case = |class: &str, expected, length: fn(usize) -> usize, with_bytes| {
        Case::new("fmi2SerializeFMUstate", class, expected, move |unit: &Unit<'_>| {
            let state = unit.save();
            let mut needed = 0;
            if supported == OK {
                assert_eq!(size(unit, state, &mut needed), OK);
            }
            let mut bytes = vec![0x55; needed + 16];
            let pointer = if with_bytes { bytes.as_mut_ptr() } else { null_mut() };
            let length = length(needed);
            // SAFETY: a live instance and state; no more is written than the state needs.
            let status =
                unsafe { (unit.api.serialize_fmu_state)(unit.component, state, pointer, length) };
            let written = if status == OK { needed } else { 0 };
            assert!(bytes[written..].iter().all(|b| *b == 0x55), "written to beyond {written}");
            unit.free(state);
            status
        })
    };
    vec![
        case("", supported, |needed| needed, true),
        case("NULL bytes", ERROR, |needed| needed, false),
        case("one byte too few", ERROR, |needed| needed.saturating_sub(1), true),
        case("no room", ERROR, |_| 0, true),
    ]
}

fn deserialize(sample: &Sample, supported: Status) -> Vec<Case<'_>> {
    let mut blobs: Vec<(String, Vec<c_char>, Status)> = vec![
        ("nothing".into(), vec![], ERROR),
        ("zeros".into(), vec![0; 256], ERROR),
        ("noise".into(), (0..999).map(|i| (i * 37 % 251) as u8 as c_char).collect(), ERROR),
    ];
    if supported == OK {
        let mut unit = Unit::started(sample);
        unit.drive(0, 3);
        let good = unit.serialized();
        for cut in [1, good.len() / 2, good.len() - 1] {
            blobs.push((format!("cut to {cut}"), good[..cut].to_vec(), ERROR));
        }
        let mut longer = good.clone();
        longer.push(0);
        blobs.push(("a byte too many".into(), longer, ERROR));
        // A bit in each part of it.
        for at in (0..good.len()).step_by(good.len() / 61 + 1) {
            let mut damaged = good.clone();
            damaged[at] ^= 0x10;
            blobs.push((format!("byte {at} changed"), damaged, ERROR));
        }
        blobs.push(("".into(), good, OK));
    }
    let mut cases: Vec<Case<'_>> = Vec::new();
    for (class, bytes, expected) in blobs {
        cases.push(Case::new("fmi2DeSerializeFMUstate", class, expected, move |unit| {
            let mut state = null_mut();
            // SAFETY: a live instance, as many bytes as declared, a pointer to null.
            let status = unsafe {
                let (bytes, n) = (bytes.as_ptr(), bytes.len());
                (unit.api.de_serialize_fmu_state)(unit.component, bytes, n, &mut state)
            };
            assert_eq!(state.is_null(), status != OK);
            if status == OK {
                unit.free(state);
            }
            status
        }));
    }
    cases.push(Case::new("fmi2DeSerializeFMUstate", "NULL bytes", ERROR, |unit| {
        // SAFETY: a live instance; null is not read.
        unsafe { (unit.api.de_serialize_fmu_state)(unit.component, null(), 64, &mut null_mut()) }
    }));
    cases.push(Case::new("fmi2DeSerializeFMUstate", "NULL state", ERROR, |unit| {
        // SAFETY: a live instance; null is not written to.
        unsafe { (unit.api.de_serialize_fmu_state)(unit.component, [0].as_ptr(), 1, null_mut()) }
    }));
    cases
}
