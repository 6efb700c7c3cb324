//! `cargo xtask test`.

use crate::run::{answer, cargo, run};
use crate::{browser, evaluate, fuzz, python, stress};
use std::io::Write;
use std::process::Command;
use std::time::{Duration, Instant};
use std::{env, io, thread};

/// What is tested.
#[derive(clap::Args)]
pub(crate) struct Options {
    /// Also the stress tests, a minute of fuzzing for each target, and the whole evaluation
    #[arg(long)]
    full: bool,
}

/// Every test of the workspace, with the Python environment that some of them need, and beside them those that are
/// outside of it.
///
/// With `STEERWRIGHT_FMU_BINARIES` they are of the FMU libraries in that folder, such as those that `cargo xtask cross`
/// built; by default of this machine's own.
///
/// What the tests need is checked before anything is built. A suite that fails does not end the others.
pub(crate) fn test(options: &Options) -> Result<(), String> {
    check_machine()?;
    let python = python::environment()?;
    let mut suites = Suites::default();
    // Release: the tests step models millions of times.
    let all = ["test", "--release", "--no-fail-fast"];
    run(cargo(&all).arg("--no-run"))?;
    suites.note("building", Ok(()));
    thread::scope(|scope| {
        // Most of what these do is on one processor. They are on their own, so that what they print stays together.
        let beside = BESIDE.map(|(task, name)| (name, scope.spawn(move || task_apart(task))));
        // With those that `cargo test` leaves out.
        let mut workspace = cargo(&all);
        workspace.args(["--", "--include-ignored", "--skip", stress::STRESS]);
        suites.note("the Rust tests", run(workspace.env("STEERWRIGHT_PYTHON", &python)));
        for (name, suite) in beside {
            let outcome = suite.join().unwrap_or_else(|_| Err("it panicked".into()));
            suites.note(name, outcome);
        }
    });
    // No default member: this program.
    let mut own = cargo(&["test", "--release", "--quiet", "--package", "xtask"]);
    suites.note("the tests of xtask", run(&mut own));
    eprintln!(
        "left out: the libraries for an older glibc and for Windows (`cargo xtask cross --run`), for ARM \
         (`cargo xtask cross --run aarch64-linux`)"
    );
    if options.full {
        suites.note("the stress tests", stress::stress());
        suites.note("fuzzing", fuzz::fuzz(1.0, &[]));
        suites.note("the evaluation", evaluate::evaluate_all());
    } else {
        eprintln!("left out: stress tests, fuzzing, long evaluations (`cargo xtask test --full`)");
    }
    suites.outcome()
}

/// Tasks that test what the Rust tests do not, and what they are.
const BESIDE: [(&str, &str); 3] = [
    ("browser", "the report in Chromium"),
    ("wheel", "the Python package"),
    ("importers", "independent importers"),
];

/// Runs a task of this program to its end, then shows what it printed.
fn task_apart(task: &str) -> Result<(), String> {
    let problem = |e: std::io::Error| format!("{task}: {e}");
    let program = env::current_exe().map_err(problem)?;
    let output = Command::new(program).arg(task).output().map_err(problem)?;
    let mut text = format!("$ cargo xtask {task}\n").into_bytes();
    text.extend(output.stdout);
    text.extend(output.stderr);
    io::stderr().lock().write_all(&text).map_err(problem)?;
    if output.status.success() {
        Ok(())
    } else {
        Err(format!("cargo xtask {task}: {}", output.status))
    }
}

/// The suites that failed, and how much longer it took until each had ended.
struct Suites {
    failed: Vec<String>,
    took: Vec<(String, Duration)>,
    since: Instant,
}

impl Default for Suites {
    fn default() -> Self {
        Self { failed: Vec::new(), took: Vec::new(), since: Instant::now() }
    }
}

impl Suites {
    /// Keeps the failure of a suite, and what it took, for the end; what the suite returned otherwise.
    fn note<T>(&mut self, suite: &str, outcome: Result<T, String>) -> Option<T> {
        let now = Instant::now();
        self.took.push((suite.to_owned(), now - self.since));
        self.since = now;
        outcome
            .map_err(|error| {
                eprintln!("failed: {suite}: {error}");
                self.failed.push(format!("{suite}: {error}"));
            })
            .ok()
    }

    fn outcome(self) -> Result<(), String> {
        for (suite, took) in &self.took {
            eprintln!("{:>6.0} s  {suite}", took.as_secs_f64());
        }
        match self.failed.len() {
            0 => Ok(()),
            count => Err(format!("{count} suites failed\n  {}", self.failed.join("\n  "))),
        }
    }
}

/// Whether all that the tests need is installed; an error names what is missing, and how it is installed.
fn check_machine() -> Result<(), String> {
    // Debian's python3 has the module venv without what makes an environment of it.
    let venv = "import sys, venv, ensurepip; sys.exit(sys.version_info < (3, 10))";
    let works = |program: &str, arguments: &[&str]| {
        Command::new(program).args(arguments).output().is_ok_and(|output| output.status.success())
    };
    let compiles = answer(Command::new("cc").arg("-print-file-name=include")).is_some();
    let needs = [
        (compiles, "a C compiler (`cc`)", "gcc libc6-dev"),
        (works("git", &["--version"]), "git", "git"),
        (
            works("python3", &["-c", venv]) || works("python", &["-c", venv]),
            "Python 3.10 or newer with venv",
            "python3-venv",
        ),
        (browser::chromium().is_ok(), "Chromium (or STEERWRIGHT_CHROMIUM)", "chromium"),
    ];
    let missing: Vec<_> = needs.into_iter().filter(|(is_there, ..)| !is_there).collect();
    if missing.is_empty() {
        return Ok(());
    }
    let names: Vec<_> = missing.iter().map(|(_, name, _)| *name).collect();
    let packages: Vec<_> = missing.iter().map(|(.., package)| *package).collect();
    Err(format!(
        "the tests need {}\nhint: on Debian and Ubuntu, apt-get install {}",
        names.join(", "),
        packages.join(" ")
    ))
}

#[cfg(test)]
mod tests {
    use super::Suites;

    #[test]
    fn a_suite_that_fails_does_not_end_the_others_and_is_reported_at_the_end() {
        let mut suites = Suites::default();
        assert_eq!(suites.note::<()>("first", Err("one test".into())), None);
        assert_eq!(suites.note("second", Ok(3)), Some(3));
        suites.note::<()>("third", Err("no program".into()));
        let message = suites.outcome().unwrap_err();
        assert!(message.starts_with("2 suites failed"), "{message}");
        assert!(message.contains("first: one test") && message.contains("third: no program"));
        assert_eq!(Suites::default().outcome(), Ok(()));
    }
}
