//! FMU states: copies of everything a later call can depend on.
//!
//! The states that are alive are listed, so that a pointer that is none, or freed already, is an
//! error and no undefined behaviour.

use super::{call, unsupported};
use crate::Slave;
use crate::calls::Call;
use crate::instance::{Instance, Snapshot};
use crate::types::Status;
use std::any::TypeId;
use std::ffi::{c_char, c_void};
use std::sync::{Mutex, MutexGuard, PoisonError};

/// Address and slave of every state alive, sorted.
static ALIVE: Mutex<Vec<(usize, TypeId)>> = Mutex::new(Vec::new());

/// Nothing that holds the lock can panic halfway.
fn alive() -> MutexGuard<'static, Vec<(usize, TypeId)>> {
    ALIVE.lock().unwrap_or_else(PoisonError::into_inner)
}

fn key<S: Slave>(state: *mut c_void) -> (usize, TypeId) {
    (state.addr(), TypeId::of::<S>())
}

fn register<S: Slave>(state: *mut c_void) {
    let mut alive = alive();
    if let Err(index) = alive.binary_search(&key::<S>(state)) {
        alive.insert(index, key::<S>(state));
    }
}

fn is_alive<S: Slave>(state: *mut c_void) -> Result<(), String> {
    match alive().binary_search(&key::<S>(state)) {
        Ok(_) => Ok(()),
        Err(_) => Err("the FMU state is none of this FMU, or was freed".into()),
    }
}

fn unregister<S: Slave>(state: *mut c_void) {
    let mut alive = alive();
    if let Ok(index) = alive.binary_search(&key::<S>(state)) {
        alive.remove(index);
    }
    if alive.is_empty() {
        // The library may be unloaded next; nobody would give this memory back.
        *alive = Vec::new();
    }
}

/// `fmi2GetFMUstate`: a state that is given already is reused.
pub unsafe fn get_fmu_state<S: Slave>(component: *mut c_void, state: *mut *mut c_void) -> i32 {
    let body = |instance: &mut Instance<S>| {
        // SAFETY: the module's contract.
        let slot = unsafe { state.as_mut() }.ok_or("the pointer to the FMU state is NULL")?;
        if slot.is_null() {
            *slot = Box::into_raw(Box::new(instance.snapshot())).cast();
            register::<S>(*slot);
        } else {
            is_alive::<S>(*slot)?;
            let snapshot = instance.snapshot();
            // SAFETY: a state of this slave that is alive, and that nobody else uses now.
            unsafe { *slot.cast::<Snapshot<S>>() = snapshot };
        }
        Ok(Status::Ok)
    };
    // SAFETY: the module's contract.
    unsafe { call(component, Call::GetFmuState, body) }
}

/// `fmi2SetFMUstate`.
pub unsafe fn set_fmu_state<S: Slave>(component: *mut c_void, state: *mut c_void) -> i32 {
    let body = |instance: &mut Instance<S>| {
        if state.is_null() {
            return Err("the FMU state is NULL".into());
        }
        is_alive::<S>(state)?;
        // SAFETY: a state of this slave that is alive, and that nobody changes now.
        instance.restore(unsafe { &*state.cast::<Snapshot<S>>() })
    };
    // SAFETY: the module's contract.
    unsafe { call(component, Call::SetFmuState, body) }
}

/// `fmi2FreeFMUstate`: the pointer becomes NULL; no pointer, and no state, are ignored.
pub unsafe fn free_fmu_state<S: Slave>(component: *mut c_void, state: *mut *mut c_void) -> i32 {
    let body = |_: &mut Instance<S>| {
        // SAFETY: the module's contract.
        let Some(slot) = (unsafe { state.as_mut() }).filter(|slot| !slot.is_null()) else {
            return Ok(Status::Ok);
        };
        is_alive::<S>(*slot)?;
        let snapshot = std::mem::replace(slot, std::ptr::null_mut());
        unregister::<S>(snapshot);
        // SAFETY: it came from `Box::into_raw` above, was alive until now, and is gone from the list.
        drop(unsafe { Box::from_raw(snapshot.cast::<Snapshot<S>>()) });
        Ok(Status::Ok)
    };
    // SAFETY: the module's contract.
    unsafe { call(component, Call::FreeFmuState, body) }
}

/// `fmi2SerializedFMUstateSize`: not supported.
pub unsafe fn serialized_fmu_state_size<S: Slave>(
    component: *mut c_void,
    _state: *mut c_void,
    _size: *mut usize,
) -> i32 {
    // SAFETY: the module's contract.
    unsafe { unsupported::<S>(component, Call::SerializedFmuStateSize) }
}

/// `fmi2SerializeFMUstate`: not supported.
pub unsafe fn serialize_fmu_state<S: Slave>(
    component: *mut c_void,
    _state: *mut c_void,
    _bytes: *mut c_char,
    _size: usize,
) -> i32 {
    // SAFETY: the module's contract.
    unsafe { unsupported::<S>(component, Call::SerializeFmuState) }
}

/// `fmi2DeSerializeFMUstate`: not supported.
pub unsafe fn de_serialize_fmu_state<S: Slave>(
    component: *mut c_void,
    _bytes: *const c_char,
    _size: usize,
    _state: *mut *mut c_void,
) -> i32 {
    // SAFETY: the module's contract.
    unsafe { unsupported::<S>(component, Call::DeSerializeFmuState) }
}
