//! Tables: aligned plain text for a terminal, or HTML in a report.

use crate::canvas::is_wide;

/// A table of texts. Columns that hold numbers only are aligned to the right.
///
/// ```
/// let table = report::Table::new(["order", "fit"]).row(["1", "8.5"]).row(["2", "79.4"]);
/// assert_eq!(table.to_string(), "order   fit\n─────  ────\n    1   8.5\n    2  79.4\n");
/// ```
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Table {
    headers: Vec<String>,
    rows: Vec<Vec<String>>,
}

impl Table {
    /// An empty table with its headers.
    #[must_use]
    pub fn new<S: Into<String>>(headers: impl IntoIterator<Item = S>) -> Self {
        Self { headers: headers.into_iter().map(Into::into).collect(), rows: Vec::new() }
    }

    /// Adds a row; missing cells are empty, and cells beyond the headers are dropped.
    #[must_use]
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

impl std::fmt::Display for Table {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        // Control characters of a file's name must not reach the terminal.
        let clean = |cells: &[String]| -> Vec<String> {
            cells.iter().map(|c| crate::html::printable(c).replace(['\n', '\t'], " ")).collect()
        };
        let headers = clean(&self.headers);
        let rows: Vec<_> = self.rows.iter().map(|r| clean(r)).collect();
        let widths: Vec<usize> = (0..headers.len())
            .map(|k| rows.iter().chain([&headers]).map(|r| width(&r[k])).fold(0, usize::max))
            .collect();
        let numeric: Vec<bool> = (0..headers.len()).map(|k| self.is_numeric(k)).collect();
        let mut line = |cells: &[String]| {
            let mut text = String::new();
            for (k, cell) in cells.iter().enumerate() {
                let space = " ".repeat(widths[k] - width(cell));
                let between = if k == 0 { "" } else { "  " };
                let (before, after) =
                    if numeric[k] { (space.as_str(), "") } else { ("", space.as_str()) };
                text += &format!("{between}{before}{cell}{after}");
            }
            writeln!(f, "{}", text.trim_end())
        };
        line(&headers)?;
        line(&widths.iter().map(|w| "─".repeat(*w)).collect::<Vec<_>>())?;
        rows.iter().try_for_each(|row| line(row))
    }
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
    fn a_hash_a_file_and_an_escape_are_no_numbers() {
        for text in ["2e5abc.csv", "9f86d081884c7d65", "inf", "nan", "12e4567890123456789012345678"]
        {
            assert!(!Table::new(["a"]).row([text]).is_numeric(0), "{text}");
        }
        assert!(!Table::new(["a"]).row(["x\u{1b}[31m\ny"]).to_string().contains('\u{1b}'));
    }
}
