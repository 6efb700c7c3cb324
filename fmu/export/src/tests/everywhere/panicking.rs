//! A unit that panics in a chosen function.

use crate::log::Log;
use crate::resources::Resources;
use crate::unit::{Capabilities, CoSimulationUnit, Known, StateSpec, Unknown, VariableId};
use model_description::{
    Causality as C, DependencyKind, Table, Value, Variability as V, VariableSpec,
};
use std::cell::Cell;

const VARIABLES: &[VariableSpec] = &[
    VariableSpec::real("u", 0, C::Input, V::Continuous),
    VariableSpec::real("y", 1, C::Output, V::Continuous),
    VariableSpec::integer("n", 2, C::Parameter, V::Tunable),
    VariableSpec::boolean("on", 3, C::Parameter, V::Tunable),
    VariableSpec::string("text", 4, C::Parameter, V::Tunable),
];
pub(super) const TABLE: Table = Table::new("Panicking", "1", "A unit that panics", VARIABLES);

/// The function in which the unit panics.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum At {
    Nowhere,
    Open,
    States,
    Get,
    Set,
    Exit,
    Step,
    State,
    StateDerivative,
    SetState,
    SetInputDerivative,
    OutputDerivative,
    Dependency,
    PartialDerivative,
    Save,
    Load,
    Clone,
    Drop,
    Reference,
}

thread_local! {
    pub(super) static AT: Cell<At> = const { Cell::new(At::Nowhere) };
    /// Whether the destructors of units and payloads panic too.
    pub(super) static DROPS: Cell<bool> = const { Cell::new(false) };
    pub(super) static ALIVE: Cell<i32> = const { Cell::new(0) };
}

pub(super) fn arm(place: At, drops: bool) {
    AT.set(place);
    DROPS.set(drops);
}

/// A panic payload that is not text and whose destructor can panic.
struct Payload;

impl Drop for Payload {
    fn drop(&mut self) {
        if DROPS.get() {
            panic!("the payload");
        }
    }
}

fn at(place: At) {
    if AT.get() == place {
        std::panic::panic_any(Payload);
    }
}

pub(super) struct Panicking;

impl Panicking {
    fn new() -> Self {
        ALIVE.set(ALIVE.get() + 1);
        Self
    }
}

impl Clone for Panicking {
    fn clone(&self) -> Self {
        at(At::Clone);
        Self::new()
    }
}

impl Drop for Panicking {
    fn drop(&mut self) {
        ALIVE.set(ALIVE.get() - 1);
        if DROPS.get() {
            std::panic::panic_any(Payload);
        }
        at(At::Drop);
    }
}

#[derive(Clone, Copy)]
pub(super) struct Variable(u32);

impl VariableId for Variable {
    fn from_reference(reference: u32) -> Option<Self> {
        at(At::Reference);
        (reference as usize).lt(&VARIABLES.len()).then_some(Self(reference))
    }

    fn spec(self) -> &'static VariableSpec {
        &VARIABLES[self.0 as usize]
    }
}

impl CoSimulationUnit for Panicking {
    type Variable = Variable;
    const TABLE: &'static Table = &TABLE;
    const CAPABILITIES: Capabilities = Capabilities::ALL;

    fn open(_: &Resources) -> Result<Self, String> {
        at(At::Open);
        Ok(Self::new())
    }

    fn get(&mut self, variable: Variable) -> Value {
        at(At::Get);
        match variable.0 {
            2 => Value::Integer(0),
            3 => Value::Boolean(false),
            4 => Value::String("text".into()),
            _ => Value::Real(0.0),
        }
    }

    fn set(&mut self, _: Variable, _: &Value) {
        at(At::Set);
    }

    fn exit_initialization(&mut self, _: f64, _: &mut Log) -> Result<(), String> {
        at(At::Exit);
        Ok(())
    }

    fn step(&mut self, _: f64, _: f64, _: &mut Log) -> Result<(), String> {
        at(At::Step);
        Ok(())
    }

    fn states(&self) -> Vec<StateSpec> {
        at(At::States);
        let (unit, derivative_unit, settable) = (None, None, true);
        vec![StateSpec { description: String::new(), unit, derivative_unit, settable }]
    }

    fn state(&mut self, _: usize) -> f64 {
        at(At::State);
        0.0
    }

    fn state_derivative(&mut self, _: usize) -> f64 {
        at(At::StateDerivative);
        0.0
    }

    fn set_state(&mut self, _: usize, _: f64) {
        at(At::SetState);
    }

    fn set_input_derivative(&mut self, _: Variable, _: f64) {
        at(At::SetInputDerivative);
    }

    fn output_derivative(&mut self, _: Variable) -> f64 {
        at(At::OutputDerivative);
        0.0
    }

    fn dependency(&self, _: Unknown<Variable>, _: Known<Variable>) -> Option<DependencyKind> {
        at(At::Dependency);
        Some(DependencyKind::Dependent)
    }

    fn partial_derivative(&mut self, _: Unknown<Variable>, _: Known<Variable>) -> Option<f64> {
        at(At::PartialDerivative);
        None
    }

    fn save(&self) -> Vec<u8> {
        at(At::Save);
        Vec::new()
    }

    fn load(&mut self, _: &[u8]) -> Result<(), String> {
        at(At::Load);
        Ok(())
    }
}
