//! One CSV file: its header, and columns of numbers with the line of each row.
//!
//! The text is read once and never held: what stays of a row are its numbers.

mod cells;
mod comments;
mod dialect;
mod head;
mod header;
mod losses;
mod missing;
pub(super) mod stamps;

use super::bytes::LogFile;
use super::{Channel, Columns, Group, Pieces, Recording, Request, Rows};
use crate::Error;
use crate::error::{Place, counted};
use crate::options::{DecimalMark, LogOptions};
use cells::{comma_number, is_blank, is_comment_record, line};
use comments::WithoutComments;
use head::Head;
use losses::Losses;
use missing::is_missing;
use stamps::Stamps;
use std::io::{Cursor, Read};
use std::rc::Rc;
use steerwright_formats::HashingReader;

/// The bytes after those that were looked at for the header, hashed on the way.
type Bytes<'a> = HashingReader<std::io::Chain<Cursor<Vec<u8>>, Box<dyn Read + 'a>>>;

struct Csv<'a> {
    groups: [Group; 1],
    decimal: Option<DecimalMark>,
    stamps: Vec<Option<Stamps>>,
    /// The clock, where bad cells of other columns are missing values, and the columns without which the read goes on.
    clock: Option<usize>,
    optional: Vec<usize>,
    is_tolerant: bool,
    losses: Losses,
    /// Whether blanks delimit the cells.
    has_blanks: bool,
    count: u64,
    reader: csv::Reader<WithoutComments<Bytes<'a>>>,
    is_read: bool,
    /// A record that was looked at, which is the next one.
    held: Option<Result<csv::ByteRecord, Error>>,
    /// Whether a row of values was read.
    has_rows: bool,
}

/// Opens a text; reads its header.
pub(super) fn open<'a>(
    file: LogFile<'a>,
    options: &LogOptions,
) -> Result<Box<dyn Recording + 'a>, Error> {
    Ok(Box::new(Csv::open(file, options)?))
}

impl<'a> Csv<'a> {
    /// Reads the header.
    fn open(file: LogFile<'a>, options: &LogOptions) -> Result<Self, Error> {
        let name = file.name.clone();
        let mut reader = file.into_reader()?;
        let (start, whole_lines) = header::start(&name, reader.as_mut(), options.header_line)?;
        let mut head = Head::of(&name, &start[..whole_lines], options.header_line)?;
        // The parser passes over a byte-order mark itself.
        let bytes = HashingReader::new(Cursor::new(start).chain(reader));
        let bytes = WithoutComments::new(bytes, head.delimiter);
        let reader = head::reader_of(head.delimiter).buffer_capacity(1 << 16).from_reader(bytes);
        let channels = head.header.iter().enumerate().map(|(j, name)| {
            let mut channel =
                Channel::new(name, head.units.get(j).map(|unit| cells::bare_unit(unit)));
            channel.has_stamps = head.stamps[j].is_some();
            channel.is_text = head.are_texts[j];
            channel
        });
        let mut channels: Vec<Channel> = channels.collect();
        dialect::complete(&mut head, &mut channels);
        let top = if !head.has_names {
            let last = channels.last().map_or("", |channel| &channel.name);
            let rows = match head.skipped {
                0 => String::new(),
                skipped => format!(", {} above the values not read", counted(skipped, "row")),
            };
            Some(format!(
                "{name}: no header: the columns are named column_1 to {last}{rows}; where a line has their names, state it with --header-line N"
            ))
        } else if head.skipped > 0 {
            let rows = counted(head.skipped, "row");
            let line = head.header_line;
            Some(format!(
                "{name}: {rows} above the values not read; the header is line {line}; where it is another one, state it with --header-line N"
            ))
        } else {
            None
        };
        let losses = Losses::new(top, channels.len());
        let mut group = Group::new(&name, "", channels);
        group.header_line = head.header_line;
        let mut csv = Self {
            groups: [group],
            decimal: options.decimal.or(head.decimal),
            stamps: head.stamps,
            clock: None,
            optional: Vec::new(),
            is_tolerant: false,
            losses,
            has_blanks: head.delimiter == b' ',
            count: 0,
            reader,
            is_read: false,
            held: None,
            has_rows: false,
        };
        let mut record = csv::ByteRecord::new();
        for _ in 0..head.records {
            csv.next(&mut record)?;
        }
        Ok(csv)
    }

