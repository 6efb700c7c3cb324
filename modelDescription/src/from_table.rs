//! From the static table and the start values of an FMU to its description.

use crate::description::{CoSimulation, DefaultExperiment, ModelDescription, Unknown, Variable};
use crate::table::{DependsOn, Table, VariableSpec};
use crate::units::{Unit, UnitSpec};
use crate::{Causality, DependencyKind, Error, Initial, Value, needs_start};

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
        if start.len() != table.variables.len() {
            return Err(Error::StartCount {
                model: table.model_name,
                got: start.len(),
                need: table.variables.len(),
            });
        }
        let mut description = Self::new(table.model_name, guid);
        description.description = text(table.description);
        description.version = text(table.version);
        description.default_experiment = default_experiment;
        description.co_simulation =
            Some(CoSimulation { model_identifier: table.model_name.into(), ..Default::default() });
        description.units = units(table);
        for (row, value) in table.variables.iter().zip(start) {
            check_start(table, row, value)?;
            description.variables.push(variable(row, value));
        }
        for (row, index) in table.variables.iter().zip(1..) {
            if row.causality == Causality::Output {
                description.outputs.push(unknown(table, index, row.depends_on));
            }
            if is_initial_unknown(row) {
                description.initial_unknowns.push(unknown(table, index, row.initial_depends_on));
            }
        }
        Ok(description)
    }
}

fn text(text: &str) -> Option<String> {
    (!text.is_empty()).then(|| text.into())
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
    if value.kind() != row.kind {
        return Err(Error::StartKind {
            model: table.model_name,
            variable: row.name,
            got: value.kind(),
            need: row.kind,
        });
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
        Err(Error::StartRange {
            model: table.model_name,
            variable: row.name,
            value: number,
            min,
            max,
        })
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
        start: needs_start(row.causality, row.effective_initial()).then(|| value.clone()),
        ..Variable::default()
    }
}

fn unknown(table: &Table, index: u32, depends_on: DependsOn) -> Unknown {
    let dependencies = match depends_on {
        DependsOn::All => None,
        DependsOn::Nothing => Some(Vec::new()),
        // Going through the table, not through the names, makes the list ascend without twins.
        DependsOn::On(names) => Some(
            table
                .variables
                .iter()
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

fn units(table: &Table) -> Vec<Unit> {
    let mut units = Vec::new();
    table.variables.iter().for_each(|row| cite(&mut units, row.unit));
    units
}

/// Adds a unit that is cited to the sorted list of those that are.
pub(crate) fn cite(units: &mut Vec<Unit>, unit: Option<&str>) {
    let Some(spec) = unit.and_then(UnitSpec::named) else { return };
    if let Err(place) = units.binary_search_by(|unit| unit.name.as_str().cmp(spec.name)) {
        units.insert(place, spec.into());
    }
}
