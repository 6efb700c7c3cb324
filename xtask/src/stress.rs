//! `cargo xtask stress`.

use crate::run::{cargo, run};

/// With this in their names, tests take minutes.
pub(crate) const STRESS: &str = "stress_";

/// The tests that take minutes: of the C interface, and of builds in two folders.
pub(crate) fn stress() -> Result<(), String> {
    let only = ["--", STRESS, "--ignored", "--nocapture", "--test-threads=1"];
    let packages = ["--package", "steerwright-abi", "--package", "steerwright-binaries"];
    run(cargo(&["test", "--release"]).args(packages).args(only))
}
