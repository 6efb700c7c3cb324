//! The stages that compute in memory, with the options of the command line.
//!
//! Each function has the options of one subcommand, by name and text, with the same defaults and checks; so
//! whatever calls them reads and computes what the command line does. [`options`] describes them.

use crate::commands::identify::accumulated::{check_factor_options, merged};
use crate::commands::{accumulate, design as design_command, identify as identify_command};
use crate::output::{OutputKind, Outputs};
use crate::terminal::progress::{self, Progress};
use clap::{ArgAction, Args, CommandFactory};
use std::path::{Path, PathBuf};
use steerwright_control::DesignPlant;
use steerwright_drivelog::{DriveLog, Response, in_memory, read_recordings};
use steerwright_formats::{
    AccumulatedDrives, Document, Manoeuvre, Model, Path as PathFile, Pid, Provenance, SourceFile,
    SpeedController, Structure, sha256_hex,
};
use steerwright_sysid::{Accumulated, IdentifiedModel};

pub use crate::failure::Failure;
pub use crate::presentation::{figures_of_controller, figures_of_model, notebook, page_of_model};
pub use crate::terminal::progress::Observer;
/// A temporary folder that a killed process does not leave for good.
pub use steerwright_host::Scratch;

/// Options by their names on the command line without dashes, such as `steering-ratio`, each with its text;
/// `None` for a switch. An option with several values is there several times.
pub type Options<'a> = &'a [(String, Option<String>)];

/// A table in memory: its name, and its named columns of equal length; a missing value is NaN.
pub type Table = (String, Vec<(String, Vec<f64>)>);

/// Where a log comes from.
#[derive(Debug)]
pub enum Source {
    /// Files of any format; none where the option `drive` names them.
    Files(Vec<PathBuf>),
    /// Tables in memory.
    Tables(Vec<Table>),
}

/// An option of a subcommand.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct OptionDescription {
    /// Name without dashes.
    pub name: String,
    /// What the value is, such as `TIME`; `None` for a switch.
    pub value: Option<String>,
    /// The values, where they are listed.
    pub values: Vec<String>,
    /// Whether it may be repeated.
    pub is_repeated: bool,
    /// The text of the default.
    pub default: Option<String>,
    /// What it means, one paragraph.
    pub help: String,
}

/// The options of a subcommand such as `identify` or `sweep merge`, or those of reading a log for `read`; `None` for
/// a name that is none.
#[must_use]
pub fn options(subcommand: &str) -> Option<Vec<OptionDescription>> {
    let mut root = match subcommand {
        "read" => ReadArguments::augment_args(clap::Command::new("read")),
        _ => crate::Arguments::command(),
    };
    // Which also gives the options of all subcommands to each.
    root.build();
    let mut names = subcommand.split(' ').filter(|name| *name != "read");
    let command = names.try_fold(&root, |command, name| command.find_subcommand(name))?;
    let described = command.get_arguments().filter_map(|argument| {
        let name = argument.get_long().filter(|_| !argument.is_hide_set())?;
        let takes = argument.get_action().takes_values();
        let value = argument.get_value_names().and_then(|names| names.first());
        let help = argument.get_long_help().or_else(|| argument.get_help());
        Some(OptionDescription {
            name: name.to_owned(),
            value: if takes {
                Some(value.map_or("VALUE", |name| name.as_str()).to_owned())
            } else {
                None
            },
            values: if takes {
                argument.get_possible_values().iter().map(|v| v.get_name().to_owned()).collect()
            } else {
                Vec::new()
            },
            is_repeated: matches!(argument.get_action(), ArgAction::Append),
            default: argument
                .get_default_values()
                .first()
                .filter(|_| takes)
                .map(|default| default.to_string_lossy().into_owned()),
            help: help.map(ToString::to_string).unwrap_or_default(),
        })
    });
    Some(
        described
            .filter(|option| !["help", "version", "verbose"].contains(&option.name.as_str()))
            .collect(),
    )
}

