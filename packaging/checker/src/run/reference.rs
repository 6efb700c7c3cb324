//! Replays the reference results of an archive with its binary.
//!
//! `extra/io.github.steerwright/reference/reference.json` names two tables with a column `time` and one for
//! each variable: the inputs, each constant until the next row, and the results at communication points.

use super::journal::{Journal, REFERENCE};
use super::trajectory::Plan;
use model_description::{Causality, Kind, Value};
use serde::Deserialize;
use std::path::Path;
use steerwright_host::{Archive, Instance};

const SCHEMA: &str = "steerwright/reference/1";

#[derive(Deserialize)]
struct Reference {
    schema: String,
    input: Option<String>,
    result: String,
    start_time: f64,
    stop_time: f64,
    step_size: f64,
    absolute_tolerance: f64,
}

/// A table: the names of its columns without the time, and its rows with it.
struct Table {
    names: Vec<String>,
    rows: Vec<Vec<f64>>,
}

impl Table {
    fn read(path: &Path) -> Result<Self, String> {
        let shown = path.file_name().unwrap_or_default().to_string_lossy();
        let problem = |error: csv::Error| format!("{shown}: {error}");
        let mut reader = csv::Reader::from_path(path).map_err(problem)?;
        let header = reader.headers().map_err(problem)?;
        let names: Vec<String> = header.iter().skip(1).map(|name| name.trim().into()).collect();
        if header.get(0).map(str::trim) != Some("time") {
            return Err(format!("{shown}: the first column is not `time`"));
        }
        let mut rows: Vec<Vec<f64>> = Vec::new();
        for record in reader.records() {
            let record = record.map_err(problem)?;
            let cells = record.iter().map(|cell| number(cell.trim()));
            let row = cells.collect::<Option<Vec<f64>>>().filter(|row| !row.is_empty());
            let line = rows.len() + 2;
            let row =
                row.ok_or_else(|| format!("{shown}:{line}: a cell is not a finite number"))?;
            if rows.last().is_some_and(|last| last[0] >= row[0]) {
                return Err(format!("{shown}:{line}: the time does not increase"));
            }
            rows.push(row);
        }
        Ok(Self { names, rows })
    }

    /// The row that is valid at a time: the last one that is not later.
    fn row_at(&self, time: f64, slack: f64) -> Option<&[f64]> {
        let after = self.rows.partition_point(|row| row[0] <= time + slack);
        Some(&self.rows.get(after.checked_sub(1)?)?[1..])
    }

    /// The row at exactly a time.
    fn exactly(&self, time: f64, slack: f64) -> Option<&[f64]> {
        let first = self.rows.partition_point(|row| row[0] < time - slack);
        self.rows.get(first).filter(|row| row[0] <= time + slack).map(|row| &row[1..])
    }
}

fn number(cell: &str) -> Option<f64> {
    match cell {
        "true" => Some(1.0),
        "false" => Some(0.0),
        cell => cell.parse().ok().filter(|value: &f64| value.is_finite()),
    }
}

pub(super) fn replay(archive: &Archive, journal: &mut Journal) {
    let file = archive.folder().join(REFERENCE);
    if !file.is_file() {
        return;
    }
    journal.start("the replay of the archive's reference");
    let tables = match read(&file) {
        Ok(tables) => tables,
        Err(problem) => return journal.found("run-reference-form", problem),
    };
    match compare(archive, &tables) {
        Err(problem) => journal.found("run-reference", problem),
        Ok(largest) => {
            let message = format!("largest difference from the reference: {largest}");
            journal.found("run-reference-difference", message);
            if largest.value > tables.reference.absolute_tolerance {
                let limit = tables.reference.absolute_tolerance;
                let message = format!("{largest}, more than {limit:e}");
                journal.found("run-reference", message);
            }
        }
    }
}

struct Tables {
    reference: Reference,
    input: Option<Table>,
    result: Table,
}

