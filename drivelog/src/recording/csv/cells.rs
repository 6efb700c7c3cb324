//! What a cell or a row of a text table is.

use super::missing::is_spreadsheet_error;
use super::stamps::Stamps;
use std::borrow::Cow;

/// Delimiters, the preferred one last.
pub(super) const DELIMITERS: [u8; 5] = [b' ', b'|', b',', b'\t', b';'];
/// What begins a line that is a comment.
const COMMENTS: [&[u8]; 3] = [b"#", b"//", b"%"];

/// Whether the line is a comment.
pub(super) fn is_comment(line: &[u8]) -> bool {
    let line = line.trim_ascii_start();
    let end = line.iter().position(|b| *b != b' ' && DELIMITERS.contains(b));
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
    match cell {
        _ if is("true") => Some(1.0),
        _ if is("false") => Some(0.0),
        _ => None,
    }
}

/// The text of a cell: UTF-8, else Latin 1, in which `°` and `ä` are a byte each.
pub(super) fn text_of(bytes: &[u8]) -> String {
    match std::str::from_utf8(bytes) {
        Ok(text) => text.trim().to_owned(),
        Err(_) => {
            let text: String = bytes.iter().map(|b| char::from(*b)).collect();
            text.trim().to_owned()
        }
    }
}

/// The same without a copy of UTF-8.
pub(super) fn decoded(bytes: &[u8]) -> Cow<'_, str> {
    match std::str::from_utf8(bytes) {
        Ok(text) => Cow::Borrowed(text.trim()),
        Err(_) => Cow::Owned(text_of(bytes)),
    }
}

/// A unit without the brackets that may enclose it.
pub(super) fn bare_unit(text: &str) -> &str {
    let inner = |open, close| text.strip_prefix(open)?.strip_suffix(close);
    inner('[', ']').or_else(|| inner('(', ')')).unwrap_or(text).trim()
}

/// A number whose power of ten is written as Fortran does: `0.5D+01`.
pub(super) fn fortran_number(cell: &str) -> Option<f64> {
    let (number, power) = cell.split_once(['D', 'd'])?;
    if !number.contains('.') || !power.ends_with(|c: char| c.is_ascii_digit()) {
        return None;
    }
    format!("{number}E{power}").parse().ok().filter(|x: &f64| x.is_finite())
}

pub(super) fn is_value(cell: &str) -> bool {
    let cell = cell.strip_prefix('−').unwrap_or(cell);
    cell.parse::<f64>().is_ok()
        || fortran_number(cell).is_some()
        || comma_number(cell).is_some()
        || Stamps::like(cell).is_some()
}

/// Whether the cell holds a number, a time or a switch, be it in groups of digits.
pub(super) fn is_number(cell: &str) -> bool {
    let is_of_groups = || {
        cell.starts_with(|c: char| c.is_ascii_digit() || "+-".contains(c))
            && cell.contains(|c: char| c.is_ascii_digit())
            && cell
                .trim_start_matches(['+', '-'])
                .chars()
                .all(|c| c.is_ascii_digit() || ".,'’ ".contains(c))
            && has_groups_of_three(cell)
    };
    is_value(cell) || switch(cell).is_some() || is_of_groups()
}

/// Whether blanks set off groups of three digits only.
fn has_groups_of_three(cell: &str) -> bool {
    let mut groups = cell.split(' ').rev();
    let Some(last) = groups.next() else { return true };
    let whole = last.split(['.', ',']).next().unwrap_or(last);
    let digits = |group: &str| group.bytes().filter(u8::is_ascii_digit).count();
    let are_digits = |group: &str| group.len() == digits(group);
    let mut groups: Vec<&str> = groups.collect();
    let Some(first) = groups.pop() else { return true };
    let first = first.trim_start_matches(['+', '-']);
    let is_group = |group: &str| group.len() == 3 && are_digits(group);
    (1..=3).contains(&first.len())
        && are_digits(first)
        && is_group(whole)
        && groups.into_iter().all(is_group)
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

pub(super) fn is_blank(record: &csv::ByteRecord) -> bool {
    record.iter().all(|c| c.trim_ascii().is_empty())
}

/// The cells without blanks around them.
pub(super) fn joined(record: &csv::ByteRecord) -> Vec<u8> {
    record.iter().map(<[u8]>::trim_ascii).collect::<Vec<_>>().join(&b'\n')
}

pub(super) fn line(record: &csv::ByteRecord) -> u64 {
    record.position().map_or(1, csv::Position::line)
}

pub(super) fn set_line(record: &mut csv::ByteRecord, line: u64) {
    let mut position = record.position().cloned().unwrap_or_else(csv::Position::new);
    position.set_line(line);
    record.set_position(Some(position));
}
