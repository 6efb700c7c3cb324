//! FMU states: getting, setting and serializing the state of an instance (FMI 2.0.5, 2.1.8).
//!
//! The FMU owns the memory behind a state and frees it through the instance. An [`FmuState`] is
//! therefore a ticket: dropped, it only notes that its place is free, on whatever thread that
//! happens; the instance frees the place when it next handles states, or at its end. A ticket that
//! outlives its instance is harmless.

#![allow(unsafe_code)]

use std::ffi::c_char;
use std::sync::{Arc, Mutex, PoisonError};

use super::Instance;
use super::phase::{self, Phase};
use crate::Error;
use crate::c_types::FmuStatePointer;

/// A saved state of one instance.
#[derive(Debug)]
pub struct FmuState {
    place: usize,
    /// Restoring a state restores this as well.
    phase: Phase,
    returned: Arc<Returned>,
}

/// Places whose tickets were dropped.
#[derive(Debug, Default)]
struct Returned(Mutex<Vec<usize>>);

impl Drop for FmuState {
    fn drop(&mut self) {
        self.returned.0.lock().unwrap_or_else(PoisonError::into_inner).push(self.place);
    }
}

/// The states that the FMU holds for an instance; NULL where a place is free.
#[derive(Default)]
pub(super) struct Saved {
    pointers: Vec<FmuStatePointer>,
    free: Vec<usize>,
    returned: Arc<Returned>,
}

impl Saved {
    /// Whether the FMU holds no state at all.
    pub(super) fn is_empty(&self) -> bool {
        self.pointers.len() == self.free.len()
    }
}

impl Instance {
    /// Takes the present state.
    pub fn get_state(&mut self) -> Result<FmuState, Error> {
        self.capable(self.model.co_simulation().can_get_and_set_fmu_state, "canGetAndSetFMUstate")?;
        self.free_returned_states();
        let mut pointer: FmuStatePointer = std::ptr::null_mut();
        let at = self.phase;
        self.call("fmi2GetFMUstate", phase::ANY, |f, c| {
            // SAFETY: as `call` requires; the pointer is NULL, so the FMU makes a new state.
            unsafe { (f.get_fmu_state)(c, &raw mut pointer) }
        })?;
        self.keep("fmi2GetFMUstate", pointer, at)
    }

    /// Goes back (or forth) to a state of this instance.
    pub fn set_state(&mut self, state: &FmuState) -> Result<(), Error> {
        let pointer = self.pointer(state)?;
        self.call("fmi2SetFMUstate", phase::ANY, |f, c| {
            // SAFETY: as `call` requires; the pointer is a state of this instance.
            unsafe { (f.set_fmu_state)(c, pointer) }
        })?;
        self.phase = state.phase;
        Ok(())
    }

    /// The bytes of a state, for another instance of the same FMU, perhaps in another process.
    pub fn serialize_state(&mut self, state: &FmuState) -> Result<Vec<u8>, Error> {
        self.capable(self.model.co_simulation().can_serialize_fmu_state, "canSerializeFMUstate")?;
        let pointer = self.pointer(state)?;
        let mut size = 0usize;
        self.call("fmi2SerializedFMUstateSize", phase::ANY, |f, c| {
            // SAFETY: as `call` requires; the pointer is a state of this instance.
            unsafe { (f.serialized_fmu_state_size)(c, pointer, &raw mut size) }
        })?;
        let mut bytes = vec![0u8; size];
        self.call("fmi2SerializeFMUstate", phase::ANY, |f, c| {
            let address = bytes.as_mut_ptr().cast::<c_char>();
            // SAFETY: as `call` requires; the array has the given length.
            unsafe { (f.serialize_fmu_state)(c, pointer, address, size) }
        })?;
        Ok(bytes)
    }

    /// A state from its bytes; `phase` is where the instance that wrote them was.
    pub fn deserialize_state(&mut self, bytes: &[u8], phase: Phase) -> Result<FmuState, Error> {
        self.capable(self.model.co_simulation().can_serialize_fmu_state, "canSerializeFMUstate")?;
        self.free_returned_states();
        let mut pointer: FmuStatePointer = std::ptr::null_mut();
        self.call("fmi2DeSerializeFMUstate", phase::ANY, |f, c| {
            let address = bytes.as_ptr().cast::<c_char>();
            // SAFETY: as `call` requires; the array has the given length.
            unsafe { (f.de_serialize_fmu_state)(c, address, bytes.len(), &raw mut pointer) }
        })?;
        self.keep("fmi2DeSerializeFMUstate", pointer, phase)
    }

    /// Where an FMU state of this instance was taken.
    fn pointer(&self, state: &FmuState) -> Result<FmuStatePointer, Error> {
        if Arc::ptr_eq(&state.returned, &self.states.returned) {
            return Ok(self.states.pointers[state.place]);
        }
        Err(Error::ForeignState { instance: self.name.clone() })
    }

    fn keep(
        &mut self,
        call: &'static str,
        pointer: FmuStatePointer,
        phase: Phase,
    ) -> Result<FmuState, Error> {
        if pointer.is_null() {
            return Err(Error::NullResult { instance: self.name.clone(), call });
        }
        let saved = &mut self.states;
        let place = match saved.free.pop() {
            Some(place) => {
                saved.pointers[place] = pointer;
                place
            }
            None => {
                saved.pointers.push(pointer);
                saved.pointers.len() - 1
            }
        };
        Ok(FmuState { place, phase, returned: Arc::clone(&saved.returned) })
    }

    /// Frees the states whose tickets were dropped.
    fn free_returned_states(&mut self) {
        let returned = std::mem::take(
            &mut *self.states.returned.0.lock().unwrap_or_else(PoisonError::into_inner),
        );
        for place in returned {
            self.free_state(place);
            self.states.free.push(place);
        }
    }

    /// Frees every state, before the instance itself is freed.
    pub(super) fn free_all_states(&mut self) {
        for place in 0..self.states.pointers.len() {
            self.free_state(place);
        }
    }

    fn free_state(&mut self, place: usize) {
        let mut pointer = std::mem::replace(&mut self.states.pointers[place], std::ptr::null_mut());
        if pointer.is_null() {
            return;
        }
        // A refusal leaves nothing to be done; `call` notes an error or a fatal end.
        let _ = self.call("fmi2FreeFMUstate", phase::ANY, |f, c| {
            // SAFETY: as `call` requires; the pointer is a state of this instance, and its place is
            // empty from now on.
            unsafe { (f.free_fmu_state)(c, &raw mut pointer) }
        });
    }

    pub(super) fn capable(&self, can: bool, capability: &'static str) -> Result<(), Error> {
        if can {
            return Ok(());
        }
        Err(Error::Unsupported { instance: self.name.clone(), capability })
    }
}
