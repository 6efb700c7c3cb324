//! Locks of outputs: two runs never write one file or folder.

use super::identity::Identity;
use crate::failure::Failure;
use std::fs::{self, File, TryLockError};
use std::path::{Path, PathBuf};
use std::time::Duration;

/// A lock that holds for as long as its process lives.
#[derive(Debug)]
pub(super) struct Lock {
    path: PathBuf,
    _file: File,
}

impl Lock {
    /// `target` is what is locked, a file or a folder, for the message.
    pub(super) fn take(path: &Path, target: &Path, kind: &str) -> Result<Self, Failure> {
        loop {
            let file = File::options().create(true).truncate(false).write(true).open(path);
            let file = file.map_err(|e| Failure::file(path, &e))?;
            match lock(&file, PASSING_MS) {
                Ok(()) => {}
                Err(TryLockError::WouldBlock) => {
                    return Err(Failure::new(
                        format!("{}: another run is writing this {kind}", target.display()),
                        format!("wait for it to end, or name another {kind}"),
                    ));
                }
                // A file system without locks.
                Err(TryLockError::Error(e)) if e.kind() == std::io::ErrorKind::Unsupported => {}
                Err(TryLockError::Error(e)) => return Err(Failure::file(path, &e)),
            }
            // Its last holder may have removed it between the two calls: then the lock is on a
            // file that no other process finds.
            let same = match (file.metadata(), fs::metadata(path)) {
                (Ok(a), Ok(b)) => Identity::new(path, &a) == Identity::new(path, &b),
                _ => false,
            };
            if same {
                return Ok(Self { path: path.into(), _file: file });
            }
        }
    }

    pub(super) fn path(&self) -> &Path {
        &self.path
    }
}

/// Pauses after which a lock is asked for again, ms, since a run that looks for what killed runs left holds each file for a
/// moment.
const PASSING_MS: &[u64] = &[5, 20];

/// Locks a file, or says that another process still has it after the pauses.
pub(super) fn lock(file: &File, pauses_ms: &[u64]) -> Result<(), TryLockError> {
    for pause_ms in pauses_ms {
        match file.try_lock() {
            Err(TryLockError::WouldBlock) => std::thread::sleep(Duration::from_millis(*pause_ms)),
            result => return result,
        }
    }
    file.try_lock()
}

impl Drop for Lock {
    /// Removed while it is held, so that it is not another run's.
    fn drop(&mut self) {
        let _ = fs::remove_file(&self.path);
    }
}
