//! Names of entries: forward slashes, inside the archive, unique.

use crate::finding::{Findings, Location};
use std::collections::{BTreeMap, BTreeSet};

pub(super) fn check(names: &[&str], findings: &mut Findings) {
    let mut seen = BTreeSet::new();
    let mut folded: BTreeMap<String, &str> = BTreeMap::new();
    for &name in names {
        let place = || Location::entry(name);
        if let Some(problem) = unsafe_name(name) {
            findings.add("zip-unsafe-name", place(), problem);
        } else if name.contains('\\') {
            findings.add("zip-backslash", place(), "its name has a backslash");
        }
        if !name.is_ascii() {
            findings.add("zip-non-ascii", place(), "its name has characters outside ASCII");
        }
        if !seen.insert(name) {
            findings.add("zip-duplicate", place(), "a second entry of this name");
        } else if let Some(other) = folded.insert(name.to_lowercase(), name) {
            let message = format!("differs from {other:?} only in case");
            findings.add("zip-case-collision", place(), message);
        }
    }
    // A file that is also the folder of another entry.
    for &name in names {
        let mut parents = name.rmatch_indices('/').map(|(at, _)| &name[..at]);
        if let Some(file) = parents.find(|parent| seen.contains(parent)) {
            let message = format!("is in {file:?}, which is a file");
            findings.add("zip-duplicate", Location::entry(name), message);
        }
    }
}

/// Why a name could point outside the folder that an archive is unpacked to.
fn unsafe_name(name: &str) -> Option<&'static str> {
    let bytes = name.as_bytes();
    if name.trim_end_matches('/').is_empty() {
        return Some("its name is empty");
    }
    if name.chars().any(char::is_control) {
        return Some("its name has a control character");
    }
    if name.starts_with(['/', '\\']) {
        return Some("its path is absolute");
    }
    if bytes.len() >= 2 && bytes[1] == b':' && bytes[0].is_ascii_alphabetic() {
        return Some("its path has a drive letter");
    }
    let path = name.strip_suffix('/').unwrap_or(name);
    for part in path.split(['/', '\\']) {
        match part {
            "" => return Some("its path has an empty part"),
            "." | ".." => return Some("its path has a part \".\" or \"..\""),
            _ => {}
        }
    }
    None
}
