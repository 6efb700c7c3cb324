//! An integrator, der(y) = gain u, as an FMU. It panics where u is above 1e6.
#![deny(unsafe_code)] // the macro allows it for itself

use fmi2_export::model_description::{
    Causality, DependsOn, Table, Value, Variability, VariableSpec,
};
use fmi2_export::{Log, Resources, Slave, VariableId};

const VARIABLES: &[VariableSpec] = &[
    VariableSpec::real("u", 0, Causality::Input, Variability::Continuous).unit("m/s"),
    VariableSpec::real("gain", 1, Causality::Parameter, Variability::Tunable).min(0.0).max(1e3),
    VariableSpec::real("y", 2, Causality::Output, Variability::Continuous)
        .unit("m")
        .depends_on(DependsOn::Nothing)
        .initial_depends_on(DependsOn::Nothing),
];
const TABLE: Table = Table::new("Integrator", "1.0.0", "An integrator", VARIABLES);

/// The variables, in the order of their value references.
#[derive(Clone, Copy)]
#[repr(u32)]
pub(crate) enum Variable {
    /// Input, m/s.
    U,
    /// Factor.
    Gain,
    /// Output, m.
    Y,
}

impl VariableId for Variable {
    fn from_reference(reference: u32) -> Option<Self> {
        match reference {
            0 => Some(Self::U),
            1 => Some(Self::Gain),
            2 => Some(Self::Y),
            _ => None,
        }
    }

    fn spec(self) -> &'static VariableSpec {
        &VARIABLES[self as usize]
    }
}

/// The slave: what it was given, and its state.
#[derive(Debug, Clone)]
pub(crate) struct Integrator {
    u: f64,
    gain: f64,
    y: f64,
}

impl Slave for Integrator {
    type Variable = Variable;
    const TABLE: &'static Table = &TABLE;

    fn open(_: &Resources) -> Result<Self, String> {
        Ok(Self { u: 0.0, gain: 1.0, y: 0.0 })
    }

    fn get(&mut self, variable: Variable) -> Value {
        Value::Real(match variable {
            Variable::U => self.u,
            Variable::Gain => self.gain,
            Variable::Y => self.y,
        })
    }

    fn set(&mut self, variable: Variable, value: &Value) {
        match (variable, value) {
            (Variable::U, Value::Real(value)) => self.u = *value,
            (Variable::Gain, Value::Real(value)) => self.gain = *value,
            _ => {}
        }
    }

    fn exit_initialization(&mut self, _start: f64, _log: &mut Log) -> Result<(), String> {
        Ok(())
    }

    fn step(&mut self, _time: f64, step: f64, _log: &mut Log) -> Result<(), String> {
        assert!(self.u <= 1e6, "too fast");
        self.y += self.gain * self.u * step;
        Ok(())
    }
}

fmi2_export::export!(Integrator);
