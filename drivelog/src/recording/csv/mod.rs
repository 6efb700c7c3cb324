//! One CSV file: its header, and columns of numbers with the line of each row.
//!
//! The text is read once and never held: what stays of a row are its numbers.

mod cells;
mod comments;
mod dialect;
mod head;
mod header;
pub(super) mod instants;
mod losses;
pub(super) mod missing;
mod rows;
pub(super) mod stamps;

use super::bytes::LogFile;
use super::{Channel, Columns, Group, Pieces, Recording, Request, Rows, Wanted};
use crate::Error;
use crate::error::{counted, shortened};
use crate::options::LogOptions;
use crate::units::without_unit;
use cells::{is_blank, joined};
use comments::WithoutComments;
use head::Head;
use losses::Losses;
use rows::Csv;
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
        let parts = dialect::parts(&group.channels);
        let groups = groups_of(&group, &parts);
        let mut csv = Self {
            table: group,
            groups,
            parts,
            decimal: options.decimal.or(head.decimal),
            stamps: head.stamps,
            clocks: Vec::new(),
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

/// The table, or a group for each of its clocks, named like its first channel.
fn groups_of(table: &Group, parts: &[Vec<usize>]) -> Vec<Group> {
    let group = |columns: &Vec<usize>| {
        let channels: Vec<Channel> = columns.iter().map(|c| table.channels[*c].clone()).collect();
        let mut group = Group { channels, ..table.clone() };
        if parts.len() > 1 {
            group.name = without_unit(&group.channels[1].name).into();
            group.clock = Some(0);
        }
        group
    };
    parts.iter().map(group).collect()
}

/// Leaves out the rows without any value: a slower clock ends before the others.
fn without_blank_rows(columns: &mut Columns) {
    let has_value = |row: usize| columns.values.iter().any(|values| !values[row].is_nan());
    let rows: Vec<usize> = (0..columns.lines.len()).filter(|row| has_value(*row)).collect();
    if rows.len() < columns.lines.len() {
        let values = columns.values.iter().map(|values| rows.iter().map(|r| values[*r]).collect());
        let lines = rows.iter().map(|row| columns.lines[*row]).collect();
        *columns = Columns { values: values.collect(), lines: Rc::new(lines) };
    }
}

impl Recording for Csv<'_> {
    fn groups(&self) -> &[Group] {
        &self.groups
    }

    fn tolerate(&mut self, clock: Option<usize>, optional: Vec<usize>) {
        self.is_tolerant = true;
        if self.groups.len() > 1 {
            // Each group has its own, which is its first column.
            self.clocks = self.parts.iter().map(|columns| columns[0]).collect();
        } else {
            (self.clocks, self.optional) = (clock.into_iter().collect(), optional);
        }
    }

    fn rows<'r>(&'r mut self, request: Request<'r>) -> Result<Pieces<'r>, Error> {
        let column = |own: &Wanted, c: &usize| self.parts[own.group][*c];
        let wanted: Vec<Vec<usize>> = request
            .wanted
            .iter()
            .map(|own| own.channels.iter().map(|c| column(own, c)).collect())
            .collect();
        let columns: Vec<usize> = wanted.concat();
        let has_several = self.groups.len() > 1;
        let mut ready: VecDeque<Result<Rows, Error>> = VecDeque::new();
        if wanted.is_empty() {
            return Ok(Box::new(std::iter::empty()));
        }
        let pieces = std::iter::from_fn(move || {
            if let Some(ready) = ready.pop_front() {
                return Some(ready);
            }
            if self.is_read {
                return None;
            }
            let (mut all, fault) = self.take(&columns, request.most);
            self.is_read = all.lines.len() < request.most;
            for (place, own) in wanted.iter().enumerate() {
                let values = all.values.drain(..own.len()).collect();
                let mut columns = Columns { values, lines: Rc::clone(&all.lines) };
                if has_several {
                    without_blank_rows(&mut columns);
                }
                ready.push_back(Ok(Rows { wanted: place, columns }));
            }
            ready.extend(fault.into_iter().chain(self.too_many()).map(Err));
            ready.pop_front()
        });
        Ok(Box::new(pieces))
    }

    fn losses(&self) -> Vec<String> {
        let file = &self.table.file;
        let open = self.stamps.iter().zip(&self.table.channels).filter_map(|(stamps, channel)| {
            let remark = stamps.as_ref()?.remark()?;
            Some(format!("{file}: column `{}`: {remark}", shortened(&channel.name)))
        });
        self.losses.sentences(file, &self.table.channels).into_iter().chain(open).collect()
    }

    fn dates(&self, clock: usize) -> Option<Dates> {
        let column = self.parts.first()?.get(clock)?;
        self.stamps[*column].as_ref()?.dates()
    }

    fn hashes_bytes(&self) -> bool {
        true
    }

    fn sha256(&mut self) -> Option<String> {
        if self.is_read { Some(self.reader.get_ref().inner().sha256_hex()) } else { None }
    }
}
