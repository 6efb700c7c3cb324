//! Telling the result: tables for people on stderr, JSON for scripts on stdout.

use crate::failure::Failure;
use serde::Serialize;
use std::io::Write;

/// How a result is told.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Tell {
    json: bool,
}

impl Tell {
    pub(crate) fn new(json: bool) -> Self {
        Self { json }
    }

    /// Tells the text on stderr and, where asked for, the value as JSON on stdout.
    pub(crate) fn result(self, text: &str, value: &impl Serialize) -> Result<(), Failure> {
        // The work is done and written: a reader who has gone away makes no failure of it.
        let _ = writeln!(std::io::stderr(), "{}", text.trim_end());
        if self.json {
            let failed = |e: std::io::Error| {
                Failure::new(format!("stdout: {e}"), "check where the output is led")
            };
            let json = serde_json::to_string_pretty(value).map_err(|e| failed(e.into()))?;
            match writeln!(std::io::stdout().lock(), "{json}") {
                Err(e) if e.kind() != std::io::ErrorKind::BrokenPipe => return Err(failed(e)),
                _ => {}
            }
        }
        Ok(())
    }
}
