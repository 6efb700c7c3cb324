//! `cargo xtask bench cluster`.

use crate::run::{root, run, target};
use crate::{python, wheel};

/// Runs, and logs of a fleet.
const WHOLE: [&str; 2] = ["1000000", "1000"];
const SHORT: [&str; 2] = ["2000", "20"];

/// Runs evaluation/cluster/cluster.py with the wheel.
pub(crate) fn cluster(short: bool) -> Result<(), String> {
    let (interpreter, _) = wheel::installed()?;
    run(python::command(&interpreter)
        .arg(root().join("evaluation/cluster/cluster.py"))
        .arg(root().join("examples/drives/multibody/drive.csv"))
        .args(if short { SHORT } else { WHOLE })
        .current_dir(target()))
}
