//! `cargo xtask experiment`: evaluation/experiment, on cars that no one here wrote.

use crate::python;
use crate::run::{program, root, run, target};

/// What is run.
#[derive(clap::Args)]
pub(crate) struct Options {
    /// The experiment's own tests instead
    #[arg(long, conflicts_with = "engagement")]
    test: bool,
    /// Engagement next to the road and large yaw steps instead: evaluation/experiment/engagement.py
    #[arg(long)]
    engagement: bool,
    /// Models of a whole drive instead: evaluation/experiment/whole_drive.py
    #[arg(long, conflicts_with = "engagement")]
    whole_drive: bool,
    /// Designs over a range of speeds instead: evaluation/experiment/over_speed.py
    #[arg(long, conflicts_with_all = ["test", "engagement", "whole_drive"])]
    over_speed: bool,
    /// A few minutes at speeds that nothing was tuned on instead: evaluation/experiment/smoke.py
    #[arg(long, conflicts_with_all = ["test", "engagement", "whole_drive", "over_speed"])]
    smoke: bool,
    /// Arguments of the Python program, such as `--quick`, `--seeds 40`, or `--seed 7` of `--smoke`
    #[arg(trailing_var_arg = true, allow_hyphen_values = true)]
    arguments: Vec<String>,
}

/// Runs the experiment with its own Python environment and the released command line.
pub(crate) fn experiment(options: &Options) -> Result<(), String> {
    let folder = root().join("evaluation/experiment");
    let requirements = folder.join("requirements.txt");
    let python = python::environment_in(&target().join("experiment-python"), &requirements)?;
    let mut command = python::command(&python);
    if options.test {
        return run(command.args(["-m", "pytest", "-q", "-p", "no:cacheprovider"]).arg(&folder));
    }
    let name = if options.engagement {
        "engagement.py"
    } else if options.whole_drive {
        "whole_drive.py"
    } else if options.over_speed {
        "over_speed.py"
    } else if options.smoke {
        "smoke.py"
    } else {
        "experiment.py"
    };
    command.arg(folder.join(name)).arg("--program").arg(program(None)?);
    if name == "experiment.py" {
        command.arg("--out").arg(target().join("experiment"));
    }
    run(command.args(&options.arguments))
}
