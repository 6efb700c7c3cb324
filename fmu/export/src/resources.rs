//! The files under `resources/` of an FMU, read at once.

use std::path::{Path, PathBuf};
use std::sync::Arc;

/// The most bytes that resources may have together: a wrong location is noticed, not swallowed.
const BYTES_LIMIT: u64 = 256 << 20;
/// The most files that resources may have.
const FILES_LIMIT: usize = 10_000;

/// What file managers leave in folders.
const LEFT_BEHIND: [&str; 2] = ["Thumbs.db", "desktop.ini"];

/// Why the resources cannot be read.
#[derive(Debug, thiserror::Error)]
pub enum ResourceError {
    /// The file system says no.
    #[error("cannot read the resources at {path}: {source}")]
    Io {
        /// The file or folder.
        path: PathBuf,
        /// The system's reason.
        source: std::io::Error,
    },
    /// There is too much under the location.
    #[error("the resources at {path} have more than {limit} {what}")]
    TooLarge {
        /// The resources' folder.
        path: PathBuf,
        /// The limit that is passed.
        limit: u64,
        /// Of what.
        what: &'static str,
    },
    /// The location is no path.
    #[error("the resource location \"{location}\" {problem}")]
    Location {
        /// The location as given.
        location: String,
        /// What is wrong with it.
        problem: String,
    },
}

impl ResourceError {
    /// What the reader can do about it.
    #[must_use]
    pub fn hint(&self) -> &'static str {
        match self {
            Self::Io { .. } => "unpack the archive again where the process may read it",
            Self::TooLarge { .. } | Self::Location { .. } => {
                "pass the file: URI of the folder `resources` of the unpacked archive"
            }
        }
    }
}

/// Files by name, sorted; names have forward slashes. Cloning is cheap.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Resources {
    entries: Arc<Vec<(String, Vec<u8>)>>,
}

impl From<Vec<(String, Vec<u8>)>> for Resources {
    fn from(mut entries: Vec<(String, Vec<u8>)>) -> Self {
        entries.sort();
        Self { entries: Arc::new(entries) }
    }
}

impl Resources {
    /// Reads a folder and those in it. Links are passed over, and what file managers leave behind
    /// (names that begin with a dot, `Thumbs.db`, `desktop.ini`): an FMU whose folder was looked at
    /// is still the same. A folder that is not there is empty.
    ///
    /// # Errors
    /// [`ResourceError`] if something cannot be read or is too large.
    pub fn read(folder: &Path) -> Result<Self, ResourceError> {
        let mut entries = Vec::new();
        let mut bytes = 0;
        if folder.exists() {
            collect(folder, folder, "", &mut entries, &mut bytes)?;
        }
        Ok(entries.into())
    }

    /// The bytes of the file with that name.
    #[must_use]
    pub fn get(&self, name: &str) -> Option<&[u8]> {
        let index = self.entries.binary_search_by(|(known, _)| known.as_str().cmp(name)).ok()?;
        self.entries.get(index).map(|(_, bytes)| bytes.as_slice())
    }

    /// Every file, sorted by name.
    #[must_use]
    pub fn entries(&self) -> &[(String, Vec<u8>)] {
        &self.entries
    }
}

fn collect(
    root: &Path,
    folder: &Path,
    prefix: &str,
    entries: &mut Vec<(String, Vec<u8>)>,
    bytes: &mut u64,
) -> Result<(), ResourceError> {
    let fault = |path: &Path| {
        let path = path.to_owned();
        move |source| ResourceError::Io { path, source }
    };
    for entry in std::fs::read_dir(folder).map_err(fault(folder))? {
        let entry = entry.map_err(fault(folder))?;
        let path = entry.path();
        let name = entry.file_name();
        let name = name.to_string_lossy();
        if name.starts_with('.') || LEFT_BEHIND.contains(&&*name) {
            continue;
        }
        let name = format!("{prefix}{name}");
        let metadata = entry.metadata().map_err(fault(&path))?;
        if metadata.is_dir() {
            collect(root, &path, &format!("{name}/"), entries, bytes)?;
        } else if metadata.is_file() {
            *bytes += metadata.len();
            let too_large =
                |limit, what| ResourceError::TooLarge { path: root.into(), limit, what };
            if *bytes > BYTES_LIMIT {
                return Err(too_large(BYTES_LIMIT, "bytes"));
            }
            if entries.len() >= FILES_LIMIT {
                return Err(too_large(FILES_LIMIT as u64, "files"));
            }
            entries.push((name, std::fs::read(&path).map_err(fault(&path))?));
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_file_managers_leave_is_passed_over() {
        let folder = std::env::temp_dir().join(format!("resources-{}", std::process::id()));
        std::fs::create_dir_all(folder.join(".git")).unwrap();
        std::fs::create_dir_all(folder.join("deep")).unwrap();
        for name in [".DS_Store", "Thumbs.db", "desktop.ini", ".git/a", "deep/.b", "deep/c.json"] {
            std::fs::write(folder.join(name), name).unwrap();
        }
        let read = Resources::read(&folder);
        std::fs::remove_dir_all(&folder).unwrap();
        let read = read.unwrap();
        assert_eq!(read.entries(), [("deep/c.json".to_owned(), b"deep/c.json".to_vec())]);
    }
}
