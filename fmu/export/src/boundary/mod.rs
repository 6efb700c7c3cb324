//! The 34 functions of the C interface, generic over the slave.
//!
//! Each one checks its pointers, contains panics and maps the outcome to a status; what it means is
//! in safe code elsewhere. [`crate::export!`] gives them their C names.
//!
//! # Safety
//! All functions here have the contract of the standard: a component is null or one that
//! [`instantiate`] gave, of the same slave, not yet freed, and used by one thread at a time;
//! pointers are null or point to what the standard says, for the time of the call.
#![allow(clippy::missing_safety_doc)] // said once, above, for all of them

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

use crate::Slave;
use crate::calls::Call;
use crate::contain::contain;
use crate::instance::{Instance, Outcome};
use crate::types::Status;
use std::ffi::c_void;

/// Runs a call on an instance: admission, containment, status.
///
/// # Safety
/// The module's contract for `component`.
#[inline]
unsafe fn call<S: Slave>(
    component: *mut c_void,
    call: Call,
    body: impl FnOnce(&mut Instance<S>) -> Outcome,
) -> i32 {
    // SAFETY: null, or a live instance of this slave that nobody else uses during the call.
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

/// Refuses a call whose flag in the XML says that the slave has no such thing.
fn supported(flag: bool) -> Result<(), String> {
    if flag { Ok(()) } else { Err("not supported, as the XML says".into()) }
}
