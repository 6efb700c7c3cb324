//! Reading and writing a versioned document.

use crate::matrix::Matrix;
use serde::{Serialize, de::DeserializeOwned};

/// Why a file is rejected. `file` is the name passed by the caller, `path` the JSON path of the fault.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[allow(missing_docs)] // the fields are named in the messages
pub enum Error {
    #[error("{file}:{line}:{column}: {}{problem}", place(path))]
    Syntax { file: String, line: usize, column: usize, path: String, problem: String },
    #[error("{file}: at `schema`: found {found}, expected `{expected}`")]
    Schema { file: String, found: String, expected: &'static str },
    #[error("{file}: at `schema`: `{schema}` is no {kinds} model")]
    NoModel { file: String, schema: String, kinds: String },
    #[error("{file}: at `{path}`: {problem}")]
    Value { file: String, path: String, problem: String },
}

/// The path of what is in no document.
const NOWHERE: &str = ".";

fn place(path: &str) -> String {
    if path == NOWHERE {
        "not a JSON document of steerwright: ".into()
    } else {
        format!("at `{path}`: ")
    }
}

impl Error {
    /// The suggested fix.
    #[must_use]
    pub fn hint(&self) -> String {
        match self {
            Self::Syntax { path, .. } if path == NOWHERE => {
                "use a JSON file that steerwright wrote".into()
            }
            Self::Syntax { .. } => {
                "write the file again with the command that makes it, or correct the named key"
                    .into()
            }
            Self::Schema { expected, .. } => format!(
                "use a file with \"schema\": \"{expected}\"; a newer version needs a newer steerwright"
            ),
            Self::NoModel { .. } => {
                "use a model that identify or bicycle wrote, such as plant.json".into()
            }
            Self::Value { .. } => "correct the value at the named path".into(),
        }
    }
}

/// The one key that every document has.
#[derive(serde::Deserialize)]
struct Tag {
    schema: Option<String>,
}

/// The schema that a JSON text states, if it states one.
#[must_use]
pub fn schema_of(text: &str) -> Option<String> {
    serde_json::from_str::<Tag>(text).ok()?.schema
}

/// A versioned JSON file.
pub trait Document: Serialize + DeserializeOwned {
    /// The schema's name and version, such as `steerwright/plant/1`.
    const SCHEMA: &'static str;

    /// Reports impossible values, in the order of the file.
    fn check(&self, checker: &mut Checker);

    /// Reads and checks a document; `file` is named in errors.
    ///
    /// # Errors
    /// [`Error`] with the place of the first fault.
    fn from_json(text: &str, file: &str) -> Result<Self, Error> {
        let syntax = |path: String, inner: &serde_json::Error| Error::Syntax {
            file: file.into(),
            line: inner.line(),
            column: inner.column(),
            path,
            problem: strip_place(&inner.to_string()),
        };
        // A list or a bare value would be reported by the number of its elements.
        let start = text.trim_start();
        if !start.is_empty()
            && !start.starts_with('{')
            && serde_json::from_str::<serde::de::IgnoredAny>(text).is_ok()
        {
            return Err(Error::Schema {
                file: file.into(),
                found: "no object".into(),
                expected: Self::SCHEMA,
            });
        }
        // The schema first: a file of another kind is reported as such, not with a missing key.
        // Text that is not JSON is left to the reader below, which reports the place.
        if let Ok(tag) = serde_json::from_str::<Tag>(text)
            && tag.schema.as_deref() != Some(Self::SCHEMA)
        {
            return Err(Error::Schema {
                file: file.into(),
                found: match tag.schema {
                    Some(schema) => format!("`{schema}`"),
                    None => "nothing".into(),
                },
                expected: Self::SCHEMA,
            });
        }
        let mut reader = serde_json::Deserializer::from_str(text);
        let document: Self = serde_path_to_error::deserialize(&mut reader)
            .map_err(|e| syntax(e.path().to_string(), e.inner()))?;
        reader.end().map_err(|e| syntax(NOWHERE.into(), &e))?;
        document.checked(file)?;
        Ok(document)
    }

