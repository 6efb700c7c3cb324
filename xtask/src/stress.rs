//! `cargo xtask stress`.

use crate::run::{cargo, run};
use crate::test::STRESS;

/// The tests that take minutes: of the C interface, and of builds in two folders.
pub(crate) fn stress() -> Result<(), String> {
    let only = ["--", STRESS, "--ignored", "--nocapture", "--test-threads=1"];
    let packages = ["--package", "steerwright-abi", "--package", "steerwright-binaries"];
    run(cargo(&["test", "--release"]).args(packages).args(only))
}