fn read(file: &Path) -> Result<Tables, String> {
    let text = std::fs::read_to_string(file).map_err(|error| error.to_string())?;
    let reference: Reference =
        serde_json::from_str(&text).map_err(|error| format!("reference.json: {error}"))?;
    if reference.schema != SCHEMA {
        let found = reference.schema;
        return Err(format!("reference.json: the schema is \"{found}\", not \"{SCHEMA}\""));
    }
    let span = reference.stop_time - reference.start_time;
    let steps = span / reference.step_size;
    if !(reference.step_size > 0.0 && (1.0..=1e6).contains(&steps) && span.is_finite()) {
        return Err("reference.json: start, stop and step do not result in 1 to 10⁶ steps".into());
    }
    // The names come from the archive, so they must not point outside its folder.
    let table = |name: &str| {
        let is_plain = !name.contains(['/', '\\', ':']) && !matches!(name, "" | "." | "..");
        if !is_plain {
            return Err(format!("reference.json: \"{name}\" is not a plain file name"));
        }
        Table::read(&file.with_file_name(name))
    };
    let input = reference.input.as_deref().map(table).transpose()?;
    let result = table(&reference.result)?;
    Ok(Tables { reference, input, result })
}

struct Largest {
    value: f64,
    variable: String,
    time: f64,
}

impl std::fmt::Display for Largest {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{:e} in `{}` at {} s", self.value, self.variable, self.time)
    }
}

fn compare(archive: &Archive, tables: &Tables) -> Result<Largest, String> {
    let Tables { reference, input, result } = tables;
    let text = |error: steerwright_host::Error| error.to_string();
    let steps = ((reference.stop_time - reference.start_time) / reference.step_size).round();
    // At most 10⁶, checked in `read`.
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
    let count = steps as u32;
    let plan = Plan { start: reference.start_time, step: reference.step_size, count };
    let slack = reference.step_size * 1e-6;
    let mut instance = Instance::new(archive, "reference").map_err(text)?;
    let mut largest = Largest { value: 0.0, variable: String::new(), time: plan.start };
    let mut met = 0;

    let apply = |instance: &mut Instance, time: f64, parameters: bool| {
        let Some((table, row)) =
            input.as_ref().and_then(|table| Some((table, table.row_at(time, slack)?)))
        else {
            return Ok(());
        };
        for (name, value) in table.names.iter().zip(row) {
            let variable = instance.variable(name).map_err(text)?;
            if (variable.causality == Causality::Parameter) == parameters {
                let value = typed(variable.kind, *value);
                instance.set(name, value).map_err(text)?;
            }
        }
        Ok::<(), String>(())
    };
    apply(&mut instance, plan.start, true)?;
    instance
        .setup_experiment(plan.start, Some(reference.stop_time), None)
        .and_then(|()| instance.enter_initialization_mode())
        .map_err(text)?;
    apply(&mut instance, plan.start, false)?;
    instance.exit_initialization_mode().map_err(text)?;
    for point in 0..=count {
        let time = plan.time(point);
        if let Some(row) = result.exactly(time, slack) {
            met += 1;
            for (name, expected) in result.names.iter().zip(row) {
                let value = instance.value(name).map_err(text)?;
                let value = match value {
                    Value::Boolean(value) => f64::from(u8::from(value)),
                    value => value.as_number().unwrap_or(f64::NAN),
                };
                let difference = (value - expected).abs();
                if difference.is_nan() || difference > largest.value {
                    let value = if difference.is_nan() { f64::INFINITY } else { difference };
                    largest = Largest { value, variable: name.clone(), time };
                }
            }
        }
        if point < count {
            apply(&mut instance, time, false)?;
            instance.do_step(time, plan.step).map_err(text)?;
        }
    }
    if met < result.rows.len() {
        let missed = result.rows.len() - met;
        return Err(format!("{missed} rows of the results are not at a communication point"));
    }
    Ok(largest)
}

fn typed(kind: Kind, value: f64) -> Value {
    match kind {
        Kind::Boolean => Value::Boolean(value != 0.0),
        // Fractions are truncated; the table belongs to the archive.
        #[allow(clippy::cast_possible_truncation)]
        Kind::Integer => Value::Integer(value as i32),
        Kind::Real | Kind::String => Value::Real(value),
    }
}
