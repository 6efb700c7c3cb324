//! Runs the tests in tests/python on a fresh demo, where there is a Python environment for them.
//!
//! `cargo xtask test` makes that environment and names its interpreter in STEERWRIGHT_PYTHON.
//! A plain `cargo test` says what it leaves out.

mod support;

use std::path::Path;
use std::process::{Command, ExitCode};

fn main() -> ExitCode {
    let Some(python) = std::env::var_os("STEERWRIGHT_PYTHON") else {
        println!("left out: fmpy's validation of the archives and its closed loop (tests/python)");
        println!("left out: rust-fmi's closed loop and types of the headers (tests/importers)");
        println!("`cargo xtask test` makes the Python environment they need and runs them");
        return ExitCode::SUCCESS;
    };
    let tests = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/python");
    let status = Command::new(python)
        .args(["-m", "pytest", "-q", "-rA", "-p", "no:cacheprovider"])
        .arg(&tests)
        .env("STEERWRIGHT_OUT", &support::demo().folder)
        .env("PYTHONDONTWRITEBYTECODE", "1")
        .status();
    match status {
        Ok(status) if status.success() => ExitCode::SUCCESS,
        Ok(_) => ExitCode::FAILURE,
        Err(error) => {
            eprintln!("STEERWRIGHT_PYTHON: {error}");
            ExitCode::FAILURE
        }
    }
}
