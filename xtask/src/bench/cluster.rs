//! `cargo xtask bench cluster`.

use crate::run::{root, run, target};
use crate::{cross, python, wheel};

/// Runs, and logs of a fleet.
const WHOLE: [&str; 2] = ["1000000", "1000"];
const SHORT: [&str; 2] = ["2000", "20"];

/// Runs evaluation/cluster/cluster.py with the wheel; the libraries are those of `cargo xtask cross` where there are
/// some, as in the wheel that was tested.
pub(crate) fn cluster(short: bool) -> Result<(), String> {
    let binaries = cross::binaries();
    let (interpreter, _) =
        wheel::installed(if binaries.is_dir() { Some(binaries.as_path()) } else { None })?;
    run(python::command(&interpreter)
        .arg(root().join("evaluation/cluster/cluster.py"))
        .arg(root().join("examples/drives/multibody/drive.csv"))
        .args(if short { SHORT } else { WHOLE })
        .current_dir(target()))
}
