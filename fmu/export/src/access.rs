//! Reading and setting variables. All arguments of a call are checked before a variable changes.

use crate::access_rules::{Access, Class, EVERYTHING_READ, Leniency, set_access};
use crate::calls::State;
use crate::exposed::Exposed;
use crate::instance::{Instance, Outcome};
use crate::logger::Category;
use crate::types::Status;
use crate::unit::{CoSimulationUnit, VariableId};
use model_description::{Causality, Kind, Value, VariableSpec};
use std::ffi::{CStr, CString, c_char};
use std::mem::MaybeUninit;
use std::ops::RangeInclusive;

/// The variable of a value reference.
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
            Self::Variable(_, row) => Class::from_row(row),
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

impl<S: CoSimulationUnit> Instance<S> {
    /// The name of a variable in the description.
    #[cold]
    pub(crate) fn name(&self, variable: S::Variable) -> String {
        match self.core.unit.stated(variable) {
            Some(stated) => stated.name,
            None => variable.spec().name.into(),
        }
    }

    /// The name of a variable or state in the description.
    #[cold]
    fn name_of(&self, target: &Target<S::Variable>) -> String {
        match target {
            Target::Variable(variable, _) => self.name(*variable),
            Target::Exposed(exposed) => exposed.name(),
        }
    }

    /// A problem of a variable with the name that it has in the description.
    #[cold]
    fn named(&self, variable: S::Variable, problem: &str) -> String {
        let row = format!("`{}`", variable.spec().name);
        problem.replace(&row, &format!("`{}`", self.name(variable)))
    }

    /// The table's variable of a reference if the archive has it and it has the type: the fast path.
    #[inline]
    fn row(&self, reference: u32, kind: Kind) -> Option<(S::Variable, &'static VariableSpec)> {
        let variable = S::Variable::from_reference(reference)?;
        let row = variable.spec();
        if row.kind == kind && self.core.unit.has(variable) { Some((variable, row)) } else { None }
    }

    /// The variable or state of a reference.
    ///
    /// # Errors
    /// The reference is unknown or the variable has another type.
    #[inline(never)]
    pub(crate) fn find(&self, reference: u32, kind: Kind) -> Result<Target<S::Variable>, String> {
        if let Some((variable, row)) = self.row(reference, kind) {
            return Ok(Target::Variable(variable, row));
        }
        match Exposed::find(reference, &self.settable) {
            Some(exposed) if kind == Kind::Real => Ok(Target::Exposed(exposed)),
            exposed => Err(self.not_found(reference, kind, exposed)),
        }
    }

    #[cold]
    fn not_found(&self, reference: u32, kind: Kind, exposed: Option<Exposed>) -> String {
        let variable = S::Variable::from_reference(reference);
        let (name, is) = match (variable.filter(|v| self.core.unit.has(*v)), exposed) {
            (Some(variable), _) => (self.name(variable), variable.spec().kind),
            (None, Some(exposed)) => (exposed.name(), Kind::Real),
            (None, None) => {
                return format!("no variable has the value reference {reference}");
            }
        };
        format!("`{name}` (value reference {reference}) is {is}, not {kind}")
    }

    #[cold]
    fn illegal_access(&self, target: &Target<S::Variable>, what: &str) -> String {
        let state = self.core.state.name();
        match target {
            Target::Variable(variable, row) => format!(
                "`{}` ({}, {}) cannot be {what} in the state \"{state}\"",
                self.name(*variable),
                row.causality,
                row.variability,
            ),
            Target::Exposed(exposed) => {
                format!("`{}` cannot be {what} in the state \"{state}\"", exposed.name())
            }
        }
    }

    /// Checks that the variables may be read in this state, and logs deviations from the standard.
    #[inline]
    fn check_get(&mut self, references: &[u32], kind: Kind) -> Result<(), String> {
        let is_row = |reference: &u32| self.row(*reference, kind).is_some();
        if EVERYTHING_READ[self.core.state as usize]
            && !self.core.set_since_step
            && references.iter().all(is_row)
        {
            return Ok(());
        }
        references.iter().try_for_each(|reference| self.check_get_one(*reference, kind))
    }

