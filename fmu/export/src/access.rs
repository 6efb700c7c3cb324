//! Reading and setting variables: everything is checked before anything changes.

use crate::calls::{Access, get_access, set_access};
use crate::instance::{Instance, Outcome};
use crate::logger::Category;
use crate::types::Status;
use crate::{Slave, VariableId};
use model_description::{Causality, Kind, Value, VariableSpec};
use std::ffi::{CStr, CString, c_char};
use std::mem::MaybeUninit;

impl<S: Slave> Instance<S> {
    /// The variable of that reference, if it has that type.
    #[inline]
    fn find(reference: u32, kind: Kind) -> Result<(S::Variable, &'static VariableSpec), String> {
        if let Some(variable) = S::Variable::from_reference(reference) {
            let row = variable.spec();
            if row.kind == kind {
                return Ok((variable, row));
            }
        }
        Err(Self::not_found(reference, kind))
    }

    #[cold]
    fn not_found(reference: u32, kind: Kind) -> String {
        match S::Variable::from_reference(reference) {
            Some(variable) => {
                let row = variable.spec();
                format!("`{}` (value reference {reference}) is {}, not {kind}", row.name, row.kind)
            }
            None => format!("there is no variable with the value reference {reference}"),
        }
    }

    /// Checks that the variable may be read now.
    #[inline]
    fn may_get(&mut self, row: &VariableSpec) -> Result<(), String> {
        match get_access(self.core.state, row) {
            Access::Legal => Ok(()),
            Access::Lenient(leniency) => {
                self.note(leniency);
                Ok(())
            }
            Access::Illegal => Err(self.not_now(row, "read")),
        }
    }

    /// Checks that the variable may be set now.
    #[inline]
    fn may_set(&self, row: &VariableSpec) -> Result<(), String> {
        match set_access(self.core.state, row) {
            Access::Legal | Access::Lenient(_) => Ok(()),
            Access::Illegal => Err(self.not_now(row, "set")),
        }
    }

    #[cold]
    fn not_now(&self, row: &VariableSpec, what: &str) -> String {
        format!(
            "`{}` ({}, {}) cannot be {what} in the state \"{}\"",
            row.name,
            row.causality,
            row.variability,
            self.core.state.name()
        )
    }

    /// Reads variables of one type. `take` gives `None` for a value of another type.
    #[inline]
    pub(crate) fn get_all<T>(
        &mut self,
        references: &[u32],
        values: &mut [MaybeUninit<T>],
        kind: Kind,
        take: impl Fn(Value) -> Option<T>,
    ) -> Outcome {
        for &reference in references {
            let (_, row) = Self::find(reference, kind)?;
            self.may_get(row)?;
        }
        for (&reference, slot) in references.iter().zip(values) {
            let (variable, row) = Self::find(reference, kind)?;
            let Some(value) = take(self.core.slave.get(variable)) else {
                return Err(format!("the model gave `{}` a value of another type", row.name));
            };
            slot.write(value);
        }
        Ok(Status::Ok)
    }

    /// Reads String variables; the pointers hold until the next such call.
    pub(crate) fn get_strings(
        &mut self,
        references: &[u32],
        values: &mut [MaybeUninit<*const c_char>],
    ) -> Outcome {
        for &reference in references {
            let (_, row) = Self::find(reference, Kind::String)?;
            self.may_get(row)?;
        }
        let mut strings = Vec::with_capacity(references.len());
        for &reference in references {
            let (variable, row) = Self::find(reference, Kind::String)?;
            let Value::String(text) = self.core.slave.get(variable) else {
                return Err(format!("the model gave `{}` a value of another type", row.name));
            };
            // C has no string with a zero in it.
            strings.push(CString::new(text.replace('\0', "")).unwrap_or_default());
        }
        self.strings = strings;
        for (string, slot) in self.strings.iter().zip(values) {
            slot.write(string.as_ptr());
        }
        Ok(Status::Ok)
    }

