//! The top of a text file: encoding, delimiter, decimal mark, header, and a row of units under it.
//!
//! What the first rows leave open is refused where it matters.

use super::cells::{
    DELIMITERS, comma_number, decoded, fortran_number, is_blank, is_comment, is_comment_record,
    is_number, is_value, joined, line, set_line, switch, text_of,
};
use super::comments::WithoutComments;
use super::header;
use super::missing::is_missing;
use super::stamps::Stamps;
use crate::Error;
use crate::options::DecimalMark;
use crate::role::Role;
use crate::units::unit_of_header;
use std::collections::HashSet;
use std::io::Read;

/// Rows that delimiter and decimal mark are determined from.
const SAMPLE: usize = 200;

/// The format of a file, from its first rows.
#[derive(Debug)]
pub(super) struct Head {
    pub(super) delimiter: u8,
    /// `None` where the first rows have neither mark, or where groups of three digits leave it open.
    pub(super) decimal: Option<DecimalMark>,
    pub(super) header: Vec<String>,
    /// 0 of a file without a header.
    pub(super) header_line: u64,
    pub(super) has_names: bool,
    /// Rows of text above the values that are neither names nor units.
    pub(super) skipped: usize,
    /// All rows above the values, blanks between their cells; blank lines are empty.
    pub(super) text: Vec<String>,
    /// The unit of each column from the row under the header; empty where there is no such row.
    pub(super) units: Vec<String>,
    pub(super) stamps: Vec<Option<Stamps>>,
    /// Columns whose cells are all texts, as far as they were looked at.
    pub(super) are_texts: Vec<bool>,
    /// The first cell that is neither a number nor a time, of columns of which most are so, and its line.
    pub(super) unread: Vec<Option<(u64, String)>>,
    /// Columns without a value, as far as they were looked at.
    pub(super) are_empty: Vec<bool>,
    /// Records from the file's start to the first row of values.
    pub(super) records: usize,
}

impl Head {
    /// Of a file that starts with these bytes, which end with a whole line.
    /// `stated` is the line of the header, where that is stated.
    pub(super) fn read(file: &str, start: &[u8], stated: Option<u64>) -> Result<Self, Error> {
        check_encoding(file, start)?;
        let text = start.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(start);
        let mut lines = text.split(|b| b"\r\n".contains(b)).map(<[u8]>::trim_ascii);
        let Some(first) = lines.clone().find(|line| !line.is_empty()) else {
            return Err(Error::EmptyFile { file: file.into() });
        };
        if first.starts_with(b"{") {
            return Err(Error::Json { file: file.into() });
        }
        let delimiter = stated_delimiter(first).unwrap_or_else(|| {
            let lines = lines.by_ref().filter(|l| !l.is_empty() && !is_comment(l));
            delimiter_of(&lines.collect::<Vec<_>>())
        });
        let mut records = records(start, delimiter);
        let lead = records.iter().take_while(|r| is_blank(r) || is_separator(r)).count();
        let rows = records.split_off(lead);
        let top = rows.iter().find(|row| !is_comment_record(row));
        let Some(top) = top else {
            let file = file.into();
            let is_text = !start.contains(&0);
            return Err(if is_text {
                Error::EmptyFile { file }
            } else {
                Error::NotText { file, line: 1 }
            });
        };
        let quoted = rows.iter().take_while(|row| is_blank(row) || is_comment_record(row));
        let quoted: Vec<csv::ByteRecord> = quoted.map(uncommented).collect();
        let of_text = |last| [comments_above(start, delimiter, last), quoted.clone()].concat();
        // Comments between the rows of text and the values name the columns, too.
        let found = header::find(&rows, &of_text(line(top)), stated).and_then(|above| {
            let last = rows.get(above.first).map_or(u64::MAX, line);
            header::find(&rows, &of_text(last), stated)
        });
        let Some(above) = found else {
            let value = stated.unwrap_or_default().to_string();
            let expected = format!("a line with text above the values of {file}");
            return Err(Error::Option { option: "header line", value, expected });
        };
        let values = &rows[above.first..];
        let header_line = above.names.as_ref().map_or(0, line);
        let width = || values.iter().take(SAMPLE).map(csv::ByteRecord::len).max().unwrap_or(0);
        let has_names = above.names.is_some();
        let mut header: Vec<String> = match &above.names {
            Some(names) => names.iter().map(text_of).collect(),
            None => vec![String::new(); width()],
        };
        for (i, name) in header.iter_mut().enumerate() {
            // Such as the index of a table that pandas wrote.
            if name.is_empty() {
                *name = format!("column_{}", i + 1);
            }
        }
        let mut marks = Marks::default();
        let mut stamps: Vec<Option<Option<Stamps>>> = vec![None; header.len()];
        let mut cells = vec![(0, 0); header.len()];
        let mut odd: Vec<(u32, Option<(u64, String)>)> = vec![(0, None); header.len()];
        let mut numbers: Vec<Option<Vec<f64>>> = (0..header.len())
            .map(|i| {
                let unit = above.units.get(i).is_none_or(String::is_empty);
                if unit && is_named_like_a_date(&header[i]) { Some(Vec::new()) } else { None }
            })
            .collect();
        let top: HashSet<Vec<u8>> = rows[..above.first].iter().map(joined).collect();
        let is_sample = |row: &&csv::ByteRecord| {
            !is_blank(row) && !is_comment_record(row) && !top.contains(&joined(row))
        };
        let samples = values.iter().filter(is_sample);
        for (place, row) in samples.enumerate() {
            for (i, ((cell, stamps), (all, texts))) in
                row.iter().zip(&mut stamps).zip(&mut cells).enumerate()
            {
                // A column of texts or without values so far may have numbers further down.
                if place >= SAMPLE && *texts < *all {
                    continue;
                }
                let cell = decoded(cell);
                let cell = cell.as_ref();
                if place < SAMPLE {
                    marks.note(cell);
                }
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
                if is_text {
                    odd[i].0 += 1;
                    odd[i].1.get_or_insert_with(|| (line(row), cell.to_owned()));
                }
                if let Some(numbers) = &mut numbers[i] {
                    numbers.extend(cell.replace(',', ".").parse::<f64>());
                }
            }
        }
        let mut stamps: Vec<Option<Stamps>> = stamps.into_iter().map(Option::flatten).collect();
        for (stamps, numbers) in stamps.iter_mut().zip(numbers) {
            if stamps.is_none() {
                *stamps = Stamps::of_serial_days(&numbers.unwrap_or_default());
            }
        }
        Ok(Self {
            delimiter,
            decimal: marks.decide(),
            header,
            header_line,
            has_names,
            skipped: above.skipped,
            text: text_above(&rows, above.first),
            units: above.units,
            stamps,
            unread: odd
                .into_iter()
                .zip(&cells)
                .map(|((count, first), (all, _))| first.filter(|_| 2 * count > *all))
                .collect(),
            are_empty: cells.iter().map(|(all, _)| *all == 0).collect(),
            are_texts: cells.into_iter().map(|(all, texts)| all > 0 && texts == all).collect(),
            records: lead + above.first,
        })
    }
}

