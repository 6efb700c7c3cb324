//! The top of a text file: encoding, delimiter, decimal mark, header, and a row of units under it.
//!
//! What the first rows leave open is refused where it matters.

use super::comments::WithoutComments;
use super::missing::{is_missing, is_spreadsheet_error};
use super::stamps::Stamps;
use crate::Error;
use crate::options::DecimalMark;
use crate::units::parse_unit;

/// Delimiters, the preferred one last.
const DELIMITERS: [u8; 3] = [b',', b'\t', b';'];
/// What begins a line that is a comment.
const COMMENTS: [&[u8]; 3] = [b"#", b"//", b"%"];
/// Rows that delimiter and decimal mark are determined from.
const SAMPLE: usize = 200;

/// The format of a file, from its first rows.
#[derive(Debug)]
pub(super) struct Head {
    pub(super) delimiter: u8,
    /// `None` where the first rows have neither mark, or where groups of three digits leave it open.
    pub(super) decimal: Option<DecimalMark>,
    pub(super) header: Vec<String>,
    pub(super) header_line: u64,
    /// The unit of each column from the row under the header; empty where there is no such row.
    pub(super) units: Vec<String>,
    pub(super) stamps: Vec<Option<Stamps>>,
    /// Columns whose first cells are all texts.
    pub(super) are_texts: Vec<bool>,
    /// Records from the file's start to the first row of values.
    pub(super) records: usize,
}

impl Head {
    /// Of a file that starts with these bytes, which end with a whole line.
    pub(super) fn of(file: &str, start: &[u8]) -> Result<Self, Error> {
        check_encoding(file, start)?;
        let text = start.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(start);
        let mut lines = text.split(|b| *b == b'\n').map(<[u8]>::trim_ascii);
        let Some(first) = lines.clone().find(|line| !line.is_empty()) else {
            return Err(Error::EmptyFile { file: file.into() });
        };
        if first.starts_with(b"{") {
            return Err(Error::Json { file: file.into() });
        }
        let delimiter = stated_delimiter(first).unwrap_or_else(|| {
            let lines = lines.by_ref().filter(|l| !l.is_empty() && !is_comment(l));
            delimiter_of(&lines.take(SAMPLE).collect::<Vec<_>>())
        });
        let mut rows = Records::new(start, delimiter);
        let Some((names, header_line)) = rows.names_and_units() else {
            return Err(Error::EmptyFile { file: file.into() });
        };
        let records = rows.read - usize::from(rows.held.is_some());
        let mut names = names.iter().map(|row| row.iter().map(text_of).collect::<Vec<_>>());
        let (mut header, units) =
            (names.next().unwrap_or_default(), names.next().unwrap_or_default());
        for (i, name) in header.iter_mut().enumerate() {
            // Such as the index of a table that pandas wrote.
            if name.is_empty() {
                *name = format!("column {}", i + 1);
            }
        }
        let mut marks = Marks::default();
        let mut stamps: Vec<Option<Option<Stamps>>> = vec![None; header.len()];
        let mut cells = vec![(0, 0); header.len()];
        for _ in 0..SAMPLE {
            let Some(row) = rows.next() else { break };
            for ((cell, stamps), (all, texts)) in row.iter().zip(&mut stamps).zip(&mut cells) {
                let cell = std::str::from_utf8(cell).unwrap_or_default().trim();
                marks.note(cell);
                if is_missing(cell) {
                    continue;
                }
                if stamps.is_none() {
                    *stamps = Some(Stamps::like(cell));
                }
                *all += 1;
                // `1.234,5` and `12:00` are faults of a number.
                let begins_number = |c: char| c.is_ascii_digit() || "+-−.,".contains(c);
                let is_text = !is_value(cell) && switch(cell).is_none();
                *texts += u32::from(is_text && !cell.starts_with(begins_number));
            }
        }
        Ok(Self {
            delimiter,
            decimal: marks.decide(),
            header,
            header_line,
            units,
            stamps: stamps.into_iter().map(Option::flatten).collect(),
            are_texts: cells.into_iter().map(|(all, texts)| all > 0 && texts == all).collect(),
            records,
        })
    }
}

/// Whether the line is a comment.
pub(super) fn is_comment(line: &[u8]) -> bool {
    let line = line.trim_ascii_start();
    let end = line.iter().position(|b| DELIMITERS.contains(b));
    let first = &line[..end.unwrap_or(line.len())];
    let is_cell = is_spreadsheet_error(first) || end.is_some() && first.trim_ascii_end() == b"%";
    !is_cell && COMMENTS.iter().any(|comment| line.starts_with(comment))
}

/// Whether the record is a comment, such as one in quotes.
pub(super) fn is_comment_record(record: &csv::ByteRecord) -> bool {
    is_comment(&record[0]) && !(record.len() > 1 && record[0].trim_ascii() == b"%")
}

