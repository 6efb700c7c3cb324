//! Peak memory beyond the signals.

use super::{Outcome, ours};
use std::path::Path;
use std::process::Command;
use steerwright_evaluation::measure::peak_memory;
use steerwright_evaluation::peers::read_signals;

/// Peak memory of this program with only the signals loaded and with the model computed.
pub(crate) fn memory(path: &Path, count: usize) {
    let peak = |what: &str| -> Outcome<f64> {
        let output = Command::new(std::env::current_exe()?)
            .args(["speed", "--memory", what])
            .arg(path)
            .arg(count.to_string())
            .output()?;
        let text = String::from_utf8_lossy(&output.stdout).trim().to_owned();
        text.parse()
            .map_err(|_| format!("the system does not report the peak memory: {text}").into())
    };
    match (peak("loaded"), peak("model")) {
        (Ok(loaded), Ok(computed)) => println!(
            "\nPeak memory at N = {count}: {:.2} MB with the signals loaded, {:.2} MB with factor and model, {:.2} MB more (target: below 4)",
            loaded / 1e6,
            computed / 1e6,
            (computed - loaded) / 1e6
        ),
        (Err(problem), _) | (_, Err(problem)) => println!("\nPeak memory left out: {problem}"),
    }
}

pub(crate) fn memory_of(values: &[String]) -> Outcome<()> {
    let [what, path, count] = values else { return Err("three values are needed".into()) };
    let (u, y) = read_signals(Path::new(path), count.parse()?)?;
    if what == "model" {
        std::hint::black_box(ours(&u, &y)?);
    }
    std::hint::black_box((&u, &y));
    println!("{}", peak_memory().ok_or("no /proc/self/status")?);
    Ok(())
}
