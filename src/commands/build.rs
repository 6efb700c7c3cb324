//! `steerwright build`: everything for one drive.

use crate::commands::identify::StructureArguments;
use crate::documents::files;
use crate::documents::gate::GateArguments;
use crate::failure::{Failure, Outcome};
use crate::options::Global;
use crate::options::log::{IdentifyArguments, LogArguments};
use crate::options::quantity;
use crate::options::specification::SpecificationArguments;
use crate::output::Outputs;
use crate::pipeline::{self, Job, Text};
use crate::terminal::{console, overview};
use std::path::{Path, PathBuf};
use steerwright_drivelog::{LOG_FORMATS, Response};

/// Identify, design, pack, track and report: all stages for one drive
#[derive(clap::Args)]
pub(crate) struct Arguments {
    #[arg(
        required_unless_present = "drives",
        value_name = "LOG",
        help = format!("Logs: {LOG_FORMATS} with --dbc")
    )]
    logs: Vec<PathBuf>,
    /// Folder for all results
    #[arg(long, short, value_name = "DIR", default_value = "out")]
    out: PathBuf,
    /// Vehicle data (TOML) of a bicycle model to compare with
    #[arg(long, value_name = "VEHICLE.toml")]
    vehicle: Option<PathBuf>,
    /// Recorded points (CSV, GPX or NMEA) of a road to track, in addition to the standard road
    #[arg(long, value_name = "TRACK")]
    track: Option<PathBuf>,
    /// Largest lateral acceleration on the standard road
    #[arg(long, value_name = "ACCELERATION", value_parser = quantity::acceleration, default_value = "4m/s2")]
    lateral_acceleration: f64,
    #[command(flatten)]
    log: LogArguments,
    #[command(flatten)]
    identify: IdentifyArguments,
    #[command(flatten)]
    structure: StructureArguments,
    #[command(flatten)]
    gate: GateArguments,
    #[command(flatten)]
    specification: SpecificationArguments,
}

pub(crate) fn run(arguments: &Arguments, global: &Global) -> Result<Outcome, Failure> {
    let inputs = arguments.logs.iter().chain(arguments.log.files());
    let inputs = inputs.chain(&arguments.vehicle).chain(&arguments.track);
    let inputs = inputs.chain(arguments.specification.files());
    let folder = Outputs::new(global.force, inputs).folder(&arguments.out, "build")?;
    let named = |path: &Option<PathBuf>| path.as_deref().map(named_text).transpose();
    let wanted = arguments.structure.with(&arguments.identify)?;
    let log = arguments.log.read(&arguments.logs, wanted.response())?;
    if log.response == Response::Channels {
        return Err(Failure::new(
            "build designs the steering of a vehicle, from one steering angle to one yaw rate",
            "identify a plant of named channels with: steerwright identify",
        ));
    }
    let built = pipeline::build(&Job {
        log,
        wanted,
        validation: arguments.identify.options(),
        design: arguments.specification.read()?.design,
        vehicle: named(&arguments.vehicle)?,
        track: named(&arguments.track)?,
        lateral_acceleration: arguments.lateral_acceleration,
        folder: folder.stage().into(),
        out: arguments.out.clone(),
        gate: arguments.gate,
    })?;
    folder.commit()?;
    if let Some(structures) = &built.structures {
        console::note(structures);
    }
    for controller in &built.controllers {
        controller.warnings().iter().for_each(console::warning);
    }
    let mut text = console::page(&built.report().sections(), None);
    text.push_str(&format!("\n{}", overview::table(std::slice::from_ref(&built))));
    console::result(&text, &overview::overview(&built))?;
    let identified = built.controllers.iter().find(|c| c.basis == pipeline::Basis::Identified);
    Ok(Outcome::when(identified.is_some_and(|c| c.pid.evidence.met)))
}

fn named_text(path: &Path) -> Result<Text, Failure> {
    Ok(Text { name: path.display().to_string(), text: files::read_text(path)? })
}
