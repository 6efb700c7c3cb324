//! Which of the first rows are names, units and values.
//!
//! The values begin at the first row from which most rows have numbers in the same cells. The header is the row of names
//! above it, or the comment above it; text further up is left out and counted.

use super::cells::{
    DELIMITERS, bare_unit, is_blank, is_comment, is_comment_record, is_number, line, text_of,
};
use super::missing::is_missing;
use crate::Error;
use crate::names::Name;
use crate::role::Role;
use crate::units::{parse_unit, unit_of_header};
use csv::ByteRecord;
use std::cmp::Ordering;
use std::io::Read;

/// Rows by which the kinds of the columns are determined.
const SAMPLE: usize = 200;

/// The first bytes, with some rows of values and the stated line if there are any, and how many of them are whole lines.
pub(super) fn start(
    file: &str,
    reader: &mut dyn Read,
    stated: Option<u64>,
) -> Result<(Vec<u8>, usize), Error> {
    const CHUNK: usize = 1 << 16;
    const LINES: usize = 4;
    const LAST: usize = 32;
    const MOST: usize = 1 << 24;
    let mut bytes = Vec::new();
    let mut ends = 0;
    loop {
        let before = bytes.len();
        // Twice as many each time, so that a long text is looked at in time linear in its length.
        let chunk = before.max(CHUNK);
        reader.take(chunk as u64).read_to_end(&mut bytes).map_err(|e| Error::Csv {
            file: file.into(),
            line: 1,
            problem: e.to_string(),
        })?;
        let is_whole = bytes.len() < before + chunk;
        // No text, or no end of a line in sight.
        if is_whole || bytes[before..].contains(&0) || bytes.len() > MOST {
            let length = bytes.len();
            return Ok((bytes, length));
        }
        ends += bytes[before..].iter().filter(|b| **b == b'\n').count() as u64;
        // The last line may be cut.
        let lines = bytes.rsplit(|b| *b == b'\n').skip(1).map(<[u8]>::trim_ascii);
        let lines = lines.filter(|line| !line.is_empty() && !is_comment(line)).take(LAST);
        let values = lines.filter(|line| is_of_values(line)).count();
        if values >= LINES && stated.is_none_or(|line| line + (LINES as u64) < ends) {
            let end = bytes.iter().rposition(|b| *b == b'\n').map_or(0, |at| at + 1);
            return Ok((bytes, end));
        }
    }
}

/// Whether the line has numbers, whatever delimits them.
fn is_of_values(line: &[u8]) -> bool {
    let cells = line.split(|b| DELIMITERS.contains(b)).filter(|cell| !cell.is_empty());
    let are_numbers: Vec<bool> =
        cells.map(|cell| is_number(text_of(cell).trim_matches('"'))).collect();
    let numbers = are_numbers.iter().filter(|is_number| **is_number).count();
    numbers == are_numbers.len() || numbers > 1 && 4 * numbers >= are_numbers.len()
}

/// The rows above the values.
#[derive(Debug, Default)]
pub(super) struct Header {
    /// The names; `None` of a file without a header.
    pub(super) names: Option<ByteRecord>,
    /// The unit of each column; empty where no row states them.
    pub(super) units: Vec<String>,
    /// Rows above the values that are neither.
    pub(super) skipped: usize,
    /// Place of the first row of values among the records.
    pub(super) first: usize,
}

/// Finds the header; `stated` is its line where that is stated. `None` where no text is at that line.
pub(super) fn find(
    records: &[ByteRecord],
    comments: &[ByteRecord],
    stated: Option<u64>,
) -> Option<Header> {
    let is_row = |record: &ByteRecord| !is_blank(record) && !is_comment_record(record);
    let rows = records.iter().enumerate().filter(|(_, record)| is_row(record));
    let mut rows: Vec<(usize, &ByteRecord)> = rows.collect();
    let (mut names, mut skipped) = (None, 0);
    if let Some(at) = stated {
        let mut all = rows.iter().map(|(_, row)| *row).chain(comments);
        let has_text = |row: &&ByteRecord| row.iter().any(|cell| kind(cell) == CellKind::Text);
        names = Some(all.find(|row| line(row) == at).filter(has_text)?);
        skipped = rows.iter().filter(|(_, row)| line(row) < at).count();
        rows.retain(|(_, row)| line(row) > at);
    }
    let table = Table::new(rows.iter().map(|(_, row)| *row).collect());
    let width = table.rows.first().map_or(0, |row| row.len());
    let is_named = names.is_some() || comments.iter().any(|comment| comment.len() == width);
    let mut first = table.first(is_named);
    let mut units = None;
    let mut used = 0;
    let place = match names {
        Some(_) => None,
        None => table.names(first),
    };
    if place.is_some() || is_named {
        first = table.first_below(place.map_or(0, |at| at + 1), first);
    }
    let above = &table.rows[..first];
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
    // pandas labels a row of units, and names the index in a row of its own above the values.
    if let Some(label) = units.as_mut().and_then(|units| units.first_mut())
        && ["unit", "units", "einheit", "einheiten"].contains(&&*label.to_lowercase())
    {
        label.clear();
    }
    let mut names = names.cloned();
    if let (Some(at), Some(own)) = (place, &mut names)
        && let Some(index) = above.last().filter(|_| first > at + 1)
        && filled(index) == 1
        && index.len() == own.len()
        && !is_unit_row(index)
        && known(index) == 1
    {
        let cells = std::iter::once(&index[0]).chain(own.iter().skip(1));
        let mut named: ByteRecord = cells.collect();
        named.set_position(own.position().cloned());
        *own = named;
        used += 1;
    }
    Some(Header {
        names: names.map(|names| with_row_names(names, &table.rows[first..])),
        units: units.unwrap_or_default(),
        skipped: skipped + first - used,
        first: rows.get(first).map_or(records.len(), |(place, _)| *place),
    })
}

