//! Why an archive cannot be checked.

use std::path::PathBuf;

/// Why an archive cannot be checked.
#[derive(Debug, thiserror::Error)]
#[allow(missing_docs)] // the fields are named in the messages
pub enum Error {
    #[error("{}: {source}", path.display())]
    Io { path: PathBuf, source: std::io::Error },
    #[error("{} is a folder", path.display())]
    Folder { path: PathBuf },
    #[error("{} has {got} bytes, more than {limit}", path.display())]
    TooLarge { path: PathBuf, got: u64, limit: u64 },
    #[error("{}: the process that runs the FMU cannot be started: {source}", path.display())]
    Child { path: PathBuf, source: std::io::Error },
}

impl Error {
    /// The suggested fix.
    #[must_use]
    pub fn hint(&self) -> String {
        match self {
            Self::Io { .. } => "check that the file exists and that you may read it",
            Self::Folder { .. } => "pass the .fmu file, not the folder that it was unpacked to",
            Self::TooLarge { .. } => "check the path: an ordinary FMU is smaller",
            Self::Child { .. } => {
                "check the permissions of the program and of the temporary folder"
            }
        }
        .into()
    }
}
