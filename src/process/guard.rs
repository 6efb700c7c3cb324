//! A command that runs FMUs, in a process of its own: an FMU that crashes or ends the process is a failure with
//! a message, and no success.
//!
//! The process repeats the command line with [`GUARDED_BY`] in its environment. Only a command that came to its end
//! has an exit status from [`FINISHED`] on; an FMU that calls `exit(0)` has not. The rows that a run has until then
//! are in a file of the waiting process, which keeps them.

use crate::failure::Failure;
use crate::process::program::{self, FINISHED, GUARDED_BY, INTERRUPTED};
use std::ffi::OsString;
use std::fs::File;
use std::io::{IsTerminal, Write};
use std::process::{Command, ExitStatus};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use steerwright_host::process::{Subprocess, end_with_parent, on_interruption};

const REPORT: &str = "report this with the command";
/// The rows of a run, in the folder of temporary files that the waiting process owns.
const ROWS: &str = "rows.csv";

/// The rows of a run, written as soon as they are there: an FMU that crashes loses none of them.
#[derive(Debug)]
pub(crate) struct KeptRows {
    file: std::io::Result<File>,
}

impl KeptRows {
    /// No rows yet; in the guarded process.
    pub(crate) fn new() -> Self {
        Self { file: File::create(std::env::temp_dir().join(ROWS)) }
    }

    /// Writes lines, unless an earlier one could not be written.
    pub(crate) fn write(&mut self, lines: &str) {
        if let Ok(file) = &mut self.file
            && let Err(error) = file.write_all(lines.as_bytes())
        {
            self.file = Err(error);
        }
    }

    /// Why rows are missing.
    pub(crate) fn error(&self) -> Option<&std::io::Error> {
        self.file.as_ref().err()
    }
}

/// Does the work in the guarded process, which ends with the waiting one; returns its exit status.
pub(crate) fn guarded(work: impl FnOnce() -> u8) -> u8 {
    if let Err(error) = end_with_parent() {
        return FINISHED
            + Failure::new(format!("the pipe of the waiting process: {error}"), REPORT).report();
    }
    FINISHED + work()
}

/// What an interruption of the waiting process does to the guarded one.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Interruption {
    /// Both end at once.
    Ends,
    /// The guarded one is asked to end, which it does in its own way; a second interruption ends it at once.
    IsPassedOn,
}

/// Runs the command line in another process and returns its exit status. Where that process does not come to its
/// end, `keep` receives the rows of its run as CSV, and returns what became of them.
pub(crate) fn run(
    arguments: &[OsString],
    interruption: Interruption,
    keep: impl FnOnce(&str) -> Result<Option<String>, Failure>,
) -> u8 {
    let hint = "an FMU crashed or ended the process: steerwright check --run FMU names the call";
    let interrupted = Arc::new(AtomicBool::new(false));
    match started(arguments, interruption, &interrupted) {
        Ok((status, rows)) => match status.code().and_then(|code| u8::try_from(code).ok()) {
            Some(code @ FINISHED..) => code - FINISHED,
            _ if interrupted.load(Ordering::Relaxed) => {
                Failure::new("interrupted", "run the command again").report();
                INTERRUPTED
            }
            _ => {
                let mut message = format!(
                    "the process that runs the FMUs {} before the command was done",
                    describe(status)
                );
                match keep(complete_lines(&rows)) {
                    Ok(kept) => message.extend(kept.map(|kept| format!("; {kept}"))),
                    Err(error) => {
                        message += &format!("; its rows are not kept: {}", error.message())
                    }
                }
                Failure::new(message, hint).report()
            }
        },
        Err(error) => Failure::new(
            format!("the process that runs the FMUs cannot be started: {error}"),
            "check the permissions of the program",
        )
        .report(),
    }
}

/// Without a last line that was cut off.
fn complete_lines(text: &str) -> &str {
    &text[..text.rfind('\n').map_or(0, |end| end + 1)]
}

/// The exit status of the process, and the rows of its run.
fn started(
    arguments: &[OsString],
    interruption: Interruption,
    interrupted: &Arc<AtomicBool>,
) -> std::io::Result<(ExitStatus, String)> {
    let (program, first) = program::words()?;
    let mut command = Command::new(program);
    command.args(first).args(&arguments[1.min(arguments.len())..]);
    command.env(GUARDED_BY, std::process::id().to_string());
    // A process in the background that reads a terminal is stopped.
    let mut process = if std::io::stdin().is_terminal() {
        Subprocess::start(&mut command)?
    } else {
        Subprocess::start_with_input(&mut command)?
    };
    if interruption == Interruption::IsPassedOn {
        let (interrupt, interrupted) = (process.interrupter(), Arc::clone(interrupted));
        // Without it an interruption ends both at once.
        let _ = on_interruption(move || interrupt(interrupted.swap(true, Ordering::Relaxed)));
    }
    // `Child::wait` closes the standard input.
    let _input = process.take_input();
    let status = process.child().wait()?;
    // Where the run did not begin there is no file.
    let rows = std::fs::read_to_string(process.folder().join(ROWS)).unwrap_or_default();
    Ok((status, rows))
}

#[cfg(unix)]
fn describe(status: ExitStatus) -> String {
    use std::os::unix::process::ExitStatusExt;
    match status.signal() {
        None => format!("ended with {status}"),
        Some(4) => "ended with signal SIGILL".into(),
        Some(6) => "ended with signal SIGABRT".into(),
        Some(7) => "ended with signal SIGBUS".into(),
        Some(8) => "ended with signal SIGFPE".into(),
        Some(9) => "ended with signal SIGKILL".into(),
        Some(11) => "ended with signal SIGSEGV".into(),
        Some(signal) => format!("ended with signal {signal}"),
    }
}

#[cfg(not(unix))]
fn describe(status: ExitStatus) -> String {
    format!("ended with {status}")
}
