//! Which of the first rows are names, units and values.
//!
//! The values begin at the first row from which most rows have numbers in the same cells. The header is the row of names
//! above it, or the comment above it; text further up is left out and counted.

use super::cells::{bare_unit, is_blank, is_comment, is_comment_record, is_number, line, text_of};
use super::missing::is_missing;
use crate::Error;
use crate::role::Role;
use crate::units::{parse_unit, unit_of_header};
use csv::ByteRecord;
use std::cmp::Ordering;
use std::io::Read;

/// Rows by which the kinds of the columns are determined.
const SAMPLE: usize = 200;

/// The first bytes, with some rows of values if there are any, and how many of them are whole lines.
pub(super) fn start(file: &str, reader: &mut dyn Read) -> Result<(Vec<u8>, usize), Error> {
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

/// The rows above the values.
#[derive(Debug, Default)]
pub(super) struct Header {
    /// The names; `None` of a file without a header.
    pub(super) names: Option<ByteRecord>,
    /// The unit of each column; empty where no row states them.
    pub(super) units: Vec<String>,
    /// Rows of text that are neither.
    pub(super) skipped: usize,
    /// Place of the first row of values among the records.
    pub(super) first: usize,
}

/// Finds the header; `stated` is its line where that is stated. `None` where nothing is at that line.
pub(super) fn find(
    records: &[ByteRecord],
    comments: &[ByteRecord],
    stated: Option<u64>,
) -> Option<Header> {
    let is_row = |record: &ByteRecord| !is_blank(record) && !is_comment_record(record);
    let rows = records.iter().enumerate().filter(|(_, record)| is_row(record));
    let mut rows: Vec<(usize, &ByteRecord)> = rows.collect();
    let mut names = None;
    if let Some(at) = stated {
        let all = rows.iter().map(|(_, row)| *row).chain(comments);
        names = Some(all.into_iter().find(|row| line(row) == at)?);
        rows.retain(|(_, row)| line(row) > at);
    }
    let table = Table::new(rows.iter().map(|(_, row)| *row).collect());
    let width = table.rows.first().map_or(0, |row| row.len());
    let is_named = names.is_some() || comments.iter().any(|comment| comment.len() == width);
    let first = table.first(is_named);
    let above = &table.rows[..first];
    let mut units = None;
    let mut used = 0;
    let place = match names {
        Some(_) => None,
        None => table.names(first),
    };
    if let Some(at) = place {
        names = Some(above[at]);
        used += 1;
    }
    let below = place.map_or(0, |at| at + 1);
    if let Some(row) = above[below..].iter().find(|row| is_unit_row(row)) {
        units = Some(cells_of(row));
        used += 1;
    } else if let Some(row) = above[..below].iter().find(|row| is_labelled_unit_row(row)) {
        units = Some(
            cells_of(row)
                .into_iter()
                .enumerate()
                .map(|(i, c)| if i == 0 { String::new() } else { c })
                .collect(),
        );
        used += 1;
    }
    if names.is_none() {
        let width = table.rows.get(first).map_or(width, |row| row.len());
        let mut alike = comments.iter().rev().filter(|comment| comment.len() == width);
        names = alike.next();
        if let Some(last) = names.filter(|last| is_unit_row(last))
            && let Some(above) = alike.next()
        {
            (names, units) = (Some(above), Some(cells_of(last)));
        }
    }
    Some(Header {
        names: names.cloned(),
        units: units.unwrap_or_default(),
        skipped: first - used,
        first: rows.get(first).map_or(records.len(), |(place, _)| *place),
    })
}

/// The kind of a cell.
#[derive(Clone, Copy, PartialEq)]
enum Kind {
    Number,
    Missing,
    Text,
}

fn kind(cell: &[u8]) -> Kind {
    match text_of(cell) {
        cell if is_missing(&cell) => Kind::Missing,
        cell if is_number(&cell) => Kind::Number,
        _ => Kind::Text,
    }
}

/// The first rows, and the columns that hold numbers further down.
struct Table<'a> {
    rows: Vec<&'a ByteRecord>,
    has_numbers: Vec<bool>,
    /// Numbers in such columns, and cells that are not blank, of most rows further down.
    numbers: usize,
    filled: usize,
}

impl<'a> Table<'a> {
    fn new(rows: Vec<&'a ByteRecord>) -> Self {
        let tail = &rows[rows.len() / 2..];
        let tail = &tail[tail.len().saturating_sub(SAMPLE)..];
        let mut counts: Vec<[usize; 2]> = Vec::new();
        for row in tail {
            counts.resize(counts.len().max(row.len()), [0; 2]);
            for (cell, counts) in row.iter().zip(&mut counts) {
                match kind(cell) {
                    Kind::Number => counts[0] += 1,
                    Kind::Text => counts[1] += 1,
                    Kind::Missing => {}
                }
            }
        }
        let has_numbers = counts.iter().map(|[numbers, texts]| *numbers > 0 && numbers >= texts);
        let mut table =
            Self { has_numbers: has_numbers.collect(), rows: Vec::new(), numbers: 0, filled: 0 };
        let median = |mut counts: Vec<usize>| {
            counts.sort_unstable();
            counts.get(counts.len() / 2).copied().unwrap_or_default()
        };
        table.numbers = median(tail.iter().map(|row| table.count(row)[0]).collect());
        table.filled = median(tail.iter().map(|row| filled(row)).collect());
        table.rows = rows;
        table
    }

