//! Running an FMU in a separate process, so that one that crashes or hangs is a finding.
//!
//! [`supervise`] starts the caller's own program again with a hidden option; there, [`child`] loads
//! the binary and exercises it with a host that is strict about the table of section 4.2.4. What it
//! does and finds goes line by line into a journal, from which the supervisor reads how far it came.
//!
//! This protects against faulty binaries, not against hostile ones: the process has the caller's
//! rights.

mod derivatives;
mod exercise;
mod journal;
mod output;
mod probes;
mod reference;
mod states;
mod trajectory;

use crate::error::Error;
use crate::finding::{Finding, Location, Report};
use journal::Journal;
use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::process::{Child, ExitStatus, Stdio};
use std::time::{Duration, Instant};

/// How the caller's program is called again: `program arguments… option JOURNAL FMU`.
#[derive(Debug, Clone)]
pub struct Command {
    /// The program.
    pub program: PathBuf,
    /// Its first arguments.
    pub arguments: Vec<OsString>,
    /// The option that names the journal.
    pub option: OsString,
}

/// What a run may take.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bounds {
    /// Time for everything together.
    pub time: Duration,
}

impl Default for Bounds {
    fn default() -> Self {
        Self { time: Duration::from_secs(60) }
    }
}

/// Address space the child may take, bytes.
#[cfg(unix)]
const MEMORY: u64 = 16 << 30;

/// Exercises an FMU in another process. `report` is what was found without running it: where that
/// leaves nothing to run, a note reports it.
///
/// # Errors
/// Where the process cannot be started or its journal not read.
pub fn supervise(
    command: &Command,
    fmu: &Path,
    report: &Report,
    bounds: &Bounds,
) -> Result<Vec<Finding>, Error> {
    if let Some(why) = why_not(report) {
        return Ok(vec![Finding::new("run-skipped", Location::archive(), why)]);
    }
    let failed = |source| Error::Child { path: command.program.clone(), source };
    // The child's own temporary files are in here too, and gone with it if it crashes.
    let folder = tempfile::Builder::new().prefix("fmu-check-").tempdir().map_err(failed)?;
    let journal = folder.path().join("journal");
    let mut process = std::process::Command::new(&command.program);
    process
        .args(&command.arguments)
        .arg(&command.option)
        .arg(&journal)
        .arg(fmu)
        .stdin(Stdio::null())
        .stdout(Stdio::piped())
        .stderr(Stdio::null());
    for variable in ["TMPDIR", "TMP", "TEMP"] {
        process.env(variable, folder.path());
    }
    #[cfg(unix)]
    std::os::unix::process::CommandExt::process_group(&mut process, 0);
    let mut child = process.spawn().map_err(failed)?;
    let output = output::Output::of(&mut child);
    let ended = wait(&mut child, bounds.time).map_err(failed)?;
    let (mut findings, end) = journal::read(&journal).map_err(failed)?;
    let during = end.started.as_deref().unwrap_or("the start of the process");
    let mut report = |rule, message: String| {
        findings.push(Finding::new(rule, end.place.clone(), message));
    };
    match ended {
        None => {
            let message = format!("no end after {} s, in {during}", bounds.time.as_secs_f64());
            report("run-hang", message);
        }
        Some(_) if end.done => {}
        Some(status) => report("run-crash", format!("{}, in {during}", describe(status))),
    }
    if let Some(text) = output.taken() {
        report("run-output", format!("it writes to stdout: {text:?}"));
    }
    Ok(findings)
}

/// Why there is nothing to run.
fn why_not(report: &Report) -> Option<String> {
    const IN_THE_WAY: [&str; 6] =
        ["zip-", "xml-", "no-", "not-co-simulation", "binary-f", "fmi-version"];
    let broken = report.findings.iter().find(|finding| {
        finding.severity == crate::Severity::Error
            && IN_THE_WAY.iter().any(|head| finding.rule.starts_with(head))
    });
    broken.map(|finding| format!("it is not run because of {}", finding.rule))
}

/// Waits for the end, or makes one: `None` where time is up.
fn wait(child: &mut Child, time: Duration) -> std::io::Result<Option<ExitStatus>> {
    let start = Instant::now();
    let mut pause = Duration::from_millis(1);
    loop {
        if let Some(status) = child.try_wait()? {
            // What the FMU started goes with it.
            kill_group(child);
            return Ok(Some(status));
        }
        if start.elapsed() > time {
            kill_group(child);
            // It may have ended by itself just now.
            let _ = child.kill();
            child.wait()?;
            return Ok(None);
        }
        std::thread::sleep(pause);
        pause = (pause * 2).min(Duration::from_millis(50));
    }
}

#[cfg(unix)]
fn kill_group(child: &Child) {
    use rustix::process::{Pid, Signal, kill_process_group};
    if let Some(group) = i32::try_from(child.id()).ok().and_then(Pid::from_raw) {
        // Nobody may be left in it.
        let _ = kill_process_group(group, Signal::KILL);
    }
}

#[cfg(not(unix))]
fn kill_group(_: &Child) {}

#[cfg(unix)]
fn describe(status: ExitStatus) -> String {
    use std::os::unix::process::ExitStatusExt;
    match status.signal() {
        Some(11) => "a segmentation fault (signal 11)".into(),
        Some(6) => "an abort (signal 6)".into(),
        Some(signal) => format!("ended by signal {signal}"),
        None => format!("it ended the process ({status})"),
    }
}

#[cfg(not(unix))]
fn describe(status: ExitStatus) -> String {
    format!("it ended the process ({status})")
}

/// What the other process does: exercises the FMU and writes the journal.
///
/// # Errors
/// Where the journal cannot be written.
pub fn child(fmu: &Path, journal: &Path) -> Result<(), Error> {
    #[cfg(unix)]
    {
        use rustix::process::{Resource, Rlimit, setrlimit};
        let limit = |bytes| Rlimit { current: Some(bytes), maximum: Some(bytes) };
        // Bounds that are tighter already stay.
        let _ = setrlimit(Resource::As, limit(MEMORY));
        let _ = setrlimit(Resource::Core, limit(0));
    }
    let io = |source| Error::Io { path: journal.into(), source };
    let mut journal = Journal::create(journal).map_err(io)?;
    exercise::all(fmu, &mut journal);
    journal.done();
    Ok(())
}
