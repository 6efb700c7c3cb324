//! Checks FMI 2.0 Co-Simulation archives of any tool against the standard (FMI 2.0.5).
//!
//! [`check`] reads an archive's bytes and reports all violations: of the zip rules and the folders, of the XML
//! schema and the rules that it cannot express, and of the requirements on binaries. It does not run the binary.
//! [`run`] adds a dynamic test: a child process loads the binary and calls its functions, so that a
//! crash or a hang is a finding.
//!
//! Hostile archives result in findings: sizes are limited before unpacking, and no input makes the checker
//! panic. This crate has no vehicle-specific code.

mod archive;
mod binary;
mod error;
mod finding;
mod layout;
mod rules;
pub mod run;
mod xml;

pub use error::Error;
pub use finding::{Finding, Location, Report};
pub use rules::{RULES, Rule, Severity};

use archive::Contents;
use finding::Findings;
use std::path::Path;

/// Size of the largest archive that is read, bytes.
const LARGEST_FILE: u64 = 2 << 30;

/// Reads and checks an archive.
///
/// # Errors
/// The file cannot be read. Problems of its content are findings.
pub fn check_file(path: &Path) -> Result<Report, Error> {
    let io = |source| Error::Io { path: path.into(), source };
    let metadata = std::fs::metadata(path).map_err(io)?;
    if metadata.is_dir() {
        return Err(Error::Folder { path: path.into() });
    }
    if metadata.len() > LARGEST_FILE {
        let got = metadata.len();
        return Err(Error::TooLarge { path: path.into(), got, limit: LARGEST_FILE });
    }
    let bytes = std::fs::read(path).map_err(io)?;
    let name = path.file_name().unwrap_or(path.as_os_str()).to_string_lossy();
    Ok(check(&bytes, &name))
}

/// Checks an archive in memory; `name` is its file name.
#[must_use]
pub fn check(bytes: &[u8], name: &str) -> Report {
    let mut findings = Findings::default();
    if !name.ends_with(".fmu") {
        let message = format!("the file is named \"{name}\"");
        findings.add("file-extension", Location::archive(), message);
    }
    if let Some(contents) = Contents::read(bytes, &mut findings) {
        let description = xml::check(&contents, &mut findings);
        // Other versions of FMI have other folders and functions.
        if !findings.has("fmi-version") {
            layout::check(&contents, description.as_ref(), &mut findings);
            binary::check(&contents, description.as_ref(), &mut findings);
        }
    }
    Report::new(name, findings.into_vec())
}
