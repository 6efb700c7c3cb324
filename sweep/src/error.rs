//! Errors of a study.

use std::path::PathBuf;

/// A place in a study.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Place {
    /// The name of the study in errors.
    pub file: String,
    /// The line, from 1.
    pub line: usize,
    /// The column, from 1, in characters.
    pub column: usize,
}

impl std::fmt::Display for Place {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}:{}:{}", self.file, self.line, self.column)
    }
}

/// Why a study cannot be run.
#[derive(Debug, thiserror::Error)]
#[allow(missing_docs)]
pub enum Error {
    #[error("{}: {source}", path.display())]
    Io { path: PathBuf, source: std::io::Error },
    #[error("{at}: {problem}")]
    Study { at: Place, problem: String, hint: &'static str },
    #[error("{at}: {source}")]
    System { at: Place, source: Box<steerwright_host::Error> },
    #[error("{at}: no run gets past its first step: {source}")]
    FirstStep { at: Place, source: Box<steerwright_host::Error> },
    #[error("{}: cannot be resumed: {problem}", path.display())]
    Resume { path: PathBuf, problem: String },
    #[error("{}: another run is writing this file", path.display())]
    Taken { path: PathBuf },
    #[error("{}: holds the first {rows} of {runs} runs of this study", path.display())]
    Unfinished { path: PathBuf, rows: usize, runs: usize },
    #[error("{}: is no piece of this study: {problem}", path.display())]
    Piece { path: PathBuf, problem: String },
    #[error("runs {from} to {to} of {runs} are in no piece")]
    Missing { from: usize, to: usize, runs: usize },
    #[error("runs {from} to {to} are in {} and in {}", first.display(), second.display())]
    Twice { first: PathBuf, second: PathBuf, from: usize, to: usize },
    #[error("run {run} does not exist: the study has {runs} runs, from 0")]
    NoSuchRun { run: usize, runs: usize },
    #[error("no process can be started for the FMUs: {reason}")]
    Process { reason: String },
    #[error("no threads can be started: {reason}")]
    Threads { reason: String },
}

impl Error {
    /// The remedy.
    #[must_use]
    pub fn hint(&self) -> String {
        let text = match self {
            Self::Io { .. } => "check that the path is right and that you may read and write there",
            Self::Study { hint, .. } => *hint,
            Self::System { source, .. } => return source.hint(),
            Self::FirstStep { source, .. } => {
                return format!("see whether the FMUs take this step_s; {}", source.hint());
            }
            Self::Resume { .. } => {
                "resume with the study, FMUs and program that the file was begun with, or start \
                 again without --resume"
            }
            Self::Piece { .. } => {
                "merge pieces that were made with this study, its FMUs and this version of the program"
            }
            Self::Missing { .. } => "make the shard that has these runs, and merge all pieces",
            Self::Twice { .. } => "merge each run once: pieces of one number of shards, each once",
            Self::Taken { .. } => "wait for it to end, or name another file",
            Self::Unfinished { .. } => "continue with --resume, or replace it with --force",
            Self::NoSuchRun { .. } => "name runs that the study has",
            Self::Process { .. } => "see its messages above; or run without --isolate",
            Self::Threads { .. } => "use fewer with --threads",
        };
        text.to_owned()
    }
}
