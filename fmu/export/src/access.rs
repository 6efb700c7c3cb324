//! Reading and setting variables: everything is checked before anything changes.

use crate::calls::{Access, Class, Leniency, State, get_access, set_access};
use crate::exposed::Exposed;
use crate::instance::{Instance, Outcome};
use crate::logger::Category;
use crate::types::Status;
use crate::{Slave, VariableId};
use model_description::{Causality, Kind, Value, VariableSpec};
use std::ffi::{CStr, CString, c_char};
use std::mem::MaybeUninit;

/// What a value reference means.
#[derive(Clone, Copy)]
pub(crate) enum Target<V> {
    /// A row of the table.
    Variable(V, &'static VariableSpec),
    /// A state or its derivative.
    Exposed(Exposed),
}

impl<V> Target<V> {
    pub(crate) fn class(&self) -> Class {
        match self {
            Self::Variable(_, row) => Class::of(row),
            Self::Exposed(exposed) => exposed.class(),
        }
    }

    pub(crate) fn name(&self) -> String {
        match self {
            Self::Variable(_, row) => row.name.into(),
            Self::Exposed(exposed) => exposed.name(),
        }
    }
}

impl<S: Slave> Instance<S> {
    /// The variable of that reference, if it has that type.
    #[inline]
    pub(crate) fn find(&self, reference: u32, kind: Kind) -> Result<Target<S::Variable>, String> {
        if let Some(variable) = S::Variable::from_reference(reference) {
            let row = variable.spec();
            if row.kind == kind {
                return Ok(Target::Variable(variable, row));
            }
        }
        self.find_exposed(reference, kind)
    }

    #[inline(never)]
    fn find_exposed(&self, reference: u32, kind: Kind) -> Result<Target<S::Variable>, String> {
        match Exposed::find(reference, &self.settable) {
            Some(exposed) if kind == Kind::Real => Ok(Target::Exposed(exposed)),
            exposed => Err(Self::not_found(reference, kind, exposed)),
        }
    }

    #[cold]
    fn not_found(reference: u32, kind: Kind, exposed: Option<Exposed>) -> String {
        let (name, is) = match (S::Variable::from_reference(reference), exposed) {
            (Some(variable), _) => (variable.spec().name.to_owned(), variable.spec().kind),
            (None, Some(exposed)) => (exposed.name(), Kind::Real),
            (None, None) => {
                return format!("there is no variable with the value reference {reference}");
            }
        };
        format!("`{name}` (value reference {reference}) is {is}, not {kind}")
    }

    /// Checks that the variable may be read now.
    #[inline]
    fn may_get(&mut self, target: Target<S::Variable>) -> Result<(), String> {
        let access = match target {
            Target::Variable(_, row) => get_access(self.core.state, row),
            Target::Exposed(exposed) => exposed.class().get_access(self.core.state),
        };
        match access {
            Access::Legal => {}
            Access::Lenient(leniency) => self.note(leniency),
            Access::Illegal => return Err(self.not_now(&target, "read")),
        }
        if self.core.set_since_step && self.core.state == State::StepComplete {
            self.note(Leniency::ReadAfterSet);
        }
        Ok(())
    }

    /// Checks that the variable may be set now.
    #[inline]
    fn may_set(&self, target: Target<S::Variable>) -> Result<(), String> {
        match self.set_access(target) {
            Access::Legal | Access::Lenient(_) => Ok(()),
            Access::Illegal => Err(self.not_now(&target, "set")),
        }
    }

    #[inline]
    fn set_access(&self, target: Target<S::Variable>) -> Access {
        match target {
            Target::Variable(_, row) => set_access(self.core.state, row),
            Target::Exposed(exposed) => exposed.class().set_access(self.core.state),
        }
    }

    #[cold]
    pub(crate) fn not_now(&self, target: &Target<S::Variable>, what: &str) -> String {
        let state = self.core.state.name();
        match target {
            Target::Variable(_, row) => format!(
                "`{}` ({}, {}) cannot be {what} in the state \"{state}\"",
                row.name, row.causality, row.variability,
            ),
            Target::Exposed(exposed) => {
                format!("`{}` cannot be {what} in the state \"{state}\"", exposed.name())
            }
        }
    }

