//! `steerwright check`: archives of any tool held against the standard.

use crate::console;
use crate::failure::{Failure, Outcome};
use crate::progress::Progress;
use crate::quantity;
use fmu_checker::{Report, Severity, run};
use std::path::{Path, PathBuf};
use std::time::Duration;

/// Check FMUs of any tool against FMI 2.0 for Co-Simulation
///
/// Looks at the archive, the XML, the folders and the binaries of every platform; runs nothing
/// unless asked to. Errors are breaches of the standard, warnings go against its recommendations,
/// notes are good to know. With `--run`, the binary is run with your rights: a process of its own
/// keeps a faulty one from taking the check down, and does not contain a malicious one, which may do
/// whatever you may do and outlive the check. Run none that you would not simulate.
///
/// Exit status: 0 no errors (there may be warnings), 1 errors found, 2 a file cannot be read; the
/// others are checked all the same.
#[derive(clap::Args)]
pub(crate) struct Arguments {
    /// Archives
    #[arg(required = true, value_name = "FMU")]
    fmus: Vec<PathBuf>,
    /// Run the binary of this platform too, in a process of its own that may crash or hang
    #[arg(long)]
    run: bool,
    /// The longest that a run may take
    #[arg(long, value_name = "TIME", default_value = "60s", value_parser = quantity::time)]
    time_limit: f64,
    /// Take warnings for errors
    #[arg(long)]
    strict: bool,
    /// What `--run` calls itself with: exercise the FMU and write findings to this file
    #[arg(long, hide = true, value_name = "FILE")]
    run_child: Option<PathBuf>,
}

pub(crate) fn run(arguments: &Arguments) -> Result<Outcome, Failure> {
    if let (Some(file), [fmu]) = (&arguments.run_child, arguments.fmus.as_slice()) {
        run::child(fmu, file)?;
        return Ok(Outcome::Done);
    }
    let time = Duration::try_from_secs_f64(arguments.time_limit).ok().filter(|t| !t.is_zero());
    let Some(time) = time else {
        let message = format!("--time-limit: {} s is no time to wait", arguments.time_limit);
        return Err(Failure::new(message, "give a time such as 60s"));
    };
    let bounds = run::Bounds { time };
    let (mut reports, mut failures) = (Vec::new(), Vec::new());
    let progress = Progress::start("checking");
    for fmu in &arguments.fmus {
        progress.now(format!("checking {}", fmu.display()));
        match check(fmu, arguments.run.then_some(&bounds)) {
            Ok(report) => reports.push(report),
            Err(failure) => failures.push(failure),
        }
    }
    drop(progress);
    let text: Vec<String> = reports.iter().map(text).collect();
    console::result(&text.join("\n\n"), &reports)?;
    // A file that cannot be read keeps nothing from being told of the others.
    if let Some(last) = failures.pop() {
        for failure in failures {
            failure.tell();
        }
        return Err(last);
    }
    let is_met = |report: &Report| report.is_clean() && !(arguments.strict && report.warnings > 0);
    Ok(if reports.iter().all(is_met) { Outcome::Done } else { Outcome::RequirementNotMet })
}

fn check(fmu: &Path, bounds: Option<&run::Bounds>) -> Result<Report, Failure> {
    let mut report = fmu_checker::check_file(fmu)?;
    if let Some(bounds) = bounds {
        let program = std::env::current_exe().map_err(|error| Failure::file(fmu, &error))?;
        let command =
            run::Command { program, arguments: vec!["check".into()], option: "--run-child".into() };
        let findings = run::supervise(&command, fmu, &report, bounds)?;
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
