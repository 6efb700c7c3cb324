//! The command that starts this command line in another process, and whether this is that process.

use std::ffi::OsString;
use std::sync::OnceLock;

/// Program and first arguments, where it is not this executable.
static PROGRAM: OnceLock<Vec<OsString>> = OnceLock::new();
/// The variable with the identifier of the process that waits for a guarded one.
pub(crate) const GUARDED_BY: &str = "STEERWRIGHT_GUARDED_BY";
/// The exit status of a guarded command that ended with 0; the others follow.
pub(crate) const FINISHED: u8 = 96;
/// The exit status of a command that was interrupted.
pub(crate) const INTERRUPTED: u8 = 130;

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

/// Whether this process is the guarded one.
pub(crate) fn is_guarded() -> bool {
    let Some(parent) = std::env::var(GUARDED_BY).ok().and_then(|text| text.parse::<u32>().ok())
    else {
        return false;
    };
    #[cfg(unix)]
    if std::os::unix::process::parent_id() != parent {
        return false;
    }
    #[cfg(not(unix))]
    let _ = parent;
    true
}

/// The exit status of a process whose work ends with this one.
pub(crate) fn exit_status(status: u8) -> u8 {
    if is_guarded() { FINISHED + status } else { status }
}