    /// Checks a document created in memory, as [`Document::from_json`] does.
    ///
    /// # Errors
    /// [`Error::Value`] with the JSON path of the first fault.
    fn checked(&self, file: &str) -> Result<(), Error> {
        let mut checker = Checker::default();
        self.check(&mut checker);
        match checker.into_first() {
            None => Ok(()),
            Some((path, problem)) => Err(Error::Value { file: file.into(), path, problem }),
        }
    }

    /// The document as indented JSON with a final newline; the same content has the same bytes.
    fn to_json(&self) -> String {
        // Serialising these plain types into memory cannot fail; an empty text would be refused
        // by every reader.
        let mut text = serde_json::to_string_pretty(self).unwrap_or_default();
        text = compact_table_rows(&compact_number_rows(&text));
        text.push('\n');
        text
    }
}

/// serde_json appends " at line L column C", which the error already states.
fn strip_place(message: &str) -> String {
    message.rsplit_once(" at line ").map_or(message, |(head, _)| head).to_owned()
}

/// Puts arrays that hold only numbers on one line each, so that a matrix reads as a matrix.
fn compact_number_rows(pretty: &str) -> String {
    let mut out = String::with_capacity(pretty.len());
    let mut rest = pretty;
    // "[\n" opens an array: inside a string a line break would be escaped.
    while let Some(open) = rest.find("[\n") {
        let (head, tail) = rest.split_at(open);
        out.push_str(head);
        let close = tail.find(']').map(|c| &tail[..=c]);
        match close {
            Some(array)
                if array[1..array.len() - 1]
                    .chars()
                    .all(|c| c.is_ascii_digit() || "+-.eE, \n".contains(c)) =>
            {
                let numbers: Vec<&str> =
                    array[1..array.len() - 1].split(',').map(str::trim).collect();
                out.push('[');
                out.push_str(&numbers.join(", "));
                out.push(']');
                rest = &tail[array.len()..];
            }
            _ => {
                out.push('[');
                rest = &tail[1..];
            }
        }
    }
    out.push_str(rest);
    out
}

/// Puts objects in arrays that hold no others on one line each, so that a list of them reads as a
/// table. A line break never stands inside a string, so joining lines changes no content.
fn compact_table_rows(pretty: &str) -> String {
    /// Longer ones stay as they are.
    const LONGEST: usize = 300;
    let mut out = String::with_capacity(pretty.len());
    let mut lines = pretty.lines();
    while let Some(line) = lines.next() {
        out.push_str(line);
        if line.trim_start() == "{" {
            let rest = lines.clone().map(str::trim);
            let inside: Vec<&str> = rest.take_while(|l| !l.starts_with('}')).collect();
            let row = inside.join(" ");
            let nested = inside.iter().any(|l| l.ends_with(['{', '[']));
            if !nested && !inside.is_empty() && row.len() <= LONGEST {
                let close = lines.nth(inside.len()).map_or("", str::trim);
                out.push(' ');
                out.push_str(&row);
                out.push(' ');
                out.push_str(close);
            }
        }
        out.push('\n');
    }
    out.truncate(out.trim_end().len());
    out
}

/// Keeps the first fault of a document: its JSON path and the problem.
#[derive(Debug, Default)]
pub struct Checker {
    first: Option<(String, String)>,
}

impl Checker {
    /// Records a fault at `path` unless `ok`.
    pub fn require(&mut self, ok: bool, path: &str, problem: impl FnOnce() -> String) {
        if !ok && self.first.is_none() {
            self.first = Some((path.to_owned(), problem()));
        }
    }

    /// The number must be finite.
    pub fn finite(&mut self, value: f64, path: &str) {
        self.require(value.is_finite(), path, || format!("{value} is not a finite number"));
    }

