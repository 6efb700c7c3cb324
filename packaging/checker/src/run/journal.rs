//! The journal of a run: one JSON object per line, written before the call that may crash the process.

use crate::finding::{Finding, Location};
use crate::rules::RULES;
use serde::{Deserialize, Serialize};
use std::collections::BTreeSet;
use std::fs::File;
use std::io::{self, Seek, SeekFrom, Write};
use std::path::Path;

pub(super) const REFERENCE: &str = "extra/io.github.steerwright/reference/reference.json";

#[derive(Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
enum Line {
    Started(String),
    /// The entry of the binary, the location of the following findings.
    Runs(String),
    /// Rule and message.
    Found(String, String),
    Done,
}

pub(super) struct Journal {
    file: File,
    /// The findings so far; equal ones of a further run are not repeated.
    found: BTreeSet<(&'static str, String)>,
    /// The place of the present [`Journal::progress`].
    progress: Option<u64>,
    /// The parents of temporary folders, whose names differ between runs.
    temporary: Vec<String>,
}

/// The length of a line of progress, longer than its text.
const PROGRESS_LENGTH: usize = 120;

/// The largest number of findings that are written.
const MOST: usize = 200;

impl Journal {
    pub(super) fn create(path: &Path) -> io::Result<Self> {
        let folder = std::env::temp_dir();
        let mut temporary: Vec<String> = folder
            .canonicalize()
            .iter()
            .chain([&folder])
            .map(|path| path.to_string_lossy().trim_end_matches(['/', '\\']).to_owned())
            .filter(|path| !path.is_empty())
            .collect();
        temporary.dedup();
        Ok(Self { file: File::create(path)?, found: BTreeSet::new(), progress: None, temporary })
    }

    fn write(&mut self, line: &Line) {
        self.progress = None;
        // An error is ignored: the supervisor detects the incomplete journal.
        if let Ok(text) = serde_json::to_string(line) {
            let _ = writeln!(self.file, "{text}");
            let _ = self.file.flush();
        }
    }

    pub(super) fn start(&mut self, what: &str) {
        self.write(&Line::Started(what.into()));
    }

    /// As [`Journal::start`], in the place of the progress before it: for calls that are too many to keep.
    pub(super) fn progress(&mut self, what: &str) {
        let Ok(text) = serde_json::to_string(&Line::Started(what.into())) else { return };
        let place = match self.progress {
            Some(place) => self.file.seek(SeekFrom::Start(place)),
            None => self.file.stream_position(),
        };
        self.progress = place.ok();
        // One write of equal length: what is read is one of the two, whenever the process ends.
        let _ = self.file.write_all(format!("{text:<PROGRESS_LENGTH$}\n").as_bytes());
    }

    pub(super) fn found(&mut self, rule: &'static str, message: impl Into<String>) {
        let mut message = message.into();
        for root in &self.temporary {
            message = without(&message, root);
        }
        if self.found.len() < MOST && self.found.insert((rule, message.clone())) {
            self.write(&Line::Found(rule.into(), message));
        }
    }

    pub(super) fn runs(&mut self, entry: Option<String>) {
        if let Some(entry) = entry {
            self.write(&Line::Runs(entry));
        }
    }

    pub(super) fn done(&mut self) {
        self.write(&Line::Done);
    }
}

/// A text with the paths in temporary folders of `root` made relative to these folders.
fn without(text: &str, root: &str) -> String {
    let mut short = String::new();
    let mut rest = text;
    while let Some(at) = rest.find(root) {
        let before = &rest[..at];
        let tail = &rest[at + root.len()..];
        let Some(below) = tail.strip_prefix(['/', '\\']) else {
            // Another folder whose name begins with that of the root.
            let (kept, next) = rest.split_at(at + root.len());
            short.push_str(kept);
            rest = next;
            continue;
        };
        short.push_str(before.strip_suffix("file://").unwrap_or(before));
        let ends = |c: char| "/\\'\"`:,;)".contains(c) || c.is_whitespace();
        let after = &below[below.find(ends).unwrap_or(below.len())..];
        match after.strip_prefix(['/', '\\']) {
            Some(relative) => rest = relative,
            None => {
                short.push_str("the unpacked archive");
                rest = after;
            }
        }
    }
    short + rest
}

#[derive(Default)]
pub(super) struct End {
    /// The entry of the binary.
    pub(super) place: Location,
    pub(super) started: Option<String>,
    pub(super) done: bool,
}

pub(super) fn read(path: &Path) -> io::Result<(Vec<Finding>, End)> {
    let (mut findings, mut end) = (Vec::new(), End::default());
    let bytes = match std::fs::read(path) {
        // The process died before it could write anything.
        Err(error) if error.kind() == io::ErrorKind::NotFound => Vec::new(),
        other => other?,
    };
    for line in String::from_utf8_lossy(&bytes).lines() {
        match serde_json::from_str(line) {
            Ok(Line::Started(what)) => end.started = Some(what),
            Ok(Line::Found(name, message)) => {
                if let Some(rule) = RULES.iter().find(|rule| rule.name == name) {
                    let place = match rule.name {
                        name if name.starts_with("run-reference") => Location::entry(REFERENCE),
                        _ => end.place.clone(),
                    };
                    findings.push(Finding::new(rule.name, place, message));
                }
            }
            Ok(Line::Runs(entry)) => end.place = Location::entry(entry),
            Ok(Line::Done) => end.done = true,
            Err(_) => {}
        }
    }
    Ok((findings, end))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn temporary_folders_are_left_out() {
        for (text, short) in [
            ("/t/fmu-1/binaries/x.so: no", "binaries/x.so: no"),
            ("at file:///t/fmu-1/resources, not", "at resources, not"),
            ("in '/t/fmu-1' and /t/fmu-1/a /t/fmu-2/b", "in 'the unpacked archive' and a b"),
            ("/tea/x and none", "/tea/x and none"),
        ] {
            assert_eq!(without(text, "/t"), short);
        }
    }
}