    fn next(&mut self, record: &mut csv::ByteRecord) -> Result<bool, Error> {
        if let Some(held) = self.held.take() {
            *record = held?;
            return Ok(true);
        }
        let more = self.reader.read_byte_record(record).map_err(|e| self.fault(&e))?;
        if record.as_slice().contains(&0) {
            return Err(Error::NotText { file: self.groups[0].file.clone(), line: line(record) });
        }
        Ok(more)
    }

    fn fault(&self, error: &csv::Error) -> Error {
        let line = error.position().map_or(1, csv::Position::line);
        Error::Csv { file: self.groups[0].file.clone(), line, problem: error.to_string() }
    }

    /// Whether no row follows.
    fn is_at_end(&mut self) -> bool {
        let mut record = csv::ByteRecord::new();
        while self.held.is_none() {
            match self.reader.read_byte_record(&mut record) {
                Ok(true) if is_blank(&record) || is_comment_record(&record) => {}
                Ok(true) => self.held = Some(Ok(std::mem::take(&mut record))),
                Ok(false) => return true,
                // The reader does not meet it again.
                Err(error) => self.held = Some(Err(self.fault(&error))),
            }
        }
        false
    }

    /// Reads so many rows, or those that are left: the columns' numbers, as written in the file. The rows before a
    /// fault come with it.
    fn take(&mut self, wanted: &[usize], most: usize) -> (Columns, Option<Error>) {
        let mut columns =
            Columns { values: vec![Vec::new(); wanted.len()], lines: Rc::new(Vec::new()) };
        let mut lines = Vec::new();
        let mut record = csv::ByteRecord::new();
        let mut fault = None;
        while lines.len() < most {
            match self.row(&mut record, wanted, &mut columns.values) {
                Ok(Some(line)) => lines.push(line),
                Ok(None) => break,
                Err(error) => {
                    fault = Some(error);
                    break;
                }
            }
        }
        // Cells of the row with the fault.
        columns.values.iter_mut().for_each(|values| values.truncate(lines.len()));
        columns.lines = Rc::new(lines);
        (columns, fault)
    }

    /// Reads a row: its numbers to the end of `values`; its line, or `None` at the end.
    fn row(
        &mut self,
        record: &mut csv::ByteRecord,
        wanted: &[usize],
        values: &mut [Vec<f64>],
    ) -> Result<Option<u64>, Error> {
        let columns = self.groups[0].channels.len();
        let rows = values.first().map_or(0, Vec::len);
        while self.next(record)? {
            // A comment in quotes is one.
            if is_blank(record) || is_comment_record(record) {
                continue;
            }
            let line = line(record);
            let beyond = record.iter().skip(columns);
            let is_longer = beyond.map(<[u8]>::trim_ascii).any(|cell| !cell.is_empty());
            let got = record.len();
            // Without the end of its line the last cell may be cut.
            let is_whole = got >= columns
                || got > 1 && (!self.is_at_end() || self.reader.get_ref().ends_line());
            // Between blanks an empty cell is not seen.
            let blanks = self.has_blanks;
            let read = if is_longer || !is_whole || blanks && got < columns {
                let file = self.groups[0].file.clone();
                Err(Error::RaggedRow { file, line, got, expected: columns, blanks })
            } else {
                self.numbers(record, line, wanted, values)
            };
            let faults = match read {
                // A mark of a tool beside texts.
                Ok(faults) if self.has_needed(&faults) && is_marked(record) => Err(faults),
                Err(_) if is_marked(record) => Err(Vec::new()),
                // What ends a file, such as a cut line or a closing remark.
                Err(error) if self.has_rows && self.is_at_end() => Err(vec![(0, error)]),
                Ok(faults) if self.is_new(&faults) && self.has_rows && self.is_at_end() => {
                    Err(faults)
                }
                read => Ok(read?),
            };
            let faults = match faults {
                Ok(faults) => faults,
                Err(mut faults) => {
                    values.iter_mut().for_each(|values| values.truncate(rows));
                    if is_marked(record) {
                        self.losses.marked.get_or_insert((0, line)).0 += 1;
                        continue;
                    }
                    let error = faults.remove(0).1;
                    self.losses.last = Some(format!("{error}: this last row is not read"));
                    return Ok(None);
                }
            };
            for (j, error) in faults {
                self.losses.bad[j].get_or_insert((0, error)).0 += 1;
            }
            if got < columns {
                let (count, _) = self.losses.short.get_or_insert((0, line));
                *count += 1;
            }
            self.has_rows = true;
            self.count += 1;
            return Ok(Some(line));
        }
        Ok(None)
    }

    /// Whether a column has its first bad cell.
    fn is_new(&self, faults: &[(usize, Error)]) -> bool {
        faults.iter().any(|(j, _)| self.losses.bad[*j].is_none() && !self.optional.contains(j))
    }