/// The names with a blank one for the names of the rows, which have none where R writes a table: all rows have one more
/// cell than the header, of which the first is a text or the number of the row.
fn with_row_names(names: ByteRecord, rows: &[&ByteRecord]) -> ByteRecord {
    const FEWEST: usize = 2;
    let is_of = |(place, row): (usize, &&ByteRecord)| {
        let first = text_of(&row[0]);
        let is_name = kind(&row[0]) == CellKind::Text || first == (place + 1).to_string();
        row.len() == names.len() + 1 && is_name && !row[names.len()].trim_ascii().is_empty()
    };
    let sample = rows.iter().take(SAMPLE);
    if rows.len() < FEWEST || !sample.enumerate().all(is_of) {
        return names;
    }
    let mut named: ByteRecord = std::iter::once(&b""[..]).chain(names.iter()).collect();
    named.set_position(names.position().cloned());
    named
}

/// The kind of a cell.
#[derive(Clone, Copy, PartialEq)]
enum CellKind {
    Number,
    Missing,
    Text,
}

fn kind(cell: &[u8]) -> CellKind {
    match text_of(cell) {
        cell if is_missing(&cell) => CellKind::Missing,
        cell if is_number(&cell) => CellKind::Number,
        _ => CellKind::Text,
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
        let mut tail = &tail[tail.len().saturating_sub(SAMPLE)..];
        let mut has_numbers = columns_of_numbers(tail);
        // A long text above a short table.
        if !has_numbers.contains(&true) {
            tail = &tail[tail.len().saturating_sub(SAMPLE / 4)..];
            has_numbers = columns_of_numbers(tail);
        }
        let mut table = Self { has_numbers, rows: Vec::new(), numbers: 0, filled: 0 };
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
                CellKind::Number => counts[0] += 1,
                CellKind::Text => counts[1] += 1,
                CellKind::Missing => {}
            }
        }
        counts
    }

    /// The first row of values; `is_named` where the names are found elsewhere.
    fn first(&self, is_named: bool) -> usize {
        if !self.has_numbers.contains(&true) {
            return usize::from(!is_named).min(self.rows.len());
        }
        const NEAR: usize = 6;
        let is_full = |row: &&ByteRecord| {
            let [numbers, texts] = self.count(row);
            numbers > 0 && texts == 0 && 2 * numbers >= self.numbers
        };
        let mut anchor = self.rows.iter().position(is_full);
        // A few numbers of a remark above the names.
        while let Some(at) = anchor {
            let below = self.rows[at..].iter().take(NEAR);
            let end = below.clone().rposition(|row| self.count(row)[0] == 0 && known(row) > 1);
            let Some(names) = end.map(|end| at + end) else { break };
            anchor = self.rows[names..].iter().position(is_full).map(|below| names + below);
        }
        let mut first = anchor.unwrap_or_else(|| usize::from(!is_named).min(self.rows.len()));
        // Sensors that start late, and bad cells.
        while first > 0 {
            let row = self.rows[first - 1];
            let [numbers, texts] = self.count(row);
            let is_of_names = texts > 0 && 2 * known(row) > texts;
            let has_bad_cells =
                numbers > texts && (first > 1 || is_named) && !is_unit_row(row) && !is_of_names;
            if numbers == 0 || texts > 0 && !has_bad_cells {
                break;
            }
            first -= 1;
        }
        first
    }

    /// The first row of values below the names and units, whatever else is in it.
    fn first_below(&self, names: usize, first: usize) -> usize {
        let rows = &self.rows[..first];
        let is_of_units = |row: &&ByteRecord| is_unit_row(row) || is_labelled_unit_row(row);
        let units = rows.iter().skip(names).rposition(is_of_units).map_or(0, |at| at + 1);
        let column = self.has_numbers.iter().position(|has| *has);
        let has_number = |row: &ByteRecord| {
            let mut cells = row.iter().zip(&self.has_numbers).enumerate();
            // `1` is a unit, too.
            cells.any(|(i, (cell, has))| {
                *has && kind(cell) == CellKind::Number
                    && (Some(i) == column || text_of(cell) != "1")
            })
        };
        (names + units..first).find(|at| has_number(rows[*at])).unwrap_or(first)
    }

    /// The row of names above the first row of values: the nearest that is neither units nor sources.
    fn names(&self, first: usize) -> Option<usize> {
        if !self.has_numbers.contains(&true) {
            return if first > 0 { Some(0) } else { None };
        }
        // Rows above the values that are looked at.
        const MOST: usize = 1 << 13;
        let width = self.rows.get(first).map_or(usize::MAX, |row| row.len());
        let mut names: Option<usize> = None;
        let mut is_near = true;
        for at in (0..first).rev().take(MOST) {
            let row = self.rows[at];
            let own = filled(row);
            let texts = row.iter().filter(|cell| kind(cell) == CellKind::Text).count();
            let [numbers, texts_of_numbers] = self.count(row);
            let has_gap = self.rows.get(at + 1).is_some_and(|below| line(below) > end(row) + 1);
            let is_full = 2 * own >= self.filled && 2 * texts >= own;
            // Directly above the values a few names are a header.
            is_near &= !has_gap;
            let is_header = || {
                let is_alike = texts_of_numbers > 0 && row.len() == width && !has_decimals(row);
                is_near && texts > 0 && (is_alike || known(row) > 0)
            };
            let is_candidate = (own > 1 || self.filled < 2) && (is_full || is_header());
            is_near &= is_unit_row(row);
            let Some(below) = names else {
                if is_candidate {
                    names = Some(at);
                }
                continue;
            };
            let below = self.rows[below];
            let has_numbers = self.count(below)[0] > 0;
            if !is_candidate && numbers > 0 && has_numbers {
                continue;
            }
            // A line without text ends the header, but not between names and units.
            let is_part = || are_units(self.rows[at + 1]) || are_types(self.rows[at + 1]);
            if !is_candidate || has_gap && !is_part() {
                break;
            }
            let is_of_units =
                is_unit_row(below) || are_types(below) || has_repeats(below) && !has_repeats(row);
            let is_fuller = filled(below) < own || is_of_units && own + 1 >= filled(below);
            match known(row).cmp(&known(below)) {
                Ordering::Greater => names = Some(at),
                Ordering::Equal if is_fuller || has_numbers && numbers == 0 => names = Some(at),
                _ => {}
            }
        }
        names
    }
}

