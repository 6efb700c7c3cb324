//! `cargo xtask readme`: what the documents show of the program, made by running it: the demo's tables and
//! the figures.

use crate::files::{read, remove};
use crate::run::{program, root, run, target};
use serde_json::Value;
use std::fs;
use std::path::Path;
use std::process::Command;

const BEGIN: &str = "<!-- demo:begin -->";
const END: &str = "<!-- demo:end -->";

/// The book's figures, from the demo and from the comparison of its two models.
const FIGURES: [(&str, &str); 9] = [
    ("demo/multibody/figures/step.svg", "step.svg"),
    ("demo/multibody/figures/drive.svg", "fig1-drive.svg"),
    ("demo/multibody/figures/comparison.svg", "fig2-yaw.svg"),
    ("comparison/fig3-drive.svg", "fig3-models.svg"),
    ("comparison/fig5-road.svg", "fig5-road.svg"),
    ("comparison/fig6-7-plant.svg", "fig6-identified.svg"),
    ("comparison/fig6-7-bicycle.svg", "fig7-bicycle.svg"),
    ("demo/multibody/figures/road-recorded.svg", "fig10-recorded-road.svg"),
    ("demo/multibody/figures/errors-recorded.svg", "fig11-12-errors.svg"),
];

/// Runs the demo and the comparison and writes what they print and draw into README.md and docs/.
pub(crate) fn readme() -> Result<(), String> {
    let out = target().join("readme");
    remove(&out)?;
    fs::create_dir_all(&out).map_err(|e| format!("{}: {e}", out.display()))?;
    let program = program(None)?;
    let demo = |options: &[&str]| {
        let mut demo = Command::new(&program);
        printed(demo.args(options).args(["demo", "--out"]).arg(out.join("demo")))
    };
    let table = table(&serde_json::from_str(&demo(&["--json"])?).map_err(|e| e.to_string())?)?;
    replace(&root().join("README.md"), &table)?;
    // The table ends at the first empty line; the files are listed after it.
    let complete = demo(&[])?;
    let complete = complete.split("\n\n").next().unwrap_or_default().trim_end();
    replace(&root().join("docs/demo.md"), &format!("```\n{complete}\n```"))?;
    let data = root().join("examples/drives/multibody");
    let models = ["plant.json", "bicycle.json"].map(|name| out.join("demo/multibody").join(name));
    run(Command::new(&program)
        .arg("compare")
        .args(models)
        .arg("--truth")
        .arg(data.join("vehicle.json"))
        .arg("--log")
        .arg(data.join("drive.csv"))
        .args(["--input-channel", "steering_command_rad", "--steering-ratio", "1"])
        .args(["--max-rate", "0.4rad/s", "--out"])
        .arg(out.join("comparison")))?;
    for (from, to) in FIGURES {
        let to = root().join("docs/figures").join(to);
        fs::copy(out.join(from), &to).map_err(|e| format!("{from}: {e}"))?;
    }
    Ok(())
}

/// What a command prints. Its exit status 1 is a requirement that is not met, which the output states.
fn printed(command: &mut Command) -> Result<String, String> {
    let output = command.output().map_err(|e| e.to_string())?;
    if !matches!(output.status.code(), Some(0 | 1)) {
        let problem = String::from_utf8_lossy(&output.stderr);
        return Err(format!("the demo ended with {}: {problem}", output.status));
    }
    Ok(String::from_utf8_lossy(&output.stdout).into_owned())
}

fn replace(file: &Path, what: &str) -> Result<(), String> {
    let text = read(file)?;
    let parts =
        text.split_once(BEGIN).and_then(|(head, rest)| Some((head, rest.split_once(END)?.1)));
    let (head, tail) = parts.ok_or(format!("{} has no demo mark", file.display()))?;
    fs::write(file, format!("{head}{BEGIN}\n{what}\n{END}{tail}"))
        .map_err(|e| format!("{}: {e}", file.display()))
}

/// A row of the table: its name, and the figure of a drive where it has one.
type Row = (&'static str, fn(&Value) -> Option<String>);

const ROWS: [Row; 8] = [
    ("speed", |drive| number(&drive["speed_mps"], 1, " m/s")),
    ("quality of the model", |drive| Some(drive["quality"]["grade"].as_str()?.to_owned())),
    ("fit on validation data", |drive| number(&drive["held_out_fit_percent"], 1, " %")),
    ("fit of the data sheet's bicycle model", |drive| {
        number(&drive["bicycle_held_out_fit_percent"], 1, " %")
    }),
    ("overshoot of the 5° yaw step (at most 1 %)", |drive| {
        number(&step(drive)["overshoot_percent"], 2, " %")
    }),
    ("settling time (at most 1 s)", |drive| number(&step(drive)["settling_time_s"], 2, " s")),
    ("steady-state error (at most 2 %)", |drive| {
        number(&step(drive)["steady_state_error_percent"], 2, " %")
    }),
    ("cross-track error on the reference road, RMS", |drive| {
        number(&drive["controllers"][0]["tracks"][0]["cross_track_rms_m"], 4, " m")
    }),
];

fn step(drive: &Value) -> &Value {
    &drive["controllers"][0]["in_the_loop_of_fmus"]
}

fn number(value: &Value, digits: usize, unit: &str) -> Option<String> {
    value.as_f64().map(|value| format!("{value:.digits$}{unit}"))
}

/// The README's table of the demo's drives.
fn table(demo: &Value) -> Result<String, String> {
    let drives = demo.as_array().ok_or("the demo's JSON is not a list")?;
    let names: Vec<&str> = drives.iter().filter_map(|drive| drive["name"].as_str()).collect();
    let mut text = format!("| | {} |\n|---|{}", names.join(" | "), "---|".repeat(names.len()));
    for (name, figure) in ROWS {
        let figures: Vec<String> =
            drives.iter().map(|drive| figure(drive).unwrap_or_else(|| "–".into())).collect();
        text += &format!("\n| {name} | {} |", figures.join(" | "));
    }
    Ok(text)
}
