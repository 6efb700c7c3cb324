//! Time derivatives of inputs and outputs, and directional derivatives.

use super::{call, supported};
use crate::arguments::{array, slots};
use crate::calls::Call;
use crate::instance::Instance;
use crate::types::Status;
use crate::unit::CoSimulationUnit;
use std::ffi::c_void;

/// `fmi2SetRealInputDerivatives`: order 1 of continuous inputs, for the next step.
pub unsafe fn set_real_input_derivatives<S: CoSimulationUnit>(
    component: *mut c_void,
    references: *const u32,
    length: usize,
    orders: *const i32,
    values: *const f64,
) -> i32 {
    let body = |instance: &mut Instance<S>| {
        supported(S::CAPABILITIES.interpolates_inputs)?;
        // SAFETY: the module's contract, here and for the rest.
        let references = unsafe { array(references, length, "value references")? };
        // SAFETY: as above.
        let orders = unsafe { array(orders, length, "orders")? };
        // SAFETY: as above.
        let values = unsafe { array(values, length, "values")? };
        instance.set_input_derivatives(references, orders, values)
    };
    // SAFETY: the module's contract.
    unsafe { call(component, Call::SetRealInputDerivatives, body) }
}

/// `fmi2GetRealOutputDerivatives`: order 1 of continuous outputs.
pub unsafe fn get_real_output_derivatives<S: CoSimulationUnit>(
    component: *mut c_void,
    references: *const u32,
    length: usize,
    orders: *const i32,
    values: *mut f64,
) -> i32 {
    let body = |instance: &mut Instance<S>| {
        supported(S::CAPABILITIES.output_derivatives)?;
        // SAFETY: the module's contract, here and for the rest.
        let references = unsafe { array(references, length, "value references")? };
        // SAFETY: as above.
        let orders = unsafe { array(orders, length, "orders")? };
        // SAFETY: as above.
        let values = unsafe { slots(values, length, "values")? };
        instance.get_output_derivatives(references, orders, values)
    };
    // SAFETY: the module's contract.
    unsafe { call(component, Call::GetRealOutputDerivatives, body) }
}

/// `fmi2GetDirectionalDerivative`.
pub unsafe fn get_directional_derivative<S: CoSimulationUnit>(
    component: *mut c_void,
    unknowns: *const u32,
    unknown_count: usize,
    knowns: *const u32,
    known_count: usize,
    seed: *const f64,
    sensitivity: *mut f64,
) -> i32 {
    let body = |instance: &mut Instance<S>| {
        supported(S::CAPABILITIES.directional_derivatives)?;
        // SAFETY: the module's contract, here and for the rest.
        let unknowns = unsafe { array(unknowns, unknown_count, "unknowns")? };
        // SAFETY: as above.
        let knowns = unsafe { array(knowns, known_count, "knowns")? };
        // SAFETY: as above.
        let seed = unsafe { array(seed, known_count, "dvKnown")? };
        // SAFETY: as above.
        let sensitivity = unsafe { slots(sensitivity, unknown_count, "dvUnknown")? };
        let result = instance.directional_derivative(unknowns, knowns, seed)?;
        for (slot, value) in sensitivity.iter_mut().zip(result) {
            slot.write(value);
        }
        Ok(Status::Ok)
    };
    // SAFETY: the module's contract.
    unsafe { call(component, Call::GetDirectionalDerivative, body) }
}
