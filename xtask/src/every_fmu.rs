//! One archive at least of every FMU: the demo's, and those that the demo does not make, the nonlinear
//! vehicle, the response of the speed and the pose estimator.

use crate::files::remove;
use crate::run::{program, root, run};
use std::ffi::OsStr;
use std::path::Path;
use std::process::Command;

/// Runs the demo into `out` and packs the three written by hand next to its archives; `binaries` is a
/// folder of libraries to pack instead of this machine's own.
pub(crate) fn pack(out: &Path, binaries: Option<&Path>) -> Result<(), String> {
    let by_hand = |name: &str| root().join("examples/drives/multibody").join(name);
    let files = ["vehicle.json", "longitudinal.json", "estimator.json"].map(by_hand);
    let program = program(binaries)?;
    // The demo replaces only a folder of its own, and the three were added to the one before.
    remove(out)?;
    for (arguments, out) in [
        (vec![OsStr::new("demo")], out.to_owned()),
        (
            [OsStr::new("package")]
                .into_iter()
                .chain(files.iter().map(|f| f.as_os_str()))
                .collect(),
            out.join("multibody/fmu"),
        ),
    ] {
        run(Command::new(&program).args(arguments).arg("--out").arg(out))?;
    }
    Ok(())
}
