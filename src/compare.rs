//! `steerwright compare`: models against a drive, controllers against each other and the truth.

use crate::comparison::{self, Comparison, Job, Road, Shape};
use crate::console;
use crate::failure::{Failure, Outcome};
use crate::gate::GateArguments;
use crate::log_options::LogArguments;
use crate::output::Outputs;
use crate::progress::Progress;
use crate::requirements::SpecificationArguments;
use crate::{Global, files, quantity};
use formats::Path as PathFile;
use std::path::PathBuf;
use sweep::Class;
use sysid::IdentifyOptions;

/// Compare models and the controllers designed on them: against a drive, on each other's plants, and
/// on a vehicle that stands for the truth
///
/// Every controller follows the same road on the plant of every model and on the truth, as packed
/// FMUs. The paper's Fig. 3 (with --log), 5, 6 and 7. A controller is designed for each model to the
/// same specification, unless --pid gives one, within the steering limits that the truth states. Exit
/// status 1 where a controller is unstable or off the path.
///
///   steerwright compare plant.json bicycle.json --truth NonlinearVehicle.fmu --log drive.csv
///       --out comparison
#[derive(clap::Args)]
#[command(verbatim_doc_comment)]
pub(crate) struct Arguments {
    /// plant.json or bicycle.json, two or more; one will do with two controllers
    #[arg(required = true, value_name = "MODEL.json")]
    models: Vec<PathBuf>,
    /// The vehicle to judge on: a plant FMU of any tool (inputs steering_angle and speed, outputs x,
    /// y, yaw), vehicle.json, or vehicle data (TOML) for a NonlinearVehicle
    #[arg(long, value_name = "FMU|FILE")]
    truth: Option<PathBuf>,
    /// A controller, of the model whose hash it carries, or of the one named before it; may be
    /// repeated
    #[arg(long = "pid", value_name = "[MODEL=]PID.json")]
    pids: Vec<String>,
    /// A drive (CSV) to hold the models against; more --log for more files
    #[arg(long = "log", value_name = "LOG")]
    logs: Vec<PathBuf>,
    /// Share of the log, at its end, that the models are judged on
    #[arg(long, value_name = "SHARE", value_parser = quantity::percent, default_value = "50%")]
    hold_out: f64,
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

/// What is driven along.
#[derive(clap::Args)]
#[command(next_help_heading = "Road")]
struct RoadArguments {
    /// Drive along this path, at its speed; its look-ahead, preview, feedforward and sideslip are
    /// replaced by those of each controller and plant
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
    /// How fast the path follower's integral of the cross-track error grows, such as 0.05/s; by
    /// default the path's, or none
    #[arg(long, value_name = "RATE", allow_hyphen_values = true, value_parser = quantity::rate)]
    cross_track_integral: Option<f64>,
    /// A cross-track error beyond this is off the path
    #[arg(long, alias = "lost-beyond", value_name = "LENGTH", value_parser = quantity::length, default_value = "1.75m")]
    max_cross_track_error: f64,
}

pub(crate) fn run(arguments: &Arguments, global: &Global) -> Result<Outcome, Failure> {
    let outputs = Outputs::new(global.force, arguments.inputs());
    let folder = arguments.out.as_deref().map(|out| outputs.folder(out, "compare")).transpose()?;
    let design = arguments.specification.options()?;
    let drive = arguments.drive()?;
    let progress = Progress::start("comparing: designs and runs");
    let compared = comparison::compare(&Job {
        models: arguments.models.clone(),
        pids: arguments.pids.clone(),
        master: arguments.specification.master()?,
        design,
        truth: arguments.truth.clone(),
        drive,
        road: arguments.road.read()?,
        cross_track_integral_per_s: arguments.road.cross_track_integral,
        gate: arguments.gate,
        max_cross_track_error_m: arguments.road.max_cross_track_error,
    })?;
    progress.now("drawing");
    let written = match folder {
        Some(folder) => {
            let written = comparison::write(&compared, folder.stage())?;
            folder.commit()?;
            written
        }
        None => Vec::new(),
    };
    drop(progress);
    let mut text = comparison::text(&compared);
    if let Some(folder) = &arguments.out {
        text.push_str(&format!(
            "\n{} files in {}, to read: {}\n",
            written.len(),
            folder.display(),
            folder.join("comparison.html").display()
        ));
    }
    console::result(&text, &comparison::json(&compared, &written))?;
    Ok(outcome(&compared))
}

fn outcome(compared: &Comparison) -> Outcome {
    match compared.worst() {
        Class::Met | Class::SpecificationMissed => Outcome::Done,
        _ => Outcome::RequirementNotMet,
    }
}

impl Arguments {
    /// The files that are read.
    fn inputs(&self) -> Vec<PathBuf> {
        // A controller's file may stand behind its model's.
        let pids = self.pids.iter().flat_map(|text| {
            let named = text.split_once('=').map(|(_, file)| file.into());
            [Some(text.into()), named].into_iter().flatten()
        });
        let named = self.models.iter().chain(&self.truth).chain(&self.logs).chain(&self.road.path);
        let named = named.chain(self.log.files()).chain(self.specification.files());
        named.cloned().chain(pids).collect()
    }

    /// The drive, where there is one.
    fn drive(&self) -> Result<Option<(drivelog::DriveLog, IdentifyOptions)>, Failure> {
        if self.logs.is_empty() && !self.log.names_files() {
            return Ok(None);
        }
        let log = self.log.read(&self.logs)?;
        let options = IdentifyOptions {
            validation_fraction: self.hold_out / 100.0,
            ..IdentifyOptions::default()
        };
        Ok(Some((log, options)))
    }
}

impl RoadArguments {
    fn read(&self) -> Result<Road, Failure> {
        Ok(match &self.path {
            Some(file) => {
                let (path, source) = files::read_document::<PathFile>(file)?;
                Road::File(Box::new(path), source)
            }
            None => Road::Standard {
                shape: self.road,
                speed: self.road_speed,
                lateral_acceleration: self.lateral_acceleration,
            },
        })
    }
}
