//! `cargo xtask lint`.

use crate::python;
use crate::run::{cargo, root, run, target};
use std::process::Command;

/// rustfmt, clippy and rustdoc over everything, warnings denied, and the spelling of all text.
pub(crate) fn lint() -> Result<(), String> {
    run(&mut cargo(&["fmt", "--all", "--check"]))?;
    run(&mut cargo(&["clippy", "--workspace", "--all-targets", "--", "-D", "warnings"]))?;
    let requirements = root().join("xtask/lint/requirements.txt");
    let python = python::environment_in(&target().join("lint-python"), &requirements)?;
    run(Command::new(python.with_file_name("typos")).current_dir(root()))?;
    run(cargo(&["doc", "--no-deps", "--workspace"]).env("RUSTDOCFLAGS", "-D warnings"))
}
