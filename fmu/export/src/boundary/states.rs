//! FMU states: copies of everything that a later call can depend on.
//!
//! All live states are listed, so that an invalid or freed pointer is an error, not undefined behaviour.

use super::{call, supported};
use crate::arguments::{array, slots};
use crate::blob::encode;
use crate::calls::Call;
use crate::instance::{Instance, Snapshot};
use crate::types::Status;
use crate::unit::CoSimulationUnit;
use std::any::TypeId;
use std::ffi::{c_char, c_void};
use std::mem::MaybeUninit;
use std::sync::{Mutex, MutexGuard, PoisonError};

/// Address and unit type of every live state, sorted.
static ALIVE: Mutex<Vec<(usize, TypeId)>> = Mutex::new(Vec::new());

/// The live states. A poisoned lock is still consistent: no holder can panic between two changes.
fn alive() -> MutexGuard<'static, Vec<(usize, TypeId)>> {
    ALIVE.lock().unwrap_or_else(PoisonError::into_inner)
}

fn key<S: CoSimulationUnit>(state: *mut c_void) -> (usize, TypeId) {
    (state.addr(), TypeId::of::<S>())
}

fn register<S: CoSimulationUnit>(state: *mut c_void) {
    let mut alive = alive();
    if let Err(index) = alive.binary_search(&key::<S>(state)) {
        alive.insert(index, key::<S>(state));
    }
}

fn is_alive<S: CoSimulationUnit>(state: *mut c_void) -> Result<(), String> {
    match alive().binary_search(&key::<S>(state)) {
        Ok(_) => Ok(()),
        Err(_) => Err("the pointer is not an FMU state of this FMU, or the state was freed".into()),
    }
}

/// Moves a state to the heap and lists it as alive.
fn into_pointer<S: CoSimulationUnit>(snapshot: Snapshot<S>) -> *mut c_void {
    let state = Box::into_raw(Box::new(snapshot)).cast();
    register::<S>(state);
    state
}

fn unregister<S: CoSimulationUnit>(state: *mut c_void) {
    let mut alive = alive();
    if let Ok(index) = alive.binary_search(&key::<S>(state)) {
        alive.remove(index);
    }
    if alive.is_empty() {
        // The library may be unloaded next; this memory would leak.
        *alive = Vec::new();
    }
}

/// `fmi2GetFMUstate`: an existing state is overwritten.
pub unsafe fn get_fmu_state<S: CoSimulationUnit>(
    component: *mut c_void,
    state: *mut *mut c_void,
) -> i32 {
    let body = |instance: &mut Instance<S>| {
        // SAFETY: the module's contract.
        let slot = unsafe { state.as_mut() }.ok_or("the pointer to the FMU state is NULL")?;
        if slot.is_null() {
            *slot = into_pointer(instance.snapshot());
        } else {
            is_alive::<S>(*slot)?;
            let snapshot = instance.snapshot();
            // SAFETY: a live state of this unit that nothing else uses now.
            let old = std::mem::replace(unsafe { &mut *slot.cast::<Snapshot<S>>() }, snapshot);
            old.core.unit.release();
        }
        Ok(Status::Ok)
    };
    // SAFETY: the module's contract.
    unsafe { call(component, Call::GetFmuState, body) }
}

/// `fmi2SetFMUstate`.
pub unsafe fn set_fmu_state<S: CoSimulationUnit>(
    component: *mut c_void,
    state: *mut c_void,
) -> i32 {
    let body = |instance: &mut Instance<S>| {
        if state.is_null() {
            return Err("the FMU state is NULL".into());
        }
        is_alive::<S>(state)?;
        // SAFETY: a live state of this unit that nothing changes now.
        instance.restore(unsafe { &*state.cast::<Snapshot<S>>() })
    };
    // SAFETY: the module's contract.
    unsafe { call(component, Call::SetFmuState, body) }
}

