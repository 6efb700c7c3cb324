//! Errors of a study.

use miette::Diagnostic;
use std::path::PathBuf;

/// A place in a study.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct StudyPlace {
    /// The name of the study in errors.
    pub file: String,
    /// The line, from 1.
    pub line: usize,
    /// The column, from 1, in characters.
    pub column: usize,
}

impl std::fmt::Display for StudyPlace {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}:{}:{}", self.file, self.line, self.column)
    }
}

/// Why a study cannot be run.
#[derive(Debug, thiserror::Error, Diagnostic)]
#[allow(missing_docs)]
pub enum Error {
    #[error("{}: {source}", path.display())]
    #[diagnostic(help("check that the path is right and that you may read and write there"))]
    Io { path: PathBuf, source: std::io::Error },
    #[error("{at}: {problem}")]
    #[diagnostic(help("{hint}"))]
    Study { at: StudyPlace, problem: String, hint: &'static str },
    #[error("{at}: {source}")]
    #[diagnostic(help("{}", source.hint()))]
    System { at: StudyPlace, source: Box<steerwright_host::Error> },
    #[error("{at}: no run gets past its first step: {source}")]
    #[diagnostic(help("see whether the FMUs take this step_s; {}", source.hint()))]
    FirstStep { at: StudyPlace, source: Box<steerwright_host::Error> },
    #[error("{}: cannot be resumed: {problem}", path.display())]
    #[diagnostic(help(
        "resume with the study, FMUs and program that the file was begun with, or start again without --resume"
    ))]
    Resume { path: PathBuf, problem: String },
    #[error("{}: another run is writing this file", path.display())]
    #[diagnostic(help("wait for it to end, or name another file"))]
    Taken { path: PathBuf },
    #[error("{}: holds the first {rows} of {runs} runs of this study", path.display())]
    #[diagnostic(help("continue with --resume, or replace it with --force"))]
    Unfinished { path: PathBuf, rows: usize, runs: usize },
    #[error("{}: is no piece of this study: {problem}", path.display())]
    #[diagnostic(help(
        "merge pieces that were made with this study, its FMUs and this version of the program"
    ))]
    Piece { path: PathBuf, problem: String },
    #[error("runs {from} to {to} of {runs} are in no piece")]
    #[diagnostic(help("make the shard that has these runs, and merge all pieces"))]
    Missing { from: usize, to: usize, runs: usize },
    #[error("runs {from} to {to} are in {} and in {}", first.display(), second.display())]
    #[diagnostic(help("merge each run once: pieces of one number of shards, each once"))]
    Twice { first: PathBuf, second: PathBuf, from: usize, to: usize },
    #[error("run {run} does not exist: the study has {runs} runs, from 0")]
    #[diagnostic(help("name runs that the study has"))]
    NoSuchRun { run: usize, runs: usize },
    #[error("no process can be started for the FMUs: {reason}")]
    #[diagnostic(help("see its messages above; or run without --isolate"))]
    Process { reason: String },
    #[error("no threads can be started: {reason}")]
    #[diagnostic(help("use fewer with --threads"))]
    Threads { reason: String },
}

impl Error {
    /// The suggested fix.
    #[must_use]
    pub fn hint(&self) -> String {
        self.help().map(|help| help.to_string()).unwrap_or_default()
    }
}