    /// Sets variables of one type. `accept` is a value that may be set, or why it may not.
    #[inline]
    fn set_all<T: Copy>(
        &mut self,
        references: &[u32],
        values: &[T],
        kind: Kind,
        accept: impl Fn(&VariableSpec, T) -> Result<Accepted, String>,
    ) -> Outcome {
        for (&reference, &value) in references.iter().zip(values) {
            let (_, row) = Self::find(reference, kind)?;
            self.may_set(row)?;
            accept(row, value)?;
        }
        let mut status = Status::Ok;
        for (&reference, &value) in references.iter().zip(values) {
            let (variable, row) = Self::find(reference, kind)?;
            if let Access::Lenient(leniency) = set_access(self.core.state, row) {
                self.note(leniency);
            }
            let accepted = accept(row, value)?;
            if accepted.clipped && self.tell_clipped(row) {
                status = Status::Warning;
            }
            self.core.slave.set(variable, &accepted.value);
        }
        Ok(status)
    }

    pub(crate) fn set_reals(&mut self, references: &[u32], values: &[f64]) -> Outcome {
        self.set_all(references, values, Kind::Real, |row, value| {
            if !value.is_finite() {
                return Err(format!("`{}` cannot be {value}", row.name));
            }
            let (number, clipped) = within_limits(row, value)?;
            Ok(Accepted { value: Value::Real(number), clipped })
        })
    }

    pub(crate) fn set_integers(&mut self, references: &[u32], values: &[i32]) -> Outcome {
        self.set_all(references, values, Kind::Integer, |row, value| {
            let (number, clipped) = within_limits(row, f64::from(value))?;
            // Limits outside the range of integers saturate.
            let value = if clipped { number as i32 } else { value };
            Ok(Accepted { value: Value::Integer(value), clipped })
        })
    }

    pub(crate) fn set_booleans(&mut self, references: &[u32], values: &[i32]) -> Outcome {
        self.set_all(references, values, Kind::Boolean, |row, value| match value {
            0 | 1 => Ok(Accepted { value: Value::Boolean(value == 1), clipped: false }),
            _ => Err(format!("`{}` cannot be {value}: a Boolean is 0 or 1", row.name)),
        })
    }

    /// Sets String variables from UTF-8 texts; `None` stands for a null pointer.
    pub(crate) fn set_strings(&mut self, references: &[u32], values: &[Option<&CStr>]) -> Outcome {
        self.set_all(references, values, Kind::String, |row, value| {
            let text = value.ok_or_else(|| format!("the text for `{}` is NULL", row.name))?;
            let text =
                text.to_str().map_err(|_| format!("the text for `{}` is no UTF-8", row.name))?;
            Ok(Accepted { value: Value::String(text.into()), clipped: false })
        })
    }

    /// Tells that an input is clipped, once for each input; whether it was told now.
    #[cold]
    fn tell_clipped(&mut self, row: &VariableSpec) -> bool {
        if self.clipped.contains(&row.reference) {
            return false;
        }
        self.clipped.push(row.reference);
        let text = format!(
            "the input `{}` is outside [{}, {}] and is clipped, here and from now on",
            row.name,
            row.min.unwrap_or(f64::NEG_INFINITY),
            row.max.unwrap_or(f64::INFINITY)
        );
        self.logger.tell(Category::Warning, &text);
        true
    }
}

/// A value that may be set.
struct Accepted {
    value: Value,
    clipped: bool,
}

/// A finite number within the limits, and whether it had to be clipped; only inputs are.
#[inline]
fn within_limits(row: &VariableSpec, value: f64) -> Result<(f64, bool), String> {
    let min = row.min.unwrap_or(f64::NEG_INFINITY);
    let max = row.max.unwrap_or(f64::INFINITY);
    if value >= min && value <= max {
        Ok((value, false))
    } else if row.causality == Causality::Input {
        Ok((if value < min { min } else { max }, true))
    } else {
        Err(format!("`{}` cannot be {value}: it is limited to [{min}, {max}]", row.name))
    }
}
