//! Extraction of an untrusted archive.
//!
//! Every entry is checked before a byte is written: its name stays inside the folder, it is a
//! plain file or a folder, its size and its compression ratio are within [`Limits`]. The
//! sizes in the headers are then compared with those decompressed.

use std::collections::HashSet;
use std::fs;
use std::io::{Read, Seek, Write};
use std::path::{Path, PathBuf};

use zip::CompressionMethod;
use zip::read::ZipFile;

use crate::Error;
use crate::scratch::Scratch;

/// Limits on an archive. The defaults are far above any practical FMU.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Limits {
    /// Largest number of entries.
    pub entries: usize,
    /// Largest uncompressed size of one entry, bytes.
    pub entry_bytes: u64,
    /// Largest uncompressed size of all entries together, bytes.
    pub total_bytes: u64,
    /// Largest uncompressed size over compressed size of an entry. DEFLATE reaches 1032 at most;
    /// entries below [`Limits::RATIO_FREE_BYTES`] are exempt from it.
    pub compression_ratio: u64,
}

impl Limits {
    /// An entry up to this size (64 MiB) may have any compression ratio, as maps and tables of zeros
    /// do; the limit on all entries together applies to it as well.
    pub const RATIO_FREE_BYTES: u64 = 64 << 20;
}

impl Default for Limits {
    fn default() -> Self {
        Self {
            entries: 100_000,
            entry_bytes: 512 << 20,
            total_bytes: 2 << 30,
            compression_ratio: 200,
        }
    }
}

/// File type bits of a Unix mode, and the two types that may be extracted.
const TYPE_MASK: u32 = 0o170_000;
const TYPE_FILE: u32 = 0o100_000;
const TYPE_FOLDER: u32 = 0o040_000;

/// Opens an archive; returns the file and its name for messages.
pub(crate) fn open(path: &Path) -> Result<(fs::File, String), Error> {
    let io = |source: std::io::Error| Error::Io { path: path.to_path_buf(), source };
    if fs::metadata(path).map_err(io)?.is_dir() {
        return Err(Error::NotAnArchive {
            archive: path.display().to_string(),
            reason: "it is a folder".to_owned(),
        });
    }
    let name = path.file_name().unwrap_or(path.as_os_str()).to_string_lossy().into_owned();
    Ok((fs::File::open(path).map_err(io)?, name))
}

/// Extracts the archive `name` from `reader` into a temporary folder.
pub(crate) fn extract<R: Read + Seek>(
    reader: R,
    name: &str,
    limits: &Limits,
) -> Result<Scratch, Error> {
    let folder =
        Scratch::new().map_err(|source| Error::Io { path: std::env::temp_dir(), source })?;
    extract_into(reader, name, folder.path(), limits)?;
    Ok(folder)
}

fn extract_into<R: Read + Seek>(
    reader: R,
    name: &str,
    into: &Path,
    limits: &Limits,
) -> Result<(), Error> {
    let archive = || name.to_owned();
    let refused = |reason: String| Error::NotAnArchive { archive: archive(), reason };
    let mut zip = zip::ZipArchive::new(reader).map_err(|e| refused(e.to_string()))?;
    let (got, limit) = (zip.len(), limits.entries);
    if got > limit {
        return Err(Error::TooManyEntries { archive: archive(), got, limit });
    }
    if zip.has_duplicate_names() {
        return Err(Error::DuplicateEntry { archive: archive(), entry: None });
    }
    // Entries that share compressed bytes multiply an archive's size without any bad ratio.
    if zip.has_overlapping_files().map_err(|e| refused(e.to_string()))? {
        return Err(refused("entries overlap".to_owned()));
    }
    let mut seen = HashSet::new();
    let mut total = 0u64;
    for index in 0..zip.len() {
        let mut entry = zip.by_index(index).map_err(|e| {
            let (entry, reason) = (format!("number {index}"), e.to_string());
            Error::CorruptEntry { archive: archive(), entry, reason }
        })?;
        let entry_name = match entry.name() {
            Ok(text) => text.into_owned(),
            Err(_) => String::from_utf8_lossy(entry.name_raw()).into_owned(),
        };
        let relative = check(&entry, &entry_name, name, limits, total)?;
        total += entry.size();
        // The entry `./` is the folder itself.
        if relative.as_os_str().is_empty() {
            continue;
        }
        if !seen.insert(relative.clone()) {
            return Err(Error::DuplicateEntry { archive: archive(), entry: Some(entry_name) });
        }
        write_entry(&mut entry, &entry_name, name, &into.join(relative))?;
    }
    Ok(())
}

