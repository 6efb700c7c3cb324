//! Reading and setting variables.

use super::call;
use crate::Slave;
use crate::arguments::{array, slots, strings};
use crate::calls::Call;
use crate::instance::Instance;
use model_description::{Kind, Value};
use std::ffi::{c_char, c_void};

const REFERENCES: &str = "value references";
const VALUES: &str = "values";

/// `fmi2GetReal`.
#[inline]
pub unsafe fn get_real<S: Slave>(
    component: *mut c_void,
    references: *const u32,
    length: usize,
    values: *mut f64,
) -> i32 {
    let body = |instance: &mut Instance<S>| {
        // SAFETY: the module's contract, here and for the values.
        let references = unsafe { array(references, length, REFERENCES)? };
        // SAFETY: as above.
        let values = unsafe { slots(values, length, VALUES)? };
        instance.get_all(references, values, Kind::Real, |value| match value {
            // A number that is none is never passed on as if all were well.
            Value::Real(value) if value.is_finite() => Some(value),
            _ => None,
        })
    };
    // SAFETY: the module's contract.
    unsafe { call(component, Call::GetReal, body) }
}

/// `fmi2GetInteger`.
#[inline]
pub unsafe fn get_integer<S: Slave>(
    component: *mut c_void,
    references: *const u32,
    length: usize,
    values: *mut i32,
) -> i32 {
    let body = |instance: &mut Instance<S>| {
        // SAFETY: the module's contract, here and for the values.
        let references = unsafe { array(references, length, REFERENCES)? };
        // SAFETY: as above.
        let values = unsafe { slots(values, length, VALUES)? };
        instance.get_all(references, values, Kind::Integer, |value| match value {
            Value::Integer(value) => Some(value),
            _ => None,
        })
    };
    // SAFETY: the module's contract.
    unsafe { call(component, Call::GetInteger, body) }
}

/// `fmi2GetBoolean`.
#[inline]
pub unsafe fn get_boolean<S: Slave>(
    component: *mut c_void,
    references: *const u32,
    length: usize,
    values: *mut i32,
) -> i32 {
    let body = |instance: &mut Instance<S>| {
        // SAFETY: the module's contract, here and for the values.
        let references = unsafe { array(references, length, REFERENCES)? };
        // SAFETY: as above.
        let values = unsafe { slots(values, length, VALUES)? };
        instance.get_all(references, values, Kind::Boolean, |value| match value {
            Value::Boolean(value) => Some(i32::from(value)),
            _ => None,
        })
    };
    // SAFETY: the module's contract.
    unsafe { call(component, Call::GetBoolean, body) }
}

/// `fmi2GetString`.
pub unsafe fn get_string<S: Slave>(
    component: *mut c_void,
    references: *const u32,
    length: usize,
    values: *mut *const c_char,
) -> i32 {
    let body = |instance: &mut Instance<S>| {
        // SAFETY: the module's contract, here and for the values.
        let references = unsafe { array(references, length, REFERENCES)? };
        // SAFETY: as above.
        let values = unsafe { slots(values, length, VALUES)? };
        instance.get_strings(references, values)
    };
    // SAFETY: the module's contract.
    unsafe { call(component, Call::GetString, body) }
}

/// `fmi2SetReal`.
#[inline]
pub unsafe fn set_real<S: Slave>(
    component: *mut c_void,
    references: *const u32,
    length: usize,
    values: *const f64,
) -> i32 {
    let body = |instance: &mut Instance<S>| {
        // SAFETY: the module's contract, here and for the values.
        let references = unsafe { array(references, length, REFERENCES)? };
        // SAFETY: as above.
        let values = unsafe { array(values, length, VALUES)? };
        instance.set_reals(references, values)
    };
    // SAFETY: the module's contract.
    unsafe { call(component, Call::SetReal, body) }
}

/// `fmi2SetInteger`.
#[inline]
pub unsafe fn set_integer<S: Slave>(
    component: *mut c_void,
    references: *const u32,
    length: usize,
    values: *const i32,
) -> i32 {
    let body = |instance: &mut Instance<S>| {
        // SAFETY: the module's contract, here and for the values.
        let references = unsafe { array(references, length, REFERENCES)? };
        // SAFETY: as above.
        let values = unsafe { array(values, length, VALUES)? };
        instance.set_integers(references, values)
    };
    // SAFETY: the module's contract.
    unsafe { call(component, Call::SetInteger, body) }
}

/// `fmi2SetBoolean`.
#[inline]
pub unsafe fn set_boolean<S: Slave>(
    component: *mut c_void,
    references: *const u32,
    length: usize,
    values: *const i32,
) -> i32 {
    let body = |instance: &mut Instance<S>| {
        // SAFETY: the module's contract, here and for the values.
        let references = unsafe { array(references, length, REFERENCES)? };
        // SAFETY: as above.
        let values = unsafe { array(values, length, VALUES)? };
        instance.set_booleans(references, values)
    };
    // SAFETY: the module's contract.
    unsafe { call(component, Call::SetBoolean, body) }
}

/// `fmi2SetString`.
pub unsafe fn set_string<S: Slave>(
    component: *mut c_void,
    references: *const u32,
    length: usize,
    values: *const *const c_char,
) -> i32 {
    let body = |instance: &mut Instance<S>| {
        // SAFETY: the module's contract, here and for the values.
        let references = unsafe { array(references, length, REFERENCES)? };
        // SAFETY: as above.
        let values = unsafe { strings(values, length, VALUES)? };
        instance.set_strings(references, &values)
    };
    // SAFETY: the module's contract.
    unsafe { call(component, Call::SetString, body) }
}
