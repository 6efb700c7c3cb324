//! The 34 functions of the C interface, generic over the unit.
//!
//! Each function checks its pointers, contains panics and maps the outcome to a status; safe code in
//! other modules implements the call. [`crate::export!`] exports them under their C names.
//!
//! # Safety
//! All functions here have the contract of the standard: a component is null or was returned by
//! [`instantiate`] for the same unit, is not freed, and is used by one thread at a time; pointers are
//! null or valid for the call as the standard requires.
#![allow(clippy::missing_safety_doc)] // stated above for all functions

mod derivatives;
mod lifecycle;
mod states;
mod stepping;
mod values;

pub use derivatives::*;
pub use lifecycle::*;
pub use states::*;
pub use stepping::*;
pub use values::*;

use crate::calls::Call;
use crate::contain::contain;
use crate::instance::{Instance, Outcome};
use crate::types::Status;
use crate::unit::CoSimulationUnit;
use std::ffi::c_void;

/// Runs a call on an instance: checks that it is legal, contains panics and returns the status.
///
/// # Safety
/// The module's contract for `component`.
#[inline]
unsafe fn call<S: CoSimulationUnit>(
    component: *mut c_void,
    call: Call,
    body: impl FnOnce(&mut Instance<S>) -> Outcome,
) -> i32 {
    // SAFETY: null, or a live instance of this unit that nothing else uses during the call.
    let Some(instance) = (unsafe { component.cast::<Instance<S>>().as_mut() }) else {
        return Status::Error as i32;
    };
    let outcome = contain(|| {
        instance.admit(call)?;
        body(instance)
    });
    let status = match outcome {
        Ok(Ok(status)) => status,
        Ok(Err(problem)) => instance.fail(call, &problem),
        Err(message) => instance.poison(call, &message),
    };
    status as i32
}

/// Rejects a call of a capability that the unit does not have.
fn supported(flag: bool) -> Result<(), String> {
    if flag { Ok(()) } else { Err("not supported, as declared in modelDescription.xml".into()) }
}