    /// The number must be finite and above zero.
    pub fn positive(&mut self, value: f64, path: &str) {
        self.require(value.is_finite() && value > 0.0, path, || {
            format!("{value} must be greater than 0")
        });
    }

    /// The number must be finite and not below zero.
    pub fn not_negative(&mut self, value: f64, path: &str) {
        self.require(value.is_finite() && value >= 0.0, path, || {
            format!("{value} must not be negative")
        });
    }

    /// The number must lie in the range, ends included.
    pub fn within(&mut self, value: f64, min: f64, max: f64, path: &str) {
        self.require((min..=max).contains(&value), path, || {
            format!("{value} must be from {min} to {max}")
        });
    }

    /// The matrix must have that shape and hold finite numbers.
    pub fn shape(&mut self, matrix: &Matrix, rows: usize, columns: usize, path: &str) {
        self.require(matrix.rows() == rows && matrix.columns() == Some(columns), path, || {
            format!("the matrix is {}, expected {rows} by {columns}", matrix.shape_text())
        });
        for (i, row) in matrix.0.iter().enumerate() {
            for (j, value) in row.iter().enumerate() {
                self.finite(*value, &format!("{path}[{i}][{j}]"));
            }
        }
    }

    /// The matrix must be a covariance of that many numbers: symmetric, with variances that are not negative and
    /// correlations within ±1.
    pub(crate) fn covariance(&mut self, matrix: &Matrix, count: usize, path: &str) {
        self.shape(matrix, count, count, path);
        if matrix.rows() != count || matrix.columns() != Some(count) {
            return;
        }
        let entry = |i: usize, j: usize| matrix.0[i][j];
        for i in 0..count {
            self.not_negative(entry(i, i), &format!("{path}[{i}][{i}]"));
            for j in 0..i {
                let largest = (entry(i, i) * entry(j, j)).sqrt();
                let (value, other) = (entry(i, j), entry(j, i));
                // Room for the digits that a file keeps.
                let tolerance = 1e-6 * largest;
                self.require(
                    (value - other).abs() <= tolerance,
                    &format!("{path}[{i}][{j}]"),
                    || {
                        format!(
                            "{value} is not {path}[{j}][{i}], {other}: a covariance is symmetric"
                        )
                    },
                );
                self.require(
                    value.abs() <= largest + tolerance,
                    &format!("{path}[{i}][{j}]"),
                    || {
                        format!(
                            "{value} is a correlation beyond ±1: the deviations allow {largest:e}"
                        )
                    },
                );
            }
        }
    }

    pub(crate) fn into_first(self) -> Option<(String, String)> {
        self.first
    }
}

#[cfg(test)]
mod tests {
    use super::{compact_number_rows, compact_table_rows};

    #[test]
    fn rows_of_a_table_stand_on_one_line_and_mean_the_same() {
        let value = serde_json::json!({
            "rows": [{"a": 1.5, "b": "x } {"}, {"a": [1, 2], "b": null}, {}, {"c": {"d": 1}}],
            "named": {"a": 1, "b": 2}
        });
        let text = serde_json::to_string_pretty(&value).unwrap();
        let text = compact_table_rows(&compact_number_rows(&text));
        assert!(text.contains("\n    { \"a\": 1.5, \"b\": \"x } {\" },\n"), "{text}");
        assert!(text.contains("\n    { \"a\": [1, 2], \"b\": null },\n"), "{text}");
        assert_eq!(serde_json::from_str::<serde_json::Value>(&text).unwrap(), value);
    }

    #[test]
    fn number_rows_stand_on_one_line_and_strings_with_brackets_survive() {
        let value =
            serde_json::json!({"a": [[1.5, -2e-9], []], "b": ["x [1, 2", "]"], "c": [true]});
        let text = compact_number_rows(&serde_json::to_string_pretty(&value).unwrap());
        assert!(text.contains("[1.5, -2e-9]"), "{text}");
        assert_eq!(serde_json::from_str::<serde_json::Value>(&text).unwrap(), value);
    }
}
