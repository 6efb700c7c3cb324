//! `cargo xtask experiment`: tests/experiment, on cars that no one here wrote.

use crate::python;
use crate::run::{program, root, run, target};

/// Runs the experiment with its own Python environment and the released command line.
pub(crate) fn experiment(test: bool, arguments: &[String]) -> Result<(), String> {
    let folder = root().join("tests/experiment");
    let requirements = folder.join("requirements.txt");
    let python = python::environment_in(&target().join("experiment-python"), &requirements)?;
    if test {
        let mut tests = python::command(&python);
        return run(tests.args(["-m", "pytest", "-q", "-p", "no:cacheprovider"]).arg(&folder));
    }
    let program = program(None)?;
    let mut command = python::command(&python);
    command.arg(folder.join("experiment.py"));
    command.arg("--program").arg(program);
    command.arg("--out").arg(target().join("experiment"));
    run(command.args(arguments))
}
