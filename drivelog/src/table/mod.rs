//! One CSV file: its header, and columns of numbers with the line of each row.
//!
//! The text is read once and never held: what stays of a row are its numbers.

mod comments;
mod head;
mod stamps;

use crate::error::{Error, Place};
use crate::options::DecimalMark;
use crate::units::split_brackets;
use comments::WithoutComments;
use head::{Head, comma_number, is_blank, is_comment, is_missing, line};
use stamps::Stamps;
use std::io::{Cursor, Read};
use std::rc::Rc;
use steerwright_formats::{HashingReader, SourceFile};

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

pub(crate) struct Table<'a> {
    pub(crate) file: String,
    pub(crate) header: Vec<String>,
    pub(crate) header_line: u64,
    /// The unit of each column from the row under the header; empty where there is no such row.
    units: Vec<String>,
    decimal: Option<DecimalMark>,
    stamps: Vec<Option<Stamps>>,
    reader: csv::Reader<WithoutComments<Bytes<'a>>>,
}

/// Columns of a table; a missing cell is NaN.
#[derive(Default)]
pub(crate) struct Columns {
    pub(crate) values: Vec<Vec<f64>>,
    pub(crate) lines: Rc<Vec<u64>>,
}

impl Columns {
    pub(crate) fn and(mut self, later: Self) -> Self {
        if self.lines.is_empty() {
            return later;
        }
        self.values.iter_mut().zip(later.values).for_each(|(all, mut new)| all.append(&mut new));
        Rc::make_mut(&mut self.lines).extend_from_slice(&later.lines);
        self
    }

    pub(crate) fn split_off(&mut self, row: usize) -> Self {
        let values = self.values.iter_mut().map(|values| values.split_off(row)).collect();
        Self { values, lines: Rc::new(Rc::make_mut(&mut self.lines).split_off(row)) }
    }
}

impl<'a> Table<'a> {
    /// Reads the header; `decimal` is the mark that is stated.
    pub(crate) fn open(file: LogFile<'a>, decimal: Option<DecimalMark>) -> Result<Self, Error> {
        let LogFile { name, mut reader } = file;
        let (start, whole_lines) = start(&name, reader.as_mut())?;
        let head = Head::of(&name, &start[..whole_lines])?;
        for (i, column) in head.header.iter().enumerate() {
            if head.header[..i].contains(column) {
                return Err(Error::RepeatedColumn {
                    file: name,
                    line: head.header_line,
                    column: column.clone(),
                });
            }
        }
        // The parser passes over a byte-order mark itself.
        let bytes = HashingReader::new(Cursor::new(start).chain(reader));
        let bytes = WithoutComments::new(bytes, head.delimiter);
        let reader = head::reader_of(head.delimiter).buffer_capacity(1 << 16).from_reader(bytes);
        let mut table = Self {
            file: name,
            header: head.header,
            header_line: head.header_line,
            units: head.units,
            decimal: decimal.or(head.decimal),
            stamps: head.stamps,
            reader,
        };
        let mut record = csv::ByteRecord::new();
        for _ in 0..head.records {
            table.next(&mut record)?;
        }
        Ok(table)
    }

    fn next(&mut self, record: &mut csv::ByteRecord) -> Result<bool, Error> {
        let more = self.reader.read_byte_record(record).map_err(|e| {
            let line = e.position().map_or(1, csv::Position::line);
            Error::Csv { file: self.file.clone(), line, problem: e.to_string() }
        })?;
        if record.as_slice().contains(&0) {
            return Err(Error::NotText { file: self.file.clone(), line: line(record) });
        }
        Ok(more)
    }

    pub(crate) fn unit_under(&self, column: usize) -> Option<&str> {
        let text = head::bare_unit(self.units.get(column)?);
        (!text.is_empty() && text != "-").then_some(text)
    }

    pub(crate) fn has_stamps(&self, column: usize) -> bool {
        self.stamps[column].is_some()
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
            // A comment in quotes is one.
            if is_blank(&record) || is_comment(&record[0]) {
                continue;
            }
            let line = line(&record);
            let beyond = record.iter().skip(self.header.len());
            let is_longer = beyond.map(<[u8]>::trim_ascii).any(|cell| !cell.is_empty());
            if record.len() < self.header.len() || is_longer {
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
        SourceFile { name, sha256: self.reader.into_inner().into_inner().sha256_hex() }
    }

    fn number(&mut self, cell: &[u8], line: u64, column: usize) -> Result<f64, Error> {
        let text = std::str::from_utf8(cell).unwrap_or_default().trim();
        let with_comma = self.decimal == Some(DecimalMark::Comma);
        if let Ok(x) = text.parse::<f64>()
            && !(with_comma && text.contains('.'))
        {
            return match x {
                x if x.is_finite() => Ok(x),
                x if x.is_nan() => Ok(f64::NAN),
                _ => Err(Error::NotFinite { at: self.place(line, column), text: text.into() }),
            };
        }
        if is_missing(text) && cell.is_ascii() {
            return Ok(f64::NAN);
        }
        if let Some(stamps) = &mut self.stamps[column] {
            return stamps.seconds(text).ok_or_else(|| Error::NotATime {
                at: self.place(line, column),
                text: text.into(),
            });
        }
        match comma_number(text) {
            Some((x, _)) if with_comma => Ok(x),
            None if !with_comma || text.parse::<f64>().is_err() => {
                let text = head::text_of(cell);
                Err(Error::NotANumber { at: self.place(line, column), text })
            }
            _ => Err(Error::DecimalMark {
                at: self.place(line, column),
                text: text.into(),
                other: self.decimal.map(DecimalMark::name),
            }),
        }
    }

    fn place(&self, line: u64, column: usize) -> Box<Place> {
        Place::new(&self.file, line, &self.header[column])
    }
}

/// The first bytes, with some rows of values if there are any, and how many of them are whole lines.
fn start(file: &str, reader: &mut dyn Read) -> Result<(Vec<u8>, usize), Error> {
    const CHUNK: u64 = 1 << 16;
    const LINES: usize = 4;
    const MOST: usize = 1 << 24;
    let mut bytes = Vec::new();
    loop {
        let before = bytes.len();
        reader.take(CHUNK).read_to_end(&mut bytes).map_err(|e| Error::Csv {
            file: file.into(),
            line: 1,
            problem: e.to_string(),
        })?;
        let is_whole = bytes.len() < before + CHUNK as usize;
        // No text, or no end of a line in sight.
        if is_whole || bytes.contains(&0) || bytes.len() > MOST {
            let length = bytes.len();
            return Ok((bytes, length));
        }
        let lines = bytes.split(|b| *b == b'\n').map(<[u8]>::trim_ascii);
        if lines.filter(|line| !line.is_empty() && !is_comment(line)).count() > LINES {
            let end = bytes.iter().rposition(|b| *b == b'\n').map_or(0, |at| at + 1);
            return Ok((bytes, end));
        }
    }
}
