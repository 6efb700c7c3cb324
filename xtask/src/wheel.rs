//! `cargo xtask wheel`: the Python package, built, installed and tested.

use crate::cross;
use crate::files::{below, remove};
use crate::python::{command, environment, environment_in, new_environment};
use crate::run::{answer, root, run, target};
use std::fs;
use std::path::{Path, PathBuf};
use std::time::Instant;

/// Oldest glibc that the wheel for Linux runs with, as maturin names it.
const COMPATIBILITY: &str = "manylinux2014";

/// Builds the wheel and tests it. `update` writes the file that is generated instead; otherwise it has to be current.
pub(crate) fn wheel(update: bool) -> Result<(), String> {
    let (python, wheel) = installed()?;
    if update {
        let written = answer(command(&python).args(["-m", "steerwright._generate"]));
        let path = root().join("python/steerwright/options.py");
        let text = written.ok_or("python -m steerwright._generate failed")? + "\n";
        return fs::write(&path, text).map_err(|e| format!("{}: {e}", path.display()));
    }
    // Elsewhere than in the sources, which would be imported instead of the installed package.
    run(command(&python)
        .args(["-m", "pytest", "-p", "no:cacheprovider"])
        .arg(root().join("python/tests"))
        .env("PYTHONDONTWRITEBYTECODE", "1")
        .current_dir(target()))?;
    fresh(&wheel)
}

/// The interpreter of the environment that the wheel is tested in, with the wheel.
pub(crate) fn installed() -> Result<(PathBuf, PathBuf), String> {
    let wheel = build()?;
    let requirements = root().join("python/tests/requirements.txt");
    let python = environment_in(&target().join("python-package"), &requirements)?;
    let install = ["-m", "pip", "install", "--quiet", "--force-reinstall", "--no-deps"];
    run(command(&python).args(install).arg(&wheel))?;
    Ok((python, wheel))
}

/// Installs the wheel into a new environment, and times it up to the first packed FMU.
fn fresh(wheel: &Path) -> Result<(), String> {
    let folder = target().join("python-fresh");
    remove(&folder)?;
    let python = new_environment(&folder)?;
    let start = Instant::now();
    run(command(&python).args(["-m", "pip", "install", "--quiet"]).arg(wheel))?;
    let installed = start.elapsed().as_secs_f64();
    let example = root().join("python/examples/log_to_fmu.py");
    let drive = root().join("examples/drives/multibody/drive.csv");
    run(command(&python).arg(example).arg(drive).arg(folder.join("fmu")).current_dir(&folder))?;
    let (name, size) =
        (wheel.file_name().unwrap_or_default().to_string_lossy(), fs::metadata(wheel));
    let size = size.map(|m| m.len() as f64 / 1e6).unwrap_or_default();
    eprintln!("{name}: {size:.1} MB");
    eprintln!(
        "a new environment: pip install {installed:.1} s, a packed FMU after {:.1} s",
        start.elapsed().as_secs_f64()
    );
    Ok(())
}

fn build() -> Result<PathBuf, String> {
    let python = environment()?;
    let wheels = target().join("wheels");
    remove(&wheels)?;
    let mut maturin = command(&python);
    maturin
        .args(["-m", "maturin", "build", "--release", "--locked", "--features", "shared-build"])
        .arg("--manifest-path")
        .arg(root().join("python/Cargo.toml"))
        .arg("--out")
        .arg(&wheels);
    if cfg!(all(target_os = "linux", target_arch = "x86_64")) {
        // The linker alone decides on the glibc, so that everything else is what the tests compiled.
        let linker = cross::linker()?;
        maturin.args(["--compatibility", COMPATIBILITY, "--"]);
        maturin.arg(format!("-Clinker={}", linker.display()));
    }
    run(&mut maturin)?;
    below(&wheels, "whl")?.pop().ok_or_else(|| format!("{}: no wheel", wheels.display()))
}
