//! Python environments: that of the tests is target/python, made from tests/python/requirements.txt.

use crate::files::{read, remove};
use crate::run::{root, run, target};
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

/// The interpreter of the tests' environment.
pub(crate) fn environment() -> Result<PathBuf, String> {
    environment_in(&target().join("python"), &root().join("tests/python/requirements.txt"))
}

/// A Python program. NumPy's OpenBLAS is left to choose its kernels: these variables, where they
/// name another processor, make it several times slower.
pub(crate) fn command(interpreter: &Path) -> Command {
    let mut command = Command::new(interpreter);
    command.env_remove("OPENBLAS_CORETYPE").env_remove("OPENBLAS_L2_SIZE");
    command
}

/// The interpreter of an environment that holds exactly the pinned requirements.
pub(crate) fn environment_in(folder: &Path, requirements: &Path) -> Result<PathBuf, String> {
    let wanted = read(requirements)?;
    let python = interpreter(folder);
    let stamp = folder.join("installed.txt");
    if python.exists() && fs::read_to_string(&stamp).is_ok_and(|installed| installed == wanted) {
        return Ok(python);
    }
    remove(folder)?;
    let python = new_environment(folder)?;
    run(Command::new(&python)
        .args(["-m", "pip", "install", "--quiet", "--disable-pip-version-check", "-r"])
        .arg(requirements))?;
    fs::write(&stamp, wanted).map_err(|e| format!("{}: {e}", stamp.display()))?;
    Ok(python)
}

/// The interpreter of a new environment that holds pip alone.
pub(crate) fn new_environment(folder: &Path) -> Result<PathBuf, String> {
    let base = base_interpreter()?;
    // Debian's Python has no ensurepip: then pip installs virtualenv.
    if run(Command::new(base).args(["-m", "venv"]).arg(folder)).is_err() {
        let tools = target().join("virtualenv");
        run(Command::new(base)
            .args(["-m", "pip", "install", "--quiet", "--target"])
            .arg(&tools)
            .arg("virtualenv"))
        .map_err(|e| format!("{e}; install the package python3-venv, or pip"))?;
        run(Command::new(base)
            .args(["-m", "virtualenv", "--quiet"])
            .arg(folder)
            .env("PYTHONPATH", &tools))?;
    }
    Ok(interpreter(folder))
}

fn interpreter(folder: &Path) -> PathBuf {
    folder.join(if cfg!(windows) { "Scripts/python.exe" } else { "bin/python" })
}

/// The first Python 3 on the path.
fn base_interpreter() -> Result<&'static str, String> {
    ["python3", "python"]
        .into_iter()
        .find(|name| {
            let check = ["-c", "import sys; sys.exit(sys.version_info < (3, 10))"];
            Command::new(name).args(check).status().is_ok_and(|s| s.success())
        })
        .ok_or_else(|| "Python 3.10 or newer was not found; install python3".into())
}