    #[inline(never)]
    fn check_get_one(&mut self, reference: u32, kind: Kind) -> Result<(), String> {
        let target = self.find(reference, kind)?;
        match target.class().get_access(self.core.state) {
            Access::Legal => {}
            Access::Lenient(leniency) => self.log_once(leniency),
            Access::Illegal => return Err(self.illegal_access(&target, "read")),
        }
        if self.core.set_since_step && self.core.state == State::StepComplete {
            self.log_once(Leniency::ReadAfterSet);
        }
        Ok(())
    }

    /// The value of a variable; the caller has checked that it may be read.
    #[inline]
    fn value(&mut self, reference: u32, kind: Kind) -> Result<Value, String> {
        match self.row(reference, kind) {
            Some((variable, _)) => Ok(self.core.unit.get(variable)),
            None => self.exposed_value(reference, kind),
        }
    }

    #[inline(never)]
    fn exposed_value(&mut self, reference: u32, kind: Kind) -> Result<Value, String> {
        Ok(match self.find(reference, kind)? {
            Target::Variable(variable, _) => self.core.unit.get(variable),
            Target::Exposed(exposed) => Value::Real(exposed.value(&mut *self.core.unit)),
        })
    }

    #[cold]
    fn no_value(&self, reference: u32, kind: Kind) -> String {
        match self.find(reference, kind) {
            Ok(target) if kind == Kind::Real => {
                format!("the value of `{}` is not finite", self.name_of(&target))
            }
            Ok(target) => {
                format!(
                    "the model returned a value of another type for `{}`",
                    self.name_of(&target)
                )
            }
            Err(problem) => problem,
        }
    }

    /// Reads variables of one type. `take` is `None` for another type or a Real that is not finite.
    #[inline]
    pub(crate) fn get_all<T>(
        &mut self,
        references: &[u32],
        values: &mut [MaybeUninit<T>],
        kind: Kind,
        take: impl Fn(Value) -> Option<T>,
    ) -> Outcome {
        self.check_get(references, kind)?;
        for (&reference, slot) in references.iter().zip(values) {
            let Some(value) = take(self.value(reference, kind)?) else {
                return Err(self.no_value(reference, kind));
            };
            slot.write(value);
        }
        Ok(Status::Ok)
    }

    /// Reads String variables; the pointers are valid until the next such call.
    pub(crate) fn get_strings(
        &mut self,
        references: &[u32],
        values: &mut [MaybeUninit<*const c_char>],
    ) -> Outcome {
        self.check_get(references, Kind::String)?;
        let mut strings = Vec::with_capacity(references.len());
        for &reference in references {
            let Value::String(text) = self.value(reference, Kind::String)? else {
                return Err(self.no_value(reference, Kind::String));
            };
            // A C string cannot contain NUL.
            strings.push(CString::new(text.replace('\0', "")).unwrap_or_default());
        }
        self.strings = strings;
        for (string, slot) in self.strings.iter().zip(values) {
            slot.write(string.as_ptr());
        }
        Ok(Status::Ok)
    }

    /// Sets variables of one type: first all are checked, then all are set. `accept` returns the value
    /// to set and whether it was clipped, or why it is invalid; `wrap` makes it a [`Value`].
    #[inline]
    fn set_all<T: Copy, U>(
        &mut self,
        references: &[u32],
        values: &[T],
        kind: Kind,
        accept: impl Fn(&VariableSpec, T) -> Result<(U, bool), String>,
        wrap: impl Fn(U) -> Value,
    ) -> Outcome {
        // A single variable is checked when it is set.
        if references.len() > 1 {
            for (&reference, &value) in references.iter().zip(values) {
                let (variable, row) = self.find_settable(reference, kind)?;
                accept(row, value).map_err(|problem| self.named(variable, &problem))?;
            }
        }
        let mut status = Status::Ok;
        for (&reference, &value) in references.iter().zip(values) {
            let (variable, row) = self.find_settable(reference, kind)?;
            let (value, clipped) =
                accept(row, value).map_err(|problem| self.named(variable, &problem))?;
            if clipped && self.warn_clipped(row) {
                status = Status::Warning;
            }
            // The only state in which setting a variable can be a leniency.
            if self.core.state == State::Instantiated {
                self.log_early_set(row);
            }
            self.core.unit.set(variable, &wrap(value));
        }
        self.core.set_since_step |= !references.is_empty();
        Ok(status)
    }

