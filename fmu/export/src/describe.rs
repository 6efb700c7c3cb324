//! The model description of a unit.

use crate::exposed;
use crate::log::Log;
use crate::logger::LOG_CATEGORIES;
use crate::resources::Resources;
use crate::structure::structure;
use crate::unit::{CoSimulationUnit, VariableId};
use model_description::{
    CoSimulation, DefaultExperiment, ExposedState, LogCategory, ModelDescription, UnitSpec, Value,
    VariableSpec,
};

/// Why a unit cannot be described.
#[derive(Debug, thiserror::Error)]
#[allow(missing_docs)] // the fields are named in the messages
pub enum DescribeError {
    #[error("{model} cannot be instantiated with these resources: {problem}")]
    Open { model: &'static str, problem: String },
    #[error("{model} cannot be initialized with its start values: {problem}")]
    Initialize { model: &'static str, problem: String },
    #[error(
        "{model}: `from_reference` returns no variable for `{variable}`, value reference {reference}"
    )]
    Unmapped { model: &'static str, variable: &'static str, reference: u32 },
    #[error(
        "{model}: `{variable}` has the value reference {reference}; value references from {first} on \
         are reserved for states",
        first = exposed::FIRST
    )]
    Reserved { model: &'static str, variable: &'static str, reference: u32 },
    #[error("{model}: the initial value of `state[{number}]` is {value}")]
    State { model: &'static str, number: usize, value: f64 },
    #[error(
        "{model}: `state[{number}]` or its derivative has the unit \"{unit}\", which is not in `UNITS`"
    )]
    Unit { model: &'static str, number: usize, unit: &'static str },
    #[error(transparent)]
    Start(#[from] model_description::Error),
}

impl DescribeError {
    /// The suggested fix.
    #[must_use]
    pub fn hint(&self) -> String {
        match self {
            Self::Open { .. } | Self::Initialize { .. } => {
                "correct the resource file, or write it again with the command that creates it"
                    .into()
            }
            Self::Reserved { .. } => "use a smaller value reference".into(),
            Self::Unit { .. } => "use a unit of `UNITS`, or none".into(),
            Self::State { .. } => "return a finite initial value from `state`".into(),
            Self::Unmapped { .. } => "add a variant for every row to the enum of variables".into(),
            Self::Start(error) => error.hint(),
        }
    }
}

/// The capabilities of a unit: those of this layer with [`CoSimulationUnit::CAPABILITIES`].
#[must_use]
pub fn capabilities<S: CoSimulationUnit>() -> CoSimulation {
    CoSimulation {
        model_identifier: S::TABLE.model_name.into(),
        can_handle_variable_communication_step_size: true,
        can_interpolate_inputs: S::CAPABILITIES.interpolates_inputs,
        max_output_derivative_order: u32::from(S::CAPABILITIES.output_derivatives),
        // Rust has an allocator of its own.
        can_not_use_memory_management_functions: true,
        can_get_and_set_fmu_state: true,
        can_serialize_fmu_state: S::CAPABILITIES.serializes,
        provides_directional_derivative: S::CAPABILITIES.directional_derivatives,
        ..CoSimulation::default()
    }
}

/// The GUID of a unit with resources, which `fmi2Instantiate` expects.
#[must_use]
pub fn guid<S: CoSimulationUnit>(resources: &Resources) -> String {
    model_description::guid(S::TABLE, resources.entries())
}

/// The description of a unit with resources.
///
/// The start values are the values at the first communication point if no variable is set before or
/// during initialization; the time is the experiment's start time.
///
/// # Errors
/// [`DescribeError`] if the unit rejects the resources or contradicts its table.
pub fn describe<S: CoSimulationUnit>(
    resources: &Resources,
    default_experiment: Option<DefaultExperiment>,
) -> Result<ModelDescription, DescribeError> {
    let table = S::TABLE;
    let model = table.model_name;
    let mut unit = S::open(resources).map_err(|problem| DescribeError::Open { model, problem })?;
    let start_time = default_experiment.and_then(|e| e.start_time).unwrap_or(0.0);
    unit.exit_initialization(start_time, &mut Log::default())
        .map_err(|problem| DescribeError::Initialize { model, problem })?;
    if let Some(row) = table.variables.iter().find(|row| row.reference >= exposed::FIRST) {
        let (variable, reference) = (row.name, row.reference);
        return Err(DescribeError::Reserved { model, variable, reference });
    }
    let mut rows = Vec::new();
    for row in table.variables {
        match S::Variable::from_reference(row.reference) {
            Some(variable) if !unit.has(variable) => {}
            _ => rows.push(row),
        }
    }
    let start = rows
        .iter()
        .map(|row| match S::Variable::from_reference(row.reference) {
            Some(variable) if variable.spec().name == row.name => Ok(unit.get(variable)),
            _ => {
                Err(DescribeError::Unmapped { model, variable: row.name, reference: row.reference })
            }
        })
        .collect::<Result<Vec<Value>, _>>()?;
    let guid = guid::<S>(resources);
    let mut description =
        ModelDescription::from_rows(table, &rows, &start, &guid, default_experiment)?;
    rename(&unit, &rows, &mut description);
    description.expose_states(&states(&mut unit)?, exposed::FIRST);
    let settable: Vec<bool> = unit.states().iter().map(|state| state.settable).collect();
    structure(&unit, &rows, &settable, &mut description);
    description.co_simulation = Some(capabilities::<S>());
    description.log_categories = LOG_CATEGORIES
        .iter()
        .map(|&(name, text)| LogCategory { name: name.into(), description: Some(text.into()) })
        .collect();
    Ok(description)
}

/// Names, units and descriptions of variables as the resources state them.
fn rename<S: CoSimulationUnit>(
    unit: &S,
    rows: &[&VariableSpec],
    description: &mut ModelDescription,
) {
    for (index, row) in rows.iter().enumerate() {
        let Some(stated) = S::Variable::from_reference(row.reference).and_then(|v| unit.stated(v))
        else {
            continue;
        };
        let variable = &mut description.variables[index];
        variable.name = stated.name;
        variable.description = Some(stated.description);
        variable.nominal = stated.nominal;
        variable.unit = stated.unit.as_ref().map(|unit| unit.name.clone());
        if let Some(unit) = stated.unit {
            description.cite(unit);
        }
    }
}

/// The states for the description.
fn states<S: CoSimulationUnit>(unit: &mut S) -> Result<Vec<ExposedState>, DescribeError> {
    let specs = unit.states().into_iter().enumerate();
    specs
        .map(|(index, spec)| {
            let model = S::TABLE.model_name;
            let number = index + 1;
            let mut units = [spec.unit, spec.derivative_unit].into_iter().flatten();
            if let Some(unit) = units.find(|unit| UnitSpec::named(unit).is_none()) {
                return Err(DescribeError::Unit { model, number, unit });
            }
            let value = unit.state(index);
            if spec.settable && !value.is_finite() {
                return Err(DescribeError::State { model, number, value });
            }
            Ok(ExposedState {
                description: spec.description,
                unit: spec.unit,
                derivative_unit: spec.derivative_unit,
                start: if spec.settable { Some(value) } else { None },
            })
        })
        .collect()
}
