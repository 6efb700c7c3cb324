//! `cargo xtask fuzz`: the fuzzer over the targets of tests/fuzzing.

use crate::run::{cargo, root, run, target};
use std::fs;
use std::path::PathBuf;
use std::process::Command;

const VERSION: &str = "0.13.2";

/// Runs each target for so many minutes; none named means all. What is found is left in
/// `tests/fuzzing/fuzz/artifacts`; the grown corpora stay in the target folder.
pub(crate) fn fuzz(minutes: f64, names: &[String]) -> Result<(), String> {
    if !(minutes > 0.0 && minutes < 1e5) {
        return Err(format!("--minutes {minutes}: expected a number above 0"));
    }
    let tool = tool()?;
    let folder = root().join("tests/fuzzing");
    for name in targets()?.iter().filter(|name| names.is_empty() || names.contains(name)) {
        let grown = target().join("fuzz-corpus").join(name);
        fs::create_dir_all(&grown).map_err(|e| format!("{}: {e}", grown.display()))?;
        let mut fuzz = Command::new(&tool);
        // Coverage needs flags that only nightly compilers take without this variable; no address
        // sanitizer, whose runtime a stable compiler comes without.
        fuzz.current_dir(&folder)
            .env("RUSTC_BOOTSTRAP", "1")
            .env("CARGO_TARGET_DIR", target().join("fuzz"))
            .args(["fuzz", "run", "--sanitizer", "none", name])
            .arg(&grown)
            .arg(folder.join("corpus").join(name))
            .args(["--", "-timeout=10", "-print_final_stats=1", "-verbosity=0"])
            .arg(format!("-max_total_time={}", (60.0 * minutes).round()));
        run(&mut fuzz)?;
    }
    Ok(())
}

/// The names of the targets, which are those of their programs.
fn targets() -> Result<Vec<String>, String> {
    let folder = root().join("tests/fuzzing/fuzz/fuzz_targets");
    let entries = fs::read_dir(&folder).map_err(|e| format!("{}: {e}", folder.display()))?;
    let mut names: Vec<String> = entries
        .filter_map(|entry| Some(entry.ok()?.path().file_stem()?.to_string_lossy().into_owned()))
        .collect();
    names.sort();
    Ok(names)
}

/// cargo-fuzz, installed into the target folder if it is not there.
fn tool() -> Result<PathBuf, String> {
    let tools = target().join("tools");
    let program = tools.join("bin/cargo-fuzz");
    if !program.is_file() {
        let arguments = ["install", "cargo-fuzz", "--locked", "--version", VERSION, "--root"];
        run(cargo(&arguments).arg(&tools))?;
    }
    Ok(program)
}
