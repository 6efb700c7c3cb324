//! The files in `resources/` of an FMU, read into memory.

use std::path::{Path, PathBuf};
use std::sync::Arc;

/// The largest total size of resources, bytes: a wrong location is reported instead of read.
const BYTES_LIMIT: u64 = 256 << 20;
/// The largest number of resource files.
const FILES_LIMIT: usize = 10_000;

/// Files that file managers create.
const FILE_MANAGER_FILES: [&str; 2] = ["Thumbs.db", "desktop.ini"];

/// Why the resources cannot be read.
#[derive(Debug, thiserror::Error)]
#[allow(missing_docs)] // the fields are named in the messages
pub enum ResourceError {
    #[error("cannot read the resources at {path}: {source}")]
    Io { path: PathBuf, source: std::io::Error },
    #[error("the resources at {path} have more than {limit} {what}")]
    TooLarge { path: PathBuf, limit: u64, what: &'static str },
    #[error("the resource location \"{location}\" {problem}")]
    Location { location: String, problem: String },
}

impl ResourceError {
    /// The suggested fix.
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

/// Files by name, sorted; folders in names end with forward slashes. Cloning is cheap.
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
    /// Reads a folder with its subfolders. Links are skipped, and so are the files of file managers
    /// (names that begin with a dot, `Thumbs.db`, `desktop.ini`), so that opening an FMU's folder in a
    /// file manager does not change its GUID. A missing folder is empty.
    ///
    /// # Errors
    /// [`ResourceError`] if a file cannot be read or the resources are too large.
    pub fn read(folder: &Path) -> Result<Self, ResourceError> {
        let mut entries = Vec::new();
        let mut bytes = 0;
        if folder.exists() {
            collect(folder, folder, "", &mut entries, &mut bytes)?;
        }
        Ok(entries.into())
    }

    /// The content of a file.
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
        if name.starts_with('.') || FILE_MANAGER_FILES.contains(&&*name) {
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
    fn files_of_file_managers_are_skipped() {
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
