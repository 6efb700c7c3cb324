//! Tables: aligned plain text for a terminal, or HTML in a report.

use crate::canvas::is_wide;
use crate::markup::printable;

/// Columns of a terminal that every table fits.
pub const COLUMNS: usize = 80;
/// Between two columns of a table.
const GAP: usize = 2;
/// A text is broken inside a word rather than made narrower than this.
const NARROW: usize = 12;

/// A table of texts. Columns that hold numbers only are aligned to the right. Displayed, it is at
/// most [`COLUMNS`] wide; see [`Table::text`].
///
/// ```
/// let table = steerwright_report::Table::new(["order", "fit"]).row(["1", "8.5"]).row(["2", "79.4"]);
/// assert_eq!(table.to_string(), "order   fit\n─────  ────\n    1   8.5\n    2  79.4\n");
/// ```
#[derive(Debug, Clone, PartialEq, Eq, Default)]
#[must_use]
pub struct Table {
    headers: Vec<String>,
    rows: Vec<Vec<String>>,
}

impl Table {
    /// An empty table with its headers.
    pub fn new<S: Into<String>>(headers: impl IntoIterator<Item = S>) -> Self {
        Self { headers: headers.into_iter().map(Into::into).collect(), rows: Vec::new() }
    }

    /// Adds a row; missing cells are empty, and cells beyond the headers are dropped.
    pub fn row<S: Into<String>>(mut self, cells: impl IntoIterator<Item = S>) -> Self {
        self.push(cells);
        self
    }

    /// Adds a row, as [`Table::row`].
    pub fn push<S: Into<String>>(&mut self, cells: impl IntoIterator<Item = S>) {
        let mut row: Vec<String> = cells.into_iter().map(Into::into).collect();
        row.resize(self.headers.len(), String::new());
        self.rows.push(row);
    }

    /// Whether there are no rows.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.rows.is_empty()
    }

    /// The headers.
    #[must_use]
    pub fn headers(&self) -> &[String] {
        &self.headers
    }

    /// The rows, each as long as the headers.
    #[must_use]
    pub fn rows(&self) -> &[Vec<String>] {
        &self.rows
    }

    /// Whether a column holds numbers (with units or not) and nothing else.
    #[must_use]
    pub fn is_numeric(&self, column: usize) -> bool {
        let cells = || self.rows.iter().filter_map(|r| r.get(column)).filter(|c| !c.is_empty());
        cells().any(|c| starts_with_number(c))
            && cells().all(|c| starts_with_number(c) || matches!(c.as_str(), "–" | "∞"))
    }
}

/// `−1.5`, `2 %`, `±3 deg`; not `2wheel.csv` or a hash.
fn starts_with_number(cell: &str) -> bool {
    let word = cell.split_whitespace().next().unwrap_or_default();
    let digits = word.trim_start_matches(['−', '-', '+', '±', '≤', '≥']);
    let digits = digits.strip_suffix('%').unwrap_or(digits).replace('−', "-");
    // `inf` and `nan` are texts here.
    digits.len() <= 24
        && digits.starts_with(|c: char| c.is_ascii_digit())
        && digits.parse::<f64>().is_ok()
}

/// Columns a text takes in a terminal.
fn width(text: &str) -> usize {
    text.chars()
        .map(|c| if is_wide(c) { 2 } else { usize::from(!('\u{300}'..='\u{36f}').contains(&c)) })
        .sum()
}

impl Table {
    /// The table as text of at most `columns`: long texts are wrapped inside their column, and where
    /// that is not enough the columns that are left follow below, with the first one before them.
    #[must_use]
    pub fn text(&self, columns: usize) -> String {
        // Control characters of a file's name must not reach the terminal.
        let clean = |cells: &[String]| -> Vec<String> {
            cells.iter().map(|c| printable(c).replace(['\n', '\t'], " ")).collect()
        };
        let headers = clean(&self.headers);
        let rows: Vec<_> = self.rows.iter().map(|r| clean(r)).collect();
        let sizes: Vec<Size> = (0..headers.len())
            .map(|k| Size::new(self.is_numeric(k), &headers[k], rows.iter().map(|r| r[k].as_str())))
            .collect();
        let mut text = String::new();
        for block in blocks(&sizes, columns) {
            if !text.is_empty() {
                text.push('\n');
            }
            let widths = widths(block.iter().map(|k| sizes[*k]), columns);
            let mut line = |cells: &[String], rule: bool| {
                let cells: Vec<Vec<String>> = block
                    .iter()
                    .zip(&widths)
                    .map(|(k, w)| if rule { vec!["─".repeat(*w)] } else { wrapped(&cells[*k], *w) })
                    .collect();
                for at in 0..cells.iter().map(Vec::len).max().unwrap_or(0) {
                    let mut line = String::new();
                    for ((lines, width), k) in cells.iter().zip(&widths).zip(&block) {
                        let cell = lines.get(at).map_or("", String::as_str);
                        let space = " ".repeat(width.saturating_sub(self::width(cell)));
                        let (before, after) =
                            if sizes[*k].numeric { (&*space, "") } else { ("", &*space) };
                        line += &format!("{before}{cell}{after}{}", " ".repeat(GAP));
                    }
                    text += line.trim_end();
                    text.push('\n');
                }
            };
            line(&headers, false);
            line(&headers, true);
            rows.iter().for_each(|row| line(row, false));
        }
        text
    }
}

impl std::fmt::Display for Table {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(&self.text(COLUMNS))
    }
}

