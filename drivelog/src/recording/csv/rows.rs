//! Which rows of a table are rows of values, and their numbers.

use super::cells::{
    comma_number, decoded, fortran_number, is_blank, is_comment_record, is_number, joined, line,
    set_line, switch, text_of,
};
use super::comments::WithoutComments;
use super::head::split;
use super::losses::Losses;
use super::missing::is_missing;
use super::stamps::Stamps;
use crate::Error;
use crate::error::{Place, shortened};
use crate::options::DecimalMark;
use crate::recording::{Channel, Group};
use crate::role::Role;
use std::collections::{HashSet, VecDeque};
use std::io::{Cursor, Read};
use steerwright_formats::HashingReader;

/// The bytes after those that were looked at for the header, hashed on the way.
pub(super) type Bytes<'a> = HashingReader<std::io::Chain<Cursor<Vec<u8>>, Box<dyn Read + 'a>>>;

pub(super) struct Csv<'a> {
    /// All columns of the file.
    pub(super) table: Group,
    /// The table, or where it has several clocks a group for each, and the columns of each group.
    pub(super) groups: Vec<Group>,
    pub(super) parts: Vec<Vec<usize>>,
    pub(super) decimal: Option<DecimalMark>,
    pub(super) stamps: Vec<Option<Stamps>>,
    /// The clocks, where bad cells of other columns are missing values, and the columns without which the read goes on.
    pub(super) clocks: Vec<usize>,
    pub(super) optional: Vec<usize>,
    pub(super) is_tolerant: bool,
    pub(super) losses: Losses,
    pub(super) delimiter: u8,
    pub(super) count: u64,
    pub(super) reader: csv::Reader<WithoutComments<Bytes<'a>>>,
    pub(super) is_read: bool,
    /// Records that were looked at, which are the next ones.
    pub(super) held: VecDeque<Result<csv::ByteRecord, Error>>,
    /// The rows above the values.
    pub(super) top: HashSet<Vec<u8>>,
    /// Whether a row of values was read.
    pub(super) has_rows: bool,
    /// Bytes of the last cells of the rows before.
    pub(super) lengths: [usize; 16],
}

/// Rows among which one with zeros is tolerated, as bad cells are.
const ROWS_OF_A_TORN_ONE: u64 = 100;

/// Whether a record goes over several lines.
fn has_line_end(bytes: &[u8]) -> bool {
    bytes.iter().any(|byte| matches!(byte, b'\n' | b'\r'))
}

