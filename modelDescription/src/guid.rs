//! The GUID that ties a binary, its description and its resources together.

use crate::table::{DependsOn, Table};
use sha2::{Digest, Sha256};

/// SHA-256 over the table (the version included) and the resources sorted by name, the first 128
/// bits of it written as a UUID without braces.
///
/// Every text and blob enters with its length before it, so that no two inputs run into each
/// other. Version and variant bits are those of a version 8 UUID (RFC 9562: custom content).
#[must_use]
pub fn guid(table: &Table, resources: &[(String, Vec<u8>)]) -> String {
    let mut hash = Sha256::new();
    fingerprint(table, &mut |bytes| hash.update(bytes));
    let mut sorted: Vec<&(String, Vec<u8>)> = resources.iter().collect();
    sorted.sort();
    hash.update((sorted.len() as u64).to_le_bytes());
    for (name, bytes) in sorted {
        blob(&mut |bytes| hash.update(bytes), name.as_bytes());
        blob(&mut |bytes| hash.update(bytes), bytes);
    }
    let digest = hash.finalize();
    let mut id = [0_u8; 16];
    id.copy_from_slice(&digest[..16]);
    id[6] = id[6] & 0x0f | 0x80;
    id[8] = id[8] & 0x3f | 0x80;
    let hex: String = id.iter().map(|byte| format!("{byte:02x}")).collect();
    [&hex[..8], &hex[8..12], &hex[12..16], &hex[16..20], &hex[20..]].join("-")
}

/// Feeds everything in the table to a hash.
fn fingerprint(table: &Table, feed: &mut dyn FnMut(&[u8])) {
    blob(feed, b"model-description table 1");
    for text in [table.model_name, table.version, table.description] {
        blob(feed, text.as_bytes());
    }
    feed(&(table.variables.len() as u64).to_le_bytes());
    for row in table.variables {
        blob(feed, row.name.as_bytes());
        feed(&row.reference.to_le_bytes());
        for word in [row.kind.as_str(), row.causality.as_str(), row.variability.as_str()] {
            blob(feed, word.as_bytes());
        }
        for text in [row.effective_initial().map(|i| i.as_str()), row.unit, row.display_unit] {
            blob(feed, text.unwrap_or("").as_bytes());
        }
        for number in [row.min, row.max, row.nominal] {
            feed(&[u8::from(number.is_some())]);
            feed(&number.unwrap_or(0.0).to_le_bytes());
        }
        blob(feed, row.description.as_bytes());
        for depends_on in [row.depends_on, row.initial_depends_on] {
            match depends_on {
                DependsOn::Nothing => feed(&[0]),
                DependsOn::All => feed(&[1]),
                DependsOn::On(names) => {
                    feed(&[2]);
                    feed(&(names.len() as u64).to_le_bytes());
                    for name in names {
                        blob(feed, name.as_bytes());
                    }
                }
            }
        }
    }
}

/// Feeds a length and the bytes after it.
fn blob(feed: &mut dyn FnMut(&[u8]), bytes: &[u8]) {
    feed(&(bytes.len() as u64).to_le_bytes());
    feed(bytes);
}
