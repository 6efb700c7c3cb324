//! `cargo xtask experiment`: evaluation/experiment, on cars that no one here wrote.

use crate::python;
use crate::run::{program, root, run, target};

/// What is run.
#[derive(clap::Args)]
pub(crate) struct Options {
    #[command(flatten)]
    alternative: Alternative,
    /// Arguments of the Python program, such as `--quick`, `--seeds 40`, or `--seed 7` of `--smoke`
    #[arg(trailing_var_arg = true, allow_hyphen_values = true)]
    arguments: Vec<String>,
}

/// Another program than experiment.py.
#[derive(clap::Args)]
#[group(multiple = false)]
struct Alternative {
    /// The experiment's own tests instead
    #[arg(long)]
    test: bool,
    /// Engagement next to the road and large yaw steps instead: evaluation/experiment/engagement.py
    #[arg(long)]
    engagement: bool,
    /// Models of a whole drive instead: evaluation/experiment/whole_drive.py
    #[arg(long)]
    whole_drive: bool,
    /// Designs over a range of speeds instead: evaluation/experiment/over_speed.py
    #[arg(long)]
    over_speed: bool,
    /// Friction, mass, wind, bank, play, fixes and servos that the design did not see, beside other steering laws,
    /// instead: evaluation/experiment/conditions.py
    #[arg(long)]
    conditions: bool,
    /// The response of the speed to an acceleration command instead: evaluation/experiment/longitudinal.py
    #[arg(long)]
    longitudinal: bool,
    /// The manoeuvre of `excite` beside sweep, slalom, steps and random steering instead:
    /// evaluation/experiment/manoeuvres.py
    #[arg(long)]
    excitation: bool,
    /// Whole roads with their speed profiles, from standstill to standstill, beside other controllers, instead:
    /// evaluation/experiment/whole_road.py
    #[arg(long)]
    whole_road: bool,
    /// What designs promise from fast and slow logs, and from measured angles, instead:
    /// evaluation/experiment/promises.py
    #[arg(long)]
    promises: bool,
    /// A few minutes at speeds that nothing was tuned on instead: evaluation/experiment/smoke.py
    #[arg(long)]
    smoke: bool,
}

impl Alternative {
    fn file(&self) -> Option<&'static str> {
        let all = [
            (self.engagement, "engagement.py"),
            (self.whole_drive, "whole_drive.py"),
            (self.over_speed, "over_speed.py"),
            (self.conditions, "conditions.py"),
            (self.longitudinal, "longitudinal.py"),
            (self.excitation, "manoeuvres.py"),
            (self.whole_road, "whole_road.py"),
            (self.promises, "promises.py"),
            (self.smoke, "smoke.py"),
        ];
        all.into_iter().find(|(is_wanted, _)| *is_wanted).map(|(_, file)| file)
    }
}

/// Runs the experiment with its own Python environment and the released command line.
pub(crate) fn experiment(options: &Options) -> Result<(), String> {
    let folder = root().join("evaluation/experiment");
    let requirements = folder.join("requirements.txt");
    let python = python::environment_in(&target().join("experiment-python"), &requirements)?;
    let mut command = python::command(&python);
    if options.alternative.test {
        return run(command.args(["-m", "pytest", "-q", "-p", "no:cacheprovider"]).arg(&folder));
    }
    let other = options.alternative.file();
    command.arg(folder.join(other.unwrap_or("experiment.py")));
    command.arg("--program").arg(program(None)?);
    if other.is_none() {
        command.arg("--out").arg(target().join("experiment"));
    }
    run(command.args(&options.arguments))
}
