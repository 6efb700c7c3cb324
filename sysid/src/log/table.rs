//! One CSV file: its header, and columns of numbers with the line each row stands on.
//!
//! The text is read once and never held: what stays of a row are its numbers.

use super::units::split_brackets;
use crate::{Error, Place};
use formats::{HashingReader, SourceFile};
use std::io::{Cursor, Read};
use std::rc::Rc;

/// Where a log's bytes come from; they are read once, from the first to the last.
pub struct LogFile<'a> {
    /// The file as the caller names it.
    pub name: String,
    /// Its bytes.
    pub reader: Box<dyn Read + 'a>,
}

impl<'a> LogFile<'a> {
    /// A file whose bytes are here.
    #[must_use]
    pub fn of_bytes(name: &str, bytes: &'a [u8]) -> Self {
        Self { name: name.into(), reader: Box::new(bytes) }
    }
}

impl std::fmt::Debug for LogFile<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("LogFile").field("name", &self.name).finish_non_exhaustive()
    }
}

/// The bytes after those that were looked at for the header, hashed on the way.
type Bytes<'a> = HashingReader<std::io::Chain<Cursor<Vec<u8>>, Box<dyn Read + 'a>>>;

/// A file whose header has been read.
pub(crate) struct Table<'a> {
    pub(crate) file: String,
    pub(crate) header: Vec<String>,
    pub(crate) header_line: u64,
    reader: csv::Reader<Bytes<'a>>,
}

/// Columns of a table; a missing cell is NaN.
pub(crate) struct Columns {
    pub(crate) values: Vec<Vec<f64>>,
    pub(crate) lines: Rc<Vec<u64>>,
}

impl<'a> Table<'a> {
    pub(crate) fn open(file: LogFile<'a>) -> Result<Self, Error> {
        let LogFile { name, mut reader } = file;
        let start = start(&name, reader.as_mut())?;
        let text = start.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(&start);
        let first = text
            .split(|b| *b == b'\n')
            .find(|line| !line.trim_ascii().is_empty())
            .unwrap_or_default();
        if first.is_empty() {
            return Err(Error::EmptyFile { file: name });
        }
        let delimiter = [b',', b';', b'\t'].into_iter().find(|d| first.contains(d)).unwrap_or(b',');
        // The parser passes over a byte-order mark itself.
        let bytes = HashingReader::new(Cursor::new(start).chain(reader));
        let reader = csv::ReaderBuilder::new()
            .has_headers(false)
            .flexible(true)
            .delimiter(delimiter)
            .buffer_capacity(1 << 16)
            .from_reader(bytes);
        let mut table = Self { file: name, header: Vec::new(), header_line: 1, reader };
        let mut record = csv::ByteRecord::new();
        // Lines of blanks may stand above the header.
        while table.next(&mut record)? {
            if record.iter().any(|c| !c.trim_ascii().is_empty()) {
                table.header_line = line(&record);
                table.header = record.iter().map(|h| lossless(h.trim_ascii())).collect();
                break;
            }
        }
        for (i, name) in table.header.iter().enumerate() {
            if !name.is_empty() && table.header[..i].contains(name) {
                return Err(Error::RepeatedColumn {
                    file: table.file,
                    line: table.header_line,
                    column: name.clone(),
                });
            }
        }
        Ok(table)
    }

    /// The next row, as text.
    fn next(&mut self, record: &mut csv::ByteRecord) -> Result<bool, Error> {
        let more = self.reader.read_byte_record(record).map_err(|e| {
            let line = e.position().map_or(1, csv::Position::line);
            Error::Csv { file: self.file.clone(), line, problem: e.to_string() }
        })?;
        let bytes = record.as_slice();
        if bytes.contains(&0) || !(bytes.is_ascii() || std::str::from_utf8(bytes).is_ok()) {
            return Err(Error::NotText { file: self.file.clone(), line: line(record) });
        }
        Ok(more)
    }

    /// The column with that header, brackets included or not.
    pub(crate) fn find(&self, name: &str) -> Option<usize> {
        self.header
            .iter()
            .position(|h| h == name)
            .or_else(|| self.header.iter().position(|h| split_brackets(h).0 == name))
    }

    /// Reads the file to its end: the columns' numbers, as written in it, and its hash.
    pub(crate) fn columns(mut self, wanted: &[usize]) -> Result<(Columns, SourceFile), Error> {
        let mut columns = self.rows(wanted, usize::MAX)?;
        columns.values.iter_mut().for_each(Vec::shrink_to_fit);
        Ok((columns, self.finish()))
    }

    /// Reads so many rows, or those that are left: the columns' numbers, as written in the file.
    pub(crate) fn rows(&mut self, wanted: &[usize], most: usize) -> Result<Columns, Error> {
        let mut values = vec![Vec::new(); wanted.len()];
        let mut lines = Vec::new();
        let mut record = csv::ByteRecord::new();
        while lines.len() < most && self.next(&mut record)? {
            if record.iter().all(|c| c.trim_ascii().is_empty()) {
                continue;
            }
            let line = line(&record);
            if record.len() != self.header.len() {
                return Err(Error::RaggedRow {
                    file: self.file.clone(),
                    line,
                    got: record.len(),
                    expected: self.header.len(),
                });
            }
            lines.push(line);
            for (values, &j) in values.iter_mut().zip(wanted) {
                values.push(self.number(&record[j], line, j)?);
            }
        }
        Ok(Columns { values, lines: Rc::new(lines) })
    }

    /// The file by name and hash, once all of it has been read.
    pub(crate) fn finish(self) -> SourceFile {
        let name = std::path::Path::new(&self.file);
        let name = name.file_name().map(|n| n.to_string_lossy().into_owned()).unwrap_or_default();
        SourceFile { name, sha256: self.reader.into_inner().sha256_hex() }
    }

    fn number(&self, cell: &[u8], line: u64, column: usize) -> Result<f64, Error> {
        let cell = std::str::from_utf8(cell).unwrap_or_default().trim();
        if let Ok(x) = cell.parse::<f64>() {
            return match x {
                x if x.is_finite() => Ok(x),
                x if x.is_nan() => Ok(f64::NAN),
                _ => Err(Error::NotFinite { at: self.place(line, column), text: cell.into() }),
            };
        }
        if cell.is_empty() || ["na", "null"].iter().any(|m| cell.eq_ignore_ascii_case(m)) {
            return Ok(f64::NAN);
        }
        Err(Error::NotANumber { at: self.place(line, column), text: cell.into() })
    }

    fn place(&self, line: u64, column: usize) -> Box<Place> {
        Place::new(&self.file, line, &self.header[column])
    }
}

/// The first bytes, at least up to the end of the first line that is not blank.
fn start(file: &str, reader: &mut dyn Read) -> Result<Vec<u8>, Error> {
    const CHUNK: u64 = 1 << 14;
    let mut bytes = Vec::new();
    loop {
        let before = bytes.len();
        reader.take(CHUNK).read_to_end(&mut bytes).map_err(|e| Error::Csv {
            file: file.into(),
            line: 1,
            problem: e.to_string(),
        })?;
        let ended = bytes.len() < before + CHUNK as usize;
        let mut lines = bytes.split(|b| *b == b'\n');
        let whole = lines.position(|line| !line.trim_ascii().is_empty()).is_some();
        if ended || (whole && lines.next().is_some()) {
            return Ok(bytes);
        }
    }
}

fn line(record: &csv::ByteRecord) -> u64 {
    record.position().map_or(1, csv::Position::line)
}

/// The text of bytes that are known to be text.
fn lossless(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).trim().to_owned()
}
