//! An integrator, der(y) = gain u, as an FMU. It panics if u exceeds 1e6.
#![deny(unsafe_code)] // the macro allows it for itself

use fmi2_export::model_description::{DependsOn::Nothing, Table, Value};
use fmi2_export::{CoSimulationUnit, Log, Resources};

fmi2_export::variables! {
    /// Variables of the integrator.
    Variable, "Integrator", "An integrator";
    U = 0, real "u", Input, Continuous, .unit("m/s");
    Gain = 1, real "gain", Parameter, Tunable, .min(0.0).max(1e3);
    Y = 2, real "y", Output, Continuous, .unit("m").depends_on(Nothing).initial_depends_on(Nothing);
}

/// The unit: its input and parameter, and its state.
#[derive(Debug, Clone)]
pub(crate) struct Integrator {
    u: f64,
    gain: f64,
    y: f64,
}

impl CoSimulationUnit for Integrator {
    type Variable = Variable;
    const TABLE: &'static Table = Variable::TABLE;

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
