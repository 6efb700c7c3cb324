//! Reading and setting variables: everything is checked before anything changes.

use crate::access_rules::EVERYTHING_READ;
use crate::calls::{Access, Class, Leniency, State, set_access};
use crate::exposed::Exposed;
use crate::instance::{Instance, Outcome};
use crate::logger::Category;
use crate::types::Status;
use crate::{Slave, VariableId};
use model_description::{Causality, Kind, Value, VariableSpec};
use std::ffi::{CStr, CString, c_char};
use std::mem::MaybeUninit;
use std::ops::RangeInclusive;

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
    /// The table's variable of that reference, if it has that type: the way that most calls take.
    #[inline]
    fn row(reference: u32, kind: Kind) -> Option<(S::Variable, &'static VariableSpec)> {
        let variable = S::Variable::from_reference(reference)?;
        let row = variable.spec();
        (row.kind == kind).then_some((variable, row))
    }

    /// The variable of that reference, if it has that type.
    #[inline(never)]
    pub(crate) fn find(&self, reference: u32, kind: Kind) -> Result<Target<S::Variable>, String> {
        if let Some((variable, row)) = Self::row(reference, kind) {
            return Ok(Target::Variable(variable, row));
        }
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

    #[cold]
    fn not_now(&self, target: &Target<S::Variable>, what: &str) -> String {
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

    /// Checks that the variables may be read now, and notes what is lenient in it.
    #[inline]
    fn may_get(&mut self, references: &[u32], kind: Kind) -> Result<(), String> {
        let is_row = |reference: &u32| Self::row(*reference, kind).is_some();
        if EVERYTHING_READ[self.core.state as usize]
            && !self.core.set_since_step
            && references.iter().all(is_row)
        {
            return Ok(());
        }
        references.iter().try_for_each(|reference| self.may_get_this(*reference, kind))
    }

    #[inline(never)]
    fn may_get_this(&mut self, reference: u32, kind: Kind) -> Result<(), String> {
        let target = self.find(reference, kind)?;
        match target.class().get_access(self.core.state) {
            Access::Legal => {}
            Access::Lenient(leniency) => self.note(leniency),
            Access::Illegal => return Err(self.not_now(&target, "read")),
        }
        if self.core.set_since_step && self.core.state == State::StepComplete {
            self.note(Leniency::ReadAfterSet);
        }
        Ok(())
    }

    /// The value of a variable that may be read.
    #[inline]
    fn value(&mut self, reference: u32, kind: Kind) -> Result<Value, String> {
        match Self::row(reference, kind) {
            Some((variable, _)) => Ok(self.core.slave.get(variable)),
            None => self.exposed_value(reference, kind),
        }
    }

    #[inline(never)]
    fn exposed_value(&mut self, reference: u32, kind: Kind) -> Result<Value, String> {
        Ok(match self.find(reference, kind)? {
            Target::Variable(variable, _) => self.core.slave.get(variable),
            Target::Exposed(exposed) => Value::Real(exposed.value(&mut *self.core.slave)),
        })
    }

    #[cold]
    fn no_value(&self, reference: u32, kind: Kind) -> String {
        match self.find(reference, kind) {
            Ok(target) if kind == Kind::Real => {
                format!("the model has no finite value for `{}` here", target.name())
            }
            Ok(target) => format!("the model gave `{}` a value of another type", target.name()),
            Err(problem) => problem,
        }
    }

    /// Reads variables of one type. `take` gives `None` for a value of another type, and for a Real
    /// that is not finite.
    #[inline]
    pub(crate) fn get_all<T>(
        &mut self,
        references: &[u32],
        values: &mut [MaybeUninit<T>],
        kind: Kind,
        take: impl Fn(Value) -> Option<T>,
    ) -> Outcome {
        self.may_get(references, kind)?;
        for (&reference, slot) in references.iter().zip(values) {
            let Some(value) = take(self.value(reference, kind)?) else {
                return Err(self.no_value(reference, kind));
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
        self.may_get(references, Kind::String)?;
        let mut strings = Vec::with_capacity(references.len());
        for &reference in references {
            let Value::String(text) = self.value(reference, Kind::String)? else {
                return Err(self.no_value(reference, Kind::String));
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

    /// Sets variables of one type: first all are checked, then all are set. `accept` says what a
    /// value becomes, and whether it was clipped for that, or why it may not be; `wrap` makes the
    /// slave's value of it.
    #[inline]
    fn set_all<T: Copy, U>(
        &mut self,
        references: &[u32],
        values: &[T],
        kind: Kind,
        accept: impl Fn(&VariableSpec, T) -> Result<(U, bool), String>,
        wrap: impl Fn(U) -> Value,
    ) -> Outcome {
        // One alone is set when it is checked.
        if references.len() > 1 {
            for (&reference, &value) in references.iter().zip(values) {
                let (_, row) = self.may_set(reference, kind)?;
                accept(row, value)?;
            }
        }
        let mut status = Status::Ok;
        for (&reference, &value) in references.iter().zip(values) {
            let (variable, row) = self.may_set(reference, kind)?;
            let (value, clipped) = accept(row, value)?;
            if clipped && self.tell_clipped(row) {
                status = Status::Warning;
            }
            // The only state in which setting something is a leniency.
            if self.core.state == State::Instantiated {
                self.note_early(row);
            }
            self.core.slave.set(variable, &wrap(value));
        }
        self.core.set_since_step |= !references.is_empty();
        Ok(status)
    }

    /// A variable of the table that may be set now.
    #[inline]
    fn may_set(
        &self,
        reference: u32,
        kind: Kind,
    ) -> Result<(S::Variable, &'static VariableSpec), String> {
        match Self::row(reference, kind) {
            Some((variable, row)) if set_access(self.core.state, row) != Access::Illegal => {
                Ok((variable, row))
            }
            _ => Err(self.may_not_set(reference, kind)),
        }
    }

    #[cold]
    fn may_not_set(&self, reference: u32, kind: Kind) -> String {
        match self.find(reference, kind) {
            Ok(target) => self.not_now(&target, "set"),
            Err(problem) => problem,
        }
    }

    #[cold]
    fn note_early(&mut self, row: &VariableSpec) {
        if let Access::Lenient(leniency) = set_access(self.core.state, row) {
            self.note(leniency);
        }
    }

    #[inline]
    pub(crate) fn set_reals(&mut self, references: &[u32], values: &[f64]) -> Outcome {
        // What nothing is to be said about: the way that most calls take.
        let plain = |(reference, value): (&u32, &f64)| {
            Self::row(*reference, Kind::Real).is_some_and(|(_, row)| {
                set_access(self.core.state, row) == Access::Legal
                    && value.is_finite()
                    && limits(row).contains(value)
            })
        };
        if !references.iter().zip(values).all(plain) {
            return self.set_reals_by_one(references, values);
        }
        for (reference, value) in references.iter().zip(values) {
            if let Some((variable, _)) = Self::row(*reference, Kind::Real) {
                self.core.slave.set(variable, &Value::Real(*value));
            }
        }
        self.core.set_since_step |= !references.is_empty();
        Ok(Status::Ok)
    }

    /// Sets Real variables among which are states, or some that something is to be said about.
    #[inline(never)]
    fn set_reals_by_one(&mut self, references: &[u32], values: &[f64]) -> Outcome {
        for (&reference, &value) in references.iter().zip(values) {
            let target = self.find(reference, Kind::Real)?;
            if target.class().set_access(self.core.state) == Access::Illegal {
                return Err(self.not_now(&target, "set"));
            }
            match target {
                Target::Variable(_, row) => drop(acceptable(row, value)?),
                Target::Exposed(_) if value.is_finite() => {}
                Target::Exposed(exposed) => return Err(cannot_be(&exposed.name(), value)),
            }
        }
        let mut status = Status::Ok;
        for (reference, value) in references.iter().zip(values) {
            if let Target::Exposed(exposed) = self.find(*reference, Kind::Real)? {
                // States have no limits; what the model cannot take, it refuses.
                exposed.set(&mut *self.core.slave, *value);
            } else {
                let (reference, value) =
                    (std::slice::from_ref(reference), std::slice::from_ref(value));
                let set = self.set_all(reference, value, Kind::Real, acceptable, Value::Real)?;
                status = status.max(set);
            }
        }
        self.core.set_since_step |= !references.is_empty();
        Ok(status)
    }

    pub(crate) fn set_integers(&mut self, references: &[u32], values: &[i32]) -> Outcome {
        let accept = |row: &VariableSpec, value| {
            let (number, clipped) = within_limits(row, f64::from(value))?;
            // Limits outside the range of integers saturate.
            Ok((if clipped { number as i32 } else { value }, clipped))
        };
        self.set_all(references, values, Kind::Integer, accept, Value::Integer)
    }

    pub(crate) fn set_booleans(&mut self, references: &[u32], values: &[i32]) -> Outcome {
        let accept = |row: &VariableSpec, value| match value {
            0 | 1 => Ok((value == 1, false)),
            _ => Err(format!("`{}` cannot be {value}: a Boolean is 0 or 1", row.name)),
        };
        self.set_all(references, values, Kind::Boolean, accept, Value::Boolean)
    }

    /// Sets String variables from UTF-8 texts; `None` stands for a null pointer.
    pub(crate) fn set_strings(&mut self, references: &[u32], values: &[Option<&CStr>]) -> Outcome {
        let accept = |row: &VariableSpec, value: Option<&CStr>| {
            let text = value.ok_or_else(|| format!("the text for `{}` is NULL", row.name))?;
            match text.to_str() {
                Ok(text) => Ok((text.to_owned(), false)),
                Err(_) => Err(format!("the text for `{}` is no UTF-8", row.name)),
            }
        };
        self.set_all(references, values, Kind::String, accept, Value::String)
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

/// What a Real variable of the table may be given.
#[inline]
fn acceptable(row: &VariableSpec, value: f64) -> Result<(f64, bool), String> {
    if value.is_finite() { within_limits(row, value) } else { Err(cannot_be(row.name, value)) }
}

#[cold]
fn cannot_be(name: &str, value: f64) -> String {
    format!("`{name}` cannot be {value}")
}

#[inline]
fn limits(row: &VariableSpec) -> RangeInclusive<f64> {
    row.min.unwrap_or(f64::NEG_INFINITY)..=row.max.unwrap_or(f64::INFINITY)
}

/// A finite number within the limits, and whether it had to be clipped; only inputs are.
#[inline]
fn within_limits(row: &VariableSpec, value: f64) -> Result<(f64, bool), String> {
    let limits = limits(row);
    let (min, max) = (*limits.start(), *limits.end());
    if limits.contains(&value) {
        Ok((value, false))
    } else if row.causality == Causality::Input {
        Ok((if value < min { min } else { max }, true))
    } else {
        Err(outside(row, value, min, max))
    }
}

#[cold]
fn outside(row: &VariableSpec, value: f64, min: f64, max: f64) -> String {
    format!("`{}` cannot be {value}: it is limited to [{min}, {max}]", row.name)
}
