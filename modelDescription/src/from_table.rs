//! From the static table, the start values and the states of an FMU to its description.

use crate::Error;
use crate::description::{CoSimulation, DefaultExperiment, ModelDescription, Unknown, Variable};
use crate::legality::needs_start;
use crate::table::{DependsOn, Table, VariableSpec};
use crate::units::{Unit, UnitSpec};
use crate::vocabulary::{Causality, DependencyKind, Initial, Value};

impl ModelDescription {
    /// The description of the FMU that `table` defines.
    ///
    /// `start` has one value for each row, in the table's order; those of rows that have no start
    /// attribute (calculated ones) are ignored. The model structure follows section 2.2.8: every
    /// output under Outputs, and under InitialUnknowns the outputs with initial approx or
    /// calculated and the calculated parameters, both ascending. The units are those that the
    /// table cites. The capability flags are all false and there are no log categories; the caller
    /// sets them.
    ///
    /// # Errors
    /// [`Error::StartCount`], [`Error::StartKind`] or [`Error::StartRange`].
    pub fn from_table(
        table: &Table,
        start: &[Value],
        guid: &str,
        default_experiment: Option<DefaultExperiment>,
    ) -> Result<Self, Error> {
        let rows: Vec<&VariableSpec> = table.variables.iter().collect();
        Self::from_rows(table, &rows, start, guid, default_experiment)
    }

    /// The description of an FMU that has these rows of `table` only, in the table's order; `start` has one value for
    /// each of them. Otherwise as [`Self::from_table`].
    ///
    /// # Errors
    /// As [`Self::from_table`].
    pub fn from_rows(
        table: &Table,
        rows: &[&VariableSpec],
        start: &[Value],
        guid: &str,
        default_experiment: Option<DefaultExperiment>,
    ) -> Result<Self, Error> {
        let (got, need) = (start.len(), rows.len());
        if got != need {
            return Err(Error::StartCount { model: table.model_name, got, need });
        }
        let mut description = Self::new(table.model_name, guid);
        description.description = text(table.description);
        description.version = text(table.version);
        description.default_experiment = default_experiment;
        description.co_simulation =
            Some(CoSimulation { model_identifier: table.model_name.into(), ..Default::default() });
        description.units = units(rows);
        for (row, value) in rows.iter().zip(start) {
            check_start(table, row, value)?;
            description.variables.push(variable(row, value));
        }
        for (row, index) in rows.iter().zip(1..) {
            if row.causality == Causality::Output {
                description.outputs.push(unknown(rows, index, row.depends_on));
            }
            if is_initial_unknown(row) {
                description.initial_unknowns.push(unknown(rows, index, row.initial_depends_on));
            }
        }
        Ok(description)
    }
}

fn text(text: &str) -> Option<String> {
    if text.is_empty() { None } else { Some(text.into()) }
}

/// Whether the row belongs under InitialUnknowns.
fn is_initial_unknown(row: &VariableSpec) -> bool {
    match row.causality {
        Causality::CalculatedParameter => true,
        Causality::Output => {
            matches!(row.effective_initial(), Some(Initial::Approx | Initial::Calculated))
        }
        _ => false,
    }
}

fn check_start(table: &Table, row: &VariableSpec, value: &Value) -> Result<(), Error> {
    let (model, variable) = (table.model_name, row.name);
    if value.kind() != row.kind {
        let (got, need) = (value.kind(), row.kind);
        return Err(Error::StartKind { model, variable, got, need });
    }
    let (Some(number), true) =
        (value.as_number(), needs_start(row.causality, row.effective_initial()))
    else {
        return Ok(());
    };
    let (min, max) = (row.min.unwrap_or(f64::MIN), row.max.unwrap_or(f64::MAX));
    // Written so that NaN fails.
    if number >= min && number <= max {
        Ok(())
    } else {
        Err(Error::StartRange { model, variable, value: number, min, max })
    }
}

fn variable(row: &VariableSpec, value: &Value) -> Variable {
    Variable {
        name: row.name.into(),
        reference: row.reference,
        kind: row.kind,
        description: text(row.description),
        causality: row.causality,
        variability: row.variability,
        // Written even where it is the default: not every importer has the table of defaults.
        initial: row.effective_initial(),
        unit: row.unit.map(Into::into),
        display_unit: row.display_unit.map(Into::into),
        min: row.min,
        max: row.max,
        nominal: row.nominal,
        start: if needs_start(row.causality, row.effective_initial()) {
            Some(value.clone())
        } else {
            None
        },
        ..Variable::default()
    }
}

fn unknown(rows: &[&VariableSpec], index: u32, depends_on: DependsOn) -> Unknown {
    let dependencies = match depends_on {
        DependsOn::All => None,
        DependsOn::Nothing => Some(Vec::new()),
        // Going through the table, not through the names, makes the list ascend without twins.
        DependsOn::On(names) => Some(
            rows.iter()
                .zip(1..)
                .filter(|(row, _)| names.contains(&row.name))
                .map(|(_, index)| index)
                .collect::<Vec<u32>>(),
        ),
    };
    // No kinds where there is nothing to have a kind: not every importer takes an empty list.
    let kinds = dependencies
        .as_ref()
        .filter(|list| !list.is_empty())
        .map(|list| vec![DependencyKind::Dependent; list.len()]);
    Unknown { index, dependencies, kinds }
}

fn units(rows: &[&VariableSpec]) -> Vec<Unit> {
    let mut units = Vec::new();
    rows.iter().for_each(|row| cite(&mut units, row.unit));
    units
}

/// Adds a unit that is cited to the sorted list of those that are.
fn cite(units: &mut Vec<Unit>, unit: Option<&str>) {
    let Some(spec) = unit.and_then(UnitSpec::named) else { return };
    if let Err(place) = units.binary_search_by(|unit| unit.name.as_str().cmp(spec.name)) {
        units.insert(place, spec.into());
    }
}

/// A continuous state to be shown with its derivative.
#[derive(Debug, Clone, PartialEq)]
pub struct ExposedState {
    /// A description of one line.
    pub description: String,
    /// Its unit, one of [`crate::UNITS`].
    pub unit: Option<&'static str>,
    /// The unit of its derivative.
    pub derivative_unit: Option<&'static str>,
    /// Its start value where it can be set (`exact`); without one it follows from others (`calculated`).
    pub start: Option<f64>,
}

impl ModelDescription {
    /// Adds a unit to the sorted list of units, unless one of its name is there.
    pub fn cite(&mut self, unit: Unit) {
        if let Err(place) = self.units.binary_search_by(|known| known.name.cmp(&unit.name)) {
            self.units.insert(place, unit);
        }
    }

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

/// A local, continuous, calculated Real variable; a unit that [`crate::UNITS`] lacks is left out.
fn local(name: &str, reference: u32, unit: Option<&str>) -> Variable {
    Variable {
        name: name.into(),
        reference,
        initial: Some(Initial::Calculated),
        unit: unit.and_then(UnitSpec::named).map(|unit| unit.name.into()),
        ..Variable::default()
    }
}
