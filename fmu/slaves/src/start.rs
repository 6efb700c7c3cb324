//! Start values of an archive's own, from `resources/start.json`.

use crate::resources::optional;
use fmi2_export::{Resources, Slave, VariableId};
use formats::Start;
use model_description::{Causality, Kind, Value};

/// The slave with the start values that its archive brings, where it brings any.
pub(crate) fn with_start_values<S: Slave>(
    mut slave: S,
    resources: &Resources,
) -> Result<S, String> {
    let file = Start::FILE;
    let Some(start) = optional::<Start>(resources, file)? else { return Ok(slave) };
    for (name, value) in &start.values {
        let row = S::TABLE.variables.iter().find(|row| row.name == name.as_str());
        let row = row.ok_or_else(|| {
            format!("{file}: {} has no variable {name}; hint: {HINT}", S::TABLE.model_name)
        })?;
        let settable = matches!(row.causality, Causality::Parameter | Causality::Input);
        if !settable || row.kind != Kind::Real {
            return Err(format!("{file}: {name} is no Real parameter or input; hint: {HINT}"));
        }
        let (min, max) = (row.min.unwrap_or(f64::NEG_INFINITY), row.max.unwrap_or(f64::INFINITY));
        if !(min..=max).contains(value) {
            return Err(format!("{file}: {name} is {value}, not in {min} to {max}; hint: {HINT}"));
        }
        if let Some(variable) = S::Variable::from_reference(row.reference) {
            slave.set(variable, &Value::Real(*value));
        }
    }
    Ok(slave)
}

const HINT: &str = "pack the archive again with `steerwright package`";