impl Csv<'_> {
    pub(super) fn next(&mut self, record: &mut csv::ByteRecord) -> Result<bool, Error> {
        if let Some(held) = self.held.pop_front() {
            *record = held?;
            return Ok(true);
        }
        self.read(record)
    }

    /// Reads a record with its line in the file. Rows with zeros among their bytes, of a block that was not written, are left
    /// out where they are few: what follows the zeros may be the end of a row.
    fn read(&mut self, record: &mut csv::ByteRecord) -> Result<bool, Error> {
        let mut last_torn = None;
        loop {
            let more = self.reader.read_byte_record(record).map_err(|e| self.fault(&e))?;
            if let Some((line, byte)) = last_torn.take() {
                self.note_torn(line, byte, more)?;
            }
            let byte = record.position().map_or(0, csv::Position::byte);
            if let Some(line) = self.reader.get_mut().line_at(byte) {
                set_line(record, line);
            }
            if !record.as_slice().contains(&0) {
                return Ok(more);
            }
            last_torn = Some((line(record), byte));
        }
    }

    /// Counts a row with zeros among its bytes, with its line and byte; the last of the file is cut off.
    fn note_torn(&mut self, line: u64, byte: u64, more: bool) -> Result<(), Error> {
        let file = self.table.file.clone();
        if self.has_rows && !more {
            let problem = "zeros cut the row off".into();
            self.losses.last = Some((Error::Read { file, byte, problem }, 1));
            return Ok(());
        }
        let (torn, first) = self.losses.torn.get_or_insert((0, line));
        *torn += 1;
        if !self.has_rows || *torn > 1 + self.count / ROWS_OF_A_TORN_ONE {
            return Err(Error::NotText { file, line: *first });
        }
        Ok(())
    }

    fn fault(&mut self, error: &csv::Error) -> Error {
        let position = error.position().unwrap_or_else(|| self.reader.position()).clone();
        let line = self.reader.get_mut().line_at(position.byte()).unwrap_or(position.line());
        let problem = error.to_string();
        Error::Csv { file: self.table.file.clone(), line, problem }
    }

    /// Whether no row follows.
    pub(super) fn is_at_end(&mut self) -> bool {
        self.look(1) == 0
    }

    /// Looks at so many of the rows that follow; how many there are.
    fn look(&mut self, rows: usize) -> usize {
        let mut record = csv::ByteRecord::new();
        while self.held.len() < rows {
            match self.read(&mut record) {
                // Lines within a comment in quotes may be rows.
                Ok(true)
                    if is_blank(&record)
                        || is_comment_record(&record) && !has_line_end(record.as_slice()) => {}
                Ok(true) => self.held.push_back(Ok(std::mem::take(&mut record))),
                Ok(false) => break,
                // The reader does not meet it again.
                Err(error) => self.held.push_back(Err(error)),
            }
        }
        self.held.len()
    }

    /// The number of rows to the end, where none of them is a row of values and they are few.
    fn trailer(&mut self, wanted: &[usize]) -> Option<usize> {
        const MOST: usize = 64;
        let rows = self.look(MOST);
        let stamps = self.stamps.clone();
        let mut values = vec![Vec::new(); wanted.len()];
        let held = std::mem::take(&mut self.held);
        let mut is_text = rows < MOST;
        for (place, row) in held.iter().enumerate() {
            let next = held.get(place + 1).and_then(|next| next.as_ref().ok());
            is_text &= match row {
                Ok(row) => {
                    self.taken_in(row, next).is_none()
                        && self.cells(row, line(row), wanted, &mut values).is_err()
                }
                Err(_) => false,
            };
        }
        (self.held, self.stamps) = (held, stamps);
        if is_text { Some(rows) } else { None }
    }

    /// Reads a row: its numbers to the end of `values`; its line, or `None` at the end.
    pub(super) fn row(
        &mut self,
        record: &mut csv::ByteRecord,
        wanted: &[usize],
        values: &mut [Vec<f64>],
    ) -> Result<Option<u64>, Error> {
        let rows = values.first().map_or(0, Vec::len);
        while self.next(record)? {
            self.check_quotes(record)?;
            // A comment in quotes is one.
            if is_blank(record) || is_comment_record(record) {
                continue;
            }
            let line = line(record);
            let mut read = self.cells(record, line, wanted, values);
            // The cell before zeros may lack digits.
            if read.is_ok() && self.is_at_end() && self.reader.get_ref().is_torn() {
                values.iter_mut().for_each(|values| values.truncate(rows));
                let byte = record.position().map_or(0, csv::Position::byte);
                let (file, problem) = (self.table.file.clone(), "zeros cut the row off".into());
                self.losses.last = Some((Error::Read { file, byte, problem }, 1));
                break;
            }
            let length = record.iter().next_back().map_or(0, <[u8]>::len);
            let is_text = self
                .table
                .channels
                .get(record.len().saturating_sub(1))
                .is_some_and(|last| last.is_text);
            // A number that the end of the file cuts is another number.
            if read.is_ok()
                && !is_text
                && self.lengths.iter().all(|before| length < *before)
                && self.is_at_end()
                && !self.reader.get_ref().ends_line()
            {
                values.iter_mut().for_each(|values| values.truncate(rows));
                let file = self.table.file.clone();
                let problem =
                    "the file ends within this line, and its last cell is shorter than those above"
                        .into();
                self.losses.last = Some((Error::Csv { file, line, problem }, 1));
                break;
            }
            self.lengths[self.count as usize % self.lengths.len()] = length;
            if !matches!(&read, Ok(faults) if faults.is_empty()) {
                let is_marked = record[0].trim_ascii() == b"%" && self.is_of_texts(record);
                let is_repeated = self.top.contains(&joined(record));
                let last = match &mut read {
                    _ if is_marked || is_repeated || !self.has_rows => None,
                    Err(error) => self.trailer(wanted).map(|rows| (error.clone(), rows + 1)),
                    Ok(faults) => {
                        let is_last = self.is_closing(record);
                        if is_last { Some((faults.remove(0).1, 1)) } else { None }
                    }
                };
                if is_marked || is_repeated || last.is_some() {
                    values.iter_mut().for_each(|values| values.truncate(rows));
                }
                if last.is_some() {
                    self.losses.last = last;
                    self.held.clear();
                    break;
                }
                let unread = [
                    (is_repeated, &mut self.losses.repeated),
                    (is_marked, &mut self.losses.marked),
                ];
                if let Some((_, unread)) = unread.into_iter().find(|(is_so, _)| *is_so) {
                    unread.get_or_insert((0, line)).0 += 1;
                    self.stamps.iter_mut().flatten().for_each(Stamps::restart_rows);
                    continue;
                }
            }
            for (j, error) in read? {
                self.losses.bad[j].get_or_insert((0, error)).0 += 1;
            }
            self.note_late_numbers(record, line);
            if record.len() < self.table.channels.len() {
                let (count, _) = self.losses.short.get_or_insert((0, line));
                *count += 1;
            }
            self.has_rows = true;
            self.count += 1;
            return Ok(Some(line));
        }
        self.losses.zeros = self.reader.get_ref().zeros();
        Ok(None)
    }

    /// Rejects a quote of names or units that takes in more lines than a name has.
    pub(super) fn check_header(&self, record: &csv::ByteRecord) -> Result<(), Error> {
        const MOST_LINES: usize = 8;
        for cell in record {
            let rows = cell.iter().filter(|byte| **byte == b'\n').count();
            if rows > MOST_LINES {
                let (file, line) = (self.table.file.clone(), line(record));
                return Err(Error::LongQuote { file, line, last: line + rows as u64, rows });
            }
        }
        Ok(())
    }

    /// Rejects a quote that takes in the rest of the file or rows of the table.
    fn check_quotes(&mut self, record: &csv::ByteRecord) -> Result<(), Error> {
        if !has_line_end(record.as_slice()) {
            return Ok(());
        }
        let file = self.table.file.clone();
        if self.is_at_end() && self.reader.get_ref().is_quoted() {
            return Err(Error::OpenQuote { file, line: line(record) });
        }
        let next = self.held.front().and_then(|next| next.as_ref().ok());
        match self.taken_in(record, next) {
            Some((line, last, rows)) => Err(Error::LongQuote { file, line, last, rows }),
            None => Ok(()),
        }
    }

    /// First and last line of a cell in whose lines there are rows of the table, and how many: rows whose clock is
    /// between that of the record and of the next one.
    fn taken_in(
        &self,
        record: &csv::ByteRecord,
        next: Option<&csv::ByteRecord>,
    ) -> Option<(u64, u64, usize)> {
        let clock = self.likely_clock()?;
        let bounds = [Some(record), next].map(|of| of?.get(clock).map(text_of));
        let mut last = line(record);
        for (j, cell) in record.iter().enumerate() {
            let first = last;
            let mut rows = 0;
            let end = if cell.contains(&b'\n') { b'\n' } else { b'\r' };
            let mut lines = cell.split(|b| *b == end).skip(1).peekable();
            while let Some(text) = lines.next() {
                last += 1;
                let mut cells = split(text, self.delimiter);
                // What follows the quote ends its last line.
                if lines.peek().is_none() {
                    cells.extend(record.iter().skip(j + 1));
                }
                rows += usize::from(self.is_row(&cells) && self.is_between(&cells, &bounds));
            }
            if rows > 0 {
                return Some((first, last, rows));
            }
        }
        None
    }

    /// The clock, or the column that looks like one.
    fn likely_clock(&self) -> Option<usize> {
        let is_clock =
            |channel: &Channel| channel.has_stamps || Role::Time.is_named_like(&channel.name);
        let first = self.clocks.first().copied();
        first.or_else(|| self.table.channels.iter().position(is_clock))
    }

    /// Whether the clock of the cells is after the first and before the second one, as far as they are there: by number,
    /// and of texts, such as dates, by their order.
    fn is_between(&self, cells: &[&[u8]], bounds: &[Option<String>; 2]) -> bool {
        let Some(own) = self.likely_clock().and_then(|clock| cells.get(clock)) else {
            return false;
        };
        let own = text_of(own);
        let number = |text: &str| text.replace(',', ".").parse::<f64>();
        let is_before = |a: &str, b: &str| match (number(a), number(b)) {
            (Ok(a), Ok(b)) => a < b,
            (Err(_), Err(_)) => a.len() == b.len() && a < b,
            _ => false,
        };
        // The cell of a quote that begins with a row is no clock.
        let first = bounds[0].as_ref().filter(|first| !has_line_end(first.as_bytes()));
        first.is_none_or(|first| is_before(first, &own))
            && bounds[1].as_ref().is_none_or(|second| is_before(&own, second))
    }

    /// Whether the cells are those of a row: no more than the header has but for empty ones, and more numbers than texts in
    /// the columns of numbers.
    fn is_row(&self, cells: &[&[u8]]) -> bool {
        let filled = cells.iter().rposition(|cell| !text_of(cell).is_empty()).map_or(0, |j| j + 1);
        let channels = &self.table.channels;
        let (mut numbers, mut texts) = (0, 0);
        for (cell, _) in cells.iter().zip(channels).filter(|(_, channel)| !channel.is_text) {
            let cell = text_of(cell);
            if is_number(&cell) {
                numbers += 1;
            } else if !is_missing(&cell) {
                texts += 1;
            }
        }
        filled > 1 && filled <= channels.len() && numbers > texts
    }

    /// The numbers of a row to the end of `values`, and its bad cells; an error where it is none of values.
    fn cells(
        &mut self,
        record: &csv::ByteRecord,
        line: u64,
        wanted: &[usize],
        values: &mut [Vec<f64>],
    ) -> Result<Vec<(usize, Error)>, Error> {
        let (got, expected) = (record.len(), self.table.channels.len());
        let beyond = record.iter().skip(expected);
        let is_longer = beyond.map(<[u8]>::trim_ascii).any(|cell| !cell.is_empty());
        // Without the end of its line the last cell may be cut.
        let is_whole =
            got >= expected || got > 1 && (!self.is_at_end() || self.reader.get_ref().ends_line());
        // Between blanks an empty cell is not seen.
        let blanks = self.delimiter == b' ';
        if is_longer || !is_whole || blanks && got < expected {
            let file = self.table.file.clone();
            return Err(Error::RaggedRow { file, line, got, expected, blanks });
        }
        // Cells that are not there are missing.
        let mut faults = Vec::new();
        for (values, &j) in values.iter_mut().zip(wanted) {
            values.push(match self.number(record.get(j).unwrap_or_default(), line, j) {
                Err(error) if self.is_tolerant && !self.clocks.contains(&j) => {
                    faults.push((j, error));
                    f64::NAN
                }
                number => number?,
            });
        }
        Ok(faults)
    }

    /// Counts the numbers in columns whose first cells are texts.
    fn note_late_numbers(&mut self, record: &csv::ByteRecord, line: u64) {
        let cells = record.iter().zip(&self.table.channels).zip(&mut self.losses.late);
        for ((cell, _), late) in cells.filter(|((_, channel), _)| channel.is_text) {
            let begins = |byte: &u8| byte.is_ascii_digit() || b"+-.".contains(byte);
            if cell.trim_ascii_start().first().is_some_and(begins) && is_number(&text_of(cell)) {
                late.get_or_insert((0, line)).0 += 1;
            }
        }
    }

    /// Whether the row has as many texts as numbers, or more, in the columns of numbers.
    fn is_of_texts(&self, record: &csv::ByteRecord) -> bool {
        let cells = record.iter().zip(&self.table.channels);
        let cells = cells.filter(|(_, channel)| !channel.is_text).map(|(cell, _)| text_of(cell));
        let (mut numbers, mut texts) = (0, 0);
        for cell in cells.filter(|cell| !is_missing(cell)) {
            *(if is_number(&cell) { &mut numbers } else { &mut texts }) += 1;
        }
        texts >= numbers
    }

    /// Whether it is the last row, and a remark or cut within a number.
    fn is_closing(&mut self, record: &csv::ByteRecord) -> bool {
        let is_cut = |cell: &[u8]| {
            let cell = text_of(cell);
            !is_missing(&cell) && !is_number(&cell)
        };
        self.is_at_end()
            && (self.is_of_texts(record)
                || !self.reader.get_ref().ends_line()
                    && record.iter().next_back().is_some_and(is_cut))
    }

    fn number(&mut self, cell: &[u8], line: u64, column: usize) -> Result<f64, Error> {
        if let Some(stamps) = &mut self.stamps[column]
            && let Some(time) = stamps.next_row()
        {
            return Ok(time);
        }
        let text = decoded(cell);
        let text = text.as_ref();
        let typeset = text.strip_prefix('−').map(|number| format!("-{number}"));
        let text = typeset.as_deref().unwrap_or(text);
        let with_comma = self.decimal == Some(DecimalMark::Comma);
        let are_stamps = self.stamps[column].as_ref().is_some_and(Stamps::are_numbers);
        if !are_stamps
            && let Ok(x) = text.parse::<f64>()
            && !(with_comma && text.contains('.'))
        {
            return match x {
                x if x.is_finite() => Ok(x),
                _ if is_missing(text) => Ok(f64::NAN),
                _ => Err(Error::NotFinite { at: self.place(line, column), text: shortened(text) }),
            };
        }
        if let Some(x) = switch(text) {
            return Ok(x);
        }
        if is_missing(text) && cell.is_ascii() {
            return Ok(f64::NAN);
        }
        if let Some(stamps) = &mut self.stamps[column] {
            return stamps.seconds(text).ok_or_else(|| Error::NotATime {
                at: self.place(line, column),
                text: shortened(text),
            });
        }
        if let Some(x) = fortran_number(text).filter(|_| !with_comma) {
            return Ok(x);
        }
        match comma_number(text) {
            Some((x, _)) if with_comma => Ok(x),
            None if !with_comma || text.parse::<f64>().is_err() => {
                let text = shortened(&text_of(cell));
                Err(Error::NotANumber { at: self.place(line, column), text })
            }
            _ => Err(Error::DecimalMark {
                at: self.place(line, column),
                text: shortened(text),
                other: self.decimal.map(DecimalMark::name),
            }),
        }
    }

    fn place(&self, line: u64, column: usize) -> Box<Place> {
        Place::new(&self.table.file, line, &self.table.channels[column].name)
    }
}
