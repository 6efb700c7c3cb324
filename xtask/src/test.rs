//! `cargo xtask test`.

use crate::cross::{self, Platform};
use crate::run::{cargo, run, target};
use crate::{browser, every_fmu, importers, python};
use std::path::Path;

/// Every test of the workspace, with the Python environment that some of them need, and then those
/// that are outside of it. With `platforms`, those that use FMU libraries run with the cross-built
/// ones too.
pub(crate) fn test(platforms: Option<&[Platform]>) -> Result<(), String> {
    let platforms = platforms.map(cross::with_own);
    if let Some(platforms) = &platforms {
        cross::check(platforms)?;
    }
    let python = python::environment()?;
    // Release: the tests step models millions of times.
    run(cargo(&["test", "--release", "--no-fail-fast"]).env("STEERWRIGHT_PYTHON", &python))?;
    // No default members: this program, and what the evaluation's programs share.
    run(&mut cargo(&["test", "--quiet", "--package", "xtask"]))?;
    browser::browser()?;
    let evaluation = ["--package", "steerwright", "--package", "xtask", "--lib"];
    run(cargo(&["test", "--release", "--quiet", "--package", "sysid-evaluation"]).args(evaluation))?;
    match platforms {
        None => {
            importers::importers(&python, None)?;
            eprintln!(
                "left out: the libraries for an older glibc and for Windows (`cargo xtask test \
                 --cross`), for ARM (`--cross aarch64-linux`)"
            );
            Ok(())
        }
        Some(platforms) => across(&platforms, &python),
    }
}

/// The tests with the cross-built libraries in the archives, and each platform's own runs.
fn across(platforms: &[Platform], python: &Path) -> Result<(), String> {
    let native = target().join("cross/native");
    every_fmu::pack(&native, None)?;
    cross::libraries(platforms, cross::Source::Auto)?;
    cross::run(platforms, &native)?;
    let binaries = cross::binaries();
    // By their names: `--package steerwright` would give shared dependencies other features, and
    // compile nearly everything once more.
    let mut tests = cargo(&["test", "--release", "--no-fail-fast", "--bin", "steerwright"]);
    tests.args(["--test", "it", "--test", "python"]);
    run(tests.env("STEERWRIGHT_PYTHON", python).env("STEERWRIGHT_FMU_BINARIES", &binaries))?;
    importers::importers(python, Some(&binaries))
}
