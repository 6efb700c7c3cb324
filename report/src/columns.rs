//! Tables of numbers from CSV files: a row of names, then rows of numbers.
//!
//! An empty cell is a gap (NaN); `true` and `false` are 1 and 0.

use crate::Error;

/// Named columns of equal length.
#[derive(Debug, Clone, PartialEq, Default)]
pub(crate) struct Columns {
    file: String,
    names: Vec<String>,
    values: Vec<Vec<f64>>,
}

impl Columns {
    /// Reads a table; `file` is named in errors.
    ///
    /// # Errors
    /// [`Error::Csv`], [`Error::Number`] with line and column, or [`Error::NoRows`].
    pub(crate) fn from_csv(text: &[u8], file: &str) -> Result<Self, Error> {
        // A byte-order mark would become part of the first name.
        let text = text.strip_prefix(b"\xef\xbb\xbf").unwrap_or(text);
        let refused = |e: csv::Error| Error::Csv {
            file: file.into(),
            line: e.position().map_or(0, csv::Position::line),
            problem: problem(&e),
        };
        let mut reader = csv::ReaderBuilder::new().trim(csv::Trim::All).from_reader(text);
        let names: Vec<String> =
            reader.headers().map_err(refused)?.iter().map(str::to_owned).collect();
        let mut values = vec![Vec::new(); names.len()];
        for record in reader.records() {
            let record = record.map_err(refused)?;
            for ((cell, column), name) in record.iter().zip(&mut values).zip(&names) {
                column.push(number(cell).ok_or_else(|| Error::Number {
                    file: file.into(),
                    line: record.position().map_or(0, csv::Position::line),
                    column: name.clone(),
                    text: cell.chars().take(40).collect(),
                })?);
            }
        }
        if values.first().is_none_or(Vec::is_empty) {
            return Err(Error::NoRows { file: file.into() });
        }
        Ok(Self { file: file.into(), names, values })
    }

    /// The column of that name, if there is one.
    pub(crate) fn get(&self, name: &str) -> Option<&[f64]> {
        let at = self.names.iter().position(|n| n == name)?;
        self.values.get(at).map(Vec::as_slice)
    }

    /// The column of that name.
    ///
    /// # Errors
    /// [`Error::MissingColumn`] naming those there are.
    pub(crate) fn column(&self, name: &str) -> Result<&[f64], Error> {
        self.get(name).ok_or_else(|| self.missing(name))
    }

    /// The first column `<instance>.<variable>` of a co-simulation result, whatever the instance.
    pub(crate) fn variable(&self, variable: &str) -> Option<&[f64]> {
        let named = |n: &String| n.rsplit_once('.').is_some_and(|(_, v)| v == variable);
        self.values.get(self.names.iter().position(named)?).map(Vec::as_slice)
    }

    pub(crate) fn missing(&self, name: &str) -> Error {
        let shown: Vec<_> = self.names.iter().take(20).map(|n| format!("`{n}`")).collect();
        Error::MissingColumn {
            file: self.file.clone(),
            column: name.into(),
            found: if shown.is_empty() { "none".into() } else { shown.join(", ") },
        }
    }
}

fn number(cell: &str) -> Option<f64> {
    match cell {
        "" => Some(f64::NAN),
        "true" => Some(1.0),
        "false" => Some(0.0),
        _ => cell.parse().ok(),
    }
}

fn problem(e: &csv::Error) -> String {
    match e.kind() {
        csv::ErrorKind::UnequalLengths { expected_len, len, .. } => {
            format!("{len} cells, expected {expected_len} as in the first row")
        }
        csv::ErrorKind::Utf8 { .. } => "the text is not UTF-8".into(),
        _ => e.to_string(),
    }
}
