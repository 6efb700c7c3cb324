//! The units of the benchmark, without C symbols: the examples add these.
//!
//! [`Linear`] is `x⁺ = A x + B u`, `y = C x⁺` with four states, the numbers and the order of
//! operations those of `bare.c`. [`Empty`] has the same variables and does nothing in a step.

use fmi2_export::model_description::{
    Causality, DependsOn, Table, Value, Variability, VariableSpec,
};
use fmi2_export::{CoSimulationUnit, Log, Resources, VariableId};

const VARIABLES: &[VariableSpec] = &[
    VariableSpec::real("u", 0, Causality::Input, Variability::Continuous),
    VariableSpec::real("y", 1, Causality::Output, Variability::Continuous)
        .depends_on(DependsOn::Nothing)
        .initial_depends_on(DependsOn::Nothing),
];
const LINEAR: Table = Table::new("Linear", "1.0.0", "Four linear states", VARIABLES);
const EMPTY: Table = Table::new("Empty", "1.0.0", "Does nothing", VARIABLES);

/// Input and output of both.
#[derive(Clone, Copy, Debug)]
#[repr(u32)]
pub enum Variable {
    /// The input.
    U,
    /// The output.
    Y,
}

impl VariableId for Variable {
    #[inline]
    fn from_reference(reference: u32) -> Option<Self> {
        match reference {
            0 => Some(Self::U),
            1 => Some(Self::Y),
            _ => None,
        }
    }

    #[inline]
    fn spec(self) -> &'static VariableSpec {
        &VARIABLES[self as usize]
    }
}

const A: [[f64; 4]; 4] =
    [[0.95, 0.05, 0.0, 0.0], [-0.05, 0.95, 0.02, 0.0], [0.0, 0.0, 0.8, 0.1], [0.0, 0.0, -0.1, 0.8]];
const B: [f64; 4] = [0.01, 0.02, 0.03, 0.01];
const C: [f64; 4] = [1.0, 0.5, 0.25, 0.125];

/// A linear model.
#[derive(Clone, Debug)]
pub struct Linear {
    x: [f64; 4],
    u: f64,
    y: f64,
}

impl CoSimulationUnit for Linear {
    type Variable = Variable;
    const TABLE: &'static Table = &LINEAR;

    fn open(_: &Resources) -> Result<Self, String> {
        Ok(Self { x: [0.0; 4], u: 1.0, y: 0.0 })
    }

    #[inline]
    fn get(&mut self, variable: Variable) -> Value {
        Value::Real(match variable {
            Variable::U => self.u,
            Variable::Y => self.y,
        })
    }

    #[inline]
    fn set(&mut self, variable: Variable, value: &Value) {
        if let (Variable::U, Value::Real(value)) = (variable, value) {
            self.u = *value;
        }
    }

    fn exit_initialization(&mut self, _: f64, _: &mut Log) -> Result<(), String> {
        Ok(())
    }

    #[inline]
    fn step(&mut self, _: f64, _: f64, _: &mut Log) -> Result<(), String> {
        let x = self.x;
        let mut y = 0.0;
        for i in 0..4 {
            let row = A[i][0] * x[0] + A[i][1] * x[1] + A[i][2] * x[2] + A[i][3] * x[3];
            self.x[i] = row + B[i] * self.u;
            y += C[i] * self.x[i];
        }
        self.y = y;
        Ok(())
    }
}

/// No model.
#[derive(Clone, Debug)]
pub struct Empty {
    u: f64,
}

impl CoSimulationUnit for Empty {
    type Variable = Variable;
    const TABLE: &'static Table = &EMPTY;

    fn open(_: &Resources) -> Result<Self, String> {
        Ok(Self { u: 1.0 })
    }

    #[inline]
    fn get(&mut self, _: Variable) -> Value {
        Value::Real(self.u)
    }

    #[inline]
    fn set(&mut self, variable: Variable, value: &Value) {
        if let (Variable::U, Value::Real(value)) = (variable, value) {
            self.u = *value;
        }
    }

    fn exit_initialization(&mut self, _: f64, _: &mut Log) -> Result<(), String> {
        Ok(())
    }

    #[inline]
    fn step(&mut self, _: f64, _: f64, _: &mut Log) -> Result<(), String> {
        Ok(())
    }
}
