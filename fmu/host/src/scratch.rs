//! Temporary folders that a killed process does not leave for good.
//!
//! A file in the folder is locked for as long as the process lives. The first folder that a process makes removes
//! those of the same temporary directory whose lock is free.

use std::ffi::OsStr;
use std::fs::{self, File};
use std::io::{Error, ErrorKind, Result};
use std::path::Path;
use std::sync::Once;
use tempfile::TempDir;

/// The start of the folders' names, of which everything is this program's.
const PREFIX: &str = "steerwright-scratch-";
const LOCK: &str = ".lock";
/// Attempts to make a folder before another process takes it for left.
const ATTEMPTS: usize = 10;

/// A temporary folder; removed when it is dropped, and by a later process where this one is killed.
#[derive(Debug)]
pub struct Scratch {
    /// Unlocked before the folder is removed: Windows removes no locked file.
    _lock: File,
    folder: TempDir,
}

impl Scratch {
    /// A new folder, empty but for its lock.
    pub fn new() -> Result<Self> {
        static REMOVED: Once = Once::new();
        let parent = std::env::temp_dir();
        REMOVED.call_once(|| remove_left(&parent));
        for _ in 0..ATTEMPTS {
            let folder = tempfile::Builder::new().prefix(PREFIX).tempdir_in(&parent)?;
            let lock = folder.path().join(LOCK);
            let file = match File::create_new(&lock) {
                Ok(file) => file,
                // Removed by another process before it was locked.
                Err(e) if e.kind() == ErrorKind::NotFound => continue,
                Err(e) => return Err(e),
            };
            match file.lock() {
                Ok(()) => {}
                // Without locks no process takes the folder for left.
                Err(e) if e.kind() == ErrorKind::Unsupported => {}
                Err(e) => return Err(e),
            }
            if lock.exists() {
                return Ok(Self { _lock: file, folder });
            }
        }
        Err(Error::other("the temporary folder is removed as soon as it is made"))
    }

    /// The folder.
    #[must_use]
    pub fn path(&self) -> &Path {
        self.folder.path()
    }
}

/// Removes the folders of processes that are gone.
fn remove_left(parent: &Path) {
    let Ok(entries) = fs::read_dir(parent) else { return };
    for entry in entries.flatten() {
        if entry.file_name().as_encoded_bytes().starts_with(OsStr::new(PREFIX).as_encoded_bytes())
            && entry.metadata().is_ok_and(|metadata| metadata.is_dir() && is_ours(&metadata))
        {
            remove_if_left(&entry.path());
        }
    }
}

fn remove_if_left(folder: &Path) {
    match File::options().write(true).open(folder.join(LOCK)) {
        Ok(file) if file.try_lock().is_ok() => {
            #[cfg(windows)]
            drop(file);
            let _ = fs::remove_dir_all(folder);
        }
        Ok(_) => {}
        // Killed before it had a lock: it is empty, or another process has just made it and tries again.
        Err(_) => {
            let _ = fs::remove_dir(folder);
        }
    }
}

/// Root removes no other user's.
#[cfg(unix)]
fn is_ours(metadata: &fs::Metadata) -> bool {
    use std::os::unix::fs::MetadataExt;
    metadata.uid() == rustix::process::geteuid().as_raw()
}

#[cfg(not(unix))]
fn is_ours(_: &fs::Metadata) -> bool {
    true
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_a_killed_process_left_is_removed_and_nothing_else() {
        let parent = tempfile::tempdir().unwrap();
        let folder = |name: &str, locked: bool| {
            let folder = parent.path().join(name);
            fs::create_dir(&folder).unwrap();
            let lock = locked.then(|| File::create(folder.join(LOCK)).unwrap());
            fs::write(folder.join("library.so"), "").unwrap();
            (folder, lock)
        };
        let (left, lock) = folder("steerwright-scratch-left", true);
        drop(lock);
        let (used, lock) = folder("steerwright-scratch-used", true);
        lock.as_ref().unwrap().lock().unwrap();
        let (foreign, _) = folder("steerwright-else", true);
        let (unlocked, _) = folder("steerwright-scratch-unlocked", false);
        let empty = parent.path().join("steerwright-scratch-empty");
        fs::create_dir(&empty).unwrap();
        remove_left(parent.path());
        assert_eq!(
            [&left, &empty, &used, &foreign, &unlocked].map(|folder| folder.exists()),
            [false, false, true, true, true]
        );
    }
}
