//! The tests in tests/importers: a package of its own, which needs libclang, a C compiler and the
//! archives of a demo.

use crate::every_fmu;
use crate::python;
use crate::run::{answer, cargo, root, run, target};
use std::env;
use std::path::Path;
use std::process::Command;

/// Packs every FMU and runs the tests on them all.
pub(crate) fn importers() -> Result<(), String> {
    let out = target().join("importers-out");
    every_fmu::pack(&out, None)?;
    let manifest = root().join("tests/importers/Cargo.toml");
    let mut test = cargo(&["test", "--release", "--no-fail-fast", "--manifest-path"]);
    test.arg(manifest).args(["--", "--show-output"]);
    // A folder of its own, so that it is built once, and not at odds with the workspace's.
    test.env("CARGO_TARGET_DIR", target().join("importers")).env("STEERWRIGHT_OUT", &out);
    if env::var_os("LIBCLANG_PATH").is_none() {
        test.env("LIBCLANG_PATH", libclang(&python::environment()?)?);
        if env::var_os("BINDGEN_EXTRA_CLANG_ARGS").is_none()
            && let Some(folder) = compiler_headers()
        {
            test.env("BINDGEN_EXTRA_CLANG_ARGS", format!("-isystem '{folder}'"));
        }
    }
    run(&mut test)
}

/// The folder of the libclang that is installed as a Python package.
fn libclang(python: &Path) -> Result<String, String> {
    let program = "import clang.native; print(clang.native.__path__[0])";
    answer(Command::new(python).args(["-c", program]))
        .ok_or_else(|| format!("{}: the package libclang is missing", python.display()))
}

/// The folder of the C compiler's own headers (`stddef.h`), which that libclang comes without.
fn compiler_headers() -> Option<String> {
    let folder = answer(Command::new("cc").arg("-print-file-name=include"))?;
    if Path::new(&folder).join("stddef.h").is_file() { Some(folder) } else { None }
}
