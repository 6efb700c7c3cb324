//! Why an archive cannot be checked.

use miette::Diagnostic;
use std::path::PathBuf;

/// Why an archive cannot be checked.
#[derive(Debug, thiserror::Error, Diagnostic)]
#[allow(missing_docs)] // the fields are named in the messages
pub enum Error {
    #[error("{}: {source}", path.display())]
    #[diagnostic(help("check that the file exists and that you may read it"))]
    Io { path: PathBuf, source: std::io::Error },
    #[error("{} is a folder", path.display())]
    #[diagnostic(help("pass the .fmu file, not the folder that it was unpacked to"))]
    Folder { path: PathBuf },
    #[error("{} has {got} bytes, more than {limit}", path.display())]
    #[diagnostic(help("check the path: an ordinary FMU is smaller"))]
    TooLarge { path: PathBuf, got: u64, limit: u64 },
    #[error("{}: the process that runs the FMU cannot be started: {source}", path.display())]
    #[diagnostic(help("check the permissions of the program and of the temporary folder"))]
    Child { path: PathBuf, source: std::io::Error },
}

impl Error {
    /// The suggested fix.
    #[must_use]
    pub fn hint(&self) -> String {
        self.help().map(|help| help.to_string()).unwrap_or_default()
    }
}
