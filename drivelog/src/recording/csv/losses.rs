//! What of a text is not read, counted and in words.

use crate::Error;
use crate::error::{counted, shortened};
use crate::recording::Channel;

pub(super) struct Losses {
    /// What stands at the top of the file besides names and units, and what the table looks like.
    top: Vec<String>,
    /// Bad cells of each column: how many, and the first.
    pub(super) bad: Vec<Option<(u64, Error)>>,
    /// Numbers in each column whose first cells are texts: how many, and the line of the first.
    pub(super) late: Vec<Option<(u64, u64)>>,
    /// Rows with fewer cells than columns, and the line of the first.
    pub(super) short: Option<(u64, u64)>,
    /// Rows that begin with a mark of a tool and hold texts, and the line of the first.
    pub(super) marked: Option<(u64, u64)>,
    /// Rows that repeat one above the values, and the line of the first.
    pub(super) repeated: Option<(u64, u64)>,
    /// The first of the rows at the end that are none of values, and how many they are.
    pub(super) last: Option<(Error, usize)>,
    /// Rows with zeros among their bytes, and the line of the first.
    pub(super) torn: Option<(u64, u64)>,
    /// Zeros at the end.
    pub(super) zeros: u64,
}

impl Losses {
    pub(super) fn new(top: Vec<String>, columns: usize) -> Self {
        let bad = (0..columns).map(|_| None).collect();
        let late = vec![None; columns];
        Self {
            top,
            bad,
            late,
            short: None,
            marked: None,
            repeated: None,
            last: None,
            torn: None,
            zeros: 0,
        }
    }

    pub(super) fn sentences(&self, file: &str, channels: &[Channel]) -> Vec<String> {
        let number = |count: u64, what| counted(usize::try_from(count).unwrap_or(usize::MAX), what);
        let short = self.short.map(|(count, line)| {
            let rows = number(count, "row");
            format!(
                "{file}: {rows} with fewer cells than the header, the first at line {line}: what is not there is a missing value"
            )
        });
        let marked = self.marked.map(|(count, line)| {
            let rows = number(count, "row");
            format!(
                "{file}: {rows} that begin with % and hold texts not read, the first at line {line}"
            )
        });
        let repeated = self.repeated.map(|(count, line)| {
            let rows = number(count, "row");
            format!("{file}: {rows} above the values repeated further down, the first at line {line}: not read")
        });
        let last = self.last.as_ref().map(|(error, rows)| match rows {
            1 => format!("{error}: this last row is not read"),
            rows => format!("{error}: the last {rows} rows are not read"),
        });
        let torn = self.torn.map(|(count, line)| {
            let rows = number(count, "row");
            format!("{file}: {rows} with zeros among the bytes, as after a loss of power, the first at line {line}: not read")
        });
        let zeros = if self.zeros > 0 {
            let bytes = number(self.zeros, "byte");
            Some(format!("{file}: {bytes} of 0 at the end, as after a loss of power, not read"))
        } else {
            None
        };
        let bad = self.bad.iter().flatten().map(|(count, first)| {
            let cells = number(*count, "cell");
            format!("{first}: {cells} of this kind in the column: missing values")
        });
        let late = self.late.iter().zip(channels).filter_map(|(late, channel)| {
            let (count, line) = (*late)?;
            let (numbers, name) = (number(count, "number"), shortened(&channel.name));
            Some(format!("{file}: column `{name}` is read as text by its first rows: {numbers} further down, the first at line {line}, not read"))
        });
        let top = self.top.clone().into_iter();
        let rows = top.chain(short).chain(marked).chain(repeated);
        rows.chain(bad).chain(late).chain(last).chain(torn).chain(zeros).collect()
    }
}
