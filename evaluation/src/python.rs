//! Python programs of the peers, each run once with a file of numbers.

use std::io::Write;
use std::process::{Command, Stdio};

/// The variable that names an interpreter with the peers' packages.
const INTERPRETER: &str = "STEERWRIGHT_PEERS_PYTHON";
/// OpenBLAS chooses its kernels by the processor. These variables replace that choice, and make it up
/// to eight times slower where they name another processor.
const OPENBLAS_TUNING: [&str; 2] = ["OPENBLAS_CORETYPE", "OPENBLAS_L2_SIZE"];

/// The interpreter with the peers' packages, set up as every comparison needs it: one thread for linear
/// algebra, with the kernels that suit the processor.
///
/// # Errors
/// Where no interpreter is named.
pub fn python() -> Result<Command, String> {
    let interpreter = std::env::var_os(INTERPRETER)
        .ok_or_else(|| format!("{INTERPRETER} names no Python interpreter"))?;
    let mut command = Command::new(interpreter);
    single_threaded(&mut command);
    Ok(command)
}

/// Limits a program to one thread for linear algebra, with OpenBLAS's own choice of kernels.
pub fn single_threaded(command: &mut Command) {
    for threads in ["OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"] {
        command.env(threads, "1");
    }
    for tuning in OPENBLAS_TUNING {
        command.env_remove(tuning);
    }
}

/// Runs `program` with the path of a file that holds `numbers` (little-endian f64) and `arguments`;
/// what it prints, line by line.
///
/// # Errors
/// In words, where there is no interpreter, or the program fails.
pub fn request(
    program: &str,
    numbers: &[f64],
    arguments: &[String],
) -> Result<Vec<String>, String> {
    let mut command = python()?;
    let mut file = tempfile::NamedTempFile::new().map_err(|e| e.to_string())?;
    let bytes: Vec<u8> = numbers.iter().flat_map(|x| x.to_le_bytes()).collect();
    file.write_all(&bytes).map_err(|e| e.to_string())?;
    command.arg("-c").arg(program).arg(file.path()).args(arguments);
    let output =
        command.stderr(Stdio::inherit()).output().map_err(|e| format!("the interpreter: {e}"))?;
    if !output.status.success() {
        return Err(format!("the Python program ended with {}", output.status));
    }
    let text = String::from_utf8(output.stdout).map_err(|e| e.to_string())?;
    Ok(text.lines().map(str::to_owned).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn peers_run_on_one_thread_with_their_own_choice_of_kernels() {
        let mut command = Command::new("python3");
        single_threaded(&mut command);
        let set: Vec<_> = command.get_envs().collect();
        for tuning in OPENBLAS_TUNING {
            assert!(set.contains(&(tuning.as_ref(), None)), "{tuning} is passed on");
        }
        assert!(set.contains(&("OPENBLAS_NUM_THREADS".as_ref(), Some("1".as_ref()))));
    }
}
