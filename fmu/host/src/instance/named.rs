//! Getting and setting by variable name, checked against modelDescription.xml.

use model_description::{Causality, Initial, Kind, Value, Variability, Variable};

use super::Instance;
use super::phase::Phase;
use crate::Error;

/// Declares the readers of one variable of a kind.
macro_rules! readers {
    ($($name:ident: $kind:ident, $type:ty, $get:ident;)*) => {$(
        #[doc = concat!("Reads a variable of type ", stringify!($kind), ".")]
        pub fn $name(&mut self, name: &str) -> Result<$type, Error> {
            let reference = self.reference(name, Kind::$kind)?;
            let mut value = [<$type>::default()];
            self.$get(&reference, &mut value)?;
            Ok(value[0])
        }
    )*};
}

impl Instance {
    /// The description of a variable in modelDescription.xml.
    pub fn variable(&self, name: &str) -> Result<&Variable, Error> {
        self.model.variable(name).ok_or_else(|| Error::UnknownVariable {
            instance: self.name.clone(),
            name: name.to_owned(),
            near: self.model.near(name),
        })
    }

    /// Reads a variable of any kind.
    pub fn value(&mut self, name: &str) -> Result<Value, Error> {
        Ok(match self.variable(name)?.kind {
            Kind::Real => Value::Real(self.real(name)?),
            Kind::Integer => Value::Integer(self.integer(name)?),
            Kind::Boolean => Value::Boolean(self.boolean(name)?),
            Kind::String => {
                let reference = self.reference(name, Kind::String)?;
                Value::String(self.get_string(&reference)?.pop().unwrap_or_default())
            }
        })
    }

    readers! {
        real: Real, f64, get_real;
        integer: Integer, i32, get_integer;
        boolean: Boolean, bool, get_boolean;
    }

    /// Refuses a variable that may not be set in the present phase, with the reason.
    pub fn settable(&self, name: &str) -> Result<(), Error> {
        let Some(reason) = why_not_settable(self.variable(name)?, self.phase) else {
            return Ok(());
        };
        let (instance, variable) = (self.name.clone(), name.to_owned());
        Err(Error::NotSettable { instance, variable, phase: self.phase.when(), reason })
    }

    /// Sets a variable, if it is of the value's kind and may be set in the present phase.
    pub fn set(&mut self, name: &str, value: impl Into<Value>) -> Result<(), Error> {
        let value = value.into();
        let reference = self.reference(name, value.kind())?;
        self.settable(name)?;
        match value {
            Value::Real(value) => self.set_real(&reference, &[value]),
            Value::Integer(value) => self.set_integer(&reference, &[value]),
            Value::Boolean(value) => self.set_boolean(&reference, &[value]),
            Value::String(value) => self.set_string(&reference, &[value]),
        }
    }

    /// The value reference of a variable of the wanted kind.
    pub(super) fn reference(&self, name: &str, kind: Kind) -> Result<[u32; 1], Error> {
        let variable = self.variable(name)?;
        if variable.kind == kind {
            return Ok([variable.reference]);
        }
        let (instance, need) = (self.name.clone(), variable.kind);
        Err(Error::WrongKind { instance, variable: name.to_owned(), need, got: kind })
    }
}

/// Why a variable may not be set in a phase by table 4.2.4 of FMI 2.0.5; `None` if it may.
pub(crate) fn why_not_settable(variable: &Variable, phase: Phase) -> Option<&'static str> {
    if variable.variability == Variability::Constant {
        return Some("it is a constant");
    }
    let input = variable.causality == Causality::Input;
    let initial = variable.effective_initial();
    match phase {
        Phase::Instantiated => match initial {
            _ if input => Some("it is an input"),
            Some(Initial::Exact | Initial::Approx) => None,
            _ => Some("its initial value is calculated"),
        },
        Phase::Initialization => match initial {
            _ if input => None,
            Some(Initial::Exact) => None,
            _ => Some("its initial value is not exact"),
        },
        Phase::StepComplete => {
            let tunable = variable.causality == Causality::Parameter
                && variable.variability == Variability::Tunable;
            if input || tunable { None } else { Some("it is no input and no tunable parameter") }
        }
        _ => Some("nothing can be set at this time"),
    }
}
