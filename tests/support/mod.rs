//! Running the program, and the folder of one demo that a test binary shares.
#![allow(dead_code, clippy::unwrap_used, clippy::panic)]

use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use std::sync::OnceLock;

/// Runs `steerwright` with arguments, in a folder.
pub(crate) fn steerwright<S: AsRef<std::ffi::OsStr>>(folder: &Path, arguments: &[S]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_steerwright"))
        .args(arguments)
        .current_dir(folder)
        .output()
        .unwrap()
}

/// What a run left on stderr.
pub(crate) fn told(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

/// The data that ships with the repository.
pub(crate) fn data() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data")
}

/// A demo: its folder, and the JSON it printed.
pub(crate) struct Demo {
    pub(crate) folder: PathBuf,
    pub(crate) overview: serde_json::Value,
}

/// The demo of this test binary, run once.
pub(crate) fn demo() -> &'static Demo {
    static DEMO: OnceLock<Demo> = OnceLock::new();
    DEMO.get_or_init(|| run_demo("demo"))
}

/// Runs the demo into a folder of that name, made anew.
pub(crate) fn run_demo(name: &str) -> Demo {
    // The test binary's name keeps binaries that run at the same time apart.
    let exe = std::env::current_exe().unwrap();
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(exe.file_stem().unwrap()).join(name);
    let _ = std::fs::remove_dir_all(&folder);
    let output = steerwright(
        &std::env::temp_dir(),
        &["demo".as_ref(), "--json".as_ref(), "--out".as_ref(), folder.as_os_str()],
    );
    assert!(output.status.success(), "{}", told(&output));
    Demo { folder, overview: serde_json::from_slice(&output.stdout).unwrap() }
}
