//! `cargo xtask lint`.

use crate::python;
use crate::run::{cargo, root, run, target};
use std::process::Command;

/// rustfmt, clippy and rustdoc over everything, warnings denied, the spelling of all text, and
/// whether the reusable crates can be published.
pub(crate) fn lint() -> Result<(), String> {
    run(&mut cargo(&["fmt", "--all", "--check"]))?;
    // Release, whose build scripts and macros the tests need too.
    let clippy = ["clippy", "--release", "--workspace", "--all-targets", "--", "-D", "warnings"];
    run(&mut cargo(&clippy))?;
    let requirements = root().join("xtask/lint/requirements.txt");
    let python = python::environment_in(&target().join("lint-python"), &requirements)?;
    run(Command::new(python.with_file_name("typos")).current_dir(root()))?;
    published()?;
    run(cargo(&["doc", "--release", "--no-deps", "--workspace"]).env("RUSTDOCFLAGS", "-D warnings"))
}

/// Whether the reusable crates can be published.
fn published() -> Result<(), String> {
    // Cargo keeps what it unpacks of a crate by the path of the folder that it is packed in: one of its own, or an earlier
    // state of the same version is compiled.
    let folder = target().join(format!("publish-{}", std::process::id()));
    let publish = ["publish", "--dry-run", "--allow-dirty", "--quiet", "--target-dir"];
    let packages = ["--package", "model-description", "--package", "fmi2-export"];
    let outcome = run(cargo(&publish).arg(&folder).args(packages));
    // What is left of it is in the target folder.
    let _ = std::fs::remove_dir_all(&folder);
    outcome
}
