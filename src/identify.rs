//! `steerwright identify`: the plant in a drive log.

use crate::evidence::{evidence, plots, traces_csv};
use crate::failure::{Failure, Outcome};
use crate::log_options::{IdentifyArguments, LogArguments};
use crate::output::{Files, Kind, Output, Outputs};
use crate::progress::Progress;
use crate::structure::{Structure, StructureArguments, Wanted};
use crate::{
    Global, console, identify_accumulated, identify_auto, identify_bicycle, identify_torque,
    identify_vehicle,
};
use std::fmt::Write;
use std::path::{Path, PathBuf};
use steerwright_drivelog::Response;
use steerwright_formats::{Bicycle, Plant, Torque};
use steerwright_sysid::Identified;

/// Identify the lateral dynamics in a drive log: steering angle in, yaw rate out
#[derive(clap::Args)]
pub(crate) struct Arguments {
    /// Logs: CSV, MDF, MCAP, Parquet, or a CAN bus (candump, ASC) with --dbc. One drive each if every file has
    /// steering and yaw rate, otherwise the channels of one drive. Or R factors (.rfactor) written by
    /// `accumulate`, which are merged
    #[arg(required_unless_present = "drives", value_name = "LOG")]
    logs: Vec<PathBuf>,
    /// Model file; by default plant.json, bicycle.json, vehicle.json or torque.json, by the structure of the model
    #[arg(long = "output", short = 'o', value_name = "FILE")]
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
    let is_of_factors = identify_accumulated::are_factors(&arguments.logs)?;
    let is_drawn = arguments.plots.is_some() || arguments.report.is_some();
    let structure = match arguments.wanted()? {
        Wanted::Auto(options) if !is_of_factors && !is_drawn => {
            let out = outputs.optional(arguments.out.as_ref(), Kind::Model)?;
            let traces = outputs.optional(arguments.traces.as_ref(), Kind::Traces)?;
            let log = arguments.log.read(&arguments.logs, Response::YawRate)?;
            return identify_auto::run(&log, &options, out, &mut outputs, traces.as_ref());
        }
        wanted => wanted.without_choice(),
    };
    let (default, kind) = match structure {
        Structure::StateSpace(_) => ("plant.json", Kind::of::<Plant>()),
        Structure::Bicycle(_) => ("bicycle.json", Kind::of::<Bicycle>()),
        Structure::Torque(_) => ("torque.json", Kind::of::<Torque>()),
        Structure::SingleTrack(_) => ("vehicle.json", Kind::IdentifiedVehicle),
    };
    let out = outputs.file(arguments.out.clone().unwrap_or_else(|| default.into()), kind)?;
    let traces = outputs.optional(arguments.traces.as_ref(), Kind::Traces)?;
    let shown = Shown::decide(arguments, &mut outputs)?;
    if is_of_factors {
        let asked = [
            ("--structure", !matches!(structure, Structure::StateSpace(_))),
            ("--traces", traces.is_some()),
            ("--plots", arguments.plots.is_some()),
            ("--report", arguments.report.is_some()),
        ];
        if let Some((option, _)) = asked.iter().find(|(_, asked)| *asked) {
            return Err(Failure::new(
                format!("{option}: an R factor holds no signals"),
                "identify from the log itself, or omit the option",
            ));
        }
        let (log, identify) = (&arguments.log, &arguments.identify);
        return identify_accumulated::run(&arguments.logs, log, identify, &out);
    }
    let of_state_space = [
        ("--plots", arguments.plots.is_some()),
        ("--report", arguments.report.is_some()),
        ("--traces", matches!(structure, Structure::Torque(_)) && traces.is_some()),
    ];
    if !matches!(structure, Structure::StateSpace(_))
        && let Some((name, _)) = of_state_space.iter().find(|(_, is_stated)| *is_stated)
    {
        let message = format!("{name} is not available for this structure");
        return Err(Failure::new(message, "omit it, or identify with --structure state-space"));
    }
    let log = arguments.log.read(&arguments.logs, structure.response())?;
    match structure {
        Structure::Bicycle(options) => identify_bicycle::run(&log, &options, &out, traces.as_ref()),
        Structure::Torque(options) => identify_torque::run(&log, &options, &out),
        Structure::SingleTrack(options) => {
            identify_vehicle::run(&log, &options, &out, traces.as_ref())
        }
        Structure::StateSpace(options) => {
            let progress = Progress::start("identifying");
            let identified = steerwright_sysid::identify(&log, &options)?;
            drop(progress);
            present(&identified, &out, traces.as_ref(), &shown)
        }
    }
}

/// Writes, draws and prints a plant.
pub(crate) fn present(
    identified: &Identified,
    out: &Output,
    traces: Option<&Output>,
    shown: &Shown<'_>,
) -> Result<Outcome, Failure> {
    out.document(&identified.plant)?;
    // The signals as text are several times the log in memory.
    let is_wanted = traces.is_some() || shown.is_wanted();
    let csv = if is_wanted { traces_csv(&identified.traces, None) } else { String::new() };
    if let Some(traces) = traces {
        traces.write(csv.as_bytes())?;
    }
    let drawn = shown.write(&identified.plant, &csv)?;
    console::result(&evidence(&identified.plant), &identified.plant)?;
    console::note(format!("written to {out}{drawn}"));
    Ok(Outcome::of(&identified.plant.quality))
}

/// The outputs that the evidence is drawn into.
#[derive(Default)]
pub(crate) struct Shown<'a> {
    plots: Option<(&'a Path, Files)>,
    report: Option<Output>,
}

impl<'a> Shown<'a> {
    fn decide(arguments: &'a Arguments, outputs: &mut Outputs) -> Result<Self, Failure> {
        let plots = arguments.plots.as_deref().map(|folder| {
            let names =
                steerwright_report::figures::OF_IDENTIFICATION.map(|name| format!("{name}.svg"));
            Ok::<_, Failure>((folder, outputs.files(folder, names, Kind::Svg)?))
        });
        let plots = plots.transpose()?;
        Ok(Self { plots, report: outputs.optional(arguments.report.as_ref(), Kind::Html)? })
    }

    fn is_wanted(&self) -> bool {
        self.plots.is_some() || self.report.is_some()
    }

    /// Draws the requested evidence; returns the places that it was written to, for people.
    fn write(&self, plant: &Plant, csv: &str) -> Result<String, Failure> {
        let mut text = String::new();
        if !self.is_wanted() {
            return Ok(text);
        }
        let traces = steerwright_report::Traces::from_csv(csv.as_bytes(), "traces")?;
        if let Some((folder, files)) = &self.plots {
            plots(plant, &traces, files)?;
            let _ = write!(text, "\nfigures in {}", folder.display());
        }
        if let Some(out) = &self.report {
            let page = steerwright_report::Report {
                title: format!("{}: the identified model", plant.name),
                plant: Some(plant),
                traces: Some(&traces),
                ..steerwright_report::Report::default()
            };
            out.write(page.to_html().as_bytes())?;
            let _ = write!(text, "\nreport in {out}");
        }
        Ok(text)
    }
}
