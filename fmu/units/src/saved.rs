//! States as bytes, for [`fmi2_export::CoSimulationUnit::save`] and `load`, and checks of values.
//!
//! The bytes are the layout version and those of postcard, in the order of the fields. A blob may be crafted, so all
//! that was read is checked: numbers of the models by the models, values of variables against the table.

use fmi2_export::{CoSimulationUnit, VariableId};
use model_description::{Causality, Value};
use serde::Serialize;
use serde::de::DeserializeOwned;

/// Rises with every change of a struct that is in a state: bytes of the same length would be read into other fields.
const LAYOUT: u8 = first_number(include_str!("saved_layouts.txt"));

/// The number on the first line of a text; it does not compile without one, or above 255.
const fn first_number(text: &str) -> u8 {
    let bytes = text.as_bytes();
    let (mut number, mut i) = (0, 0);
    while bytes[i].is_ascii_digit() {
        number = 10 * number + (bytes[i] - b'0');
        i += 1;
    }
    assert!(i > 0, "saved_layouts.txt begins with the version of the layouts");
    number
}

/// The bytes of a state.
pub(crate) fn encode<T: Serialize>(state: &T) -> Vec<u8> {
    // Into a growing vector nothing can fail; no bytes at all would be refused when loaded.
    postcard::to_allocvec(&(LAYOUT, state)).unwrap_or_default()
}

/// The state whose bytes these are, all of them.
pub(crate) fn decode<T: DeserializeOwned>(bytes: &[u8]) -> Result<T, String> {
    let Some((layout, bytes)) = bytes.split_first() else {
        return Err("the saved state cannot be read: it is empty".into());
    };
    if *layout != LAYOUT {
        return Err(format!(
            "the saved state has the layout {layout}; this library reads the layout {LAYOUT}"
        ));
    }
    match postcard::take_from_bytes(bytes) {
        Ok((state, [])) => Ok(state),
        Ok((_, rest)) => Err(format!("the saved state has {} bytes too many", rest.len())),
        Err(error) => Err(format!("the saved state cannot be read: {error}")),
    }
}

/// Refuses a state of a model, with the model's hint.
pub(crate) fn refuse(error: &steerwright_models::Error) -> String {
    format!("{error}; hint: {}", error.hint())
}

/// Refuses inputs and parameters that no importer could have set.
pub(crate) fn check_settable<S: CoSimulationUnit>(unit: &mut S) -> Result<(), String> {
    for row in S::TABLE.variables {
        let settable = matches!(row.causality, Causality::Input | Causality::Parameter);
        let Some(variable) = S::Variable::from_reference(row.reference).filter(|_| settable) else {
            continue;
        };
        let Value::Real(value) = unit.get(variable) else { continue };
        let (min, max) = (row.min.unwrap_or(f64::MIN), row.max.unwrap_or(f64::MAX));
        // Written so that NaN fails.
        if !(value >= min && value <= max) {
            return Err(format!("{} of the saved state is {value}, which cannot be", row.name));
        }
    }
    Ok(())
}

/// Refuses a start from which an output is beyond all numbers.
pub(crate) fn outputs_are_finite<S: CoSimulationUnit>(unit: &mut S) -> Result<(), String> {
    for row in S::TABLE.variables.iter().filter(|row| row.causality == Causality::Output) {
        let Some(variable) = S::Variable::from_reference(row.reference) else { continue };
        if let Value::Real(value) = unit.get(variable)
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
