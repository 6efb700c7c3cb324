//! `steerwright identify`: the plant in a drive log.

pub(crate) mod accumulated;
mod auto;
mod present;
mod structure;

use crate::commands::identify::present::{Shown, present};
use crate::failure::{Failure, Outcome};
use crate::options::Global;
use crate::options::log::{IdentifyArguments, LogArguments};
use crate::output::{OutputKind, Outputs};
use crate::terminal::progress::Progress;
use std::path::PathBuf;
use steerwright_drivelog::{LOG_FORMATS, Response};
use steerwright_formats::{Structure, alternatives};

pub(crate) use structure::{StructureArguments, Wanted};

/// Identify a model from drive logs: the lateral dynamics from steering angle to yaw rate, the response to a
/// steering torque, the response of the speed, or a plant of named channels
#[derive(clap::Args)]
pub(crate) struct Arguments {
    #[arg(
        required_unless_present = "drives",
        value_name = "LOG",
        help = format!(
            "Logs: {LOG_FORMATS} with --dbc. One drive each if every file has steering and yaw rate, otherwise the \
             channels of one drive. Or R factors (.rfactor) written by `accumulate`, which are merged"
        )
    )]
    logs: Vec<PathBuf>,
    #[arg(
        long = "output",
        short = 'o',
        value_name = "FILE",
        help = format!("Model file; by default {}, by the structure of the model",
            alternatives(&Structure::ALL.map(Structure::file_name)))
    )]
    out: Option<PathBuf>,
    /// Write measured and simulated signals as CSV
    #[arg(long, value_name = "CSV")]
    traces: Option<PathBuf>,
    /// Write the figures of the evidence (SVG) into this folder
    #[arg(long, value_name = "DIR")]
    plots: Option<PathBuf>,
    /// Write the evidence with its figures as one HTML page
    #[arg(long, value_name = "HTML")]
    report: Option<PathBuf>,
    #[command(flatten)]
    log: LogArguments,
    #[command(flatten)]
    identify: IdentifyArguments,
    #[command(flatten)]
    structure: StructureArguments,
}

impl Arguments {
    pub(crate) fn wanted(&self) -> Result<Wanted, Failure> {
        self.structure.with(&self.identify)
    }

    pub(crate) fn log(&self) -> &LogArguments {
        &self.log
    }

    pub(crate) fn identify(&self) -> &IdentifyArguments {
        &self.identify
    }
}

pub(crate) fn run(arguments: &Arguments, global: &Global) -> Result<Outcome, Failure> {
    let mut outputs =
        Outputs::new(global.force, arguments.logs.iter().chain(arguments.log.files()));
    let is_of_factors = accumulated::are_factors(&arguments.logs)?;
    let wanted = arguments.wanted()?;
    // Before the work, unless the data choose the structure.
    let structure = if is_of_factors { Some(Structure::StateSpace) } else { wanted.structure() };
    let named = structure.map(|structure| PathBuf::from(structure.file_name()));
    let named = arguments.out.clone().or(named);
    let out = outputs
        .optional(named.as_ref(), structure.map_or(OutputKind::Model, OutputKind::of_model))?;
    let traces = outputs.optional(arguments.traces.as_ref(), OutputKind::Traces)?;
    let shown = Shown::decide(arguments.plots.as_deref(), arguments.report.as_ref(), &mut outputs)?;
    let of_signals = [
        ("--traces", traces.is_some()),
        ("--plots", arguments.plots.is_some()),
        ("--report", arguments.report.is_some()),
    ];
    let of_signals = of_signals.iter().find(|(_, is_stated)| *is_stated).map(|(name, _)| name);
    if let Some(out) = out.as_ref().filter(|_| is_of_factors) {
        let is_other = wanted.structure().is_some_and(|other| other != Structure::StateSpace);
        if let Some(option) = is_other.then_some(&"--structure").or(of_signals) {
            return Err(Failure::new(
                format!("{option}: an R factor holds no signals"),
                "identify from the log itself, or omit the option",
            ));
        }
        return accumulated::run(&arguments.logs, &arguments.log, &arguments.identify, out);
    }
    let log = arguments.log.read(&arguments.logs, wanted.response())?;
    if log.response == Response::Channels {
        check_channels(structure)?;
    }
    let progress = Progress::start("identifying");
    let (identified, table) = wanted.identify(&log)?;
    drop(progress);
    let structure = identified.model.structure();
    let out = match out {
        Some(out) => out,
        None => outputs.file(structure.file_name(), OutputKind::of_model(structure))?,
    };
    present(&identified, table.as_deref(), &arguments.logs, &out, traces.as_ref(), &shown)
}

/// Rejects what a plant of named channels has not.
fn check_channels(structure: Option<Structure>) -> Result<(), Failure> {
    if let Some(structure) = structure.filter(|structure| *structure != Structure::StateSpace) {
        return Err(Failure::new(
            format!(
                "the structure {structure} is that of a vehicle, from one steering angle to one yaw rate"
            ),
            "name one --input-channel and one --output-channel of a vehicle, or omit --structure",
        ));
    }
    Ok(())
}
