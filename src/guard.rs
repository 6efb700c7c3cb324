//! A command that runs FMUs, in a process of its own: an FMU that crashes or ends the process is a failure with
//! a message, and no success.
//!
//! The process repeats the command line with [`PARENT`] in its environment. Only a command that came to its end
//! has an exit status from [`FINISHED`] on; an FMU that calls `exit(0)` has not.

use crate::failure::Failure;
use crate::program;
use std::ffi::OsString;
use std::io::IsTerminal;
use std::process::{Command, ExitStatus};
use steerwright_host::process::{Subprocess, end_with_parent};

/// The variable with the identifier of the process that waits.
const PARENT: &str = "STEERWRIGHT_GUARDED_BY";
const REPORT: &str = "report this with the command";
/// The exit status of a guarded command that ended with 0.
const FINISHED: u8 = 96;

/// Whether this process is the guarded one.
pub(crate) fn is_guarded() -> bool {
    let Some(parent) = std::env::var(PARENT).ok().and_then(|text| text.parse::<u32>().ok()) else {
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

/// Does the work in the guarded process, which ends with the waiting one; returns its exit status.
pub(crate) fn guarded(work: impl FnOnce() -> u8) -> u8 {
    if let Err(error) = end_with_parent() {
        return FINISHED
            + Failure::new(format!("the pipe of the waiting process: {error}"), REPORT).report();
    }
    FINISHED + work()
}

/// Runs the command line in another process and returns its exit status.
pub(crate) fn run(arguments: &[OsString]) -> u8 {
    match started(arguments) {
        Ok(status) => match status.code().and_then(|code| u8::try_from(code).ok()) {
            Some(code @ FINISHED..) => code - FINISHED,
            _ => Failure::new(
                format!(
                    "the process that runs the FMUs {} before the command was done",
                    describe(status)
                ),
                "an FMU crashed or ended the process: steerwright check --run FMU names the call",
            )
            .report(),
        },
        Err(error) => Failure::new(
            format!("the process that runs the FMUs cannot be started: {error}"),
            "check the permissions of the program",
        )
        .report(),
    }
}

fn started(arguments: &[OsString]) -> std::io::Result<ExitStatus> {
    let (program, first) = program::words()?;
    let mut command = Command::new(program);
    command.args(first).args(&arguments[1.min(arguments.len())..]);
    command.env(PARENT, std::process::id().to_string());
    // A process in the background that reads a terminal is stopped.
    let mut process = if std::io::stdin().is_terminal() {
        Subprocess::start(&mut command)?
    } else {
        Subprocess::start_with_input(&mut command)?
    };
    // `Child::wait` closes the standard input.
    let _input = process.take_input();
    process.child().wait()
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
