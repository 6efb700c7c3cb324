//! Running other programs.

use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::LazyLock;

/// The workspace's folder.
pub(crate) fn root() -> &'static Path {
    // That of the working folder, else where it was built: a target folder may have been copied with the program.
    static ROOT: LazyLock<PathBuf> = LazyLock::new(|| {
        let here = std::env::current_dir().unwrap_or_default();
        let own = here.ancestors().find(|folder| folder.join("xtask/Cargo.toml").is_file());
        let built = || Path::new(env!("CARGO_MANIFEST_DIR")).parent().map(Path::to_path_buf);
        own.map(Path::to_path_buf).or_else(built).unwrap_or_else(|| ".".into())
    });
    &ROOT
}

/// The target folder of this build, wherever the user has put it.
pub(crate) fn target() -> PathBuf {
    std::env::current_exe()
        .ok()
        .and_then(|exe| Some(exe.parent()?.parent()?.to_path_buf()))
        .unwrap_or_else(|| root().join("target"))
}

/// Cargo, in the workspace.
pub(crate) fn cargo(arguments: &[&str]) -> Command {
    let mut cargo = Command::new(std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into()));
    cargo.args(arguments).current_dir(root());
    // Its child processes may start a Python program, see `python::command`.
    cargo.env_remove("OPENBLAS_CORETYPE").env_remove("OPENBLAS_L2_SIZE");
    cargo
}

/// The command line that users run, with the FMU libraries of a folder or this machine's own.
///
/// It is built as `cargo test --release` builds it. Other selections of packages give shared
/// dependencies other features, and all that depends on them would be compiled once more.
pub(crate) fn program(binaries: Option<&Path>) -> Result<PathBuf, String> {
    let mut build = cargo(&["test", "--release", "--quiet", "--no-run", "--test", "python"]);
    run(build.envs(binaries.map(|folder| ("STEERWRIGHT_FMU_BINARIES", folder))))?;
    Ok(released("steerwright"))
}

/// A program in the folder of the release profile.
pub(crate) fn released(name: &str) -> PathBuf {
    target().join("release").join(format!("{name}{}", std::env::consts::EXE_SUFFIX))
}

/// A command as a line, which is shown.
pub(crate) fn shown(command: &Command) -> String {
    let name = command.get_program().to_string_lossy().into_owned();
    let words = command.get_args().map(|a| a.to_string_lossy().into_owned()).collect::<Vec<_>>();
    let line = format!("{name} {}", words.join(" "));
    eprintln!("$ {line}");
    line
}

/// Runs to the end; an error names the command.
pub(crate) fn run(command: &mut Command) -> Result<(), String> {
    let line = shown(command);
    let status = command.status().map_err(|e| format!("{line}: {e}"))?;
    if status.success() { Ok(()) } else { Err(format!("{line}: {status}")) }
}

/// Runs to the end, as [`run`]; returns what the program prints on its standard output, which is shown.
pub(crate) fn run_and_read(command: &mut Command) -> Result<String, String> {
    let line = shown(command);
    let problem = |e: std::io::Error| format!("{line}: {e}");
    let mut child = command.stdout(Stdio::piped()).spawn().map_err(problem)?;
    let mut text = String::new();
    if let Some(output) = child.stdout.take() {
        for line in BufReader::new(output).lines() {
            let line = line.map_err(problem)?;
            println!("{line}");
            text += &(line + "\n");
        }
    }
    let status = child.wait().map_err(problem)?;
    if status.success() { Ok(text) } else { Err(format!("{line}: {status}")) }
}

/// What a program prints, if it succeeds.
pub(crate) fn answer(command: &mut Command) -> Option<String> {
    let output = command.output().ok().filter(|output| output.status.success())?;
    Some(String::from_utf8_lossy(&output.stdout).trim().to_owned()).filter(|text| !text.is_empty())
}