    /// The value of a variable.
    #[inline]
    fn value(&mut self, target: Target<S::Variable>) -> Value {
        match target {
            Target::Variable(variable, _) => self.core.slave.get(variable),
            Target::Exposed(exposed) => Value::Real(exposed.value(&mut *self.core.slave)),
        }
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
            let target = self.find(reference, kind)?;
            self.may_get(target)?;
        }
        for (&reference, slot) in references.iter().zip(values) {
            let target = self.find(reference, kind)?;
            let Some(value) = take(self.value(target)) else {
                return Err(wrong_kind(&target));
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
            let target = self.find(reference, Kind::String)?;
            self.may_get(target)?;
        }
        let mut strings = Vec::with_capacity(references.len());
        for &reference in references {
            let target = self.find(reference, Kind::String)?;
            let Value::String(text) = self.value(target) else {
                return Err(wrong_kind(&target));
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
        accept: impl Fn(&Target<S::Variable>, T) -> Result<Accepted, String>,
    ) -> Outcome {
        for (&reference, &value) in references.iter().zip(values) {
            let target = self.find(reference, kind)?;
            self.may_set(target)?;
            accept(&target, value)?;
        }
        let mut status = Status::Ok;
        for (&reference, &value) in references.iter().zip(values) {
            let target = self.find(reference, kind)?;
            if let Access::Lenient(leniency) = self.set_access(target) {
                self.note(leniency);
            }
            let accepted = accept(&target, value)?;
            match target {
                Target::Variable(variable, row) => {
                    if accepted.clipped && self.tell_clipped(row) {
                        status = Status::Warning;
                    }
                    self.core.slave.set(variable, &accepted.value);
                }
                Target::Exposed(exposed) => exposed.set(&mut *self.core.slave, &accepted.value),
            }
        }
        self.core.set_since_step = true;
        Ok(status)
    }

    pub(crate) fn set_reals(&mut self, references: &[u32], values: &[f64]) -> Outcome {
        self.set_all(references, values, Kind::Real, |target, value| {
            if !value.is_finite() {
                return Err(cannot_be(target, value));
            }
            let (number, clipped) = within_limits(target, value)?;
            Ok(Accepted { value: Value::Real(number), clipped })
        })
    }

    pub(crate) fn set_integers(&mut self, references: &[u32], values: &[i32]) -> Outcome {
        self.set_all(references, values, Kind::Integer, |target, value| {
            let (number, clipped) = within_limits(target, f64::from(value))?;
            // Limits outside the range of integers saturate.
            let value = if clipped { number as i32 } else { value };
            Ok(Accepted { value: Value::Integer(value), clipped })
        })
    }

    pub(crate) fn set_booleans(&mut self, references: &[u32], values: &[i32]) -> Outcome {
        self.set_all(references, values, Kind::Boolean, |target, value| match value {
            0 | 1 => Ok(Accepted { value: Value::Boolean(value == 1), clipped: false }),
            _ => Err(format!("`{}` cannot be {value}: a Boolean is 0 or 1", target.name())),
        })
    }

    /// Sets String variables from UTF-8 texts; `None` stands for a null pointer.
    pub(crate) fn set_strings(&mut self, references: &[u32], values: &[Option<&CStr>]) -> Outcome {
        self.set_all(references, values, Kind::String, |target, value| {
            let text = value.ok_or_else(|| format!("the text for `{}` is NULL", target.name()))?;
            let text = text
                .to_str()
                .map_err(|_| format!("the text for `{}` is no UTF-8", target.name()))?;
            Ok(Accepted { value: Value::String(text.into()), clipped: false })
        })
    }

    /// Tells that an input is clipped, once for each input; whether it was told now.
    #[cold]
    fn tell_clipped(&mut self, row: &VariableSpec) -> bool {
        if self.core.clipped.contains(&row.reference) {
            return false;
        }
        self.core.clipped.push(row.reference);
        let text = format!(
            "the input `{}` is outside [{}, {}] and is clipped, here and from now on",
            row.name,
            row.min.unwrap_or(f64::NEG_INFINITY),
            row.max.unwrap_or(f64::INFINITY)
        );
        self.tell_often(Category::Warning, text);
        true
    }
}

/// A value that may be set.
struct Accepted {
    value: Value,
    clipped: bool,
}

#[cold]
fn wrong_kind<V>(target: &Target<V>) -> String {
    format!("the model gave `{}` a value of another type", target.name())
}

#[cold]
fn cannot_be<V>(target: &Target<V>, value: f64) -> String {
    format!("`{}` cannot be {value}", target.name())
}

/// A finite number within the limits, and whether it had to be clipped; only inputs are.
#[inline]
fn within_limits<V>(target: &Target<V>, value: f64) -> Result<(f64, bool), String> {
    // States have no limits here; what the model cannot take it refuses when it is initialized.
    let Target::Variable(_, row) = target else { return Ok((value, false)) };
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
