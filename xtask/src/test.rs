//! `cargo xtask test`.

use crate::python;
use crate::run::{cargo, run};

/// Every test of the workspace, with the Python environment that some of them need.
pub(crate) fn test() -> Result<(), String> {
    let python = python::environment()?;
    // Release: the tests step models millions of times.
    run(cargo(&["test", "--release", "--no-fail-fast"]).env("STEERWRIGHT_PYTHON", python))
}