/// The arguments of a subcommand with these options.
fn parsed<A: Args>(options: Options<'_>, positional: &[&str]) -> Result<A, Failure> {
    let words = options.iter().map(|(name, value)| match value {
        Some(value) => format!("--{name}={value}"),
        None => format!("--{name}"),
    });
    let words = words.chain(positional.iter().map(ToString::to_string));
    let command = A::augment_args(clap::Command::new("").no_binary_name(true));
    let refused = |error: clap::Error| {
        let text = error.to_string();
        let message = text.lines().next().unwrap_or_default().trim_start_matches("error: ");
        Failure::new(message, "the description of the option states its unit and its values")
    };
    let matches = command.try_get_matches_from(words).map_err(refused)?;
    A::from_arg_matches(&matches).map_err(refused)
}

/// Stands where the command line has the name of a log.
const LOG: &str = "log";

#[derive(Args)]
struct ReadArguments {
    /// What responds: the yaw rate to the steering angle; for the structure single-track also accelerations and
    /// sideslip (motion); for the structure torque, the lateral acceleration to a steering torque or its
    /// normalised command; or, for the structure longitudinal, the speed to accelerator and brake or to an
    /// acceleration command
    #[arg(long, value_name = Response::WORDS, default_value = "yaw-rate")]
    response: Response,
    #[command(flatten)]
    log: crate::options::log::LogArguments,
}

/// Reads a log, with the options of `read`.
///
/// # Errors
/// As `steerwright identify`, with file, line and column.
pub fn read(source: Source, options: Options<'_>) -> Result<DriveLog, Failure> {
    let ReadArguments { response, log } = parsed(options, &[])?;
    match source {
        Source::Files(paths) => log.read(&paths, response),
        Source::Tables(tables) => {
            if log.files().next().is_some() {
                let hint = "name files, or pass the tables of each drive on their own";
                return Err(Failure::new("--drive: tables are no files", hint));
            }
            let options = log.options(response)?;
            let _progress = Progress::start("reading the log");
            let tables = tables.into_iter().map(|(name, columns)| in_memory(&name, columns));
            Ok(read_recordings(tables.collect::<Result<_, _>>()?, &options)?)
        }
    }
}