/// The width of a column, and its smallest width.
#[derive(Debug, Clone, Copy)]
struct Size {
    numeric: bool,
    natural: usize,
    /// Between words.
    wrapped: usize,
    /// Inside words too.
    broken: usize,
}

impl Size {
    fn new<'a>(numeric: bool, header: &str, cells: impl Iterator<Item = &'a str>) -> Self {
        let word = |text: &str| text.split(' ').map(width).max().unwrap_or(0);
        let (mut natural, mut wrapped) = (width(header), word(header));
        for cell in cells {
            natural = natural.max(width(cell));
            // A number stays with its unit.
            wrapped = wrapped.max(if numeric { width(cell) } else { word(cell) });
        }
        let broken = if numeric { wrapped } else { wrapped.min(NARROW) };
        Self { numeric, natural, wrapped, broken }
    }
}

/// The columns that stand next to each other, block by block; each but the first begins with the
/// table's first column.
fn blocks(sizes: &[Size], columns: usize) -> Vec<Vec<usize>> {
    let mut blocks: Vec<Vec<usize>> = Vec::new();
    let mut block: Vec<usize> = Vec::new();
    let mut used = 0;
    for (k, size) in sizes.iter().enumerate() {
        if block.len() > 1 && used + GAP + size.broken > columns {
            blocks.push(std::mem::replace(&mut block, vec![0]));
            used = sizes[0].broken;
        }
        used += size.broken + if block.is_empty() { 0 } else { GAP };
        block.push(k);
    }
    blocks.push(block);
    blocks
}

/// Widths that fit: the widest columns are narrowed first, between words before inside them.
fn widths(sizes: impl Iterator<Item = Size>, columns: usize) -> Vec<usize> {
    let sizes: Vec<Size> = sizes.collect();
    let gaps = GAP * sizes.len().saturating_sub(1);
    let mut widths: Vec<usize> = sizes.iter().map(|s| s.natural).collect();
    for least in [|s: &Size| s.wrapped, |s: &Size| s.broken] {
        while widths.iter().sum::<usize>() + gaps > columns {
            let narrower = (0..sizes.len()).filter(|k| widths[*k] > least(&sizes[*k]));
            let Some(widest) = narrower.max_by_key(|k| widths[*k]) else { break };
            widths[widest] -= 1;
        }
    }
    widths
}

/// A cell's lines; an indentation holds for all of them.
fn wrapped(cell: &str, columns: usize) -> Vec<String> {
    if width(cell) <= columns {
        return vec![cell.to_owned()];
    }
    let indent = cell.len() - cell.trim_start_matches(' ').len();
    let indent = " ".repeat(indent.min(columns / 2));
    let (mut lines, mut line) = (Vec::new(), indent.clone());
    for word in cell.split(' ').filter(|word| !word.is_empty()) {
        let space = usize::from(line.len() > indent.len());
        if space == 1 && width(&line) + 1 + width(word) > columns {
            lines.push(std::mem::replace(&mut line, indent.clone()));
        } else if space == 1 {
            line.push(' ');
        }
        for c in word.chars() {
            if width(&line) + width(c.encode_utf8(&mut [0; 4])) > columns {
                lines.push(std::mem::replace(&mut line, indent.clone()));
            }
            line.push(c);
        }
    }
    lines.push(line);
    lines
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_right_and_words_left() {
        let table = Table::new(["channel", "rate", "note"])
            .row(["steering", "100.0 Hz", "ok"])
            .row(["größe", "−9.5 Hz", ""])
            .row(["x"]);
        assert_eq!(
            table.to_string(),
            "channel       rate  note\n────────  ────────  ────\nsteering  100.0 Hz  ok\n\
             größe      −9.5 Hz\nx\n"
        );
    }

    #[test]
    fn a_wide_table_is_wrapped_between_words_then_inside_them_then_into_blocks() {
        let table = Table::new(["name", "what was measured", "value"]).row([
            "a",
            "the quick brown fox jumps over the lazy dog",
            "12 Hz",
        ]);
        assert_eq!(
            table.text(32),
            "name  what was measured    value\n────  ───────────────────  ─────\n\
             a     the quick brown fox  12 Hz\n      jumps over the lazy\n      dog\n"
        );
        let table = Table::new(["file", "n"]).row(["a/very/long/path/without/any/space.csv", "1"]);
        assert!(
            table.text(30).contains("\na/very/long/path/without/an  1\ny/space.csv\n"),
            "{table}"
        );
        let headers: Vec<String> = (0..12).map(|k| format!("column{k}")).collect();
        let table = Table::new(headers).row((0..12).map(|k| format!("{k}.25 rad/s")));
        let text = table.to_string();
        assert!(text.lines().all(|line| width(line) <= COLUMNS), "{text}");
        // The first column stands in each of the three blocks.
        assert_eq!(text.matches("column0 ").count(), 3, "{text}");
        assert!((0..12).all(|k| text.contains(&format!("{k}.25 rad/s"))), "{text}");
    }

    #[test]
    fn a_hash_a_file_and_an_escape_are_no_numbers() {
        for text in ["2e5abc.csv", "9f86d081884c7d65", "inf", "nan", "12e4567890123456789012345678"]
        {
            assert!(!Table::new(["a"]).row([text]).is_numeric(0), "{text}");
        }
        assert!(!Table::new(["a"]).row(["x\u{1b}[31m\ny"]).to_string().contains('\u{1b}'));
    }
}
