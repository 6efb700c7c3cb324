//! The archive: its directory, read byte by byte, and its entries' contents.
//!
//! The zip library that unpacks archives elsewhere is tolerant, as it should be; here the headers
//! themselves are looked at.

mod directory;
mod names;
mod unpack;

use crate::finding::{Findings, Location};
use directory::Record;
use host::Limits;
use std::collections::{BTreeMap, BTreeSet};

/// The entries of a readable archive.
pub(crate) struct Contents<'a> {
    bytes: &'a [u8],
    records: Vec<Record>,
    /// The names of all entries, sorted.
    present: BTreeSet<String>,
    /// Files by name; the first of a name counts.
    files: BTreeMap<String, usize>,
}

impl<'a> Contents<'a> {
    /// Reads the directory and every entry; `None` where there is no archive to speak of.
    pub(crate) fn read(bytes: &'a [u8], findings: &mut Findings) -> Option<Self> {
        let limits = Limits::default();
        let records = directory::read(bytes, &limits, findings)?;
        let mut files = BTreeMap::new();
        let names: Vec<&str> = records.iter().map(|record| record.name.as_str()).collect();
        names::check(&names, findings);
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
            match unpack::verify(record, bytes) {
                Err(problem) => findings.add("zip-entry-damaged", place(), problem),
                Ok(()) if !record.name.ends_with('/') => {
                    files.entry(record.name.clone()).or_insert(index);
                }
                Ok(()) => {}
            }
        }
        let present = names.into_iter().map(str::to_owned).collect();
        Some(Self { bytes, records, present, files })
    }

    /// The names of all entries, folders among them, as they stand in the directory.
    pub(crate) fn names(&self) -> impl Iterator<Item = &str> {
        self.records.iter().map(|record| record.name.as_str())
    }

    /// Whether there is an entry of that name, intact or not: a damaged one is a finding already.
    pub(crate) fn has(&self, name: &str) -> bool {
        self.present.contains(name)
    }

    /// The bytes of an intact file.
    pub(crate) fn file(&self, name: &str) -> Option<Vec<u8>> {
        unpack::contents(&self.records[*self.files.get(name)?], self.bytes)
    }

    /// Whether there is anything in that folder, given with a slash at its end.
    pub(crate) fn has_folder(&self, folder: &str) -> bool {
        self.names().any(|name| name.starts_with(folder))
    }
}

/// Why an entry is not unpacked: by its own promise it takes too much room.
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
