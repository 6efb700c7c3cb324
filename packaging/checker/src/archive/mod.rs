//! The archive: its directory, read byte by byte, and the contents of its entries.
//!
//! The zip library that unpacks archives in `host` is tolerant; this module checks the headers themselves.

mod directory;
mod names;

use crate::finding::{Findings, Location};
use directory::Record;
use flate2::read::DeflateDecoder;
use std::collections::{BTreeMap, BTreeSet};
use std::io::Read;
use steerwright_host::Limits;

pub(crate) struct Contents<'a> {
    bytes: &'a [u8],
    records: Vec<Record>,
    /// The names of all entries, sorted.
    present: BTreeSet<String>,
    /// Intact files by name, the first of each name.
    files: BTreeMap<String, usize>,
}

impl<'a> Contents<'a> {
    /// Reads the directory and every entry; `None` if the directory is unreadable.
    pub(crate) fn read(bytes: &'a [u8], findings: &mut Findings) -> Option<Self> {
        let limits = Limits::default();
        let mut records = directory::read(bytes, &limits, findings)?;
        let mut files = BTreeMap::new();
        let written: Vec<&str> = records.iter().map(|record| record.name.as_str()).collect();
        names::check(&written, findings);
        for record in &mut records {
            record.name = names::without_dots(&record.name);
        }
        let mut total = 0_u64;
        for (record, index) in records.iter().zip(0..) {
            let place = || Location::entry(&record.name);
            if let Some(problem) = too_large(record, &mut total, &limits) {
                findings.add("not-examined", place(), problem);
                continue;
            }
            if !record.is_readable {
                continue;
            }
            match verify(record, bytes) {
                Err(problem) => findings.add("zip-entry-damaged", place(), problem),
                Ok(()) if !record.name.is_empty() && !record.name.ends_with('/') => {
                    files.entry(record.name.clone()).or_insert(index);
                }
                Ok(()) => {}
            }
        }
        let present = records.iter().map(|record| record.name.clone()).collect();
        Some(Self { bytes, records, present, files })
    }

    /// The names of all entries, including folders, in the order of the directory.
    pub(crate) fn names(&self) -> impl Iterator<Item = &str> {
        self.records.iter().map(|record| record.name.as_str()).filter(|name| !name.is_empty())
    }

    /// Whether an entry exists, intact or damaged: a damaged one is already a finding.
    pub(crate) fn has(&self, name: &str) -> bool {
        self.present.contains(name)
    }

    /// The bytes of an intact file.
    pub(crate) fn file(&self, name: &str) -> Option<Vec<u8>> {
        unpack(&self.records[*self.files.get(name)?], self.bytes)
    }

    pub(crate) fn has_folder(&self, folder: &str) -> bool {
        self.names().any(|name| name.starts_with(folder))
    }
}

/// Why an entry is not unpacked: its declared size is too large.
fn too_large(record: &Record, total: &mut u64, limits: &Limits) -> Option<String> {
    let size = u64::from(record.size);
    *total += size;
    let ratio = size / u64::from(record.compressed).max(1);
    if size > limits.entry_bytes {
        Some(format!("{size} bytes unpacked, more than {}", limits.entry_bytes))
    } else if *total > limits.total_bytes {
        let limit = limits.total_bytes;
        Some(format!("{total} bytes unpacked up to here, more than {limit}"))
    } else if size > Limits::RATIO_FREE_BYTES && ratio > limits.compression_ratio {
        let limit = limits.compression_ratio;
        Some(format!("{ratio} times its compressed size, more than {limit}"))
    } else {
        None
    }
}

/// Unpacks an entry and compares its size and checksum with the directory.
fn verify(record: &Record, bytes: &[u8]) -> Result<(), String> {
    let mut hasher = crc32fast::Hasher::new();
    let mut count = 0_u64;
    let mut buffer = vec![0; 64 << 10];
    let mut reader = reader(record, bytes);
    loop {
        let n = reader.read(&mut buffer).map_err(|e| format!("it cannot be unpacked: {e}"))?;
        if n == 0 {
            break;
        }
        count += n as u64;
        hasher.update(&buffer[..n]);
    }
    if count != u64::from(record.size) {
        let bound = if count > u64::from(record.size) { "at least " } else { "" };
        return Err(format!("its size is {} bytes, but it has {bound}{count}", record.size));
    }
    if hasher.finalize() != record.crc {
        return Err("its checksum differs from the directory's".into());
    }
    Ok(())
}

/// The bytes of a verified entry.
fn unpack(record: &Record, bytes: &[u8]) -> Option<Vec<u8>> {
    let mut contents = Vec::new();
    reader(record, bytes).read_to_end(&mut contents).ok()?;
    Some(contents)
}

/// The unpacked bytes, at most one more than the declared size.
fn reader<'a>(record: &Record, bytes: &'a [u8]) -> impl Read + use<'a> {
    let data = bytes.get(record.data.clone()).unwrap_or_default();
    let limit = u64::from(record.size) + 1;
    let unpacked: Box<dyn Read + 'a> =
        if record.deflated { Box::new(DeflateDecoder::new(data)) } else { Box::new(data) };
    unpacked.take(limit)
}
