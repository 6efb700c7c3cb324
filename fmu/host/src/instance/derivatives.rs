//! Derivatives of inputs and outputs in time, and of unknowns with respect to knowns.

#![allow(unsafe_code)]

use super::{Instance, phase};
use crate::Error;

impl Instance {
    /// Sets derivatives in time of Real inputs, of the given orders (1 is the first derivative).
    pub fn set_real_input_derivatives(
        &mut self,
        references: &[u32],
        orders: &[i32],
        values: &[f64],
    ) -> Result<(), Error> {
        const CALL: &str = "fmi2SetRealInputDerivatives";
        self.same_length(CALL, references.len(), values.len())?;
        self.same_length(CALL, references.len(), orders.len())?;
        let (r, n, orders) = (references.as_ptr(), references.len(), orders.as_ptr());
        self.call(CALL, phase::SET, |f, c| {
            // SAFETY: as `call` requires; the arrays have the given length.
            unsafe { (f.set_real_input_derivatives)(c, r, n, orders, values.as_ptr()) }
        })
    }

    /// Reads derivatives in time of Real outputs, of the given orders.
    pub fn get_real_output_derivatives(
        &mut self,
        references: &[u32],
        orders: &[i32],
        values: &mut [f64],
    ) -> Result<(), Error> {
        const CALL: &str = "fmi2GetRealOutputDerivatives";
        self.same_length(CALL, references.len(), values.len())?;
        self.same_length(CALL, references.len(), orders.len())?;
        let (r, n, orders) = (references.as_ptr(), references.len(), orders.as_ptr());
        self.call(CALL, phase::GET_OUTPUT_DERIVATIVES, |f, c| {
            // SAFETY: as `call` requires; the arrays have the given length.
            unsafe { (f.get_real_output_derivatives)(c, r, n, orders, values.as_mut_ptr()) }
        })
    }

    /// The change of the unknowns for a change of the knowns, at the present communication point.
    pub fn get_directional_derivative(
        &mut self,
        unknowns: &[u32],
        knowns: &[u32],
        known_change: &[f64],
        unknown_change: &mut [f64],
    ) -> Result<(), Error> {
        const CALL: &str = "fmi2GetDirectionalDerivative";
        self.capable(
            self.model.co_simulation().provides_directional_derivative,
            "providesDirectionalDerivative",
        )?;
        self.same_length(CALL, unknowns.len(), unknown_change.len())?;
        self.same_length(CALL, knowns.len(), known_change.len())?;
        let (u, n) = (unknowns.as_ptr(), unknowns.len());
        let (k, m, change) = (knowns.as_ptr(), knowns.len(), known_change.as_ptr());
        self.call(CALL, phase::GET, |f, c| {
            let to = unknown_change.as_mut_ptr();
            // SAFETY: as `call` requires; the arrays have the given lengths.
            unsafe { (f.get_directional_derivative)(c, u, n, k, m, change, to) }
        })
    }
}
