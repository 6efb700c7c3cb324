//! The Rust compiler and standard library for a platform.
//!
//! Where rustup can add the target, that is all. Elsewhere the standard library is built from
//! source with Debian's compiler, since both must be of one version and only Debian has the source.

use super::debian;
use super::platform::Platform;
use crate::run::{root, shown};
use clap::ValueEnum;
use std::path::PathBuf;
use std::process::{Command, Stdio};
use std::thread::sleep;
use std::time::{Duration, Instant};

/// Where the standard library of another platform comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum Source {
    /// rustup, or Debian where rustup cannot add the target
    Auto,
    /// rustup
    Rustup,
    /// built from Debian's source, with Debian's compiler
    Debian,
}

/// What compiles for a platform.
pub(crate) enum Toolchain {
    /// The compiler that cargo takes anyway, which has the standard library.
    Ready,
    /// A compiler of its own, whose standard library is built too.
    FromSource(debian::Compiler),
}

impl Toolchain {
    pub(crate) fn target(&self, platform: Platform) -> &'static str {
        match self {
            Self::Ready => platform.target(),
            Self::FromSource(_) => platform.target_from_source(),
        }
    }

    /// What to call it in a table.
    pub(crate) fn name(&self) -> &'static str {
        match self {
            Self::Ready => "std of the toolchain",
            Self::FromSource(_) => "std from Debian's source",
        }
    }
}

/// The toolchain for a platform; brings what is not there yet.
pub(crate) fn toolchain(platform: Platform, source: Source) -> Result<Toolchain, String> {
    if source != Source::Debian {
        match ready(platform.target()) {
            Ok(()) => return Ok(Toolchain::Ready),
            Err(e) if source == Source::Rustup => return Err(e),
            Err(e) => eprintln!("{e}\n{platform:?}: taking Debian's compiler and source instead"),
        }
    } else if platform == Platform::Linux64 {
        // Its standard library is there in any case.
        return Ok(Toolchain::Ready);
    }
    debian::compiler().map(Toolchain::FromSource)
}

/// Makes sure that the standard library for a target is there.
fn ready(target: &str) -> Result<(), String> {
    if library_folder(target).is_some_and(|folder| folder.is_dir()) {
        return Ok(());
    }
    // In the workspace, so that rustup takes the toolchain that cargo takes there.
    let mut rustup = Command::new("rustup");
    rustup.args(["target", "add", target]).current_dir(root()).env("RUSTUP_MAX_RETRIES", "0");
    within(&mut rustup, Duration::from_secs(120))
}

/// The folder of a target's standard library, whether or not it is there.
fn library_folder(target: &str) -> Option<PathBuf> {
    let mut rustc = Command::new("rustc");
    let print = ["--print", "target-libdir", "--target", target];
    let output = rustc.args(print).current_dir(root()).output().ok()?;
    if output.status.success() {
        Some(String::from_utf8_lossy(&output.stdout).trim().into())
    } else {
        None
    }
}

/// Runs a command that may wait for a server that never answers.
fn within(command: &mut Command, limit: Duration) -> Result<(), String> {
    let line = shown(command);
    let mut child = command.stdin(Stdio::null()).spawn().map_err(|e| format!("{line}: {e}"))?;
    let start = Instant::now();
    while start.elapsed() < limit {
        match child.try_wait().map_err(|e| format!("{line}: {e}"))? {
            Some(status) if status.success() => return Ok(()),
            Some(status) => return Err(format!("{line}: {status}")),
            None => sleep(Duration::from_millis(100)),
        }
    }
    let _ = child.kill();
    let _ = child.wait();
    Err(format!("{line}: no end after {} s", limit.as_secs()))
}
