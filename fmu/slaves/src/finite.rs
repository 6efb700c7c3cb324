//! Outputs that are numbers.

use fmi2_export::{Slave, VariableId};
use model_description::{Causality, Value};

/// Refuses a start from which an output is beyond all numbers.
pub(crate) fn outputs_are_finite<S: Slave>(slave: &mut S) -> Result<(), String> {
    for row in S::TABLE.variables.iter().filter(|row| row.causality == Causality::Output) {
        let Some(variable) = S::Variable::from_reference(row.reference) else { continue };
        if let Value::Real(value) = slave.get(variable)
            && !value.is_finite()
        {
            return Err(format!(
                "{} is {value} at the start; hint: check the parameters and the initial states",
                row.name
            ));
        }
    }
    Ok(())
}
