//! `cargo xtask stress`.

use crate::run::{cargo, run};

/// The tests that take minutes: of the C interface, and of builds in two folders.
pub(crate) fn stress() -> Result<(), String> {
    let only = ["--", "--ignored", "--nocapture", "--test-threads=1"];
    let packages = ["--package", "abi-tests", "--package", "fmu-binaries"];
    run(cargo(&["test", "--release"]).args(packages).args(only))
}
