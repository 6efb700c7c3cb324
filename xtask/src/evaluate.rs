//! `cargo xtask evaluate` and `bench sysid`: the programs of `sysid/evaluation`, in release mode, with
//! the Python environment of the peers they are compared with.

use crate::python;
use crate::run::{cargo, root, run, target};

/// Runs one of the programs with its arguments; where the peers cannot be had, without them.
pub(crate) fn evaluate(program: &str, arguments: &[String]) -> Result<(), String> {
    if program == "command_line" {
        // It runs the program that users run.
        run(&mut cargo(&["build", "--release", "--quiet", "--package", "steerwright"]))?;
    }
    let mut command =
        cargo(&["run", "--release", "--quiet", "--package", "sysid-evaluation", "--bin", program]);
    command.arg("--").args(arguments);
    let peers = python::environment_in(
        &target().join("peers-python"),
        &root().join("sysid/evaluation/requirements.txt"),
    );
    match peers {
        Ok(interpreter) => {
            command.env("STEERWRIGHT_PEERS_PYTHON", interpreter);
        }
        Err(problem) => eprintln!("left out: peers from Python: {problem}"),
    }
    run(&mut command)
}