/// Whether a cell is a number as values are written and names are not: with a sign or a decimal mark.
fn has_decimals(row: &ByteRecord) -> bool {
    let is_value = |cell: String| is_number(&cell) && cell.contains(['-', '+', '.', ',']);
    row.iter().map(text_of).any(is_value)
}

/// Columns with as many numbers as texts or more.
fn columns_of_numbers(rows: &[&ByteRecord]) -> Vec<bool> {
    let mut counts: Vec<[usize; 2]> = Vec::new();
    for row in rows {
        counts.resize(counts.len().max(row.len()), [0; 2]);
        for (cell, counts) in row.iter().zip(&mut counts) {
            match kind(cell) {
                CellKind::Number => counts[0] += 1,
                CellKind::Text => counts[1] += 1,
                CellKind::Missing => {}
            }
        }
    }
    counts.iter().map(|[numbers, texts]| *numbers > 0 && numbers >= texts).collect()
}

/// Cells that are named like a quantity of a vehicle or end in a unit.
fn known(row: &ByteRecord) -> usize {
    let roles = || Role::OF_CHANNELS.into_iter().chain([Role::Time]);
    let is_known = |cell: &String| {
        let name = Name::new(cell);
        unit_of_header(cell).is_some() || roles().any(|role| role.is_of(&name))
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

/// A row of units throughout.
fn are_units(row: &ByteRecord) -> bool {
    let cells = cells_of(row);
    let units = cells.iter().filter(|cell| parse_unit(bare_unit(cell)).is_some()).count();
    is_unit_row(row) && 2 * units >= filled(row)
}

/// A row of the types of the columns, as ETAS writes it.
fn are_types(row: &ByteRecord) -> bool {
    const TYPES: [&str; 10] = ["f4", "f8", "u1", "u2", "u4", "u8", "s1", "s2", "s4", "s8"];
    row.iter().all(|cell| TYPES.contains(&&*text_of(cell).to_lowercase()))
}

/// A row such as `Y_Unit_Label,deg,deg/s`.
fn is_labelled_unit_row(row: &ByteRecord) -> bool {
    let mut cells = row.iter().map(text_of);
    let label = cells.next().unwrap_or_default().to_lowercase();
    label.contains("unit") && cells.any(|cell| parse_unit(bare_unit(&cell)).is_some())
}
