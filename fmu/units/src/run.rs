//! An FMU's unit run in this process, without its C symbols: the code that its library runs.

use fmi2_export::{CoSimulationUnit, Log, VariableId};
use model_description::Value;

/// A [`CoSimulationUnit`] of any FMU after [`crate::Fmu::open`], without the checks of the FMI layer.
pub trait Running {
    /// The value of the variable with that reference, if there is one.
    fn get(&mut self, reference: u32) -> Option<Value>;

    /// Sets the variable with that reference, if there is one.
    fn set(&mut self, reference: u32, value: &Value);

    /// Leaves initialization at `start_time` (s).
    ///
    /// # Errors
    /// The message of the unit.
    fn exit_initialization(&mut self, start_time: f64) -> Result<(), String>;

    /// Advances from `time` by `step` (s).
    ///
    /// # Errors
    /// The message of the unit.
    fn step(&mut self, time: f64, step: f64) -> Result<(), String>;
}

impl<S: CoSimulationUnit> Running for S {
    fn get(&mut self, reference: u32) -> Option<Value> {
        S::Variable::from_reference(reference).map(|variable| CoSimulationUnit::get(self, variable))
    }

    fn set(&mut self, reference: u32, value: &Value) {
        if let Some(variable) = S::Variable::from_reference(reference) {
            CoSimulationUnit::set(self, variable, value);
        }
    }

    fn exit_initialization(&mut self, start_time: f64) -> Result<(), String> {
        CoSimulationUnit::exit_initialization(self, start_time, &mut Log::default())
    }

    fn step(&mut self, time: f64, step: f64) -> Result<(), String> {
        CoSimulationUnit::step(self, time, step, &mut Log::default())
    }
}