/// `fmi2FreeFMUstate`: the pointer becomes NULL; null pointers are ignored.
pub unsafe fn free_fmu_state<S: CoSimulationUnit>(
    component: *mut c_void,
    state: *mut *mut c_void,
) -> i32 {
    let body = |_: &mut Instance<S>| {
        // SAFETY: the module's contract.
        let Some(slot) = (unsafe { state.as_mut() }).filter(|slot| !slot.is_null()) else {
            return Ok(Status::Ok);
        };
        is_alive::<S>(*slot)?;
        let snapshot = std::mem::replace(slot, std::ptr::null_mut());
        unregister::<S>(snapshot);
        // SAFETY: created by `Box::into_raw` above, alive until now, and removed from the list.
        let snapshot = unsafe { Box::from_raw(snapshot.cast::<Snapshot<S>>()) };
        snapshot.core.unit.release();
        Ok(Status::Ok)
    };
    // SAFETY: the module's contract.
    unsafe { call(component, Call::FreeFmuState, body) }
}

/// Serializes a state.
///
/// # Safety
/// The module's contract for `state`.
unsafe fn bytes_of<S: CoSimulationUnit>(state: *mut c_void) -> Result<Vec<u8>, String> {
    supported(S::CAPABILITIES.serializes)?;
    if state.is_null() {
        return Err("the FMU state is NULL".into());
    }
    is_alive::<S>(state)?;
    // SAFETY: a live state of this unit that nothing changes now.
    Ok(encode(unsafe { &*state.cast::<Snapshot<S>>() }))
}

/// `fmi2SerializedFMUstateSize`.
pub unsafe fn serialized_fmu_state_size<S: CoSimulationUnit>(
    component: *mut c_void,
    state: *mut c_void,
    size: *mut usize,
) -> i32 {
    let body = |_: &mut Instance<S>| {
        // SAFETY: the module's contract, here and for the state.
        let slot = unsafe { slots(size, 1, "sizes")? };
        // SAFETY: as above.
        let bytes = unsafe { bytes_of::<S>(state)? };
        slot.fill(MaybeUninit::new(bytes.len()));
        Ok(Status::Ok)
    };
    // SAFETY: the module's contract.
    unsafe { call(component, Call::SerializedFmuStateSize, body) }
}

/// `fmi2SerializeFMUstate`: a buffer may be longer than needed; the rest of it does not change.
pub unsafe fn serialize_fmu_state<S: CoSimulationUnit>(
    component: *mut c_void,
    state: *mut c_void,
    bytes: *mut c_char,
    size: usize,
) -> i32 {
    let body = |_: &mut Instance<S>| {
        // SAFETY: the module's contract, here and for the buffer.
        let content = unsafe { bytes_of::<S>(state)? };
        // SAFETY: as above.
        let buffer = unsafe { slots(bytes.cast::<u8>(), size, "bytes")? };
        let Some(buffer) = buffer.get_mut(..content.len()) else {
            return Err(format!("the buffer has {size} bytes; {} are needed", content.len()));
        };
        for (slot, byte) in buffer.iter_mut().zip(content) {
            slot.write(byte);
        }
        Ok(Status::Ok)
    };
    // SAFETY: the module's contract.
    unsafe { call(component, Call::SerializeFmuState, body) }
}

/// `fmi2DeSerializeFMUstate`: "constructs a copy of the FMU state" (the standard) and returns a new
/// pointer. The previous content of the slot is not read, since it may be uninitialized; if it is a
/// state, that state stays alive and the importer frees it.
pub unsafe fn de_serialize_fmu_state<S: CoSimulationUnit>(
    component: *mut c_void,
    bytes: *const c_char,
    size: usize,
    state: *mut *mut c_void,
) -> i32 {
    let body = |instance: &mut Instance<S>| {
        supported(S::CAPABILITIES.serializes)?;
        // SAFETY: the module's contract, here and for the bytes.
        let slot = unsafe { slots(state, 1, "FMU states")? };
        // SAFETY: as above.
        let bytes = unsafe { array(bytes.cast::<u8>(), size, "bytes")? };
        let snapshot = instance.decode(bytes)?;
        slot.fill(MaybeUninit::new(into_pointer(snapshot)));
        Ok(Status::Ok)
    };
    // SAFETY: the module's contract.
    unsafe { call(component, Call::DeSerializeFmuState, body) }
}
