//! Steps and their status.

use super::{call, supported};
use crate::arguments::slots;
use crate::calls::Call;
use crate::instance::Instance;
use crate::types::{LAST_SUCCESSFUL_TIME, Status, TERMINATED};
use crate::unit::CoSimulationUnit;
use std::ffi::{c_char, c_void};

/// `fmi2DoStep`. The last argument is not used, since any FMU state can be restored.
#[inline]
pub unsafe fn do_step<S: CoSimulationUnit>(
    component: *mut c_void,
    time: f64,
    step: f64,
    _no_set_fmu_state_prior_to_current_point: i32,
) -> i32 {
    let body = |instance: &mut Instance<S>| instance.do_step(time, step);
    // SAFETY: the module's contract.
    unsafe { call(component, Call::DoStep, body) }
}

/// `fmi2CancelStep`: always an error, since no step is asynchronous.
pub unsafe fn cancel_step<S: CoSimulationUnit>(component: *mut c_void) -> i32 {
    // SAFETY: the module's contract.
    unsafe {
        call(component, Call::CancelStep, |_: &mut Instance<S>| {
            supported(false).map(|()| Status::Ok)
        })
    }
}

/// Returns a status of the last step; `status` returns `None` for a kind that does not exist.
///
/// # Safety
/// The module's contract.
unsafe fn get<S: CoSimulationUnit, T>(
    component: *mut c_void,
    which: Call,
    value: *mut T,
    status: impl FnOnce(&Instance<S>) -> Option<T>,
) -> i32 {
    let body = |instance: &mut Instance<S>| {
        // SAFETY: the module's contract.
        let slot = unsafe { slots(value, 1, "values")? };
        match (status(instance), slot) {
            (Some(value), [slot]) => {
                slot.write(value);
                Ok(Status::Ok)
            }
            _ => instance.discard(which),
        }
    };
    // SAFETY: the module's contract.
    unsafe { call(component, which, body) }
}

/// `fmi2GetRealStatus`: the end of the last step.
pub unsafe fn get_real_status<S: CoSimulationUnit>(
    component: *mut c_void,
    kind: i32,
    value: *mut f64,
) -> i32 {
    let status = |instance: &Instance<S>| {
        if kind == LAST_SUCCESSFUL_TIME { Some(instance.core.time) } else { None }
    };
    // SAFETY: the module's contract.
    unsafe { get(component, Call::GetRealStatus, value, status) }
}

/// `fmi2GetBooleanStatus`: a unit never requests the end of the simulation.
pub unsafe fn get_boolean_status<S: CoSimulationUnit>(
    component: *mut c_void,
    kind: i32,
    value: *mut i32,
) -> i32 {
    let status = |_: &Instance<S>| if kind == TERMINATED { Some(0) } else { None };
    // SAFETY: the module's contract.
    unsafe { get(component, Call::GetBooleanStatus, value, status) }
}

/// Declares the functions whose status never exists.
macro_rules! without_status {
    ($($(#[$doc:meta])* $name:ident($value:ty) is $call:ident;)*) => {$(
        $(#[$doc])*
        pub unsafe fn $name<S: CoSimulationUnit>(component: *mut c_void, _kind: i32, value: *mut $value) -> i32 {
            // SAFETY: the module's contract.
            unsafe { get::<S, _>(component, Call::$call, value, |_| None) }
        }
    )*};
}

without_status! {
    /// `fmi2GetStatus`: exists only for pending steps, and no step is pending.
    get_status(i32) is GetStatus;
    /// `fmi2GetIntegerStatus`: the standard defines none.
    get_integer_status(i32) is GetIntegerStatus;
    /// `fmi2GetStringStatus`: exists only for pending steps, and no step is pending.
    get_string_status(*const c_char) is GetStringStatus;
}
