//! `steerwright compare`: models against a drive, controllers against each other and the truth.

mod channels;

use crate::documents::files;
use crate::documents::gate::GateArguments;
use crate::failure::{Failure, Outcome};
use crate::options::Global;
use crate::options::log::LogArguments;
use crate::options::quantity;
use crate::options::specification::SpecificationArguments;
use crate::output::Outputs;
use crate::pipeline::Writer;
use crate::terminal::console;
use crate::terminal::progress::Progress;
use std::path::{Path, PathBuf};
use steerwright_comparison::{ComparedModel, ControllerFile, Job, Road, Truth};
use steerwright_drivelog::{LogOptions, Response};
use steerwright_formats::{Model, Path as PathFile, Pid, SourceFile};
use steerwright_sweep::Class;
use steerwright_sysid::{IdentifyOptions, ValidationData};

/// Compare models and the controllers designed on them: with a drive, on each other's plants, and on a
/// vehicle that represents the truth
///
/// Every controller follows the same road on the plant of every model and on the truth, as packed
/// FMUs: the paper's Fig. 3 (with --log), 5, 6 and 7. A model without a --pid gets a controller that is
/// designed to the specification, within the steering limits of the truth. The exit status is 1 if a
/// controller is unstable or off the path. Plants of named channels follow no road: each simulates the
/// --log, and its fits are compared.
///
/// Example: steerwright compare plant.json bicycle.json --truth NonlinearVehicle.fmu --log drive.csv
/// --out comparison
#[derive(clap::Args)]
pub(crate) struct Arguments {
    /// plant.json, bicycle.json or vehicle.json, two or more; one is enough with two controllers, or of named channels
    #[arg(required = true, value_name = "MODEL.json")]
    models: Vec<PathBuf>,
    /// The vehicle that represents the truth: a plant FMU of any tool (inputs steering_angle and speed, outputs x,
    /// y, yaw), vehicle.json, plant.json, bicycle.json, or vehicle data (TOML) for a NonlinearVehicle
    #[arg(long, value_name = "FMU|FILE")]
    truth: Option<PathBuf>,
    /// A controller, of the model whose hash it carries, or of the named model; may be repeated
    #[arg(long = "pid", value_name = "[MODEL=]PID.json")]
    pids: Vec<String>,
    /// A drive to compare the models with, in any format that `identify` reads; may be repeated for more files
    #[arg(long = "log", value_name = "LOG")]
    logs: Vec<PathBuf>,
    /// Share of the log that is validation data, at its end; by default 50%
    #[arg(long, value_name = "SHARE", value_parser = quantity::percent)]
    validation_fraction: Option<f64>,
    /// Folder for figures (SVG), results.csv, the runs, and one HTML page
    #[arg(long, short, value_name = "DIR")]
    out: Option<PathBuf>,
    #[command(flatten)]
    road: RoadArguments,
    #[command(flatten)]
    log: LogArguments,
    #[command(flatten)]
    gate: GateArguments,
    #[command(flatten)]
    specification: SpecificationArguments,
}

/// The road.
#[derive(clap::Args)]
#[command(next_help_heading = "Road")]
struct RoadArguments {
    /// Drive along this path at its speed; look-ahead, preview, feedforward and sideslip are those of
    /// each controller and plant
    #[arg(long, value_name = "PATH.json", conflicts_with_all = ["road", "road_speed", "lateral_acceleration"])]
    path: Option<PathBuf>,
    /// A standard road
    #[arg(long, value_enum, default_value = "reference")]
    road: Shape,
    /// Speed on the standard road; by default that of the models
    #[arg(long, value_name = "SPEED", allow_hyphen_values = true, value_parser = quantity::speed)]
    road_speed: Option<f64>,
    /// Largest lateral acceleration of the standard road
    #[arg(long, value_name = "ACCELERATION", allow_hyphen_values = true, value_parser = quantity::acceleration, default_value = "4m/s2")]
    lateral_acceleration: f64,
    /// Gain of the integral of the cross-track error in the path follower, such as 0.05/s; by default
    /// that of the path, or none
    #[arg(long, value_name = "PER_SECOND", allow_hyphen_values = true, value_parser = quantity::rate)]
    cross_track_integral: Option<f64>,
    /// A cross-track error beyond this is off the path
    #[arg(long, value_name = "LENGTH", value_parser = quantity::length, default_value = "1.75m")]
    max_cross_track_error: f64,
}