/// The number of a cell that is true or false.
pub(super) fn switch(cell: &str) -> Option<f64> {
    let is = |word: &str| cell.eq_ignore_ascii_case(word);
    if is("true") { Some(1.0) } else { is("false").then_some(0.0) }
}

/// The text of a cell: UTF-8, else Latin 1, in which `°` and `ä` are a byte each.
pub(super) fn text_of(bytes: &[u8]) -> String {
    let text = std::str::from_utf8(bytes)
        .map_or_else(|_| bytes.iter().map(|b| char::from(*b)).collect(), ToOwned::to_owned);
    text.trim().to_owned()
}

/// UTF-16 has a mark at its start, or a zero in every other byte.
fn check_encoding(file: &str, start: &[u8]) -> Result<(), Error> {
    let marked = start.starts_with(b"\xFF\xFE") || start.starts_with(b"\xFE\xFF");
    let sample = &start[..start.len().min(64)];
    let zeros = |odd: usize| {
        let mut every_other = sample.iter().skip(odd).step_by(2);
        sample.len() >= 8 && every_other.all(|b| *b == 0)
    };
    if marked || zeros(0) != zeros(1) {
        return Err(Error::Utf16 { file: file.into() });
    }
    Ok(())
}

/// The delimiter of a line `sep=;`, which Excel writes and reads.
fn stated_delimiter(line: &[u8]) -> Option<u8> {
    let line = line.strip_prefix(b"\"").unwrap_or(line);
    let line = line.strip_suffix(b"\"").unwrap_or(line);
    // A tab at the end has been trimmed.
    let (key, rest) = line.split_at_checked(4)?;
    match rest {
        _ if !key.eq_ignore_ascii_case(b"sep=") => None,
        [] => Some(b'\t'),
        [delimiter] => Some(*delimiter),
        _ => None,
    }
}

/// The delimiter by which most rows have as many cells as the header; of several, the preferred one.
fn delimiter_of(lines: &[&[u8]]) -> u8 {
    let Some((header, rows)) = lines.split_first() else { return b',' };
    let score = |delimiter: u8| {
        let cells = cells(header, delimiter);
        let alike = rows.iter().filter(|row| self::cells(row, delimiter) == cells).count();
        (cells > 1).then_some(alike)
    };
    DELIMITERS.into_iter().max_by_key(|d| score(*d)).unwrap_or(b',')
}

/// Cells of a line, delimiters in quotes apart.
fn cells(line: &[u8], delimiter: u8) -> usize {
    let mut quoted = false;
    let mut cells = 1;
    for b in line {
        quoted ^= *b == b'"';
        cells += usize::from(!quoted && *b == delimiter);
    }
    cells
}

/// A row without a number in which a cell is a unit.
fn is_unit_row(row: &csv::ByteRecord) -> bool {
    let cells: Vec<String> = row.iter().map(text_of).collect();
    let is_value = |cell: &String| cell != "1" && is_value(cell);
    !cells.iter().any(is_value)
        && cells.iter().any(|cell| cell != "1" && parse_unit(bare_unit(cell)).is_some())
}

/// A unit without the brackets that may enclose it.
pub(super) fn bare_unit(text: &str) -> &str {
    let inner = |open, close| text.strip_prefix(open)?.strip_suffix(close);
    inner('[', ']').or_else(|| inner('(', ')')).unwrap_or(text).trim()
}

fn is_value(cell: &str) -> bool {
    cell.parse::<f64>().is_ok() || comma_number(cell).is_some() || Stamps::like(cell).is_some()
}

/// The number of a cell with a decimal comma, and whether the comma may set off three digits instead.
pub(super) fn comma_number(cell: &str) -> Option<(f64, bool)> {
    let (whole, part) = cell.split_once(',')?;
    if cell.contains('.') || part.contains(',') || !part.starts_with(|c: char| c.is_ascii_digit()) {
        return None;
    }
    let number = format!("{whole}.{part}").parse().ok()?;
    let digits = whole.trim_start_matches(['+', '-']);
    let group = part.len() == 3 && part.bytes().all(|b| b.is_ascii_digit());
    let leads = (1..=3).contains(&digits.len()) && !digits.starts_with('0');
    Some((number, group && leads))
}

/// Decimal marks that were seen.
#[derive(Default)]
struct Marks {
    point: bool,
    comma: bool,
}

impl Marks {
    fn note(&mut self, cell: &str) {
        if cell.contains('.') {
            self.point |= cell.parse::<f64>().is_ok();
        } else if let Some((_, is_open)) = comma_number(cell) {
            self.comma |= !is_open;
        }
    }

    fn decide(&self) -> Option<DecimalMark> {
        match (self.point, self.comma) {
            (true, false) => Some(DecimalMark::Point),
            (false, true) => Some(DecimalMark::Comma),
            _ => None,
        }
    }
}

