//! Why nothing could be checked.

use std::path::PathBuf;

/// Why nothing could be checked.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// The file cannot be read.
    #[error("{}: {source}", path.display())]
    Io {
        /// The file.
        path: PathBuf,
        /// Why.
        source: std::io::Error,
    },
    /// It is a folder.
    #[error("{} is a folder", path.display())]
    Folder {
        /// The folder.
        path: PathBuf,
    },
    /// The file is larger than is read into memory.
    #[error("{} has {got} bytes, more than {limit}", path.display())]
    TooLarge {
        /// The file.
        path: PathBuf,
        /// Its size, bytes.
        got: u64,
        /// The largest size, bytes.
        limit: u64,
    },
    /// The process that exercises the binary cannot be started.
    #[error("{}: the process that runs the FMU: {source}", path.display())]
    Child {
        /// The program.
        path: PathBuf,
        /// Why.
        source: std::io::Error,
    },
}

impl Error {
    /// What to do about it.
    #[must_use]
    pub fn hint(&self) -> String {
        match self {
            Self::Io { .. } => "check that the path is right and that you may read it",
            Self::Folder { .. } => "give the .fmu file, not the folder it was unpacked to",
            Self::TooLarge { .. } => "no ordinary FMU is that large",
            Self::Child { .. } => "check that the program and the temporary folder may be used",
        }
        .into()
    }
}
