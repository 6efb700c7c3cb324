//! `cargo xtask test`.

use crate::run::{cargo, run};
use crate::{importers, python};

/// Every test of the workspace, with the Python environment that some of them need, and then those
/// that are outside of it.
pub(crate) fn test() -> Result<(), String> {
    let python = python::environment()?;
    // Release: the tests step models millions of times.
    run(cargo(&["test", "--release", "--no-fail-fast"]).env("STEERWRIGHT_PYTHON", &python))?;
    importers::importers(&python)
}
