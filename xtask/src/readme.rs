//! `cargo xtask readme`: the table and the picture in the README, from the demo.

use crate::run::{program, root, target};
use std::fs;
use std::path::Path;
use std::process::Command;

const BEGIN: &str = "<!-- demo:begin -->";
const END: &str = "<!-- demo:end -->";

/// Runs the demo and puts what it made into the README and docs/.
pub(crate) fn readme() -> Result<(), String> {
    let out = target().join("readme");
    let said = |path: &Path| {
        let path = path.display().to_string();
        move |e: std::io::Error| format!("{path}: {e}")
    };
    let demo = Command::new(program(None)?)
        .args(["demo", "--out"])
        .arg(&out)
        .output()
        .map_err(|e| e.to_string())?;
    let printed = String::from_utf8_lossy(&demo.stdout);
    // 1: done, but a requirement is not met, which the table says.
    if !matches!(demo.status.code(), Some(0 | 1)) {
        let problem = String::from_utf8_lossy(&demo.stderr);
        return Err(format!("the demo ended with {}: {problem}", demo.status));
    }
    // The table ends at the first empty line; what follows names the files.
    let table = printed.split("\n\n").next().unwrap_or_default().trim_end();
    let readme = root().join("README.md");
    let text = fs::read_to_string(&readme).map_err(said(&readme))?;
    let (head, rest) = text.split_once(BEGIN).ok_or("README.md has no demo mark")?;
    let (_, tail) = rest.split_once(END).ok_or("README.md has no demo mark")?;
    let text = format!("{head}{BEGIN}\n```\n{table}\n```\n{END}{tail}");
    fs::write(&readme, text).map_err(said(&readme))?;
    let picture = out.join("multibody/figures/step.svg");
    fs::copy(&picture, root().join("docs/step.svg")).map_err(said(&picture))?;
    Ok(())
}
