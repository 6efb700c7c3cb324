//! Python programs of the peers, each asked once with a file of numbers.

use std::io::Write;
use std::process::{Command, Stdio};

/// The variable that names an interpreter with the peers' packages.
const INTERPRETER: &str = "STEERWRIGHT_PEERS_PYTHON";

/// Runs `program` with the path of a file that holds `numbers` (little-endian f64) and `arguments`;
/// what it prints, line by line.
///
/// # Errors
/// In words, where there is no interpreter, or the program fails.
pub fn ask(program: &str, numbers: &[f64], arguments: &[String]) -> Result<Vec<String>, String> {
    let interpreter = std::env::var_os(INTERPRETER)
        .ok_or_else(|| format!("{INTERPRETER} names no Python interpreter"))?;
    let mut file = tempfile::NamedTempFile::new().map_err(|e| e.to_string())?;
    let bytes: Vec<u8> = numbers.iter().flat_map(|x| x.to_le_bytes()).collect();
    file.write_all(&bytes).map_err(|e| e.to_string())?;
    let mut command = Command::new(&interpreter);
    command.arg("-c").arg(program).arg(file.path()).args(arguments);
    for threads in ["OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"] {
        command.env(threads, "1");
    }
    let output = command
        .stderr(Stdio::inherit())
        .output()
        .map_err(|e| format!("{}: {e}", interpreter.display()))?;
    if !output.status.success() {
        return Err(format!("the Python program ended with {}", output.status));
    }
    let text = String::from_utf8(output.stdout).map_err(|e| e.to_string())?;
    Ok(text.lines().map(str::to_owned).collect())
}
