//! The identity of the file behind a path, independent of its name.

use std::fs::{self, Metadata};
use std::path::{Component, Path, PathBuf};

/// Links that are followed, as by Linux.
const LINKS: usize = 40;

/// A file of this machine: through symbolic links, and the same for all of its hard links.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) enum Identity {
    /// Device and inode.
    #[cfg(unix)]
    There(u64, u64),
    /// Its path without links.
    #[cfg(not(unix))]
    There(PathBuf),
    /// Where a file will be.
    New(PathBuf),
}

impl Identity {
    /// Of a file that is there. `-` is standard input.
    pub(super) fn of_input(path: &Path) -> Option<Self> {
        let path = if path == Path::new("-") { Path::new("/dev/stdin") } else { path };
        let metadata = fs::metadata(path).ok()?;
        // A terminal is read and written at the same time, and /dev/null as often as one likes.
        if metadata.is_file() || is_fifo(&metadata) {
            Some(Self::new(path, &metadata))
        } else {
            None
        }
    }

    #[cfg(unix)]
    pub(super) fn new(_: &Path, metadata: &Metadata) -> Self {
        use std::os::unix::fs::MetadataExt;
        Self::There(metadata.dev(), metadata.ino())
    }

    #[cfg(not(unix))]
    pub(super) fn new(path: &Path, _: &Metadata) -> Self {
        Self::There(fs::canonicalize(path).unwrap_or_else(|_| path.to_path_buf()))
    }

    /// Of a file that is not there yet, below the folder that is.
    pub(super) fn of_new(path: &Path) -> Self {
        let (there, rest) = nearest(path);
        let there = fs::canonicalize(&there).unwrap_or(there);
        Self::New(there.join(rest))
    }
}

/// A FIFO or an open pipe.
#[cfg(unix)]
pub(super) fn is_fifo(metadata: &Metadata) -> bool {
    std::os::unix::fs::FileTypeExt::is_fifo(&metadata.file_type())
}

#[cfg(not(unix))]
pub(super) fn is_fifo(_: &Metadata) -> bool {
    false
}

/// A terminal, /dev/null and the like.
#[cfg(unix)]
pub(super) fn is_character_device(metadata: &Metadata) -> bool {
    std::os::unix::fs::FileTypeExt::is_char_device(&metadata.file_type())
}

#[cfg(not(unix))]
pub(super) fn is_character_device(_: &Metadata) -> bool {
    false
}

/// The file that a path leads to, through symbolic links; what an open file is called by its number
/// stays so, since that is not a link that could be followed by name.
pub(super) fn resolved(path: &Path) -> PathBuf {
    let mut path = path.to_path_buf();
    for _ in 0..LINKS {
        if is_open_file(&path) {
            break;
        }
        let Ok(to) = fs::read_link(&path) else { break };
        path = path.parent().unwrap_or(Path::new("")).join(to);
    }
    path
}

/// Whether a path names a file that is open already: /dev/stdout, /dev/fd/3.
pub(super) fn is_open_file(path: &Path) -> bool {
    let standard = ["/dev/stdin", "/dev/stdout", "/dev/stderr"];
    standard.iter().any(|name| path == Path::new(name))
        || path.starts_with("/dev/fd")
        || path.strip_prefix("/proc").is_ok_and(|rest| {
            let parts: Vec<_> = rest.components().collect();
            parts.len() >= 3 && parts[parts.len() - 2] == Component::Normal("fd".as_ref())
        })
}

pub(super) fn is_stdout(path: &Path) -> bool {
    ["-", "/dev/stdout", "/dev/fd/1", "/proc/self/fd/1"].iter().any(|name| path == Path::new(name))
}

/// The nearest part of a path that is there, and the rest.
pub(super) fn nearest(path: &Path) -> (PathBuf, PathBuf) {
    let mut there = path.to_path_buf();
    let mut rest = Vec::new();
    while fs::symlink_metadata(&there).is_err() {
        let Some(name) = there.file_name().map(ToOwned::to_owned) else { break };
        rest.push(name);
        there.pop();
    }
    if there.as_os_str().is_empty() {
        there = ".".into();
    }
    (there, rest.iter().rev().collect())
}
