//! FMU states.

use super::{ERROR, FRESH, OK, State, Status, instance};
use core::ffi::c_void;
use core::ptr::null_mut;

static mut STATES: [(bool, State); 64] = [(false, FRESH); 64];

fn new_state(value: State) -> *mut c_void {
    // SAFETY: one thread at a time.
    unsafe {
        let states = &raw mut STATES;
        for slot in &mut *states {
            if !slot.0 {
                *slot = (true, value);
                return (slot as *mut (bool, State)).cast();
            }
        }
    }
    null_mut()
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetFMUstate(c: *mut c_void, state: *mut *mut c_void) -> Status {
    // SAFETY: a slot for a pointer.
    unsafe { *state = new_state(instance(c).state) };
    OK
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SetFMUstate(c: *mut c_void, state: *mut c_void) -> Status {
    // SAFETY: one of ours.
    let saved = unsafe { &*state.cast::<(bool, State)>() }.1;
    let i = instance(c);
    let x = i.state.x;
    i.state = saved;
    if i.has("state") {
        i.state.x = x;
    }
    OK
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2FreeFMUstate(_: *mut c_void, state: *mut *mut c_void) -> Status {
    // SAFETY: a pointer to one of ours, or to NULL.
    unsafe {
        if let Some(slot) = (*state).cast::<(bool, State)>().as_mut() {
            slot.0 = false;
        }
        *state = null_mut();
    }
    OK
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SerializedFMUstateSize(_: *mut c_void, _: *mut c_void, size: *mut usize) -> Status {
    // SAFETY: a slot for a size.
    unsafe { *size = size_of::<State>() };
    OK
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SerializeFMUstate(_: *mut c_void, state: *mut c_void, bytes: *mut u8, _: usize) -> Status {
    // SAFETY: one of ours, and an array of the returned size.
    unsafe {
        let value = &raw const (*state.cast::<(bool, State)>()).1;
        core::ptr::copy_nonoverlapping(value.cast::<u8>(), bytes, size_of::<State>());
    }
    OK
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2DeSerializeFMUstate(c: *mut c_void, bytes: *const u8, _: usize, state: *mut *mut c_void) -> Status {
    if instance(c).has("serialize") {
        return ERROR;
    }
    // SAFETY: the bytes of a state.
    unsafe { *state = new_state(bytes.cast::<State>().read_unaligned()) };
    OK
}
