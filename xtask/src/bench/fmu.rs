//! `cargo xtask bench fmu`: builds what is compared, and runs the benchmark of `tests/abi`.

use crate::files::remove;
use crate::python;
use crate::run::{cargo, root, run, target};
use std::fs;
use std::path::{Path, PathBuf};

/// The FMUs' own profile for the libraries, and the pinned rival, if it can be had.
pub(crate) fn fmu(short: bool) -> Result<(), String> {
    run(&mut cargo(&[
        "build",
        "--profile",
        "fmu",
        "--package",
        "steerwright-bench-fmus",
        "--examples",
    ]))?;
    let mut bench = cargo(&["bench", "--bench", "fmu"]);
    bench.env("STEERWRIGHT_BENCH_FMUS", target().join("fmu/examples"));
    match pythonfmu() {
        Ok((unpacked, library)) => {
            bench.env("STEERWRIGHT_BENCH_PYTHONFMU", unpacked);
            bench.env("STEERWRIGHT_BENCH_LIBPYTHON", library);
        }
        Err(problem) => eprintln!("left out: pythonfmu: {problem}"),
    }
    if short {
        bench.args(["--", "--short"]);
    }
    run(&mut bench)
}

/// An unpacked FMU of pythonfmu with the linear model, made in an environment of its own, and the
/// library of Python that it takes to be loaded.
fn pythonfmu() -> Result<(PathBuf, PathBuf), String> {
    let python = python::environment_in(
        &target().join("bench-python"),
        &root().join("tests/abi/bench/requirements.txt"),
    )?;
    let script = root().join("tests/abi/bench/linear.py");
    let folder = target().join("bench-pythonfmu");
    remove(&folder)?;
    fs::create_dir_all(&folder).map_err(|e| format!("{}: {e}", folder.display()))?;
    let module = |module: &str| {
        let mut command = python::command(&python);
        command.args(["-m", module]);
        command
    };
    run(module("pythonfmu").args(["build", "-f"]).arg(&script).arg("-d").arg(&folder))?;
    let unpacked = folder.join("unpacked");
    let archive: &Path = &folder.join("Linear.fmu");
    run(module("zipfile").arg("-e").arg(archive).arg(&unpacked))?;
    let library = "import sysconfig; v = sysconfig.get_config_var; \
                   print(v('LIBDIR') + '/' + v('LDLIBRARY'))";
    let answer =
        python::command(&python).args(["-c", library]).output().map_err(|e| e.to_string())?;
    let library = PathBuf::from(String::from_utf8_lossy(&answer.stdout).trim());
    if !library.is_file() || library.extension().is_some_and(|e| e == "a") {
        return Err(format!("this Python has no shared library: {}", library.display()));
    }
    Ok((unpacked, library))
}
