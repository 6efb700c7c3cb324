//! One CSV file: its header, and columns of numbers with the line of each row.
//!
//! The text is read once and never held: what stays of a row are its numbers.

mod cells;
mod comments;
mod dialect;
mod head;
mod header;
mod losses;
pub(super) mod missing;
mod rows;
pub(super) mod stamps;

use super::bytes::LogFile;
use super::{Channel, Columns, Group, Pieces, Recording, Request, Rows};
use crate::Error;
use crate::error::{counted, shortened};
use crate::options::LogOptions;
use cells::is_blank;
use comments::WithoutComments;
use head::Head;
use losses::Losses;
use rows::{Csv, joined};
use stamps::Dates;
use std::collections::{HashSet, VecDeque};
use std::io::{Cursor, Read};
use std::rc::Rc;
use steerwright_formats::HashingReader;

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
        let mut head = Head::read(&name, &start[..whole_lines], options.header_line)?;
        // The parser passes over a byte-order mark itself.
        let bytes = HashingReader::new(Cursor::new(start).chain(reader));
        let bytes = WithoutComments::new(bytes, head.delimiter);
        let reader = head::reader_of(head.delimiter).buffer_capacity(1 << 16).from_reader(bytes);
        let channels = head.header.iter().enumerate().map(|(j, name)| {
            let mut channel =
                Channel::new(name, head.units.get(j).map(|unit| cells::bare_unit(unit)));
            channel.has_stamps = head.stamps[j].is_some();
            channel.is_text = head.are_texts[j];
            channel.unread.clone_from(&head.unread[j]);
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
        let is_bus = dialect::has_frames(&head.header);
        let mut top = Vec::from_iter(top);
        if is_bus || !head.has_names && !options.dbc.is_empty() {
            top.push(format!(
                "{name}: no frames of a bus are recognised, and it is read as a table of numbers; frames are read from a log of candump, ASC or TRC, into which python -m can.logconvert converts others"
            ));
        }
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
            delimiter: head.delimiter,
            count: 0,
            reader,
            is_read: false,
            held: VecDeque::new(),
            top: HashSet::new(),
            has_rows: false,
            lengths: [0; 16],
        };
        let mut record = csv::ByteRecord::new();
        let (mut is_short, mut is_long) = (Ok(()), false);
        for _ in 0..head.records {
            csv.next(&mut record)?;
            is_long |= record.iter().any(|cell| cell.contains(&b'\n'));
            is_short = is_short.and(csv.check_header(&record));
            if !is_blank(&record) {
                csv.top.insert(joined(&record));
            }
        }
        if is_long && csv.is_at_end() && csv.reader.get_ref().is_quoted() {
            return Err(Error::OpenQuote { file: name, line: head.header_line });
        }
        is_short?;
        Ok(csv)
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
        let open =
            self.stamps.iter().zip(&self.groups[0].channels).filter_map(|(stamps, channel)| {
                let remark = stamps.as_ref()?.remark()?;
                Some(format!("{file}: column `{}`: {remark}", shortened(&channel.name)))
            });
        self.losses.sentences(file, &self.groups[0].channels).into_iter().chain(open).collect()
    }

    fn dates(&self, clock: usize) -> Option<Dates> {
        self.stamps.get(clock)?.as_ref()?.dates()
    }

    fn hashes_bytes(&self) -> bool {
        true
    }

    fn sha256(&mut self) -> Option<String> {
        if self.is_read { Some(self.reader.get_ref().inner().sha256_hex()) } else { None }
    }
}
