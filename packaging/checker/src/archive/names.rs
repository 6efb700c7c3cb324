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
        } else if name.split('/').any(|part| part == ".") {
            findings.add("zip-dot-name", place(), "its path has a part \".\"");
        } else if name.contains('\\') {
            findings.add("zip-backslash", place(), "its name has a backslash");
        }
        if !name.is_ascii() {
            findings.add("zip-non-ascii", place(), "its name has characters outside ASCII");
        }
        let plain = without_dots(name);
        if plain.is_empty() {
            continue;
        }
        if !seen.insert(plain.clone()) {
            findings.add("zip-duplicate", place(), "a second entry of this name");
        } else if let Some(other) = folded.insert(plain.to_lowercase(), name) {
            let message = format!("differs from {other:?} only in case");
            findings.add("zip-case-collision", place(), message);
        }
    }
    // A file that is also the folder of another entry.
    for &name in names {
        let plain = without_dots(name);
        let mut parents = plain.rmatch_indices('/').map(|(at, _)| &plain[..at]);
        if let Some(file) = parents.find(|parent| seen.contains(*parent)) {
            let message = format!("is in {file:?}, which is a file");
            findings.add("zip-duplicate", Location::entry(name), message);
        }
    }
}

/// A name without its parts `.`, as importers unpack it; that of the archive's own folder is empty.
pub(super) fn without_dots(name: &str) -> String {
    let mut parts: Vec<&str> = name.split('/').filter(|part| *part != ".").collect();
    if parts == [""] {
        parts.clear();
    }
    parts.join("/")
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
            ".." => return Some("its path has a part \"..\""),
            _ => {}
        }
    }
    None
}
