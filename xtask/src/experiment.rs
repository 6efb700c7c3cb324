//! `cargo xtask experiment`: tests/experiment, on cars that no one here wrote.

use crate::python;
use crate::run::{program, root, run, target};

/// What is run.
#[derive(clap::Args)]
pub(crate) struct Options {
    /// The experiment's own tests instead
    #[arg(long, conflicts_with = "engagement")]
    test: bool,
    /// Engagement next to the road and large yaw steps instead: tests/experiment/engagement.py
    #[arg(long)]
    engagement: bool,
    /// Models of a whole drive instead: tests/experiment/whole_drive.py
    #[arg(long, conflicts_with = "engagement")]
    whole_drive: bool,
    /// Arguments of the Python program, such as `--quick` or `--seeds 40`
    #[arg(trailing_var_arg = true, allow_hyphen_values = true)]
    arguments: Vec<String>,
}

/// Runs the experiment with its own Python environment and the released command line.
pub(crate) fn experiment(options: &Options) -> Result<(), String> {
    let folder = root().join("tests/experiment");
    let requirements = folder.join("requirements.txt");
    let python = python::environment_in(&target().join("experiment-python"), &requirements)?;
    let mut command = python::command(&python);
    if options.test {
        return run(command.args(["-m", "pytest", "-q", "-p", "no:cacheprovider"]).arg(&folder));
    }
    let name = match (options.engagement, options.whole_drive) {
        (true, _) => "engagement.py",
        (_, true) => "whole_drive.py",
        _ => "experiment.py",
    };
    command.arg(folder.join(name)).arg("--program").arg(program(None)?);
    if name == "experiment.py" {
        command.arg("--out").arg(target().join("experiment"));
    }
    run(command.args(&options.arguments))
}