    fn has_needed(&self, faults: &[(usize, Error)]) -> bool {
        faults.iter().any(|(j, _)| !self.optional.contains(j))
    }

    /// Bad cells of a column that is needed: any where the decimal mark is open, and at the end more than one in a
    /// hundred rows.
    fn too_many(&mut self) -> Vec<Error> {
        let mut errors = Vec::new();
        for (j, bad) in self.losses.bad.iter_mut().enumerate() {
            let Some((count, error)) = bad.as_ref().filter(|_| !self.optional.contains(&j)) else {
                continue;
            };
            if matches!(error, Error::DecimalMark { .. }) {
                errors.push(error.clone());
                // It is an error once, where the read goes on.
                self.optional.push(j);
            } else if self.is_read && 100 * count > self.count {
                let first = Box::new(error.clone());
                errors.push(Error::TooManyBadCells { first, bad: *count, rows: self.count });
            } else {
                continue;
            }
            *bad = None;
        }
        errors
    }

    /// The numbers of a row, and its bad cells; cells that are not there are missing.
    fn numbers(
        &mut self,
        record: &csv::ByteRecord,
        line: u64,
        wanted: &[usize],
        values: &mut [Vec<f64>],
    ) -> Result<Vec<(usize, Error)>, Error> {
        let mut faults = Vec::new();
        for (values, &j) in values.iter_mut().zip(wanted) {
            values.push(match self.number(record.get(j).unwrap_or_default(), line, j) {
                Err(error) if self.is_tolerant && self.clock != Some(j) => {
                    faults.push((j, error));
                    f64::NAN
                }
                number => number?,
            });
        }
        Ok(faults)
    }

    fn number(&mut self, cell: &[u8], line: u64, column: usize) -> Result<f64, Error> {
        let text = std::str::from_utf8(cell).unwrap_or_default().trim();
        let with_comma = self.decimal == Some(DecimalMark::Comma);
        let is_of_digits = self.stamps[column].as_ref().is_some_and(Stamps::are_digits);
        if !is_of_digits
            && let Ok(x) = text.parse::<f64>()
            && !(with_comma && text.contains('.'))
        {
            return match x {
                x if x.is_finite() => Ok(x),
                _ if is_missing(text) => Ok(f64::NAN),
                _ => Err(Error::NotFinite { at: self.place(line, column), text: text.into() }),
            };
        }
        if let Some(x) = cells::switch(text) {
            return Ok(x);
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
                let text = cells::text_of(cell);
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
        Place::new(&self.groups[0].file, line, &self.groups[0].channels[column].name)
    }
}

impl Recording for Csv<'_> {
    fn groups(&self) -> &[Group] {
        &self.groups
    }

    fn tolerate(&mut self, clock: Option<usize>, optional: Vec<usize>) {
        (self.is_tolerant, self.clock, self.optional) = (true, clock, optional);
    }

    fn rows<'r>(&'r mut self, request: Request<'r>) -> Result<Pieces<'r>, Error> {
        let Some(wanted) = request.wanted.first() else { return Ok(Box::new(std::iter::empty())) };
        let mut faults = Vec::new();
        let pieces = std::iter::from_fn(move || {
            if let Some(error) = faults.pop() {
                return Some(Err(error));
            }
            if self.is_read {
                return None;
            }
            let (columns, fault) = self.take(&wanted.channels, request.most);
            self.is_read = columns.lines.len() < request.most;
            faults = self.too_many();
            faults.reverse();
            faults.extend(fault);
            Some(Ok(Rows { wanted: 0, columns }))
        });
        Ok(Box::new(pieces))
    }

    fn losses(&self) -> Vec<String> {
        let file = &self.groups[0].file;
        let open = self
            .stamps
            .iter()
            .zip(&self.groups[0].channels)
            .filter(|(stamps, _)| stamps.as_ref().is_some_and(Stamps::has_open_order));
        let open = open.map(|(_, channel)| {
            format!(
                "{file}: column `{}`: day and month are open and the month is taken to be first, which changes no time between rows",
                channel.name
            )
        });
        self.losses.sentences(file).into_iter().chain(open).collect()
    }

    fn hashes_bytes(&self) -> bool {
        true
    }

    fn sha256(&mut self) -> Option<String> {
        self.is_read.then(|| self.reader.get_ref().inner().sha256_hex())
    }
}

fn is_marked(record: &csv::ByteRecord) -> bool {
    record[0].trim_ascii() == b"%"
}