/// What `identify` with these options reads a log for: a word of the option `response` of `read`.
///
/// # Errors
/// Options that are wrong, as `steerwright identify`.
pub fn response(options: Options<'_>) -> Result<&'static str, Failure> {
    let arguments: identify_command::Arguments = parsed(options, &[LOG])?;
    Ok(arguments.wanted()?.response().name())
}

/// Identifies the model of a log that is read, with the options of `identify` that are not those of `read`.
///
/// # Errors
/// As `steerwright identify`.
pub fn identify(log: &DriveLog, options: Options<'_>) -> Result<IdentifiedModel, Failure> {
    let arguments: identify_command::Arguments = parsed(options, &[LOG])?;
    let _progress = Progress::start("identifying");
    let (identified, _) = arguments.wanted()?.identify(log)?;
    Ok(identified)
}

/// Accumulates logs, each a drive, with the options of `accumulate`.
///
/// # Errors
/// As `steerwright accumulate`.
pub fn accumulate(source: Source, options: Options<'_>) -> Result<Accumulated, Failure> {
    let arguments: accumulate::Arguments = parsed(options, &[LOG])?;
    let options = arguments.options()?;
    let progress = Progress::start("reading the logs");
    match source {
        Source::Files(paths) => {
            merged(paths.iter().map(|path| accumulate::accumulate_drive(path, &options, &progress)))
        }
        Source::Tables(tables) => merged(tables.into_iter().map(|(name, columns)| {
            Ok(Accumulated::of_recording(in_memory(&name, columns)?, &options)?)
        })),
    }
}

/// The drives of an R factor's document; `file` is its name in errors.
///
/// # Errors
/// A document that is none.
pub fn accumulated(document: &str, file: &str) -> Result<Accumulated, Failure> {
    let document = AccumulatedDrives::from_json(document, file)?;
    Ok(Accumulated::from_file(&document, file)?)
}

/// Adds what another has accumulated, and returns whether it did: a log that is in both counts once.
///
/// # Errors
/// Drives that differ in what all must share, or share some of their logs.
pub fn merge(into: &mut Accumulated, other: Accumulated) -> Result<bool, Failure> {
    Ok(into.merge(other)?)
}

/// The document of accumulated drives, as `steerwright accumulate` writes it.
#[must_use]
pub fn accumulated_json(drives: &Accumulated) -> String {
    drives.to_file().to_json()
}

/// Identifies the plant of accumulated drives; its document.
///
/// # Errors
/// As `steerwright identify`.
pub fn identify_accumulated(drives: &Accumulated, options: Options<'_>) -> Result<String, Failure> {
    let arguments: identify_command::Arguments = parsed(options, &[LOG])?;
    let options = check_factor_options(arguments.log(), Some(arguments.identify()))?;
    let _progress = Progress::start("identifying");
    Ok(drives.identify(&options)?.to_json())
}

/// Designs a controller on the document of a model, with the options of `design`; its document.
/// `file` is the name of the document in the controller's provenance.
///
/// # Errors
/// As `steerwright design`; a requirement that is not met is in the document.
pub fn design(document: &str, file: &str, options: Options<'_>) -> Result<String, Failure> {
    let arguments: design_command::Arguments = parsed(options, &[file])?;
    let model = Model::from_json(document, file)?;
    arguments.gate.check(file, model.quality())?;
    let source = SourceFile::from_bytes(file.as_ref(), document.as_bytes());
    let progress = Progress::start("designing");
    if let Some(longitudinal) = model.longitudinal() {
        let speeds = arguments.speeds.map(|range| range.0);
        let specified = arguments.specification.read_speed(speeds)?;
        let now = |what: &str| progress.now(what);
        let designed =
            design_command::speed_controller(longitudinal, &source, &specified.design, now)?;
        return Ok(designed.to_json());
    }
    let specified = arguments.specification.read()?;
    let plant = DesignPlant::from_model(&model)?;
    let pid = design_command::designed(
        document,
        &plant,
        &source,
        arguments.speeds,
        &specified,
        |what| {
            progress.now(what);
        },
    )?;
    Ok(pid.to_json())
}

/// Does work whose progress is observed instead of printed.
pub fn observed<T>(observer: &Observer, work: impl FnOnce() -> T) -> T {
    progress::observed(observer, work)
}

/// Writes a document as the commands do: whole or not at all, and over no file but a document of its kind, unless
/// `force` is set. What it was computed from is never written over.
///
/// # Errors
/// As a command with that output.
pub fn save(path: &Path, document: &str, force: bool) -> Result<(), Failure> {
    #[derive(serde::Deserialize)]
    struct Tag {
        schema: String,
        provenance: Option<Provenance>,
    }
    let unknown = || Failure::new("this is no document of this program", "pass one that it wrote");
    let tag: Tag = serde_json::from_str(document).map_err(|_| unknown())?;
    let others = [
        OutputKind::for_document::<Pid>(),
        OutputKind::for_document::<SpeedController>(),
        OutputKind::for_document::<PathFile>(),
        OutputKind::for_document::<Manoeuvre>(),
        OutputKind::for_document::<AccumulatedDrives>(),
    ];
    let has = |kind: &OutputKind| matches!(kind, OutputKind::Document(schema) if tag.schema.starts_with(schema));
    let structure = Structure::ALL
        .into_iter()
        .find(|structure| has(&OutputKind::for_schema(structure.schema())));
    let kind = match structure {
        // They replace each other.
        Some(structure) if structure.is_lateral() => OutputKind::Model,
        Some(structure) => OutputKind::for_schema(structure.schema()),
        None => others.into_iter().find(has).ok_or_else(unknown)?,
    };
    let is_source = |bytes: &Vec<u8>| {
        let hash = sha256_hex(bytes);
        tag.provenance.iter().flat_map(|p| &p.sources).any(|source| source.sha256 == hash)
    };
    let is_read = std::fs::metadata(path).is_ok_and(|m| m.is_file())
        && std::fs::read(path).is_ok_and(|bytes| is_source(&bytes));
    let inputs = if is_read { Some(path) } else { None };
    Outputs::new(force, inputs).file(path, kind)?.write(document.as_bytes())
}

/// The yaw step of a controller on its model: times (s), yaw (rad) and steering angle (rad).
///
/// # Errors
/// Documents that are none, or a loop that cannot be evaluated.
pub fn yaw_step(document: &str, controller: &str, until_s: f64) -> Result<[Vec<f64>; 3], Failure> {
    let plant = DesignPlant::from_model(&Model::from_json(document, "the model")?)?;
    let pid = Pid::from_json(controller, "pid.json")?;
    let plant = plant.behind(pid.designed_for.actuator);
    let trace = steerwright_control::step_response(&plant, &pid, false, until_s)?;
    Ok([trace.time, trace.yaw, trace.steering])
}
