//! One archive at least of every FMU: the demo's, and those of the examples of FMUs that the demo does not make.

use crate::files::remove;
use crate::fmus::fmus;
use crate::run::{program, root, run};
use std::path::Path;
use std::process::Command;

/// Runs the demo into `out` and packs what is missing next to its archives; `binaries` is a folder of libraries to
/// pack instead of this machine's own.
pub(crate) fn pack(out: &Path, binaries: Option<&Path>) -> Result<(), String> {
    let program = program(binaries)?;
    // The demo replaces only a folder of its own, and others were added to the one before.
    remove(out)?;
    run(Command::new(&program).args(["demo", "--out"]).arg(out))?;
    let archives = out.join("multibody/fmu");
    let mut others = Vec::new();
    for (folder, name) in fmus(root())? {
        if !archives.join(format!("{name}.fmu")).is_file() {
            others.push(root().join("fmu").join(folder).join("example.json"));
        }
    }
    run(Command::new(&program).arg("package").args(others).arg("--out").arg(archives))
}