pub(crate) fn run(arguments: &Arguments, global: &Global) -> Result<Outcome, Failure> {
    let outputs = Outputs::new(global.force, arguments.inputs());
    let folder = arguments.out.as_deref().map(|out| outputs.folder(out, "compare")).transpose()?;
    let specified = arguments.specification.read()?;
    // A model without a response to the steering is rejected before the log is searched for that.
    let files = arguments.documents()?;
    if channels::is_of_channels(&files) {
        return channels::run(arguments, files, folder);
    }
    let models = steerwright_comparison::models(files)?;
    let drive = arguments.drive()?;
    let progress = Progress::start("comparing: designs and runs");
    let compared = steerwright_comparison::compare(Job {
        controllers: arguments.controllers(&models)?,
        models,
        coupling: specified.coupling,
        design: specified.design,
        truth: arguments.truth.as_deref().map(truth).transpose()?,
        drive,
        road: arguments.road.read()?,
        cross_track_integral_per_s: arguments.road.cross_track_integral,
        max_cross_track_error_m: arguments.road.max_cross_track_error,
    })?;
    progress.now("drawing");
    let written = match folder {
        Some(folder) => {
            let mut out = Writer::new(folder.stage());
            for file in steerwright_comparison::files(&compared)? {
                out.bytes(&file.source.name, &file.bytes)?;
            }
            folder.commit()?;
            out.into_written()
        }
        None => Vec::new(),
    };
    drop(progress);
    let mut text = steerwright_comparison::text(&compared, console::columns());
    if let Some(folder) = &arguments.out {
        let (count, page) = (written.len(), folder.join(steerwright_comparison::PAGE));
        let (folder, page) = (folder.display(), page.display());
        text.push_str(&format!("\n{count} files in {folder}, to read: {page}\n"));
    }
    console::result(&text, &steerwright_comparison::json(&compared, &written))?;
    Ok(Outcome::when(compared.worst() <= Class::SpecificationMissed))
}

impl Arguments {
    fn inputs(&self) -> Vec<PathBuf> {
        // The file of a controller may follow the model and `=`.
        let pids = self.pids.iter().flat_map(|text| {
            let named = text.split_once('=').map(|(_, file)| file.into());
            [Some(text.into()), named].into_iter().flatten()
        });
        let named = self.models.iter().chain(&self.truth).chain(&self.logs).chain(&self.road.path);
        let named = named.chain(self.log.files()).chain(self.specification.files());
        named.cloned().chain(pids).collect()
    }

    fn documents(&self) -> Result<Vec<(PathBuf, SourceFile, Model)>, Failure> {
        let read = |path: &PathBuf| {
            let (document, source, _) = self.gate.read(path)?;
            Ok((path.clone(), source, document))
        };
        self.models.iter().map(read).collect()
    }

    /// The controllers' files; before `=` a model's label or file.
    fn controllers(&self, models: &[ComparedModel]) -> Result<Vec<ControllerFile>, Failure> {
        let read = |argument: &String| {
            let named = argument.split_once('=').and_then(|(model, file)| {
                let is_it = |m: &ComparedModel| m.label == model || m.path.as_os_str() == model;
                Some((models.iter().position(is_it)?, file))
            });
            let path = PathBuf::from(named.map_or(argument.as_str(), |(_, file)| file));
            if let (None, Some((model, _)), false) =
                (named, argument.split_once('='), path.exists())
            {
                let labels: Vec<&str> = models.iter().map(|m| m.label.as_str()).collect();
                return Err(Failure::new(
                    format!("--pid {argument}: no model is named {model}"),
                    format!("the models are {}", labels.join(", ")),
                ));
            }
            let (pid, source) = files::read_document::<Pid>(&path)?;
            Ok(ControllerFile { path, pid, source, model: named.map(|(model, _)| model) })
        };
        self.pids.iter().map(read).collect()
    }

    fn drive(&self) -> Result<Option<(steerwright_drivelog::DriveLog, IdentifyOptions)>, Failure> {
        if self.logs.is_empty() && self.log.drives.is_empty() {
            let is_stated = self.validation_fraction.is_some();
            if is_stated || self.log.options(Response::YawRate)? != LogOptions::default() {
                let hint = "add the drive with --log, or omit them";
                return Err(Failure::new(
                    "options for reading a log have no effect without one",
                    hint,
                ));
            }
            return Ok(None);
        }
        let log = self.log.read(&self.logs, Response::YawRate)?;
        let options = IdentifyOptions {
            validation: ValidationData {
                fraction: self.validation_fraction.unwrap_or(50.0) / 100.0,
                ..ValidationData::default()
            },
            ..IdentifyOptions::default()
        };
        Ok(Some((log, options)))
    }
}

/// The vehicle in a file: FMU, JSON or TOML.
fn truth(path: &Path) -> Result<Truth, Failure> {
    let is = |end: &str| path.extension().is_some_and(|e| e.eq_ignore_ascii_case(end));
    Ok(if is("toml") {
        Truth::from_vehicle_data(path, &files::read_text(path)?)?
    } else if is("json") {
        Truth::from_json(path, &files::read_text(path)?)?
    } else {
        Truth::from_fmu(path, &files::read(path)?)?
    })
}

#[derive(Debug, Clone, Copy, clap::ValueEnum)]
enum Shape {
    /// A double lane change of 3.5 m, then an S-curve of 40° to each side
    Reference,
    /// The double lane change alone
    LaneChange,
    /// The S-curve alone
    SCurve,
}

impl RoadArguments {
    fn read(&self) -> Result<Road, Failure> {
        Ok(match &self.path {
            Some(file) => {
                let (path, source) = files::read_document::<PathFile>(file)?;
                Road::File(Box::new(path), source)
            }
            None => Road::Standard {
                shape: match self.road {
                    Shape::Reference => steerwright_comparison::Shape::Reference,
                    Shape::LaneChange => steerwright_comparison::Shape::LaneChange,
                    Shape::SCurve => steerwright_comparison::Shape::SCurve,
                },
                speed: self.road_speed,
                lateral_acceleration: self.lateral_acceleration,
            },
        })
    }
}
