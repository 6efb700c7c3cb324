//! Inputs from a table: CSV with a header, the time in s in the first column, `time`, and a column
//! for each input, named `instance.input`, as a connector of the system for the inputs that this feeds, or
//! `input` for every unconnected input of that name.
//!
//! Values are held from their time until the next row's (zero-order hold), the last row's for ever.
//! Booleans are `true`/`false` or 1/0. Times must rise; the first must not be after the run's start.

use std::fs::File;
use std::io::Read;
use std::path::Path;

use model_description::Kind;

use crate::Error;

/// A read table; that its columns fit a system is seen when the system is run.
#[derive(Debug, Clone, PartialEq)]
pub struct InputTable {
    name: String,
    columns: Vec<String>,
    times: Vec<f64>,
    /// The line of each row in the file.
    lines: Vec<u64>,
    /// Row after row, without the time.
    values: Vec<f64>,
}

impl InputTable {
    /// Reads a CSV file.
    pub fn open(path: impl AsRef<Path>) -> Result<Self, Error> {
        let path = path.as_ref();
        let io = |source: std::io::Error| Error::Io { path: path.to_path_buf(), source };
        Self::read(File::open(path).map_err(io)?, &path.display().to_string())
    }

    /// Reads CSV; `name` is its name in errors.
    pub fn read(reader: impl Read, name: &str) -> Result<Self, Error> {
        let bad = |reason: String| Error::Table { table: name.to_owned(), reason };
        let mut csv = csv::ReaderBuilder::new().trim(csv::Trim::All).from_reader(reader);
        let header = csv.headers().map_err(|e| bad(row_fault(&e)))?.clone();
        let columns: Vec<String> =
            header.iter().map(|c| c.trim_start_matches('\u{feff}').to_owned()).collect();
        if columns.first().map(String::as_str) != Some("time") {
            let first = columns.first().cloned().unwrap_or_default();
            return Err(bad(format!("the first column is {first:?}, not \"time\"")));
        }
        for (i, column) in columns.iter().enumerate() {
            if column.is_empty() {
                return Err(bad(format!("column {} has no name", i + 1)));
            }
            if columns[..i].contains(column) {
                return Err(bad(format!("two columns are named {column:?}")));
            }
        }
        let mut table = Self {
            name: name.to_owned(),
            columns: columns[1..].to_vec(),
            times: Vec::new(),
            lines: Vec::new(),
            values: Vec::new(),
        };
        for record in csv.records() {
            let record = record.map_err(|e| bad(row_fault(&e)))?;
            let line = record.position().map_or(0, csv::Position::line);
            for (column, text) in columns.iter().zip(&record) {
                let value = number(text).ok_or_else(|| Error::TableCell {
                    table: name.to_owned(),
                    line,
                    column: column.clone(),
                    text: text.to_owned(),
                    need: "a finite number, true or false",
                })?;
                if column != "time" {
                    table.values.push(value);
                    continue;
                }
                if let Some(&previous) = table.times.last()
                    && value <= previous
                {
                    let table = name.to_owned();
                    return Err(Error::TableTime { table, line, time: value, previous });
                }
                table.times.push(value);
                table.lines.push(line);
            }
        }
        if table.times.is_empty() {
            return Err(bad("it has no rows".to_owned()));
        }
        Ok(table)
    }

    /// The name of the table in errors.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.name
    }

    /// The columns' names, without `time`.
    #[must_use]
    pub fn columns(&self) -> &[String] {
        &self.columns
    }

    /// The rows' times, s.
    #[must_use]
    pub fn times(&self) -> &[f64] {
        &self.times
    }

    /// The values of a row.
    #[must_use]
    pub fn row(&self, row: usize) -> &[f64] {
        let width = self.columns.len();
        self.values.get(row * width..(row + 1) * width).unwrap_or_default()
    }

    /// Refuses a column whose values are not of the kind of the input that it feeds.
    pub(super) fn fits(&self, column: usize, kind: Kind) -> Result<(), Error> {
        let need = match kind {
            Kind::Real => return Ok(()),
            Kind::Integer => "a whole number",
            Kind::Boolean => "true or false",
            Kind::String => "of use: the input is a text",
        };
        let fits = |value: f64| match kind {
            Kind::Integer => value.fract() == 0.0 && i32::try_from(value as i64).is_ok(),
            Kind::Boolean => value == 0.0 || value == 1.0,
            Kind::Real | Kind::String => false,
        };
        let values = self.values.iter().skip(column).step_by(self.columns.len().max(1));
        match values.zip(&self.lines).find(|(value, _)| !fits(**value)) {
            None => Ok(()),
            Some((value, line)) => Err(Error::TableCell {
                table: self.name.clone(),
                line: *line,
                column: self.columns[column].clone(),
                text: value.to_string(),
                need,
            }),
        }
    }
}

/// The problem of a row.
fn row_fault(error: &csv::Error) -> String {
    match error.kind() {
        csv::ErrorKind::UnequalLengths { pos, expected_len, len } => {
            let line = pos.as_ref().map_or(0, csv::Position::line);
            format!("line {line}: the row has {len} cells, the header has {expected_len}")
        }
        csv::ErrorKind::Utf8 { .. } => "it is not UTF-8 text".to_owned(),
        _ => error.to_string(),
    }
}

fn number(text: &str) -> Option<f64> {
    match text {
        "true" => Some(1.0),
        "false" => Some(0.0),
        _ => text.parse().ok().filter(|v: &f64| v.is_finite()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn error(text: &str) -> String {
        InputTable::read(text.as_bytes(), "in.csv").unwrap_err().to_string()
    }

    #[test]
    fn a_table_is_read_row_by_row() {
        let table = InputTable::read(
            "time, plant.speed ,enabled\n0,10,true\n0.5,11.5,0\n".as_bytes(),
            "in.csv",
        )
        .unwrap();
        assert_eq!(table.columns(), ["plant.speed", "enabled"]);
        assert_eq!(table.times(), [0.0, 0.5]);
        assert_eq!(table.row(1), [11.5, 0.0]);
        assert!(table.fits(1, Kind::Boolean).is_ok() && table.fits(1, Kind::Integer).is_ok());
        let error = table.fits(0, Kind::Integer).unwrap_err().to_string();
        assert!(error.contains("line 3") && error.contains("11.5"), "{error}");
    }

    #[test]
    fn faults_are_named_with_line_and_column() {
        assert!(error("t,a\n0,1\n").contains("first column is \"t\""));
        assert!(error("time,a,a\n0,1,1\n").contains("two columns are named \"a\""));
        assert!(error("time,a\n").contains("no rows"));
        let text = error("time,a\n0,1\n1,x\n");
        assert!(text.contains("line 3") && text.contains("\"a\"") && text.contains("\"x\""));
        assert!(error("time,a\n0,1\n1,NaN\n").contains("line 3"));
        assert!(error("time,a\n0,1\n0,2\n").contains("does not come after"));
        assert!(error("time,a\n0,1\n1\n").contains("line"), "a short row");
    }
}
