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
    let published = ["publish", "--dry-run", "--allow-dirty", "--quiet"];
    run(cargo(&published).args(["--package", "model-description", "--package", "fmi2-export"]))?;
    run(cargo(&["doc", "--release", "--no-deps", "--workspace"]).env("RUSTDOCFLAGS", "-D warnings"))
}
