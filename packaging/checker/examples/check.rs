//! A minimal checker: `check FMU…` prints the findings, including those of the running binary.
//!
//! `check --run-child JOURNAL SECONDS FMU` is the command of its child process.

use std::path::Path;
use std::process::ExitCode;
use std::time::Duration;
use steerwright_checker::run::{self, Command};

fn main() -> Result<ExitCode, Box<dyn std::error::Error>> {
    let arguments: Vec<_> = std::env::args_os().skip(1).collect();
    if let [option, journal, seconds, fmu] = arguments.as_slice()
        && option == "--run-child"
    {
        let seconds: f64 = seconds.to_string_lossy().parse()?;
        run::child(Path::new(fmu), Path::new(journal), seconds)?;
        return Ok(ExitCode::SUCCESS);
    }
    let command = Command {
        program: std::env::current_exe()?,
        arguments: Vec::new(),
        option: "--run-child".into(),
    };
    let mut clean = true;
    for fmu in &arguments {
        let fmu = Path::new(fmu);
        let mut report = steerwright_checker::check_file(fmu)?;
        let findings = run::supervise(&command, fmu, &report, Duration::from_secs(60))?;
        report.extend(findings);
        for finding in &report.findings {
            println!("{finding}");
        }
        clean &= report.is_clean();
    }
    Ok(if clean { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}
