//! The command that starts this command line in another process.

use std::ffi::OsString;
use std::sync::OnceLock;

/// Program and first arguments, where it is not this executable.
static PROGRAM: OnceLock<Vec<OsString>> = OnceLock::new();

pub(crate) fn set(program: Option<Vec<OsString>>) {
    if let Some(words) = program.filter(|words| !words.is_empty()) {
        // The first one holds: it is the same for the whole process.
        let _ = PROGRAM.set(words);
    }
}

/// The program and its first arguments.
pub(crate) fn words() -> std::io::Result<(OsString, Vec<OsString>)> {
    match PROGRAM.get().and_then(|words| words.split_first()) {
        Some((program, first)) => Ok((program.clone(), first.to_vec())),
        None => Ok((std::env::current_exe()?.into(), Vec::new())),
    }
}
