//! The timer in C, `timing.c`: compiled, given its subjects, its numbers read.

use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

/// Step size of every subject, s.
const STEP: f64 = 0.01;

/// A timed call, as `timing.c` reads it.
pub(crate) struct Subject {
    pub(crate) kind: &'static str,
    pub(crate) library: PathBuf,
    pub(crate) guid: String,
    pub(crate) uri: String,
    /// Calls in a round.
    pub(crate) count: u32,
    pub(crate) reference: u32,
    /// First and last value of the Real.
    pub(crate) range: [f64; 2],
    /// Reals before the start, `REF=VALUE` apart by commas.
    pub(crate) start: String,
}

/// Compiles with `cc`; an error where there is none.
pub(crate) fn compile(arguments: &[&str], to: &Path) -> std::io::Result<()> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR"));
    let status =
        Command::new("cc").args(arguments).arg("-o").arg(to).current_dir(folder).status()?;
    assert!(status.success(), "cc {arguments:?}");
    Ok(())
}

/// Compiles the timer into a folder.
pub(crate) fn compile_timer(folder: &Path) -> std::io::Result<PathBuf> {
    let timer = folder.join("timing");
    compile(&["-std=c99", "-O2", "-I", "fmi2", "bench/timing.c", "-ldl"], &timer)?;
    Ok(timer)
}

/// Nanoseconds a call: round by round, subject by subject.
pub(crate) fn time(timer: &Path, rounds: usize, subjects: &[Subject]) -> Vec<Vec<f64>> {
    let mut command = Command::new(timer);
    if let Some(python) = std::env::var_os("STEERWRIGHT_BENCH_LIBPYTHON") {
        command.env("LD_PRELOAD", python);
    }
    let mut child = command
        .arg(rounds.to_string())
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .spawn()
        .unwrap();
    let lines: String = subjects.iter().map(line).collect();
    // A timer that refuses a line ends before it has read all: its status and message count.
    let written = child.stdin.take().unwrap().write_all(lines.as_bytes());
    let output = child.wait_with_output().unwrap();
    assert!(output.status.success(), "timing: {}", output.status);
    written.unwrap();
    let numbers = |line: &str| line.split_whitespace().map(|word| word.parse().unwrap()).collect();
    String::from_utf8(output.stdout).unwrap().lines().map(numbers).collect()
}

fn line(s: &Subject) -> String {
    let (kind, guid, uri, count, reference) = (s.kind, &s.guid, &s.uri, s.count, s.reference);
    let (library, [low, high], start) = (s.library.display(), s.range, &s.start);
    format!(
        "{kind}\t{library}\t{guid}\t{uri}\t{STEP}\t{count}\t{reference}\t{low}\t{high}\t{start}\n"
    )
}