    /// Numbers and texts in the columns of numbers.
    fn count(&self, row: &ByteRecord) -> [usize; 2] {
        let mut counts = [0; 2];
        for (cell, _) in row.iter().zip(&self.has_numbers).filter(|(_, has)| **has) {
            match kind(cell) {
                Kind::Number => counts[0] += 1,
                Kind::Text => counts[1] += 1,
                Kind::Missing => {}
            }
        }
        counts
    }

    /// The first row of values; `is_named` where the names are found elsewhere.
    fn first(&self, is_named: bool) -> usize {
        if !self.has_numbers.contains(&true) {
            return usize::from(!is_named).min(self.rows.len());
        }
        let is_full = |row: &&ByteRecord| {
            let [numbers, texts] = self.count(row);
            numbers > 0 && texts == 0 && 2 * numbers >= self.numbers
        };
        let anchor = self.rows.iter().position(is_full);
        let mut first = anchor.unwrap_or_else(|| usize::from(!is_named).min(self.rows.len()));
        // Sensors that start late, and bad cells.
        while first > 0 {
            let row = self.rows[first - 1];
            let [numbers, texts] = self.count(row);
            let has_bad_cells = numbers > texts && (first > 1 || is_named) && !is_unit_row(row);
            if numbers == 0 || texts > 0 && !has_bad_cells {
                break;
            }
            first -= 1;
        }
        first
    }

    /// The row of names above the first row of values: the nearest that is neither units nor sources.
    fn names(&self, first: usize) -> Option<usize> {
        if !self.has_numbers.contains(&true) {
            return (first > 0).then_some(0);
        }
        let mut names: Option<usize> = None;
        for at in (0..first).rev() {
            let row = self.rows[at];
            let own = filled(row);
            let texts = row.iter().filter(|cell| kind(cell) == Kind::Text).count();
            let is_candidate =
                2 * own >= self.filled && 2 * texts >= own && (own > 1 || self.filled < 2);
            let Some(below) = names else {
                if is_candidate {
                    names = Some(at);
                }
                continue;
            };
            // A line without text ends the header.
            if !is_candidate || line(self.rows[at + 1]) > end(row) + 1 {
                break;
            }
            let below = self.rows[below];
            let is_of_units = is_unit_row(below) || has_repeats(below) && !has_repeats(row);
            let is_fuller = filled(below) < own || is_of_units && own + 1 >= filled(below);
            match known(row).cmp(&known(below)) {
                Ordering::Greater => names = Some(at),
                Ordering::Equal if is_fuller => names = Some(at),
                _ => {}
            }
        }
        names
    }
}

/// Cells that are named like a quantity of a vehicle or end in a unit.
fn known(row: &ByteRecord) -> usize {
    let roles = || Role::OF_CHANNELS.into_iter().chain([Role::Time]);
    let is_known = |cell: &String| {
        unit_of_header(cell).is_some() || roles().any(|role| role.is_named_like(cell))
    };
    cells_of(row).iter().filter(|cell| is_known(cell)).count()
}

/// The last line of a row.
fn end(row: &ByteRecord) -> u64 {
    line(row) + row.as_slice().iter().filter(|b| **b == b'\n').count() as u64
}

fn filled(row: &ByteRecord) -> usize {
    row.iter().filter(|cell| !cell.trim_ascii().is_empty()).count()
}

fn has_repeats(row: &ByteRecord) -> bool {
    let mut cells: Vec<&[u8]> = row.iter().filter(|cell| !cell.trim_ascii().is_empty()).collect();
    let all = cells.len();
    cells.sort_unstable();
    cells.dedup();
    cells.len() < all
}

fn cells_of(row: &ByteRecord) -> Vec<String> {
    row.iter().map(text_of).collect()
}

/// A row without a number in which a cell is a unit.
fn is_unit_row(row: &ByteRecord) -> bool {
    let cells = cells_of(row);
    !cells.iter().any(|cell| cell != "1" && !cell.is_empty() && is_number(cell))
        && cells.iter().any(|cell| cell != "1" && parse_unit(bare_unit(cell)).is_some())
}

/// A row such as `Y_Unit_Label,deg,deg/s`.
fn is_labelled_unit_row(row: &ByteRecord) -> bool {
    let mut cells = row.iter().map(text_of);
    let label = cells.next().unwrap_or_default().to_lowercase();
    label.contains("unit") && cells.any(|cell| parse_unit(bare_unit(&cell)).is_some())
}
