//! The files in an archive's `resources/`: those that models are made from, and the start values.

use fmi2_export::{CoSimulationUnit, Resources, VariableId};
use model_description::{Causality, Kind, Value, VariableSpec};
use steerwright_formats::{Document, Start};

/// The document of that name, where the archive has it.
pub(crate) fn optional<D: Document>(
    resources: &Resources,
    name: &str,
) -> Result<Option<D>, String> {
    let Some(bytes) = resources.get(name) else { return Ok(None) };
    let text = std::str::from_utf8(bytes).map_err(|e| format!("{name}: not UTF-8 text: {e}"))?;
    D::from_json(text, name).map(Some).map_err(|e| format!("{e}; hint: {}", e.hint()))
}

/// The document of that name.
pub(crate) fn required<D: Document>(resources: &Resources, name: &str) -> Result<D, String> {
    optional(resources, name)?.ok_or_else(|| format!("resources/{name} is missing; {HINT}"))
}

/// The unit with the start values of its archive, if it has any.
pub(crate) fn with_start_values<S: CoSimulationUnit>(
    mut unit: S,
    resources: &Resources,
) -> Result<S, String> {
    let file = Start::FILE;
    let Some(start) = optional::<Start>(resources, file)? else { return Ok(unit) };
    for (name, value) in &start.values {
        let row = named(&unit, name).ok_or_else(|| {
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
            unit.set(variable, &Value::Real(*value));
        }
    }
    Ok(unit)
}

/// The row of the variable that has this name in the description.
fn named<S: CoSimulationUnit>(unit: &S, name: &str) -> Option<&'static VariableSpec> {
    let has_name = |row: &&VariableSpec| match S::Variable::from_reference(row.reference) {
        Some(variable) if unit.has(variable) => match unit.stated(variable) {
            Some(stated) => stated.name == name,
            None => row.name == name,
        },
        _ => false,
    };
    S::TABLE.variables.iter().find(has_name)
}

const HINT: &str = "pack the archive again with `steerwright package`";

#[cfg(test)]
mod tests {
    use crate::lateral_pid::{LateralPid, Variable};
    use fmi2_export::{CoSimulationUnit, Resources};
    use model_description::Value;

    fn opened(values: &str) -> Result<LateralPid, String> {
        let text = format!("{{\"schema\": \"steerwright/start/1\", \"values\": {{{values}}}}}");
        let files = vec![("start.json".to_owned(), text.into_bytes())];
        LateralPid::open(&Resources::from(files))
    }

    #[test]
    fn an_archive_starts_with_its_own_values() {
        let mut pid = opened("\"kp\": 0.75, \"steering_feedforward\": 0.125").unwrap();
        assert_eq!(pid.get(Variable::Kp), Value::Real(0.75));
        assert_eq!(pid.get(Variable::SteeringFeedforward), Value::Real(0.125));
    }

    #[test]
    fn what_cannot_start_so_is_refused() {
        for (values, what) in [
            ("\"kq\": 1", "LateralPid has no variable kq"),
            ("\"steering_angle\": 1", "steering_angle is no Real parameter or input"),
            ("\"enabled\": 1", "enabled is no Real parameter or input"),
            ("\"sample_time\": -1", "sample_time is -1, not in"),
            ("\"kp\": 1e999", "start.json"),
            ("\"kp\": \"1\"", "start.json"),
        ] {
            let error = opened(values).err().unwrap();
            assert!(error.contains(what) && error.contains("hint: "), "{error}");
        }
    }
}
