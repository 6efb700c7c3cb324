//! Getting and setting by value reference: the fast way, one call of the FMU for a whole slice.
//!
//! Nothing is checked here but lengths and the phase; whether a reference exists and may be set now
//! is for the FMU to check. [`super::named`] checks against modelDescription.xml.

#![allow(unsafe_code)]

use std::ffi::{CStr, c_char};

use super::{Instance, c_string, phase};
use crate::Error;
use crate::c_types;

/// Declares a getter and a setter whose C type is the Rust type.
macro_rules! plain {
    ($get:ident, $set:ident, $get_name:literal, $set_name:literal, $kind:ty, $what:literal) => {
        #[doc = concat!("Reads ", $what, " variables by value reference.")]
        #[inline]
        pub fn $get(&mut self, references: &[u32], values: &mut [$kind]) -> Result<(), Error> {
            self.same_length($get_name, references.len(), values.len())?;
            if references.is_empty() {
                return Ok(());
            }
            self.call($get_name, phase::GET, |f, c| {
                // SAFETY: as `call` requires; both arrays have the given length.
                unsafe { (f.$get)(c, references.as_ptr(), references.len(), values.as_mut_ptr()) }
            })
        }

        #[doc = concat!("Sets ", $what, " variables by value reference.")]
        #[inline]
        pub fn $set(&mut self, references: &[u32], values: &[$kind]) -> Result<(), Error> {
            self.same_length($set_name, references.len(), values.len())?;
            if references.is_empty() {
                return Ok(());
            }
            self.call($set_name, phase::SET, |f, c| {
                // SAFETY: as `call` requires; both arrays have the given length.
                unsafe { (f.$set)(c, references.as_ptr(), references.len(), values.as_ptr()) }
            })
        }
    };
}

impl Instance {
    plain!(get_real, set_real, "fmi2GetReal", "fmi2SetReal", f64, "Real");
    plain!(get_integer, set_integer, "fmi2GetInteger", "fmi2SetInteger", i32, "Integer");

    /// Reads Boolean variables by value reference.
    pub fn get_boolean(&mut self, references: &[u32], values: &mut [bool]) -> Result<(), Error> {
        const CALL: &str = "fmi2GetBoolean";
        self.same_length(CALL, references.len(), values.len())?;
        if references.is_empty() {
            return Ok(());
        }
        let mut buffer = std::mem::take(&mut self.booleans);
        buffer.clear();
        buffer.resize(values.len(), c_types::FALSE);
        let result = self.call(CALL, phase::GET, |f, c| {
            // SAFETY: as `call` requires; both arrays have the given length.
            unsafe {
                (f.get_boolean)(c, references.as_ptr(), references.len(), buffer.as_mut_ptr())
            }
        });
        if result.is_ok() {
            for (value, raw) in values.iter_mut().zip(&buffer) {
                *value = *raw != c_types::FALSE;
            }
        }
        self.booleans = buffer;
        result
    }

    /// Sets Boolean variables by value reference.
    pub fn set_boolean(&mut self, references: &[u32], values: &[bool]) -> Result<(), Error> {
        const CALL: &str = "fmi2SetBoolean";
        self.same_length(CALL, references.len(), values.len())?;
        if references.is_empty() {
            return Ok(());
        }
        let mut buffer = std::mem::take(&mut self.booleans);
        buffer.clear();
        buffer.extend(values.iter().map(|value| c_types::Boolean::from(*value)));
        let result = self.call(CALL, phase::SET, |f, c| {
            // SAFETY: as `call` requires; both arrays have the given length.
            unsafe { (f.set_boolean)(c, references.as_ptr(), references.len(), buffer.as_ptr()) }
        });
        self.booleans = buffer;
        result
    }

    /// Reads String variables by value reference.
    pub fn get_string(&mut self, references: &[u32]) -> Result<Vec<String>, Error> {
        const CALL: &str = "fmi2GetString";
        if references.is_empty() {
            return Ok(Vec::new());
        }
        let mut pointers: Vec<*const c_char> = vec![std::ptr::null(); references.len()];
        self.call(CALL, phase::GET, |f, c| {
            // SAFETY: as `call` requires; both arrays have the given length.
            unsafe {
                (f.get_string)(c, references.as_ptr(), references.len(), pointers.as_mut_ptr())
            }
        })?;
        pointers
            .into_iter()
            .map(|pointer| {
                if pointer.is_null() {
                    return Err(Error::NullResult { instance: self.name.clone(), call: CALL });
                }
                // SAFETY: a C string that the FMU keeps until it is called again, which `&mut self`
                // prevents for as long as it is read here.
                Ok(unsafe { CStr::from_ptr(pointer) }.to_string_lossy().into_owned())
            })
            .collect()
    }

    /// Sets String variables by value reference.
    pub fn set_string<S: AsRef<str>>(
        &mut self,
        references: &[u32],
        values: &[S],
    ) -> Result<(), Error> {
        const CALL: &str = "fmi2SetString";
        self.same_length(CALL, references.len(), values.len())?;
        if references.is_empty() {
            return Ok(());
        }
        let texts = values
            .iter()
            .map(|value| c_string(&self.name, value.as_ref()))
            .collect::<Result<Vec<_>, _>>()?;
        let pointers: Vec<*const c_char> = texts.iter().map(|text| text.as_ptr()).collect();
        self.call(CALL, phase::SET, |f, c| {
            // SAFETY: as `call` requires; both arrays have the given length, and the texts outlive
            // the call (the FMU copies them).
            unsafe { (f.set_string)(c, references.as_ptr(), references.len(), pointers.as_ptr()) }
        })
    }

    #[inline]
    pub(super) fn same_length(
        &self,
        call: &'static str,
        references: usize,
        values: usize,
    ) -> Result<(), Error> {
        if references == values {
            return Ok(());
        }
        Err(Error::Lengths { instance: self.name.clone(), call, references, values })
    }
}
