//! One CSV file: its header, and columns of numbers with the line each row stands on.

use super::units::split_brackets;
use crate::{Error, Place};

/// A file whose header has been read; cells are parsed when columns are asked for.
pub(crate) struct Table<'a> {
    pub(crate) file: &'a str,
    pub(crate) header: Vec<String>,
    pub(crate) header_line: u64,
    text: &'a str,
    delimiter: u8,
}

/// Columns of a table; a missing cell is NaN.
pub(crate) struct Columns {
    pub(crate) values: Vec<Vec<f64>>,
    pub(crate) lines: Vec<u64>,
}

impl<'a> Table<'a> {
    pub(crate) fn open(file: &'a str, bytes: &'a [u8]) -> Result<Self, Error> {
        let bytes = bytes.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(bytes);
        let text = std::str::from_utf8(bytes).map_err(|e| {
            let line = 1 + bytes[..e.valid_up_to()].iter().filter(|b| **b == b'\n').count();
            Error::NotText { file: file.into(), line: line as u64 }
        })?;
        if let Some(at) = text.find('\0') {
            let line = 1 + text[..at].matches('\n').count() as u64;
            return Err(Error::NotText { file: file.into(), line });
        }
        if text.trim().is_empty() {
            return Err(Error::EmptyFile { file: file.into() });
        }
        let first = text.lines().find(|l| !l.trim().is_empty()).unwrap_or_default();
        let delimiter =
            [b',', b';', b'\t'].into_iter().find(|d| first.as_bytes().contains(d)).unwrap_or(b',');
        let mut table = Self { file, header: Vec::new(), header_line: 1, text, delimiter };
        let mut reader = table.reader();
        let mut record = csv::StringRecord::new();
        if reader.read_record(&mut record).map_err(|e| table.fault(&e))? {
            table.header_line = record.position().map_or(1, csv::Position::line);
            table.header = record.iter().map(|h| h.trim().to_owned()).collect();
        }
        for (i, name) in table.header.iter().enumerate() {
            if !name.is_empty() && table.header[..i].contains(name) {
                return Err(Error::RepeatedColumn {
                    file: file.into(),
                    line: table.header_line,
                    column: name.clone(),
                });
            }
        }
        Ok(table)
    }

    fn reader(&self) -> csv::Reader<&'a [u8]> {
        csv::ReaderBuilder::new()
            .has_headers(false)
            .flexible(true)
            .delimiter(self.delimiter)
            .from_reader(self.text.as_bytes())
    }

    fn fault(&self, error: &csv::Error) -> Error {
        let line = error.position().map_or(1, csv::Position::line);
        Error::Csv { file: self.file.into(), line, problem: error.to_string() }
    }

    /// The column with that header, brackets included or not.
    pub(crate) fn find(&self, name: &str) -> Option<usize> {
        self.header
            .iter()
            .position(|h| h == name)
            .or_else(|| self.header.iter().position(|h| split_brackets(h).0 == name))
    }

    /// The columns' numbers, as written in the file.
    pub(crate) fn columns(&self, wanted: &[usize]) -> Result<Columns, Error> {
        let mut columns = Columns { values: vec![Vec::new(); wanted.len()], lines: Vec::new() };
        let mut reader = self.reader();
        let mut record = csv::StringRecord::new();
        let mut header = true;
        while reader.read_record(&mut record).map_err(|e| self.fault(&e))? {
            if std::mem::take(&mut header) || record.iter().all(|c| c.trim().is_empty()) {
                continue;
            }
            let line = record.position().map_or(0, csv::Position::line);
            if record.len() != self.header.len() {
                return Err(Error::RaggedRow {
                    file: self.file.into(),
                    line,
                    got: record.len(),
                    expected: self.header.len(),
                });
            }
            columns.lines.push(line);
            for (values, &j) in columns.values.iter_mut().zip(wanted) {
                let cell = record.get(j).unwrap_or_default();
                values.push(self.number(cell, line, j)?);
            }
        }
        Ok(columns)
    }

    fn number(&self, cell: &str, line: u64, column: usize) -> Result<f64, Error> {
        let cell = cell.trim();
        if cell.is_empty() || ["nan", "na", "null"].iter().any(|m| cell.eq_ignore_ascii_case(m)) {
            return Ok(f64::NAN);
        }
        let at = || Place::new(self.file, line, &self.header[column]);
        match cell.parse::<f64>() {
            Ok(x) if x.is_finite() => Ok(x),
            Ok(x) if x.is_nan() => Ok(f64::NAN),
            Ok(_) => Err(Error::NotFinite { at: at(), text: cell.into() }),
            Err(_) => Err(Error::NotANumber { at: at(), text: cell.into() }),
        }
    }
}
