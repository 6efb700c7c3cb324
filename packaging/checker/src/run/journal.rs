//! The journal of a run: one JSON object a line, written before the process can die of what follows.

use crate::finding::{Finding, Location};
use crate::rules::RULES;
use serde::{Deserialize, Serialize};
use std::fs::File;
use std::io::{self, Write};
use std::path::Path;

/// A line.
#[derive(Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
enum Line {
    /// What is done from here on.
    Started(String),
    /// Rule and message.
    Found(String, String),
    /// The end was reached.
    Done,
}

/// A journal being written.
pub(super) struct Journal {
    file: File,
    found: usize,
}

/// Findings that are written at most.
const MOST: usize = 200;

impl Journal {
    pub(super) fn create(path: &Path) -> io::Result<Self> {
        Ok(Self { file: File::create(path)?, found: 0 })
    }

    fn write(&mut self, line: &Line) {
        // Without a journal there is nobody to tell; the supervisor sees that the end is missing.
        if let Ok(text) = serde_json::to_string(line) {
            let _ = writeln!(self.file, "{text}");
            let _ = self.file.flush();
        }
    }

    pub(super) fn start(&mut self, what: &str) {
        self.write(&Line::Started(what.into()));
    }

    pub(super) fn found(&mut self, rule: &'static str, message: impl Into<String>) {
        self.found += 1;
        if self.found <= MOST {
            self.write(&Line::Found(rule.into(), message.into()));
        }
    }

    pub(super) fn done(&mut self) {
        self.write(&Line::Done);
    }
}

/// How far a run came.
#[derive(Default)]
pub(super) struct End {
    pub(super) started: Option<String>,
    pub(super) done: bool,
}

/// Reads a journal; a last line that is cut off is passed over.
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
                    findings.push(Finding::new(rule.name, Location::archive(), message));
                }
            }
            Ok(Line::Done) => end.done = true,
            Err(_) => {}
        }
    }
    Ok((findings, end))
}
