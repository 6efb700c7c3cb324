//! Reading and setting variables.

use super::call;
use crate::arguments::{array, slots, strings};
use crate::calls::Call;
use crate::instance::Instance;
use crate::unit::CoSimulationUnit;
use model_description::{Kind, Value};
use std::ffi::{c_char, c_void};

const REFERENCES: &str = "value references";
const VALUES: &str = "values";

/// Declares functions that read or set variables. A row is the function, the C type of the values, the
/// call, the conversion of the values and the method of [`Instance`] with its further arguments.
macro_rules! functions {
    ($($name:ident($values:ty) is $call:ident: $convert:ident, $method:ident($($argument:expr),*);)*) => {
        $(
            #[doc = concat!("`fmi2", stringify!($call), "`.")]
            #[inline]
            pub unsafe fn $name<S: CoSimulationUnit>(
                component: *mut c_void,
                references: *const u32,
                length: usize,
                values: $values,
            ) -> i32 {
                let body = |instance: &mut Instance<S>| {
                    // SAFETY: the module's contract, here and for the values.
                    let references = unsafe { array(references, length, REFERENCES)? };
                    // SAFETY: as above.
                    let values = unsafe { $convert(values, length, VALUES)? };
                    instance.$method(references, values $(, $argument)*)
                };
                // SAFETY: the module's contract.
                unsafe { call(component, Call::$call, body) }
            }
        )*
    };
}

functions! {
    get_real(*mut f64) is GetReal: slots, get_all(Kind::Real, |value| match value {
        // NaN and infinities are never returned with status OK.
        Value::Real(value) if value.is_finite() => Some(value),
        _ => None,
    });
    get_integer(*mut i32) is GetInteger: slots, get_all(Kind::Integer, |value| match value {
        Value::Integer(value) => Some(value),
        _ => None,
    });
    get_boolean(*mut i32) is GetBoolean: slots, get_all(Kind::Boolean, |value| match value {
        Value::Boolean(value) => Some(i32::from(value)),
        _ => None,
    });
    get_string(*mut *const c_char) is GetString: slots, get_strings();
    set_real(*const f64) is SetReal: array, set_reals();
    set_integer(*const i32) is SetInteger: array, set_integers();
    set_boolean(*const i32) is SetBoolean: array, set_booleans();
    set_string(*const *const c_char) is SetString: strings, set_strings();
}
