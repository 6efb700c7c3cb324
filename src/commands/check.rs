//! `steerwright check`: archives of any tool compared with the standard.

use crate::failure::{Failure, Outcome};
use crate::options::quantity;
use crate::process::program;
use crate::terminal::console;
use crate::terminal::progress::Progress;
use std::path::{Path, PathBuf};
use std::time::Duration;
use steerwright_checker::{Report, Severity, run};

/// Check FMUs of any tool against FMI 2.0 for Co-Simulation
///
/// Checks the archive, the XML, the folders and the binaries of every platform; runs nothing without
/// --run. Errors violate the standard, warnings violate its recommendations, notes are informative.
/// With --run the binary runs with your rights in a separate process: a faulty binary cannot crash the
/// check, but a malicious one can do whatever you can do, also after the check. Run only FMUs that you
/// would simulate.
///
/// Exit status: 0 no errors (warnings are possible), 1 errors found, 2 a file cannot be read; the other
/// files are checked.
#[derive(clap::Args)]
pub(crate) struct Arguments {
    /// Archives
    #[arg(required = true, value_name = "FMU")]
    fmus: Vec<PathBuf>,
    /// Also run the binary of this platform, in a separate process that may crash or hang
    #[arg(long)]
    run: bool,
    /// Longest duration of a run of --run; a longer experiment is cut
    #[arg(long, value_name = "TIME", default_value = "60s", value_parser = quantity::time)]
    time_limit: f64,
    /// Treat warnings as errors
    #[arg(long)]
    strict: bool,
    /// The process that `--run` starts: exercise the FMU within this time, s, and write the findings to
    /// this file
    #[arg(long, hide = true, num_args = 2, value_names = ["FILE", "SECONDS"])]
    run_child: Option<Vec<PathBuf>>,
}

pub(crate) fn run(arguments: &Arguments) -> Result<Outcome, Failure> {
    if let (Some([file, seconds]), [fmu]) = (arguments.run_child.as_deref(), &arguments.fmus[..]) {
        run::child(fmu, file, seconds.to_string_lossy().parse().unwrap_or(arguments.time_limit))?;
        return Ok(Outcome::Done);
    }
    let time = Duration::try_from_secs_f64(arguments.time_limit).ok().filter(|t| !t.is_zero());
    let Some(time_limit) = time else {
        let message = format!("--time-limit: {} s must be greater than 0", arguments.time_limit);
        return Err(Failure::new(message, "state a time such as 60s"));
    };
    let (mut reports, mut failures) = (Vec::new(), Vec::new());
    let progress = Progress::start("checking");
    for fmu in &arguments.fmus {
        progress.now(format!("checking {}", fmu.display()));
        match check(fmu, if arguments.run { Some(time_limit) } else { None }) {
            Ok(report) => reports.push(report),
            Err(failure) => failures.push(failure),
        }
    }
    drop(progress);
    let text: Vec<String> = reports.iter().map(text).collect();
    console::result(&text.join("\n\n"), &reports)?;
    // The findings of readable files are printed in any case.
    if let Some(last) = failures.pop() {
        for failure in failures {
            failure.report();
        }
        return Err(last);
    }
    let is_met = |report: &Report| report.is_clean() && !(arguments.strict && report.warnings > 0);
    Ok(Outcome::when(reports.iter().all(is_met)))
}

fn check(fmu: &Path, time_limit: Option<Duration>) -> Result<Report, Failure> {
    let mut report = steerwright_checker::check_file(fmu)?;
    if let Some(time_limit) = time_limit {
        let (program, mut arguments) =
            program::words().map_err(|error| Failure::file(fmu, &error))?;
        arguments.push("check".into());
        let command =
            run::Command { program: program.into(), arguments, option: "--run-child".into() };
        let findings = run::supervise(&command, fmu, &report, time_limit)?;
        report.extend(findings);
    }
    Ok(report)
}

/// The findings of an archive, the worst last, where the eye is.
fn text(report: &Report) -> String {
    let mut findings: Vec<_> = report.findings.iter().collect();
    findings.sort_by_key(|finding| finding.severity);
    let lines: Vec<String> = findings.iter().map(|finding| format!("{finding}\n")).collect();
    let notes = report.findings.iter().filter(|f| f.severity == Severity::Note).count();
    let verdict = match (report.errors, report.warnings) {
        (0, 0) => "no breach of FMI 2.0 found".to_owned(),
        (errors, warnings) => {
            format!("{} and {}", count(errors, "error"), count(warnings, "warning"))
        }
    };
    format!("{}{}: {verdict} ({})", lines.concat(), report.archive, count(notes, "note"))
}

fn count(number: usize, word: &str) -> String {
    if number == 1 { format!("1 {word}") } else { format!("{number} {word}s") }
}