struct Records<'a> {
    reader: csv::Reader<WithoutComments<&'a [u8]>>,
    /// Records read so far, blank ones among them.
    read: usize,
    /// Where comments name the columns: the row of values that showed it.
    held: Option<csv::ByteRecord>,
    comments: Vec<csv::ByteRecord>,
}

/// The cells of each comment above the first row; a quote that is open at its end closes there.
fn comments_above(start: &[u8], delimiter: u8) -> Vec<csv::ByteRecord> {
    let text = start.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(start);
    let lines = text.split(|b| *b == b'\n').zip(1..);
    let parts = lines.flat_map(|(line, n)| line.split(|b| *b == b'\r').map(move |part| (part, n)));
    let above = parts
        .filter(|(part, _)| !part.trim_ascii().is_empty())
        .filter(|(part, _)| stated_delimiter(part.trim_ascii()).is_none())
        .take_while(|(part, _)| is_comment(part));
    let cells = |(part, n): (&[u8], u64)| {
        let mut record = reader_of(delimiter).from_reader(part).into_byte_records().next()?.ok()?;
        let mut position = csv::Position::new();
        position.set_line(n);
        record.set_position(Some(position));
        Some(record)
    };
    above.filter_map(cells).collect()
}

impl<'a> Records<'a> {
    fn new(start: &'a [u8], delimiter: u8) -> Self {
        let reader = reader_of(delimiter).from_reader(WithoutComments::new(start, delimiter));
        Self { reader, read: 0, held: None, comments: comments_above(start, delimiter) }
    }

    fn record(&mut self) -> Option<csv::ByteRecord> {
        let mut record = csv::ByteRecord::new();
        // What cannot be read here is reported when the rows are.
        let is_there = self.reader.read_byte_record(&mut record).is_ok_and(|there| there);
        self.read += usize::from(is_there);
        is_there.then_some(record)
    }

    fn next(&mut self) -> Option<csv::ByteRecord> {
        loop {
            let record = match self.held.take() {
                Some(held) => held,
                None => self.record()?,
            };
            if !is_blank(&record) && !is_comment(&record[0]) {
                return Some(record);
            }
        }
    }

    /// The rows above the values, with the header's line: the first record, or the comments above it.
    fn names_and_units(&mut self) -> Option<(Vec<csv::ByteRecord>, u64)> {
        let mut comments = std::mem::take(&mut self.comments);
        let first = loop {
            let record = self.record()?;
            if is_blank(&record) || is_separator(&record) {
                continue;
            }
            if !is_comment(&record[0]) {
                break record;
            }
            comments.push(record);
        };
        comments.retain(|comment| comment.len() == first.len());
        let cells: Vec<String> = first.iter().map(text_of).collect();
        let mut values = cells.iter().filter(|c| !is_missing(c)).peekable();
        let is_values = values.peek().is_some() && values.all(|c| is_value(c));
        if let Some(last) = comments.pop().filter(|_| is_values) {
            self.held = Some(first);
            let last = uncommented(&last);
            let rows = match comments.pop().filter(|_| is_unit_row(&last)) {
                Some(names) => vec![uncommented(&names), last],
                None => vec![last],
            };
            let line = line(&rows[0]);
            return Some((rows, line));
        }
        let line = line(&first);
        let mut rows = vec![first];
        match self.next() {
            Some(row) if is_unit_row(&row) => rows.push(row),
            row => self.held = row,
        }
        Some((rows, line))
    }
}

/// A reader of rows of any length.
pub(super) fn reader_of(delimiter: u8) -> csv::ReaderBuilder {
    let mut builder = csv::ReaderBuilder::new();
    builder.has_headers(false).flexible(true).delimiter(delimiter);
    builder
}

/// A comment's cells without what makes it one.
fn uncommented(record: &csv::ByteRecord) -> csv::ByteRecord {
    let bare = |cell: &[u8]| {
        let cell = cell.trim_ascii_start();
        let marks = cell.iter().take_while(|b| b"#/%".contains(b)).count();
        cell[marks..].to_vec()
    };
    let cells = record.iter().enumerate();
    let mut new: csv::ByteRecord =
        cells.map(|(i, cell)| if i == 0 { bare(cell) } else { cell.to_vec() }).collect();
    new.set_position(record.position().cloned());
    new
}

pub(super) fn is_blank(record: &csv::ByteRecord) -> bool {
    record.iter().all(|c| c.trim_ascii().is_empty())
}

/// Whether the record is the line `sep=;`, which its own delimiter splits.
fn is_separator(record: &csv::ByteRecord) -> bool {
    let rest_is_blank = record.iter().skip(1).all(|c| c.trim_ascii().is_empty());
    rest_is_blank && stated_delimiter(record[0].trim_ascii()).is_some()
}

pub(super) fn line(record: &csv::ByteRecord) -> u64 {
    record.position().map_or(1, csv::Position::line)
}