    /// A variable of the table that may be set in this state.
    #[inline]
    fn find_settable(
        &self,
        reference: u32,
        kind: Kind,
    ) -> Result<(S::Variable, &'static VariableSpec), String> {
        match self.row(reference, kind) {
            Some((variable, row)) if set_access(self.core.state, row) != Access::Illegal => {
                Ok((variable, row))
            }
            _ => Err(self.not_settable(reference, kind)),
        }
    }

    #[cold]
    fn not_settable(&self, reference: u32, kind: Kind) -> String {
        match self.find(reference, kind) {
            Ok(target) => self.illegal_access(&target, "set"),
            Err(problem) => problem,
        }
    }

    #[cold]
    fn log_early_set(&mut self, row: &VariableSpec) {
        if let Access::Lenient(leniency) = set_access(self.core.state, row) {
            self.log_once(leniency);
        }
    }

    #[inline]
    pub(crate) fn set_reals(&mut self, references: &[u32], values: &[f64]) -> Outcome {
        // The fast path: values that need no clipping and no message.
        let plain = |(reference, value): (&u32, &f64)| {
            self.row(*reference, Kind::Real).is_some_and(|(_, row)| {
                set_access(self.core.state, row) == Access::Legal
                    && value.is_finite()
                    && limits(row).contains(value)
            })
        };
        if !references.iter().zip(values).all(plain) {
            return self.set_reals_by_one(references, values);
        }
        for (reference, value) in references.iter().zip(values) {
            if let Some((variable, _)) = self.row(*reference, Kind::Real) {
                self.core.unit.set(variable, &Value::Real(*value));
            }
        }
        self.core.set_since_step |= !references.is_empty();
        Ok(Status::Ok)
    }

    /// Sets Real variables one by one: some are states, or need clipping or a message.
    #[inline(never)]
    fn set_reals_by_one(&mut self, references: &[u32], values: &[f64]) -> Outcome {
        for (&reference, &value) in references.iter().zip(values) {
            let target = self.find(reference, Kind::Real)?;
            if target.class().set_access(self.core.state) == Access::Illegal {
                return Err(self.illegal_access(&target, "set"));
            }
            match target {
                Target::Variable(variable, row) => {
                    acceptable(row, value).map_err(|problem| self.named(variable, &problem))?;
                }
                Target::Exposed(_) if value.is_finite() => {}
                Target::Exposed(exposed) => return Err(cannot_be(&exposed.name(), value)),
            }
        }
        let mut status = Status::Ok;
        for (reference, value) in references.iter().zip(values) {
            if let Target::Exposed(exposed) = self.find(*reference, Kind::Real)? {
                // States have no limits; the model rejects values that it cannot use.
                exposed.set(&mut *self.core.unit, *value);
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

    /// Sets String variables from UTF-8 texts; `None` is a null pointer.
    pub(crate) fn set_strings(
        &mut self,
        references: &[u32],
        values: Vec<Option<&CStr>>,
    ) -> Outcome {
        let accept = |row: &VariableSpec, value: Option<&CStr>| {
            let text = value.ok_or_else(|| format!("the text for `{}` is NULL", row.name))?;
            match text.to_str() {
                Ok(text) => Ok((text.to_owned(), false)),
                Err(_) => Err(format!("the text for `{}` is not UTF-8", row.name)),
            }
        };
        self.set_all(references, &values, Kind::String, accept, Value::String)
    }

    /// Logs that an input is clipped, once for each input. Returns whether it is the first time.
    #[cold]
    fn warn_clipped(&mut self, row: &VariableSpec) -> bool {
        if self.core.clipped.contains(&row.reference) {
            return false;
        }
        self.core.clipped.push(row.reference);
        let text = format!(
            "the input `{}` is outside [{}, {}] and is clipped; this warning is logged once",
            row.name,
            row.min.unwrap_or(f64::NEG_INFINITY),
            row.max.unwrap_or(f64::INFINITY)
        );
        self.log_repeated(Category::Warning, text);
        true
    }
}

/// Checks a value of a Real variable of the table; returns it clipped, and whether it was clipped.
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

/// Checks a finite number against the limits; inputs are clipped, and the flag is then true.
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
    format!("`{}` cannot be {value}: its limits are [{min}, {max}]", row.name)
}
