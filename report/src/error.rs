//! Errors of reading a table and of drawing a figure.

/// Why a table was refused or a figure cannot be drawn.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum Error {
    /// No series of a panel has a finite point.
    #[error("figure `{figure}`, panel {panel}: there is no finite point to draw")]
    NoData {
        /// Title of the figure.
        figure: String,
        /// Number of the panel, from 1.
        panel: usize,
    },
    /// The figure is too small for its labels, or absurdly large.
    #[error(
        "figure `{figure}`: {width} by {height} pixels for {panels} panels; \
         a panel needs at least 200 by 60 inside its labels, and 10000 is the largest side"
    )]
    Size {
        /// Title of the figure.
        figure: String,
        /// Requested width.
        width: u32,
        /// Requested height.
        height: u32,
        /// Number of panels.
        panels: usize,
    },
    /// The text is not a table: a row of another length, broken quotes or broken UTF-8.
    #[error("{file}:{line}: {problem}")]
    Csv {
        /// Name of the file as the caller gave it.
        file: String,
        /// Line, from 1; 0 where unknown.
        line: u64,
        /// The fault.
        problem: String,
    },
    /// A column that is needed is not there.
    #[error("{file}: no column `{column}`; there are {found}")]
    MissingColumn {
        /// Name of the file as the caller gave it.
        file: String,
        /// The column looked for.
        column: String,
        /// The columns there are.
        found: String,
    },
    /// A cell holds no number.
    #[error("{file}:{line}: column `{column}`: `{text}` is not a number")]
    Number {
        /// Name of the file as the caller gave it.
        file: String,
        /// Line, from 1.
        line: u64,
        /// Name of the column.
        column: String,
        /// The cell.
        text: String,
    },
    /// There is a header and nothing below it.
    #[error("{file}: the table has no rows")]
    NoRows {
        /// Name of the file as the caller gave it.
        file: String,
    },
}

impl Error {
    /// The remedy, for the reader.
    #[must_use]
    pub fn hint(&self) -> &'static str {
        match self {
            Self::NoData { .. } => {
                "check that the stage before wrote its table to the end and that it holds numbers"
            }
            Self::Size { .. } => "ask for a size such as 760 by 480 pixels",
            Self::Csv { .. } | Self::Number { .. } => {
                "correct the line named, or write the table again with the command that makes it"
            }
            Self::MissingColumn { .. } => {
                "give a table made by the command that writes this kind; names are in its first row"
            }
            Self::NoRows { .. } => "run the command that writes this table again",
        }
    }
}
