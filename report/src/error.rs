//! Errors of reading a table and of drawing a figure.

use miette::Diagnostic;

/// Why a table was refused or a figure cannot be drawn.
#[derive(Debug, Clone, PartialEq, thiserror::Error, Diagnostic)]
#[allow(missing_docs)] // the fields are named in the messages
pub enum Error {
    /// No series of a panel has a finite point.
    #[error("figure `{figure}`, panel {panel}: there is no finite point to draw")]
    #[diagnostic(help(
        "check that the stage before wrote its table to the end and that it holds numbers"
    ))]
    NoData { figure: String, panel: usize },
    /// The figure is too small for its labels, or absurdly large.
    #[error(
        "figure `{figure}`: {width} by {height} pixels for {panels} panels; \
         a panel needs at least 200 by 60 inside its labels, and 10000 is the largest side"
    )]
    #[diagnostic(help("ask for a size such as 760 by 480 pixels"))]
    Size { figure: String, width: u32, height: u32, panels: usize },
    /// The text is not a table: a row of another length, broken quotes or broken UTF-8.
    #[error("{file}:{line}: {problem}")]
    #[diagnostic(help("{}", LINE))]
    Csv { file: String, line: u64, problem: String },
    #[error("{file}: no column `{column}`; there are {found}")]
    #[diagnostic(help(
        "give a table made by the command that writes this kind; names are in its first row"
    ))]
    MissingColumn { file: String, column: String, found: String },
    #[error("{file}:{line}: column `{column}`: `{text}` is not a number")]
    #[diagnostic(help("{}", LINE))]
    Number { file: String, line: u64, column: String, text: String },
    #[error("{file}: the table has no rows")]
    #[diagnostic(help("run the command that writes this table again"))]
    NoRows { file: String },
}

impl Error {
    /// The suggested fix.
    #[must_use]
    pub fn hint(&self) -> String {
        self.help().map(|help| help.to_string()).unwrap_or_default()
    }
}

const LINE: &str =
    "correct the line named, or write the table again with the command that makes it";