/// Refuses an entry by its headers alone; returns the relative path it may be written to.
fn check<R: Read>(
    entry: &ZipFile<'_, R>,
    entry_name: &str,
    archive: &str,
    limits: &Limits,
    total_before: u64,
) -> Result<PathBuf, Error> {
    let names = || (archive.to_owned(), entry_name.to_owned());
    let unsafe_entry = |reason: &'static str| {
        let (archive, entry) = names();
        Error::UnsafeEntry { archive, entry, reason }
    };
    let relative = safe_path(entry_name).map_err(unsafe_entry)?;
    let file_type = entry.unix_mode().map_or(0, |mode| mode & TYPE_MASK);
    if !matches!(file_type, 0 | TYPE_FILE | TYPE_FOLDER) {
        return Err(unsafe_entry("it is a link or a device, not a plain file"));
    }
    if entry.encrypted() {
        return Err(unsafe_entry("it is encrypted"));
    }
    if !matches!(entry.compression(), CompressionMethod::Stored | CompressionMethod::Deflated) {
        return Err(unsafe_entry("it is neither stored nor deflated, as FMI 2.0 requires"));
    }
    let size = entry.size();
    let too_large = |what: &'static str, got: u64, limit: u64| {
        let (archive, entry) = names();
        Error::TooLarge { archive, entry, what, got, limit }
    };
    if size > limits.entry_bytes {
        return Err(too_large("bytes uncompressed", size, limits.entry_bytes));
    }
    let total = total_before.saturating_add(size);
    if total > limits.total_bytes {
        return Err(too_large("bytes in all entries up to this one", total, limits.total_bytes));
    }
    let ratio = size / entry.compressed_size().max(1);
    if size > Limits::RATIO_FREE_BYTES && ratio > limits.compression_ratio {
        return Err(too_large("times its compressed size", ratio, limits.compression_ratio));
    }
    Ok(relative)
}

/// The path of an entry name inside the folder, or why there is none.
///
/// Stricter than needed on purpose: a name like `a/../b` is harmless, but no tool writes it. A part `.`
/// is left out, since zip programs write it.
pub(crate) fn safe_path(name: &str) -> Result<PathBuf, &'static str> {
    if name.contains('\0') {
        return Err("its name contains a NUL");
    }
    if name.contains('\\') {
        return Err("its name contains a backslash; FMI requires forward slashes");
    }
    if name.starts_with('/') {
        return Err("its path is absolute");
    }
    let bytes = name.as_bytes();
    if bytes.len() >= 2 && bytes[1] == b':' && bytes[0].is_ascii_alphabetic() {
        return Err("its path names a drive");
    }
    if cfg!(windows) && name.contains(':') {
        return Err("its name contains a colon");
    }
    let trimmed = name.strip_suffix('/').unwrap_or(name);
    if trimmed.is_empty() {
        return Err("its name is empty");
    }
    let mut path = PathBuf::new();
    for part in trimmed.split('/') {
        match part {
            "" => return Err("its path has an empty part"),
            ".." => return Err("its path leaves the archive's folder (\"..\")"),
            "." => {}
            _ => path.push(part),
        }
    }
    if path.as_os_str().is_empty() && trimmed.len() == name.len() {
        return Err("its name is that of the folder");
    }
    Ok(path)
}

/// Writes one checked entry, holding the decompressed size against the promised one.
fn write_entry<R: Read>(
    entry: &mut ZipFile<'_, R>,
    entry_name: &str,
    archive: &str,
    to: &Path,
) -> Result<(), Error> {
    let io = |source: std::io::Error| Error::Io { path: to.to_path_buf(), source };
    if entry.is_dir() {
        return fs::create_dir_all(to).map_err(io);
    }
    if let Some(folder) = to.parent() {
        fs::create_dir_all(folder).map_err(io)?;
    }
    let corrupt = |reason: String| Error::CorruptEntry {
        archive: archive.to_owned(),
        entry: entry_name.to_owned(),
        reason,
    };
    // `create_new`: on a file system that ignores case, two names may still meet here.
    let mut file = fs::File::options().write(true).create_new(true).open(to).map_err(io)?;
    let promised = entry.size();
    let mut buffer = vec![0u8; 64 << 10];
    let mut written = 0u64;
    loop {
        let n = entry.read(&mut buffer).map_err(|e| corrupt(e.to_string()))?;
        if n == 0 {
            break;
        }
        written += n as u64;
        if written > promised {
            return Err(corrupt(format!("it is longer than the {promised} bytes it promises")));
        }
        file.write_all(&buffer[..n]).map_err(io)?;
    }
    if written != promised {
        return Err(corrupt(format!("it has {written} bytes and promises {promised}")));
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_that_leave_the_folder_are_refused() {
        for name in [
            "../evil",
            "a/../../evil",
            "a/./../b",
            ".",
            "/etc/passwd",
            "C:/x",
            "c:evil",
            "a\\b",
            "..",
            "",
            "/",
            "a//b",
            "nul\0byte",
        ] {
            assert!(safe_path(name).is_err(), "{name:?} was accepted");
        }
        assert_eq!(safe_path("./").unwrap(), PathBuf::new());
        assert_eq!(safe_path("./a/./b").unwrap(), PathBuf::from("a/b"));
        assert_eq!(safe_path("binaries/linux64/").unwrap(), PathBuf::from("binaries/linux64"));
        assert_eq!(safe_path("resources/ä b..c").unwrap(), PathBuf::from("resources/ä b..c"));
    }
}
