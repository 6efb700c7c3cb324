//! `steerwright design`: a PID controller to a specification.

use crate::Global;
use crate::console;
use crate::design_plots;
use crate::design_summary::summary;
use crate::failure::{Failure, Outcome};
use crate::gate::GateArguments;
use crate::output::{Kind, Outputs};
use crate::progress::Progress;
use crate::specification::SpecificationArguments;
use std::path::PathBuf;
use steerwright_formats::Pid;

/// Design a PID steering controller (eq 14) on a plant or bicycle file
#[derive(clap::Args)]
pub(crate) struct Arguments {
    /// plant.json or bicycle.json
    #[arg(value_name = "PLANT.json")]
    plant: PathBuf,
    /// Write the controller here
    #[arg(long = "output", short = 'o', value_name = "FILE", default_value = "pid.json")]
    out: PathBuf,
    /// Write Bode, Nyquist and step plots (SVG) into this folder
    #[arg(long, value_name = "DIR")]
    plots: Option<PathBuf>,
    #[command(flatten)]
    gate: GateArguments,
    #[command(flatten)]
    specification: SpecificationArguments,
}

pub(crate) fn run(arguments: &Arguments, global: &Global) -> Result<Outcome, Failure> {
    let inputs = std::iter::once(&arguments.plant).chain(arguments.specification.files());
    let mut outputs = Outputs::new(global.force, inputs);
    let out = outputs.file(&arguments.out, Kind::of::<Pid>())?;
    let figures = |folder| outputs.files(folder, design_plots::NAMES, Kind::Svg);
    let plots = arguments.plots.as_deref().map(figures).transpose()?;
    let specified = arguments.specification.read()?;
    let (model, source, document) = arguments.gate.read(&arguments.plant)?;
    let plant =
        model.design_plant().map_err(|e| Failure::in_file(&arguments.plant, &e, e.hint()))?;
    let progress = Progress::start("designing");
    let mut pid = steerwright_control::design(&plant, &source, &specified.design)?;
    progress.now("running the loop of FMUs");
    steerwright_comparison::verify(&mut pid, &document, &plant)?;
    drop(progress);
    out.document(&pid)?;
    let mut written = vec![format!("written to {out}")];
    if let Some(plots) = &plots {
        for file in design_plots::write(plots, &plant, &pid)? {
            written.push(format!("written to {}", file.display()));
        }
    }
    console::result(&summary(&pid), &pid)?;
    written.iter().for_each(console::note);
    Ok(if is_met(&pid, specified.must_be_robust) {
        Outcome::Done
    } else {
        Outcome::RequirementNotMet
    })
}

/// Whether the requirements are met, and by all plants if the options require it.
fn is_met(pid: &Pid, must_be_robust: bool) -> bool {
    let by_all = pid.evidence.robustness.as_ref().is_none_or(|r| r.met);
    pid.evidence.met && (by_all || !must_be_robust)
}
