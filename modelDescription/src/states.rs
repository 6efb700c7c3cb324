//! Continuous states shown as variables: `state[i]` and `der(state[i])`.

use crate::description::{ModelDescription, Variable};
use crate::from_table::cite;
use crate::units::UnitSpec;
use crate::{Initial, Value};

/// A continuous state to be shown with its derivative.
#[derive(Debug, Clone, PartialEq)]
pub struct ExposedState {
    /// A description of one line.
    pub description: String,
    /// Its unit, one of [`crate::UNITS`].
    pub unit: Option<&'static str>,
    /// The unit of its derivative.
    pub derivative_unit: Option<&'static str>,
    /// Its start value where it can be set (`initial="exact"`); without one it follows from others
    /// (`initial="calculated"`).
    pub start: Option<f64>,
}

impl ModelDescription {
    /// Appends for each state its variable and that of its derivative, both local and continuous,
    /// with value references from `first` on, and the units that they cite. The model structure
    /// is unchanged: the caller sets the dependencies.
    pub fn expose_states(&mut self, states: &[ExposedState], first: u32) {
        let mut reference = first;
        for (state, number) in states.iter().zip(1_u32..) {
            cite(&mut self.units, state.unit);
            cite(&mut self.units, state.derivative_unit);
            let name = format!("state[{number}]");
            let index = u32::try_from(self.variables.len() + 1).ok();
            self.variables.push(Variable {
                description: Some(state.description.clone()).filter(|text| !text.is_empty()),
                initial: Some(state.start.map_or(Initial::Calculated, |_| Initial::Exact)),
                start: state.start.map(Value::Real),
                ..local(&name, reference, state.unit)
            });
            self.variables.push(Variable {
                description: Some(format!("Derivative of {name} by time")),
                derivative: index,
                ..local(&format!("der({name})"), reference + 1, state.derivative_unit)
            });
            reference += 2;
        }
    }
}

/// A local, continuous, calculated Real variable. A unit that [`crate::UNITS`] lacks is left out: there is
/// no definition for it.
fn local(name: &str, reference: u32, unit: Option<&str>) -> Variable {
    Variable {
        name: name.into(),
        reference,
        initial: Some(Initial::Calculated),
        unit: unit.and_then(UnitSpec::named).map(|unit| unit.name.into()),
        ..Variable::default()
    }
}
