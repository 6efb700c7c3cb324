//! One archive at least of every FMU: the demo's, and those that the demo does not make, the nonlinear
//! vehicle and the pose estimator.

use crate::files::remove;
use crate::run::{program, root, run};
use std::ffi::OsStr;
use std::path::Path;
use std::process::Command;

/// Runs the demo into `out` and packs the two written by hand next to its archives; `binaries` is a
/// folder of libraries to pack instead of this machine's own.
pub(crate) fn pack(out: &Path, binaries: Option<&Path>) -> Result<(), String> {
    let by_hand = |name: &str| root().join("examples/drives/multibody").join(name);
    let (vehicle, estimator) = (by_hand("vehicle.json"), by_hand("estimator.json"));
    let program = program(binaries)?;
    // The demo replaces only a folder of its own, and the two were added to the one before.
    remove(out)?;
    for (arguments, out) in [
        (vec![OsStr::new("demo")], out.to_owned()),
        (
            vec![OsStr::new("package"), vehicle.as_os_str(), estimator.as_os_str()],
            out.join("multibody/fmu"),
        ),
    ] {
        run(Command::new(&program).args(arguments).arg("--out").arg(out))?;
    }
    Ok(())
}
