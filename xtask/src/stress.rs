//! `cargo xtask stress`.

use crate::run::{cargo, run};

/// The tests of the C interface that take minutes.
pub(crate) fn stress() -> Result<(), String> {
    let only = ["--", "--ignored", "--nocapture", "--test-threads=1"];
    run(cargo(&["test", "--release", "--package", "abi-tests"]).args(only))
}
