//! Why an archive cannot be checked.

use std::path::PathBuf;

/// Why an archive cannot be checked.
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
    /// The path is a folder.
    #[error("{} is a folder", path.display())]
    Folder {
        /// The folder.
        path: PathBuf,
    },
    /// The file is too large to be read into memory.
    #[error("{} has {got} bytes, more than {limit}", path.display())]
    TooLarge {
        /// The file.
        path: PathBuf,
        /// The size, bytes.
        got: u64,
        /// The largest size, bytes.
        limit: u64,
    },
    /// The process that exercises the binary cannot be started.
    #[error("{}: the process that runs the FMU cannot be started: {source}", path.display())]
    Child {
        /// The program.
        path: PathBuf,
        /// Why.
        source: std::io::Error,
    },
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