/// Whether a column has the name of an instant, and no unit in it.
fn is_named_like_a_date(name: &str) -> bool {
    let plain = name.trim_start_matches(['#', '%', '/', ' ']).to_lowercase();
    let is_date = ["date", "datum", "fecha"].into_iter().any(|word| plain.starts_with(word));
    (is_date || Role::Time.is_named_like(name)) && unit_of_header(name).is_none()
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

/// The delimiter that a line of names has, too, and by which the rows have most numbers, or else by which most have as
/// many cells; of several, the preferred one. Blanks delimit only where no other delimiter makes a table of numbers.
fn delimiter_of(lines: &[&[u8]]) -> u8 {
    let others = DELIMITERS.into_iter().filter(|delimiter| *delimiter != b' ');
    let best = others.filter_map(|d| Some((Score::new(lines, d)?, d))).max_by_key(|(s, _)| s.rank);
    let blanks = Score::new(lines, b' ').filter(|score| score.rank.1 > 0);
    match (best, blanks) {
        (Some((best, delimiter)), Some(blanks)) => {
            let has_more = match best.columns {
                0 | 1 => blanks.rank > best.rank,
                _ => blanks.rank.0 >= best.rank.0 && blanks.is_of_values && !best.is_of_values,
            };
            if has_more { b' ' } else { delimiter }
        }
        (Some((_, delimiter)), None) => delimiter,
        (None, blanks) => blanks.map_or(b',', |_| b' '),
    }
}

/// How well a delimiter splits the lines.
struct Score {
    /// Whether a line of names is as wide as the rows; numbers; rows of this width.
    rank: (bool, usize, usize),
    /// Columns that hold numbers.
    columns: usize,
    /// Whether each cell is a number without groups of digits, or missing.
    is_of_values: bool,
}

impl Score {
    /// `None` where the delimiter splits few lines.
    fn new(lines: &[&[u8]], delimiter: u8) -> Option<Self> {
        // Above may be a text.
        let tail = &lines[lines.len() / 2..];
        let tail = &tail[tail.len().saturating_sub(SAMPLE)..];
        let rows: Vec<Vec<&[u8]>> = tail.iter().map(|line| split(line, delimiter)).collect();
        let mut widths: Vec<usize> = rows.iter().map(Vec::len).collect();
        widths.sort_unstable();
        let width = widths.get(widths.len() / 2).copied().filter(|width| *width > 1)?;
        let alike = rows.iter().filter(|row| row.len() == width).count();
        let mut counts = vec![0; width];
        let (mut numbers, mut is_of_values) = (0, true);
        for row in &rows {
            for (i, cell) in row.iter().enumerate() {
                let cell = unquoted(cell);
                let is_number = is_number(&cell);
                numbers += usize::from(is_number);
                is_of_values &= is_value(&cell) || switch(&cell).is_some() || is_missing(&cell);
                if let Some(count) = counts.get_mut(i) {
                    *count += usize::from(is_number);
                }
            }
        }
        let is_of_names = |line: &&[u8]| {
            let cells = split(line, delimiter);
            let texts = || cells.iter().map(|cell| unquoted(cell)).filter(|cell| !cell.is_empty());
            cells.len() == width && texts().count() > 1 && !texts().any(|cell| is_number(&cell))
        };
        let has_names = lines.iter().any(is_of_names);
        let columns = counts.iter().filter(|count| 2 * **count >= rows.len()).count();
        Some(Self { rank: (has_names, numbers, alike), columns, is_of_values })
    }
}

/// The cells of a line; delimiters in quotes are none, and a run of blanks is one.
pub(super) fn split(line: &[u8], delimiter: u8) -> Vec<&[u8]> {
    let mut is_quoted = false;
    let is_blank = delimiter == b' ';
    let cells = line.split(|b| {
        is_quoted ^= *b == b'"';
        !is_quoted && (*b == delimiter || is_blank && *b == b'\t')
    });
    cells.filter(|cell| !is_blank || !cell.is_empty()).collect()
}

fn unquoted(cell: &[u8]) -> String {
    text_of(cell).trim_matches('"').trim().to_owned()
}

/// The rows above the first row of values.
fn text_above(rows: &[csv::ByteRecord], first: usize) -> Vec<String> {
    let mut text = Vec::new();
    let mut next = rows.first().map_or(1, line);
    for row in &rows[..first] {
        text.extend((next..line(row)).map(|_| String::new()));
        text.push(row.iter().map(text_of).collect::<Vec<_>>().join(" "));
        next = line(row) + 1;
    }
    text
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
            self.point |= cell.parse::<f64>().is_ok() || fortran_number(cell).is_some();
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

/// The first records at their lines, comments apart.
fn records(start: &[u8], delimiter: u8) -> Vec<csv::ByteRecord> {
    let mut text = Vec::new();
    let mut reader = WithoutComments::new(start, delimiter);
    // Bytes in memory are read without an error.
    let _ = reader.read_to_end(&mut text);
    // What cannot be read here is reported when the rows are.
    let records = reader_of(delimiter).from_reader(&text[..]).into_byte_records();
    let at_its_line = |mut record: csv::ByteRecord| {
        let byte = record.position().map_or(0, csv::Position::byte);
        set_line(&mut record, reader.line_at(byte).unwrap_or(1));
        record
    };
    records.map_while(Result::ok).map(at_its_line).collect()
}

/// The lines of a text with their numbers, whatever ends them.
fn lines(text: &[u8]) -> impl Iterator<Item = (&[u8], u64)> {
    let (mut number, mut is_return) = (0, false);
    text.split_inclusive(|b| b"\r\n".contains(b)).filter_map(move |line| {
        let is_rest = is_return && line == b"\n";
        is_return = line.ends_with(b"\r");
        if is_rest {
            return None;
        }
        number += 1;
        Some((line, number))
    })
}

/// The cells of each comment above a line, without its marks.
fn comments_above(start: &[u8], delimiter: u8, last: u64) -> Vec<csv::ByteRecord> {
    let text = start.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(start);
    let mut comments = Vec::new();
    let mut is_top = true;
    for (part, n) in lines(text).filter(|(part, _)| !part.trim_ascii().is_empty()) {
        is_top &= is_comment(part) || stated_delimiter(part.trim_ascii()).is_some();
        if !is_top && n >= last {
            break;
        }
        if is_comment(part) {
            let cells = split(bare(part), delimiter).into_iter().map(unquoted);
            comments.push(at_line(cells.collect::<Vec<_>>().into(), n));
        }
    }
    comments
}

/// A comment without its marks.
fn bare(text: &[u8]) -> &[u8] {
    let text = text.trim_ascii_start();
    let marks = text.iter().take_while(|b| b"#/%".contains(b)).count();
    &text[marks..]
}

fn at_line(mut record: csv::ByteRecord, line: u64) -> csv::ByteRecord {
    set_line(&mut record, line);
    record
}

/// A reader of rows of any length.
pub(super) fn reader_of(delimiter: u8) -> csv::ReaderBuilder {
    let mut builder = csv::ReaderBuilder::new();
    builder.has_headers(false).flexible(true).delimiter(delimiter);
    builder
}

/// A comment's cells without what makes it one.
fn uncommented(record: &csv::ByteRecord) -> csv::ByteRecord {
    let cells = record.iter().enumerate();
    let new: csv::ByteRecord =
        cells.map(|(i, cell)| if i == 0 { bare(cell) } else { cell }).collect();
    at_line(new, line(record))
}

/// Whether the record is the line `sep=;`, which its own delimiter splits.
fn is_separator(record: &csv::ByteRecord) -> bool {
    let rest_is_blank = record.iter().skip(1).all(|c| c.trim_ascii().is_empty());
    rest_is_blank && stated_delimiter(record[0].trim_ascii()).is_some()
}
