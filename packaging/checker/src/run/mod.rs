//! Running an FMU in a separate process, so that a crash or a hang is a finding.
//!
//! [`supervise`] starts the caller's own program again with a hidden option; that process, in [`child`], writes
//! its calls and findings to a journal, in which the supervisor finds the last call.
//! This protects against faulty binaries, not against hostile ones: the process has the caller's permissions.

mod derivatives;
mod exercise;
mod experiment;
mod journal;
mod probes;
mod reference;
mod states;
mod trajectory;

use crate::Error;
use crate::finding::{Finding, Location, Report};
use journal::Journal;
use std::ffi::OsString;
use std::io::Read;
use std::path::{Path, PathBuf};
use std::process::{Child, ExitStatus, Stdio};
use std::sync::mpsc::{Receiver, channel};
use std::time::{Duration, Instant};
use steerwright_host::Scratch;
use steerwright_host::process::{Subprocess, end_with_parent};

/// The command of the child process: `program arguments… option JOURNAL SECONDS FMU`, in which the seconds
/// are its time limit.
#[derive(Debug, Clone)]
pub struct Command {
    /// The program.
    pub program: PathBuf,
    /// Its first arguments.
    pub arguments: Vec<OsString>,
    /// The option before the path of the journal and the time limit.
    pub option: OsString,
}

/// The limit of the child's address space, bytes.
#[cfg(unix)]
const MEMORY: u64 = 16 << 30;

/// The share of the time limit within which the child ends its last run.
const SHARE: f64 = 0.8;
/// Longer limits are none.
const LONGEST: Duration = Duration::from_secs(365 * 86_400);

/// Bytes of the output that are reported.
const OUTPUT_SHOWN: usize = 80;
/// Time to wait for output, which a detached process may keep open.
const OUTPUT_TIMEOUT: Duration = Duration::from_millis(200);

/// Tests an FMU in another process. `report` has the findings of [`check`](crate::check): if they
/// prevent a run, the result is a note. A process that runs longer than `time_limit` is a hang.
///
/// # Errors
/// The process cannot be started, or its journal cannot be read.
pub fn supervise(
    command: &Command,
    fmu: &Path,
    report: &Report,
    time_limit: Duration,
) -> Result<Vec<Finding>, Error> {
    if let Some(why) = why_skipped(report) {
        return Ok(vec![Finding::new("run-skipped", Location::archive(), why)]);
    }
    let failed = |source| Error::Child { path: command.program.clone(), source };
    let folder = Scratch::new().map_err(failed)?;
    let journal = folder.path().join("journal");
    let mut process = std::process::Command::new(&command.program);
    process
        .args(&command.arguments)
        .arg(&command.option)
        .arg(&journal)
        .arg(time_limit.as_secs_f64().to_string())
        .arg(fmu)
        .stdout(Stdio::piped())
        .stderr(Stdio::null());
    let mut process = Subprocess::start(&mut process).map_err(failed)?;
    let output = Output::from_child(process.child());
    let ended = wait(&mut process, time_limit).map_err(failed)?;
    let (mut findings, end) = journal::read(&journal).map_err(failed)?;
    let during = end.started.as_deref().unwrap_or("the start of the process");
    let mut report = |rule, message: String| {
        findings.push(Finding::new(rule, end.place.clone(), message));
    };
    match ended {
        None => {
            let message =
                format!("it does not end within {} s, in {during}", time_limit.as_secs_f64());
            report("run-hang", message);
        }
        Some(_) if end.done => {}
        Some(status) => report("run-crash", format!("{}, in {during}", describe(status))),
    }
    if let Some(text) = output.beginning() {
        report("run-output", format!("it writes to stdout: {text:?}"));
    }
    Ok(findings)
}

fn why_skipped(report: &Report) -> Option<String> {
    const PREVENTING: [&str; 6] =
        ["zip-", "xml-", "no-", "not-co-simulation", "binary-f", "fmi-version"];
    let broken = report.findings.iter().find(|finding| {
        finding.severity == crate::rules::Severity::Error
            // The description could be read all the same.
            && finding.rule != "xml-encoding"
            && PREVENTING.iter().any(|head| finding.rule.starts_with(head))
    });
    broken.map(|finding| format!("the FMU is not run because of {}", finding.rule))
}

/// Waits for the end of a process; kills it after a time and returns `None`.
fn wait(process: &mut Subprocess, time: Duration) -> std::io::Result<Option<ExitStatus>> {
    let start = Instant::now();
    let mut pause = Duration::from_millis(1);
    loop {
        let ended = process.child().try_wait()?;
        if ended.is_some() || start.elapsed() > time {
            // Processes that the FMU started end too.
            process.kill();
            process.child().wait()?;
            return Ok(ended);
        }
        std::thread::sleep(pause);
        pause = (pause * 2).min(Duration::from_millis(50));
    }
}

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

/// The beginning of the standard output; a thread reads all of it, so that the FMU never blocks.
struct Output(Receiver<Vec<u8>>);

impl Output {
    fn from_child(child: &mut Child) -> Self {
        let (sender, receiver) = channel();
        if let Some(mut stdout) = child.stdout.take() {
            std::thread::spawn(move || {
                let mut buffer = [0; 4096];
                let mut kept = 0;
                while let Ok(n @ 1..) = stdout.read(&mut buffer) {
                    let more = n.min(OUTPUT_SHOWN - kept);
                    kept += more;
                    if more > 0 && sender.send(buffer[..more].to_vec()).is_err() {
                        break;
                    }
                }
            });
        }
        Self(receiver)
    }

    fn beginning(self) -> Option<String> {
        let mut bytes = Vec::new();
        while let Ok(more) = self.0.recv_timeout(OUTPUT_TIMEOUT) {
            bytes.extend(more);
        }
        if bytes.is_empty() { None } else { Some(String::from_utf8_lossy(&bytes).into_owned()) }
    }
}

/// Runs in the child process: tests the FMU within the time limit, s, and writes the journal.
///
/// # Errors
/// The journal cannot be written.
pub fn child(fmu: &Path, journal: &Path, time_limit: f64) -> Result<(), Error> {
    let share = Duration::try_from_secs_f64(SHARE * time_limit).unwrap_or(LONGEST);
    let deadline = Instant::now() + share.min(LONGEST);
    #[cfg(unix)]
    {
        use rustix::process::{Resource, Rlimit, setrlimit};
        let limit = |bytes| Rlimit { current: Some(bytes), maximum: Some(bytes) };
        // Setting fails if the limits are already tighter.
        let _ = setrlimit(Resource::As, limit(MEMORY));
        let _ = setrlimit(Resource::Core, limit(0));
    }
    let io = |source| Error::Io { path: journal.into(), source };
    end_with_parent().map_err(io)?;
    let mut journal = Journal::create(journal).map_err(io)?;
    exercise::all(fmu, &mut journal, deadline);
    journal.done();
    Ok(())
}
