//! `cargo xtask test`.

use crate::cross::{self, Platform};
use crate::run::{cargo, run, target};
use crate::{browser, evaluate, every_fmu, fuzz, importers, python, stress, wheel};
use std::path::{Path, PathBuf};

/// The modules of the system tests that are about the libraries in the archives.
const LOADING: [&str; 7] = [
    "check::",
    "closed_loop::",
    "fmus::",
    "installed::",
    "nonlinear_vehicle::",
    "pose_loop::",
    "ssp::",
];

/// What is tested.
#[derive(clap::Args)]
pub(crate) struct Options {
    /// Also with the libraries of other platforms, as far as they run here; without names,
    /// linux64 and win64
    #[arg(long, num_args = 0.., value_name = "PLATFORM")]
    cross: Option<Vec<Platform>>,
    /// Also other platforms, the stress tests, a minute of fuzzing for each target, and the whole
    /// evaluation
    #[arg(long)]
    full: bool,
}

/// Every test of the workspace, with the Python environment that some of them need, and then those
/// that are outside of it.
///
/// Other platforms are tested with the cross-built libraries: the tests about libraries in archives run with
/// them once more, and each platform's library is compared with this machine's.
pub(crate) fn test(options: &Options) -> Result<(), String> {
    let platforms = match &options.cross {
        None if options.full => Some(&[][..]),
        named => named.as_deref(),
    };
    let platforms = platforms.map(cross::with_own);
    if let Some(platforms) = &platforms {
        cross::check(platforms, true)?;
    }
    let python = python::environment()?;
    // Release: the tests step models millions of times. With those that `cargo test` leaves out.
    let all = ["--", "--include-ignored", "--skip", stress::STRESS];
    run(cargo(&["test", "--release", "--no-fail-fast"])
        .args(all)
        .env("STEERWRIGHT_PYTHON", &python))?;
    // No default member: this program.
    run(&mut cargo(&["test", "--release", "--quiet", "--package", "xtask"]))?;
    browser::browser()?;
    let binaries = match &platforms {
        Some(platforms) => Some(across(platforms, &python)?),
        None => {
            eprintln!(
                "left out: the libraries for an older glibc and for Windows (`cargo xtask test \
                 --cross`), for ARM (`--cross aarch64-linux`)"
            );
            None
        }
    };
    wheel::wheel(binaries.as_deref(), false)?;
    importers::importers(&python, binaries.as_deref())?;
    if options.full {
        stress::stress()?;
        fuzz::fuzz(1.0, &[])?;
        evaluate::evaluate_all()?;
    } else {
        eprintln!("left out: stress tests, fuzzing, long evaluations (`cargo xtask test --full`)");
    }
    Ok(())
}

/// The tests with the cross-built libraries in the archives, and each platform's own runs. Returns the
/// folder of the libraries.
fn across(platforms: &[Platform], python: &Path) -> Result<PathBuf, String> {
    let native = target().join("cross/native");
    every_fmu::pack(&native, None)?;
    cross::libraries(platforms, cross::Source::Auto)?;
    cross::run(platforms, &native)?;
    let binaries = cross::binaries();
    // By their names: `--package steerwright` would give shared dependencies other features, and
    // compile nearly everything once more. The tests of other crates load no packed library.
    for (program, modules) in [("system", &LOADING[..]), ("python", &[])] {
        let mut tests = cargo(&["test", "--release", "--no-fail-fast", "--test", program]);
        tests.args(["--", "--include-ignored"]).args(modules);
        run(tests.env("STEERWRIGHT_PYTHON", python).env("STEERWRIGHT_FMU_BINARIES", &binaries))?;
    }
    Ok(binaries)
}
